#!/usr/bin/env python3
"""Modules of sprout-view's page by themselves, in a real browser, with a server that is none: no
graph is needed. Exit code 0 when all is as it should be, 77 where there is no Chromium."""

import functools
import http.server
import pathlib
import sys
import threading

import web_driver
from page_test import check, failures

PAGE = pathlib.Path(__file__).resolve().parents[3] / "services" / "view" / "page"
FULL = "too many pages are open: allowed are 16"


class Files(http.server.SimpleHTTPRequestHandler):
    """The files of the page, and an empty page to import them in."""

    refuses = True  # at /ws

    def do_GET(self):
        if self.path == "/ws":
            upgrade = "Upgrade" in self.headers
            return self.answer(503 if self.refuses else 400 if upgrade else 200, FULL + "\n")
        if self.path == "/empty":
            return self.answer(200, "<!doctype html><body></body>")
        return super().do_GET()

    def answer(self, status, text):
        self.send_response(status)
        self.send_header("Content-Type", "text/html")
        self.send_header("Content-Length", str(len(text)))
        self.end_headers()
        self.wfile.write(text.encode())

    def log_message(self, *_):
        pass


# A board of one stage, and what the page shows of it; scripts of the checks begin with this.
PLOTS = """
    const {Plots} = await import('/plots.js');
    const plots = new Plots(document.body.appendChild(document.createElement('div')));
    plots.start({}, false);
    const status = (extra) => ({stage: 'grow', host: 'robot', pid: 7, health: 'good', rate_hz: 10, age_p50_ms: 80,
        age_p99_ms: 90, rss_bytes: 2 ** 20, bad_messages: 0, frames_out: 1, frames_skipped: 0, frames_incomplete: 0,
        frames_failed: 0, frames_degenerate: 0, sequence_gaps: 0, ...extra});
    const drawn = () => new Promise((resolve) => requestAnimationFrame(() => requestAnimationFrame(resolve)));
    const update = (seconds, extra = {}) => plots.update({stages: [status(extra)]}, seconds);
    const text = (name) => plots.root.querySelector(name).textContent;
"""


def run(browser, script):
    """Value of a script that may wait."""
    return browser.run("return (async () => {" + script + "})()")


def check_plots(browser):
    lost = run(browser, PLOTS + """
        update(1, {frames_skipped: 1, frames_incomplete: 20, frames_failed: 300, frames_degenerate: 4000,
                   sequence_gaps: 50000});
        await drawn();
        return [text('.lost span'), plots.courses.grow.lost];""")
    check("frames are counted that were lost in any way", lost == ["54321", [54321]], lost)
    frames = run(browser, PLOTS + """
        // What a status without a rate does; the browser tells of it in the console.
        plots.board = {stages: [status({rate_hz: null})]};
        try { plots.show(); } catch (error) { }
        update(2, {frames_out: 77});
        await drawn();
        return text('.frames');""")
    check("a board that cannot be drawn does not stop the next one", frames == "77", frames)
    remark = run(browser, PLOTS + """
        plots.update({configurations: 'configurations differ', stages: [status()]}, 1);
        await drawn();
        return text('p');""")
    check("a board's remark is shown below it", remark == "configurations differ", remark)
    times = run(browser, PLOTS + """
        for (const seconds of [100, 100.1, 101, 102, 50, 51, 50]) update(seconds, {rate_hz: seconds});
        const {t, rate_hz, lost} = plots.courses.grow;
        return [t, rate_hz, lost.length];""")
    check("plots go on when the clock was set back", times == [[50], [50], 1], times)


def check_refusal(browser):
    said = """
        const {Connection} = await import('/connection.js');
        const said = await new Promise((resolve) => {
          const connection = new Connection({
            open: () => resolve('open'), closed: () => resolve('closed'), refused: (why) => resolve(why)});
          connection.watch = () => {};
        });
        return said;"""
    Files.refuses = True
    check("a page that is refused is told why", run(browser, said) == FULL)
    Files.refuses = False
    check("what else goes wrong is no answer", run(browser, said) == "closed")


def check_saving(browser):
    offered = run(browser, """
        sprout.head = {channels: ['SPROUT_LEFT', 'SPROUT_RIG', 'SPROUT_SIGMA', 'SPROUT_CONFIDENCE']};
        document.getElementById('save').click();
        return [...document.querySelectorAll('#save-frame a')].map((link) => link.textContent);""")
    check("files are offered that the frame has", offered == ["left.png", "confidence.png", "sigma.pfm"], offered)


def main():
    web_driver.require()
    handler = functools.partial(Files, directory=PAGE)
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        try:
            with web_driver.Browser() as browser:
                browser.open(f"http://127.0.0.1:{server.server_port}/empty")
                check_plots(browser)
                check_refusal(browser)
                browser.open(f"http://127.0.0.1:{server.server_port}/index.html")
                check_saving(browser)
        finally:
            server.shutdown()
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
