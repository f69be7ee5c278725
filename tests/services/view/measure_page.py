#!/usr/bin/env python3
"""What looking costs, by hand on a quiet machine, on a network of its own:

    tests/system/in_private_network tests/services/view/measure_page.py --bin build/release/bin

Prints: pictures a second in Chromium from a graph of 2 MP at 10 Hz and what was lost meanwhile; how
soon the first picture is there; the processor time of sprout-view with and without a page at 5 Hz;
and the rate of a computing graph with and without sprout-view. Takes five minutes."""

import argparse
import json
import os
import pathlib
import signal
import statistics
import subprocess
import tempfile
import time

import page_test
import web_driver

SIZE = "1624x1224"
FLAGS = ["--log-level", "warning"]


def cpu_seconds(pid):
    fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def cpu_share(pid, seconds):
    start, cpu = time.monotonic(), cpu_seconds(pid)
    time.sleep(seconds)
    return (cpu_seconds(pid) - cpu) / (time.monotonic() - start)


def make_log(programs, log):
    """Twenty whole frames of 2 MP."""
    logger = subprocess.Popen(["lcm-logger", "-q", "--max-unwritten-mb=2000",
                               "--lcm-url=udpm://239.255.76.67:7667?ttl=0&recv_buf_size=67108864", log],
                              stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    for stage in ("refine", "prior", "grow"):
        programs.start(stage, *FLAGS)
    capture = [programs.folder / "sprout-capture", "--source", f"synthetic:{SIZE}", "--frames", "20",
               "--lockstep", "1", "--wait-for", "refine,prior,grow", *FLAGS]
    subprocess.run(capture, check=True)
    time.sleep(3)
    logger.send_signal(signal.SIGINT)
    logger.wait()
    programs.stop_all()


def play(programs, log, rate, seconds):
    return subprocess.Popen([programs.folder / "play_frames", log, str(rate), str(seconds)],
                            stdout=subprocess.PIPE, text=True)


def measure_pictures(programs, log):
    programs.start("view", *FLAGS)
    page_test.wait_for_server()
    player = play(programs, log, 10, 40)
    time.sleep(3)
    # Makes one pane about 1152 px wide: a picture of 1.0 MP.
    with web_driver.Browser(1190, 1320) as browser:
        start = time.monotonic()
        browser.open(page_test.URL)
        browser.wait("window.sprout && sprout.frames > 0")
        print(f"first picture {time.monotonic() - start:.2f} s after opening")
        for pane, name in (("1", "left image"), ("2", "disparity")):
            browser.press(pane)
            time.sleep(2)
            frames, start = browser.run("return sprout.frames"), time.monotonic()
            time.sleep(6)
            rate = (browser.run("return sprout.frames") - frames) / (time.monotonic() - start)
            width, height = browser.run(
                "const c = document.querySelector('.big canvas'); return [c.width, c.height]")
            print(f"{name}: {rate:.1f} pictures a second of {width * height / 1e6:.2f} MP")
            browser.press("Escape")
        time.sleep(2)
        frames, start = browser.run("return sprout.frames"), time.monotonic()
        time.sleep(6)
        rate = (browser.run("return sprout.frames") - frames) / (time.monotonic() - start)
        print(f"all six panes: {rate:.1f} pictures a second")
        print(player.communicate()[0].strip())
        time.sleep(1.5)
        view = next(s for s in browser.run("return sprout.board.stages") if s["stage"] == "view")
        print("sprout-view: " + ", ".join(f"{name} {view[name]}" for name in (
            "frames_in", "sequence_gaps", "bad_messages", "frames_skipped")))
    programs.stop("view")


def measure_processor(programs, log):
    programs.start("view", *FLAGS)
    page_test.wait_for_server()
    pid = programs.running["view"].pid
    player = play(programs, log, 5, 45)
    time.sleep(5)
    alone = cpu_share(pid, 10)
    with web_driver.Browser() as browser:
        browser.open(page_test.URL)
        browser.wait("window.sprout && sprout.frames > 5")
        watched = cpu_share(pid, 10)
        rate = browser.run("return document.getElementById('rate').textContent")
    print(f"sprout-view at 5 Hz, of one core: {100 * alone:.1f} % without a page, "
          f"{100 * watched:.1f} % with one ({rate} frames a second): {100 * (watched - alone):.1f} % a page")
    player.communicate()
    programs.stop("view")


def frames_answered(programs):
    top = subprocess.run([programs.folder / "sprout-top", "--once", "--json", "--log-level", "error"],
                         capture_output=True, text=True)
    return next(s["frames_out"] for s in json.loads(top.stdout)["stages"] if s["stage"] == "grow")


def graph_rate(programs, seconds=10):
    """Frames a second that grow answers."""
    time.sleep(2)
    first, start = frames_answered(programs), time.monotonic()
    time.sleep(seconds)
    return (frames_answered(programs) - first) / (time.monotonic() - start)


def measure_graph(programs, rounds=4):
    """A graph that gets more frames than it can answer; in turns, since other programs come and go."""
    for stage in ("refine", "prior", "grow"):
        programs.start(stage, *FLAGS)
    programs.start("capture", "--source", f"synthetic:{SIZE}", "--lockstep", "1", "--rate", "0", *FLAGS,
                   "--wait-for", "refine,prior,grow")
    without, connected, watched = [], [], []
    for _ in range(rounds):
        without.append(graph_rate(programs))
        programs.start("view", *FLAGS)
        page_test.wait_for_server()
        connected.append(graph_rate(programs))
        with web_driver.Browser() as browser:
            browser.open(page_test.URL)
            watched.append(graph_rate(programs))
        programs.stop("view")
    programs.stop_all()
    base = statistics.median(without)
    print(f"a computing graph of {SIZE}, medians of {rounds}: {base:.2f} Hz without sprout-view")
    for rates, what in ((connected, "with it"), (watched, "with a page open in Chromium on the same machine")):
        rate = statistics.median(rates)
        print(f"  {rate:.2f} Hz {what} ({100 * (rate / base - 1):+.1f} %; {', '.join(f'{r:.2f}' for r in rates)})")
    print(f"  single ones without: {', '.join(f'{r:.2f}' for r in without)}")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--bin", type=pathlib.Path, required=True, help="folder of the programs")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        programs = page_test.Programs(options.bin.resolve(), folder)
        log = folder / "frames.lcm"
        try:
            make_log(programs, log)
            measure_pictures(programs, log)
            measure_processor(programs, log)
            measure_graph(programs)
        finally:
            programs.stop_all()


if __name__ == "__main__":
    main()
