#!/usr/bin/env python3
"""The page of sprout-view when it, its browser or its connection sleeps while the graph runs at 10 Hz:
nothing may pile up, and the newest frame must be back. On a network of its own only
(see in_private_network). Exit code 0 when all is as it should be, 77 where there is no Chromium."""

import argparse
import contextlib
import os
import pathlib
import signal
import socket
import sys
import tempfile
import threading
import time

import web_driver
from page_test import PORT, URL, Programs, check, failures, wait_for_server

RELAY_PORT = 8421


class Relay:
    """Passes connections on to sprout-view. cut() kills those there are, and nobody is told."""

    def __init__(self):
        self.alive = object()  # another one after each cut
        self.listener = socket.create_server(("127.0.0.1", RELAY_PORT))
        threading.Thread(target=self._accept, daemon=True).start()

    def cut(self):
        self.alive = object()

    def _accept(self):
        while True:
            near, _ = self.listener.accept()
            far = socket.create_connection(("127.0.0.1", PORT))
            for ends in ((near, far), (far, near)):
                threading.Thread(target=self._pass, args=(*ends, self.alive), daemon=True).start()

    def _pass(self, source, target, alive):
        with contextlib.suppress(OSError):  # one of both hung up
            while data := source.recv(65536):
                if self.alive is alive:
                    target.sendall(data)
            if self.alive is alive:
                target.shutdown(socket.SHUT_WR)


def resident_mb(pid):
    pages = int(pathlib.Path(f"/proc/{pid}/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGESIZE") / 2 ** 20


def check_sleep(what, browser, programs, times, asleep, awake):
    """@param times  to sleep, and until the newest frame must be back, s.
    @param asleep, awake  functions that begin and end the sleep."""
    sleep, soon = times
    view = programs.running["view"].pid
    browser.wait("sprout.frames > 5")
    before, heap = resident_mb(view), browser.heap_mb()
    asleep()
    try:
        time.sleep(sleep)
        during = resident_mb(view)
    finally:
        awake()
    start = time.monotonic()
    # Waits for a frame that was captured when the page was awake again.
    woken = time.time()
    back = browser.wait(f"sprout.head.utime > {int(1e6 * woken)}", seconds=2 * soon)
    took = time.monotonic() - start
    check(f"{what}: the newest frame is back", back and took < soon, f"after {took:.2f} s")
    frames = browser.run("return sprout.frames")
    check(f"{what}: and others follow", browser.wait(f"sprout.frames > {frames + 10}", seconds=10))
    # The ring of sprout-view grows until it has 100 frames; what a page leaves unread comes beside it.
    check(f"{what}: sprout-view does not grow", during - before < 20, f"{before:.0f} MB, {during:.0f} MB")
    now = browser.heap_mb()
    check(f"{what}: the page does not grow", now - heap < 20, f"{heap:.1f} MB, {now:.1f} MB")


def check_backlog(browser):
    """A page that wakes finds the statuses of a minute."""
    browser.run("""
        const fill = sprout.plots.fillRow;
        window.filled = 0;
        sprout.plots.fillRow = function(...row) { ++window.filled; fill.apply(this, row); };
        for (let i = 1; i <= 60; ++i) {
          sprout.status({...sprout.statusMessage, utime: sprout.statusMessage.utime + 1e6});
        }""")
    browser.wait("filled > 0")
    filled, stages = browser.run("return [filled, sprout.board.stages.length]")
    # Other frames may have come meanwhile.
    check("of a minute of statuses the newest is drawn", filled <= 5 * stages, f"{filled} rows of {stages}")


def check_cut(browser, relay):
    browser.open(f"http://127.0.0.1:{RELAY_PORT}/")
    check("a page through a relay", browser.wait("window.sprout && sprout.frames > 5"))
    relay.cut()
    start = time.monotonic()
    # Waits for a frame that was captured too late to have been on its way.
    back = browser.wait(f"sprout.head.utime > {int(1e6 * (time.time() + 1))}", seconds=20)
    check("a dead connection is noticed and made anew", back, f"{time.monotonic() - start:.1f} s")


def run(browser, programs, times):
    browser.open(URL)
    browser.wait("window.sprout && sprout.frames > 0")
    # The ring is full, and every picture was painted: what comes now is what sleep costs.
    browser.wait("sprout.keys[1] - sprout.keys[0] >= 99", seconds=60)
    check_sleep("a frozen page", browser, programs, times, browser.freeze, browser.thaw)
    browser_processes = browser.processes()[1:]

    def stop_and_go(number):
        for pid in browser_processes:
            web_driver.send(pid, number)
    check_sleep("a stopped browser", browser, programs, times,
                lambda: stop_and_go(signal.SIGSTOP), lambda: stop_and_go(signal.SIGCONT))
    check_backlog(browser)
    check_cut(browser, Relay())
    # That a page which is stopped loses its connection is as it should be.
    complaints = [text for text in browser.complaints() if "Back-Forward Cache" not in text]
    check("nothing to complain of in the console", complaints == [], complaints)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--bin", type=pathlib.Path, required=True, help="folder of the programs")
    parser.add_argument("--sleep", type=float, default=10, help="how long, s")
    parser.add_argument("--soon", type=float, default=10,
                        help="until the newest frame must be back, s; on a quiet machine 1 is enough")
    options = parser.parse_args()
    web_driver.require()
    with tempfile.TemporaryDirectory() as name:
        programs = Programs(options.bin.resolve(), pathlib.Path(name))
        try:
            programs.start("view")
            programs.start("capture", "--source", "synthetic:640x480", "--rate", "10", "--wait-for", "view")
            wait_for_server()
            with web_driver.Browser() as browser:
                run(browser, programs, (options.sleep, options.soon))
        finally:
            programs.stop_all()
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
