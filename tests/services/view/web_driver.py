"""Drives Chromium by ChromeDriver's WebDriver protocol; nothing but Python's own library."""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import urllib.request

FLAGS = [
    "--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
    "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--hide-scrollbars",
]
KEYS = {"ArrowLeft": "\ue012", "ArrowRight": "\ue014", "Home": "\ue011", "End": "\ue010",
        "Escape": "\ue00c", "Shift": "\ue008"}


def require():
    """Ends the test, as skipped, where the machine lacks something to do this."""
    for program in ("chromium", "chromedriver"):
        if shutil.which(program) is None:
            print(f"skipped: {program} is missing (scripts/setup --tests installs it)")
            sys.exit(77)


def send(pid, number):
    """A signal, unless the process has ended."""
    try:
        os.kill(pid, number)
    except ProcessLookupError:
        pass


class Browser:
    """One window. Use in a with statement."""

    def __init__(self, width=1600, height=1000):
        self.size = (width, height)

    def __enter__(self):
        self.folder = tempfile.mkdtemp(prefix="sprout_view_")
        self.driver = subprocess.Popen(["chromedriver", "--port=0"], stdout=subprocess.PIPE, text=True)
        self.base = None
        for line in self.driver.stdout:
            found = re.search(r"successfully on port (\d+)", line)
            if found:
                self.base = f"http://127.0.0.1:{found.group(1)}"
                break
        flags = FLAGS + [f"--user-data-dir={self.folder}", f"--window-size={self.size[0]},{self.size[1]}"]
        options = {"args": flags}
        session = self._call("POST", "/session", {"capabilities": {"alwaysMatch": {
            "goog:chromeOptions": options, "goog:loggingPrefs": {"browser": "ALL"}}}})
        self.session = f"/session/{session['sessionId']}"
        return self

    def __exit__(self, *_):
        family = self.processes()
        try:
            self._call("DELETE", self.session)
        finally:
            for pid in family:  # a browser that hangs would outlive its driver
                send(pid, signal.SIGKILL)
            self.driver.wait()
            shutil.rmtree(self.folder, ignore_errors=True)

    def processes(self):
        """Numbers of the driver and of all processes of the browser."""
        listed = subprocess.run(["ps", "-eo", "pid=,ppid="], capture_output=True, text=True, check=True)
        parents = [tuple(map(int, line.split())) for line in listed.stdout.splitlines()]
        family = [self.driver.pid]
        for member in family:
            family += [child for child, parent in parents if parent == member]
        return family

    def _call(self, method, path, body=None):
        data = None if method != "POST" else json.dumps(body or {}).encode()
        request = urllib.request.Request(self.base + path, data=data, method=method,
                                         headers={"Content-Type": "application/json"})
        try:
            with urllib.request.urlopen(request, timeout=60) as answer:
                return json.load(answer)["value"]
        except urllib.error.HTTPError as error:
            raise RuntimeError(json.load(error)["value"]["message"]) from error

    def open(self, url):
        self._call("POST", self.session + "/url", {"url": url})

    def run(self, script, *arguments):
        """Value of a script with a return statement."""
        return self._call("POST", self.session + "/execute/sync",
                          {"script": script, "args": list(arguments)})

    def wait(self, script, seconds=30):
        """Waits until an expression is true; returns its value, false after `seconds`."""
        end = time.monotonic() + seconds
        value = False
        while not value and time.monotonic() < end:
            value = self.run(f"return {script}")
            if not value:
                time.sleep(0.05)
        return value

    def press(self, key):
        value = KEYS.get(key, key)
        actions = [{"type": kind, "value": value} for kind in ("keyDown", "keyUp")]
        self._call("POST", self.session + "/actions",
                   {"actions": [{"type": "key", "id": "keys", "actions": actions}]})

    def point(self, x, y):
        """Moves the mouse there, CSS pixels."""
        self._call("POST", self.session + "/actions", {"actions": [
            {"type": "pointer", "id": "mouse", "parameters": {"pointerType": "mouse"},
             "actions": [{"type": "pointerMove", "x": int(x), "y": int(y), "duration": 0}]}]})

    def drag(self, start, end, key=None):
        """Pulls the mouse from one place to another, CSS pixels, with a key down."""
        pause = {"type": "pause"}
        mouse = [{"type": "pointerMove", "x": int(start[0]), "y": int(start[1]), "duration": 0},
                 {"type": "pointerDown", "button": 0},
                 {"type": "pointerMove", "x": int(end[0]), "y": int(end[1]), "duration": 0},
                 {"type": "pointerUp", "button": 0}]
        keys = [pause, {"type": "keyDown", "value": KEYS.get(key, key)}, pause, pause,
                {"type": "keyUp", "value": KEYS.get(key, key)}]
        self._call("POST", self.session + "/actions", {"actions": [
            {"type": "pointer", "id": "mouse", "parameters": {"pointerType": "mouse"},
             "actions": [mouse[0], pause, *mouse[1:]]},
            {"type": "key", "id": "keys", "actions": keys if key else [pause] * 5}]})

    def devtools(self, command, **parameters):
        """A command of the DevTools protocol."""
        return self._call("POST", self.session + "/goog/cdp/execute",
                          {"cmd": command, "params": parameters})

    def freeze(self):
        """Behind other windows for long: the browser stops the page, as it does to save power."""
        self._call("POST", self.session + "/window/minimize")
        self.devtools("Page.setWebLifecycleState", state="frozen")

    def thaw(self):
        """Before them again."""
        self.devtools("Page.setWebLifecycleState", state="active")
        self._call("POST", self.session + "/window/rect", dict(zip(("width", "height"), self.size)))

    def heap_mb(self):
        """What the page's scripts hold, without what nobody needs any more."""
        self.devtools("HeapProfiler.collectGarbage")
        return self.devtools("Runtime.getHeapUsage")["usedSize"] / 2 ** 20

    def complaints(self):
        """What the page complained of in the console, but for a server that was away."""
        log = self._call("POST", self.session + "/se/log", {"type": "browser"})
        return [entry["message"] for entry in log
                if entry["level"] == "SEVERE" and "ERR_CONNECTION" not in entry["message"]]
