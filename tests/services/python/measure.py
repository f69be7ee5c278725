#!/usr/bin/python3
"""What Python costs, beside C++ and in the same run: tables for services/python/NOTES.md.

    PYTHONPATH=build/release/python tests/services/python/measure.py build/release/bin [ROUNDS]

Needs build/release/bin/python_cpp_times (target python_cpp_times). In turns, C++ and Python, medians of
ROUNDS (5) pairs: compute() on synthetic:1624x1224 with one thread, frames of a log, two threads.
"""
import pathlib
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


def cpp(program: pathlib.Path, *arguments: str) -> List[float]:
    return [float(word) for word in subprocess.check_output([program, *arguments], text=True).split()]


def timed(work: Callable[[], object]) -> float:
    begun = time.perf_counter()
    work()
    return 1000 * (time.perf_counter() - begun)


def overhead(times: pathlib.Path, preset: str, rounds: int) -> None:
    scene = sprout.Dataset(SOURCE)[0]
    pipeline = sprout.Pipeline(preset)
    pipeline.compute(scene.left, scene.right, scene.tof, scene.rig)
    ours, theirs = [], []
    for _ in range(rounds):
        theirs += cpp(times, "compute", SOURCE, preset, str(FRAMES + 1))[1:]
        ours += [timed(lambda: pipeline.compute(scene.left, scene.right, scene.tof, scene.rig))
                 for _ in range(FRAMES)]
    print(f"compute, {preset}: C++ {numpy.median(theirs):.1f} ms (least {min(theirs):.1f}), Python "
          f"{numpy.median(ours):.1f} ms (least {min(ours):.1f}): overhead "
          f"{100 * (numpy.median(ours) / numpy.median(theirs) - 1):+.1f} %, of the least "
          f"{100 * (min(ours) / min(theirs) - 1):+.1f} %")


def wrapping(preset: str) -> None:
    """What the module itself does at 2 MP: a pipeline that finds nothing would be no measure, so the same
    conversions, without the computation."""
    scene = sprout.Dataset(SOURCE)[0]
    left, right, tof, rig = scene.left, scene.right, scene.tof.depth_m, scene.rig
    frame = sprout.Pipeline(preset).compute(left, right, tof, rig)
    arrays = [timed(lambda: (sprout.Tof(tof), frame.left, frame.depth_m, frame.confidence, frame.seeds))
              for _ in range(50)]
    maps = [timed(lambda: (frame.disparity,)) for _ in range(50)]
    print(f"arrays of a frame: {numpy.median(arrays):.3f} ms; disparity in px: {numpy.median(maps):.1f} ms")


def reading(times: pathlib.Path, log: str, rounds: int) -> None:
    ours, theirs = [], []
    for _ in range(rounds):
        theirs += cpp(times, "read", log)
        count = len(list(sprout.Log(log).frames(["rig"]))) or len(sprout.Log(log))
        ours.append(timed(lambda: [None for _ in sprout.Log(log).frames()]) / count)
    print(f"read: C++ {numpy.median(theirs):.3f} ms a frame, Python {numpy.median(ours):.3f}: "
          f"{numpy.median(theirs) / numpy.median(ours):.2f} times as fast")


def scaling(preset: str, rounds: int) -> None:
    scene = sprout.Dataset(SOURCE)[0]
    pipelines = [sprout.Pipeline(preset) for _ in range(2)]

    def work(pipeline: sprout.Pipeline) -> None:
        for _ in range(FRAMES):
            pipeline.compute(scene.left, scene.right, scene.tof, scene.rig)

    def both() -> None:
        threads = [threading.Thread(target=work, args=(pipeline,)) for pipeline in pipelines]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    both()
    ratios = [2 * timed(lambda: work(pipelines[0])) / timed(both) for _ in range(rounds)]
    print(f"two threads, {preset}: {numpy.median(ratios):.2f} times the frames of one "
          f"({min(ratios):.2f} to {max(ratios):.2f})")


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
            write(log, 40)
            reading(times, log, rounds)


if __name__ == "__main__":
    main()
