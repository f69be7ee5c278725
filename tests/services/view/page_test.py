#!/usr/bin/env python3
"""The page of sprout-view in a real browser, with a real graph: on a network of its own only (see
in_private_network). Exit code 0 when all is as it should be, 77 where there is no Chromium."""

import argparse
import contextlib
import decimal
import json
import pathlib
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time
import urllib.request

import web_driver

PORT = 8420
URL = f"http://127.0.0.1:{PORT}/"
failures = []


def check(what, passed, detail=""):
    print(("ok     " if passed else "FAILED ") + what + (f" ({detail})" if detail else ""), flush=True)
    if not passed:
        failures.append(what)


class Programs:
    """Programs of ours, ended when the test ends."""

    def __init__(self, folder, logs):
        self.folder, self.logs, self.running = folder, logs, {}

    def start(self, name, *flags):
        with open(self.logs / f"{name}.log", "a") as log:
            self.running[name] = subprocess.Popen([self.folder / f"sprout-{name}", *flags],
                                                  stderr=log, stdout=log)

    def stop(self, name):
        program = self.running.pop(name)
        program.send_signal(signal.SIGINT)
        try:
            return program.wait(timeout=20)
        except subprocess.TimeoutExpired:
            program.kill()  # or it would outlive the test, and those behind it, too
            return program.wait()

    def stop_all(self):
        for name in list(self.running):
            self.stop(name)


def get(path):
    with urllib.request.urlopen(URL + path, timeout=20) as answer:
        return answer.read()


def start_graph(programs, source="synthetic:320x240"):
    for stage in ("refine", "prior", "grow", "temporal"):
        programs.start(stage)
    programs.start("view")
    programs.start("capture", "--source", source, "--rate", "4", "--wait-for", "refine,prior,grow,temporal,view")


def wait_for_server():
    end = time.monotonic() + 20
    while time.monotonic() < end:
        try:
            return get("")
        except OSError:
            time.sleep(0.05)
    raise RuntimeError("sprout-view does not answer")


def open_log(browser, programs, log, *flags):
    """The page of a log, instead of what sprout-view showed before."""
    programs.stop("view")
    programs.start("view", "--log", log, *flags)
    wait_for_server()
    browser.open(URL)


def picture(browser, pane):
    """What a pane shows, as a text that changes with it."""
    return browser.run("return document.querySelector(arguments[0]).toDataURL()", f".{pane} canvas")


def check_pictures(browser):
    start = time.monotonic()
    browser.open(URL)
    shown = browser.wait("window.sprout && sprout.frames > 0")
    check("a first picture", shown, f"{time.monotonic() - start:.2f} s after opening")
    check("every pane has its picture", browser.wait(
        "sprout.head.parts.map(part => part.name).sort().join() == "
        "'cloud,confidence,disparity,left,prior,seeds,tof'"),
        browser.run("return sprout.head.parts.map(part => part.name).join()"))
    before = picture(browser, "left")
    frames = browser.run("return sprout.frames")
    check("frames follow each other", browser.wait(f"sprout.frames > {frames + 3}"))
    check("pictures change", picture(browser, "left") != before)
    check("the cloud has points", browser.wait("sprout.cloud.points > 10000"),
          browser.run("return sprout.cloud.points"))
    colors = browser.run("""
        sprout.cloud.render();
        const canvas = document.createElement('canvas');
        [canvas.width, canvas.height] = [64, 64];
        const context = canvas.getContext('2d');
        context.drawImage(sprout.cloud.renderer.domElement, 0, 0, 64, 64);
        return new Set(new Uint32Array(context.getImageData(0, 0, 64, 64).data.buffer)).size;""")
    check("the cloud is drawn", colors > 100, f"{colors} colours")


def check_looking(browser):
    browser.press(" ")
    browser.wait("!sprout.playing")
    time.sleep(0.5)
    key, frames = browser.run("return [sprout.key, sprout.frames]")
    time.sleep(1.5)
    check("pausing stops the pictures", browser.run("return sprout.frames") == frames)
    for _ in range(2):
        browser.press("ArrowLeft")
    check("a step goes one frame back", browser.wait(f"sprout.key == {key - 2}"))
    browser.press("ArrowRight")
    check("and one on", browser.wait(f"sprout.key == {key - 1}"))
    browser.press("f")
    check("the fused map is beside the single one", browser.wait(
        "document.querySelector('.prior h2 span').textContent == 'Fused disparity' && "
        "sprout.head.parts.some(part => part.name == 'fused')"))
    browser.press("f")
    return key - 1


def check_sigma(browser):
    before = picture(browser, "confidence")
    browser.press("o")
    check("the standard deviation of the disparity takes the confidence's place", browser.wait(
        "sprout.head.parts.some(part => part.name == 'disparity_sigma') && "
        "document.querySelector('.confidence h2').textContent.startsWith('Standard deviation')"))
    check("and is another picture", picture(browser, "confidence") != before)
    browser.press("o")
    check("and goes again", browser.wait(
        "sprout.head.parts.some(part => part.name == 'confidence') && "
        "document.querySelector('.confidence h2').textContent.startsWith('Confidence')"))


def check_pixel(browser, key):
    box = browser.run("""
        const box = document.querySelector('.disparity .view').getBoundingClientRect();
        return [box.left, box.top, box.width, box.height];""")
    browser.point(box[0] + box[2] / 2, box[1] + box[3] / 2)
    probe = browser.wait("sprout.hover.shown && sprout.hover.shown.key == sprout.key && sprout.hover.shown")
    check("the pixel under the mouse is told", bool(probe) and "disparity_px" in probe and
          "seed" in probe and "sigma_px" in probe and "confidence" in probe and "disparity_sigma_px" in probe, json.dumps(probe))
    header, size, _, pixels = get(f"save?key={key}&what=disparity.pfm").split(b"\n", 3)
    width, height = map(int, size.split())
    row = height - 1 - probe["v"]
    expected = struct.unpack_from("<f", pixels, 4 * (row * width + probe["u"]))[0]
    check("with the disparity that is saved", header == b"Pf" and expected == probe["disparity_px"], expected)


def check_saving(browser, programs, folder):
    offered = browser.run("""
        document.getElementById('save').click();
        const files = [...document.querySelectorAll('#save-frame a')].map((link) => link.textContent);
        document.getElementById('save-box').close();
        return files;""")
    check("what a frame of the whole graph has is offered", len(offered) == 9, offered)
    check("seconds are asked for", browser.run("return document.getElementById('seconds').required"))
    log = folder / "saved.lcm"
    log.write_bytes(get("save-log?seconds=3"))
    said = subprocess.run([programs.folder / "sprout-log", "info", "--json", log], capture_output=True, text=True)
    info = json.loads(said.stdout or '{"channels": []}')
    undecodable = {channel["name"]: channel["undecodable"] for channel in info["channels"]}
    # Frames may be missing: a busy machine skips some.
    check("the last seconds are a good log", info.get("damage") == [] and "SPROUT_DISPARITY" in undecodable and
          not any(undecodable.values()), said.stderr.strip())


def fixed(value, digits):
    """Text of a number as JavaScript's toFixed() writes it. Python's formats round halves to the
    even digit, 12.5 to 12, JavaScript away from zero, to 13."""
    return str(decimal.Decimal(value).quantize(decimal.Decimal(1).scaleb(-digits), decimal.ROUND_HALF_UP))


def numbers_of(stage, board):
    """What the row of a stage must say."""
    status = board[stage]
    lost = sum(status[f"frames_{kind}"] for kind in ("skipped", "incomplete", "failed", "degenerate"))
    lost += status["sequence_gaps"]
    return [str(status["frames_out"]), fixed(status["rate_hz"], 1),
            f"{fixed(status['age_p50_ms'], 0)} / {fixed(status['age_p99_ms'], 0)}", str(lost),
            str(status["bad_messages"]), fixed(status["rss_bytes"] / 2 ** 20, 0)]


def check_numbers(browser, programs):
    """The table against sprout-top, once the graph stands still."""
    browser.press("End")
    check("the graph is followed again", browser.wait("sprout.playing"))
    programs.stop("capture")
    time.sleep(2.5)
    for stage in ("refine", "prior", "grow", "view"):
        # The rate changes for a while, and both read it at different moments.
        for _ in range(6):
            top = subprocess.run([programs.folder / "sprout-top", "--once", "--json", "--log-level", "error"],
                                 capture_output=True, text=True)
            board = {status["stage"]: status for status in json.loads(top.stdout)["stages"]}
            row = browser.run("""
                const row = document.querySelector(`#stages tr[data-stage=${arguments[0]}]`);
                const text = (name) => row.querySelector(name).textContent;
                return [text('.frames'), ...[...row.querySelectorAll('.plot span')].map((span) => span.textContent)];
                """, stage)
            expected = numbers_of(stage, board)
            # Memory may change by a page from one second to the next.
            same = row[:5] == expected[:5] and abs(int(row[5]) - int(expected[5])) <= 2
            if same:
                break
        check(f"the numbers of {stage} are those of its status", same, f"{row} and {expected}")


def check_phone(browser):
    browser.devtools("Emulation.setDeviceMetricsOverride", width=390, height=844, deviceScaleFactor=1, mobile=True)
    check("a phone shows the whole width", browser.wait("innerWidth == 390 && document.body.scrollWidth <= 390"),
          browser.run("return [innerWidth, document.body.scrollWidth]"))
    check("nothing in its header lies over another", browser.run("""
        const boxes = [...document.querySelectorAll('header > *')].map((e) => e.getBoundingClientRect());
        return boxes.every((a, i) => boxes.every((b, k) => i === k ||
            a.left >= b.right || b.left >= a.right || a.top >= b.bottom || b.top >= a.bottom));"""))
    browser.devtools("Emulation.clearDeviceMetricsOverride")


def check_coming_back(browser, programs):
    check("a picture that no other follows grows older",
          browser.wait("Number(document.getElementById('age').textContent) > 4000", 10))
    programs.start("capture", "--source", "synthetic:320x240", "--rate", "4")
    check("sprout-view ends when it is told to", programs.stop("view") == 0)
    check("the page says that nobody answers",
          browser.wait("document.body.classList.contains('stale') && !document.getElementById('banner').hidden"))
    programs.start("view")
    frames = browser.run("return sprout.frames")
    check("the page comes back by itself", browser.wait(f"sprout.frames > {frames + 3}"))


def check_page(browser):
    foreign = browser.run("""
        return performance.getEntriesByType('resource').map((entry) => entry.name)
            .filter((name) => !name.startsWith(location.origin) && !name.startsWith('blob:'));""")
    check("nothing comes from elsewhere", foreign == [], foreign)
    complaints = browser.complaints()
    check("nothing to complain of in the console", complaints == [], complaints)


def check_too_many(browser):
    """More pages than sprout-view takes."""
    browser.open("about:blank")
    request = (f"GET /ws HTTP/1.1\r\nHost: 127.0.0.1:{PORT}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
               "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n").encode()
    with contextlib.ExitStack() as others:
        answer = b""
        while b" 503 " not in answer:
            other = others.enter_context(socket.create_connection(("127.0.0.1", PORT), timeout=20))
            other.sendall(request)
            answer = other.recv(64)
        browser.open(URL)
        banner = "document.getElementById('banner').textContent"
        check("a page too many says so", browser.wait(f"window.sprout && {banner}.includes('too many pages are open')"),
              browser.run(f"return {banner}"))
    check("and is taken when there is room", browser.wait("sprout.frames > 0"))
    browser.complaints()  # those of a page that was refused


def check_log(browser, programs, log):
    programs.stop("view")
    programs.start("view", "--log", log)
    check("a log, in a page that showed the graph, shows its first frame", browser.wait("window.sprout && sprout.isLog && sprout.key == 0 && sprout.frames > 0"))
    room = "return [document.getElementById('panes').getBoundingClientRect().right, innerWidth]"
    right, width = browser.run(room)
    check("without statuses the pictures take their room", width >= 1300 and width - right < 20, (right, width))
    check("its time line is rated", browser.wait("sprout.timeLine.line && sprout.timeLine.line.settled"))
    buckets = browser.run("return sprout.timeLine.line.buckets")
    check("every stretch has a quality", len(buckets) > 1 and all("quality" in bucket for bucket in buckets))
    check("thumbnails are there", browser.wait("[...sprout.timeLine.images.values()].some((i) => i.naturalWidth > 0)"))
    browser.press("ArrowRight")
    check("a step goes on", browser.wait("sprout.key == 1"))
    browser.press(" ")
    check("it plays to its end", browser.wait("sprout.key == sprout.keys[1] && !sprout.playing"))


def drag_region(browser, share, key=None):
    """Draws a rectangle on the disparity map, from one share of its size to another."""
    x, y, width, height = browser.run("""
        const pane = sprout.panes.panes.get('disparity');
        const box = pane.view.getBoundingClientRect();
        const [x, y, width, height] = sprout.panes.frameOf(pane);
        return [box.left + x, box.top + y, width, height];""")
    browser.drag((x + share[0] * width, y + share[1] * height),
                 (x + share[2] * width, y + share[3] * height), key)


def check_measuring(browser, programs, log):
    """The panel of a flat target, with the log open, against sprout-quality."""
    browser.press("Home")
    browser.wait("sprout.key == 0")
    browser.press("m")
    shown = browser.wait("sprout.target.shown")
    right, width = browser.run("return [document.getElementById('panes').getBoundingClientRect().right, innerWidth]")
    check("the panel of the target has its room", 400 < width - right < 600, (right, width))
    check("the middle is measured first", bool(shown) and shown["region"] == [32, 24, 64, 48], shown)
    drag_region(browser, (0.1, 0.2, 0.6, 0.7))
    region = browser.wait("sprout.target.region && sprout.target.shown && "
                          "sprout.target.shown.region.join() == sprout.target.region.join() && sprout.target.region")
    near = bool(region) and all(abs(is_at - should) <= 2 for is_at, should in zip(region, (12, 19, 65, 49)))
    check("the mouse draws a region", near, region)
    browser.run("""
        const input = document.getElementById('target-distance');
        input.value = 2;
        input.dispatchEvent(new Event('change'));""")
    check("the true distance is asked for", browser.wait(
        "sprout.target.shown.figures.some((figure) => figure.name == 'z_accuracy_percent')"))
    seq = browser.run("return sprout.head.seq")
    said = subprocess.run([programs.folder / "sprout-quality", log, "--frames", str(seq), "--distance-m", "2",
                           "--region", ",".join(map(str, region or [0, 0, 9, 9]))], capture_output=True, text=True)
    rows = browser.run("""
        return [...document.querySelectorAll('#target-figures tr')].map((row) => [...row.cells].map((cell) => cell.textContent));""")
    missing = [row for row in rows if " ".join(row) not in " ".join(said.stdout.split())]
    check("the figures are those of sprout-quality", len(rows) > 8 and not missing, f"{missing} {said.stderr}")
    drag_region(browser, (0.3, 0.3, 0.9, 0.8), "Shift")
    check("with Shift it draws an edge", browser.wait("sprout.target.shown.edge && sprout.target.shown.edge[2] > 60"),
          browser.run("return sprout.target.shown"))
    browser.press("ArrowRight")
    check("frames come together", browser.wait("sprout.target.shown.frames == 2"))
    lines = browser.run("""
        const mark = sprout.panes.panes.get('disparity').mark;
        return mark.getContext('2d').getImageData(0, 0, mark.width, mark.height).data.some((value) => value > 0);""")
    check("the region is on the picture", lines)
    browser.press("m")
    check("it goes away", browser.run("return document.getElementById('target').hidden"))


def check_log_at_frame(browser, programs, log, seq):
    open_log(browser, programs, log, "--frame", str(seq))
    check("a log opens at the frame that is asked for", browser.wait(f"window.sprout && sprout.frames > 0 && sprout.head.seq == {seq}"))
    browser.press("ArrowLeft")
    check("and stays a log to step through", browser.wait(f"sprout.head.seq == {seq - 1}"))
    open_log(browser, programs, log, "--frame", "987654")
    check("a frame that is not there is said to be missing", browser.wait(
        "document.getElementById('banner').textContent.includes('no frame 987654')"))


def check_answers_alone(browser, programs, log, folder):
    """The log of a replay has neither images nor calibration."""
    seeds = folder / "seeds.lcm"
    subprocess.run([programs.folder / "sprout-refine", "--replay", log, "--record", seeds], check=True)
    open_log(browser, programs, seeds)
    browser.wait("window.sprout && sprout.key == 0 && sprout.frames > 0")
    browser.press("ArrowRight")
    check("a log without images can be stepped through", browser.wait("sprout.key == 1"))
    browser.complaints()  # there are no thumbnails


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--bin", type=pathlib.Path, required=True, help="folder of the programs")
    parser.add_argument("--log", type=pathlib.Path, required=True, help="a log with whole frames")
    options = parser.parse_args()
    web_driver.require()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        programs = Programs(options.bin.resolve(), folder)
        try:
            start_graph(programs)
            wait_for_server()
            with web_driver.Browser() as browser:
                check_pictures(browser)
                check_pixel(browser, check_looking(browser))
                check_sigma(browser)
                check_phone(browser)
                check_saving(browser, programs, folder)
                check_numbers(browser, programs)
                check_coming_back(browser, programs)
                check_page(browser)
                check_too_many(browser)
                check_log(browser, programs, options.log.resolve())
                check_measuring(browser, programs, options.log.resolve())
                check_log_at_frame(browser, programs, options.log.resolve(), seq=3)
                check_page(browser)
                check_answers_alone(browser, programs, options.log.resolve(), folder)
        finally:
            programs.stop_all()
        if failures:
            for log in sorted(folder.glob("*.log")):
                print(f"--- {log.name}\n{log.read_text()[-3000:]}")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
