#!/usr/bin/python3
"""What Python costs, beside C++ and in the same run: tables for services/python/NOTES.md.

    PYTHONPATH=build/release/python tests/services/python/measure.py build/release/bin [ROUNDS]

Needs build/release/bin/python_cpp_times (target python_cpp_times). In turns, C++ and Python, medians of
ROUNDS (5) pairs: compute() on synthetic:1624x1224 with one thread, frames of a log, two threads.
"""
import pathlib
import resource
import subprocess
import sys
import tempfile
import threading
import time
from typing import Callable, List

import numpy

import sprout

SOURCE = "synthetic:1624x1224"
FRAMES = 4
LOG_FRAMES = 40


def cpp(program: pathlib.Path, *arguments: str) -> List[float]:
    return [float(word) for word in subprocess.check_output([program, *arguments], text=True).split()]


def timed(work: Callable[[], object]) -> float:
    begun = time.perf_counter()
    work()
    return 1000 * (time.perf_counter() - begun)


def cpu_ms(program: pathlib.Path, preset: str, frames: int) -> float:
    """Of a C++ process with so many frames, user and system: what others do on the machine does not count."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([program, "compute", SOURCE, preset, str(frames)], check=True, stdout=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return 1000 * (after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime)


def overhead(times: pathlib.Path, preset: str, rounds: int) -> None:
    scene = sprout.Dataset(SOURCE)[0]
    pipeline = sprout.Pipeline(preset)
    pipeline.compute(scene.left, scene.right, scene.tof, scene.rig)
    ours, theirs = [], []
    for _ in range(rounds):
        theirs.append((cpu_ms(times, preset, 1 + FRAMES) - cpu_ms(times, preset, 1)) / FRAMES)
        begun = time.process_time()
        for _ in range(FRAMES):
            pipeline.compute(scene.left, scene.right, scene.tof, scene.rig)
        ours.append(1000 * (time.process_time() - begun) / FRAMES)
    print(f"compute, {preset}: CPU a frame in C++ {numpy.median(theirs):.1f} ms ({min(theirs):.1f} to "
          f"{max(theirs):.1f}), in Python {numpy.median(ours):.1f} ms ({min(ours):.1f} to {max(ours):.1f}): "
          f"{100 * (numpy.median(ours) / numpy.median(theirs) - 1):+.1f} %")


def wrapping(preset: str) -> None:
    """What compute() does beside the computation, alone: the same arrays, and a frame refused at once."""
    scene = sprout.Dataset(SOURCE)[0]
    frame = sprout.Pipeline(preset).compute(scene.left, scene.right, scene.tof, scene.rig)
    arrays = [timed(lambda: (sprout.Tof(scene.tof.depth_m), frame.left, frame.right, frame.depth_m,
                             frame.confidence, frame.seeds, frame.rig)) for _ in range(200)]
    print(f"arrays of a frame in and out: {numpy.median(arrays):.3f} ms")


def reading(times: pathlib.Path, log: str, rounds: int) -> None:
    ours, theirs = [], []
    for _ in range(rounds):
        theirs += cpp(times, "read", log)
        ours.append(timed(lambda: [None for _ in sprout.Log(log).frames()]) / LOG_FRAMES)
    print(f"read: C++ {numpy.median(theirs):.3f} ms a frame, Python {numpy.median(ours):.3f}: "
          f"{numpy.median(theirs) / numpy.median(ours):.2f} times as fast")


def runnable_ms() -> float:
    """Of this thread so far: on a core, or waiting for one that others had; not waiting for a lock."""
    stat = pathlib.Path(f"/proc/self/task/{threading.get_native_id()}/schedstat").read_text().split()
    return (int(stat[0]) + int(stat[1])) / 1e6


def scaling(preset: str, rounds: int) -> None:
    """How many times the frames of one thread two give; and, for a machine whose cores are taken, how many of the
    two could run at any time: 2 when neither ever waits for the other."""
    scene = sprout.Dataset(SOURCE)[0]
    pipelines = [sprout.Pipeline(preset) for _ in range(2)]
    able: List[float] = []

    def work(pipeline: sprout.Pipeline) -> None:
        begun = runnable_ms()
        for _ in range(FRAMES):
            pipeline.compute(scene.left, scene.right, scene.tof, scene.rig)
        able.append(runnable_ms() - begun)

    def both() -> None:
        able.clear()
        threads = [threading.Thread(target=work, args=(pipeline,)) for pipeline in pipelines]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    both()
    ratios, at_once = [], []
    for _ in range(rounds):
        one = timed(lambda: work(pipelines[0]))
        together = timed(both)
        ratios.append(2 * one / together)
        at_once.append(sum(able) / together)
    print(f"two threads, {preset}: {numpy.median(ratios):.2f} times the frames of one "
          f"({min(ratios):.2f} to {max(ratios):.2f}); {numpy.median(at_once):.2f} of them able to run at any time "
          f"({min(at_once):.2f} to {max(at_once):.2f})")


def main() -> None:
    times = pathlib.Path(sys.argv[1]) / "python_cpp_times"
    rounds = int(sys.argv[2]) if len(sys.argv) > 2 else 5
    what = sys.argv[3:] or ["overhead", "wrapping", "reading", "scaling"]
    sprout.set_threads(1)
    if "overhead" in what:
        for preset in ("default", "fast"):
            overhead(times, preset, rounds)
    if "wrapping" in what:
        wrapping("default")
    if "scaling" in what:
        scaling("default", rounds)
    if "reading" in what:
        with tempfile.TemporaryDirectory() as folder:
            log = str(pathlib.Path(folder) / "big.lcm")
            from big_log import write
            write(log, LOG_FRAMES)
            reading(times, log, rounds)


if __name__ == "__main__":
    main()
