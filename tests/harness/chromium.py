"""A headless Chromium for tests of report.html, driven by the DevTools protocol over a pipe.

No driver program and no socket: Chromium reads commands on file descriptor 3 and answers on 4,
messages end with a zero byte. Each browser has its own profile folder.
"""

import base64
import fcntl
import json
import os
import select
import shutil
import subprocess
import time
from pathlib import Path
from typing import Any

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome")
SOFTWARE = ("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
NO_3D = ("--disable-gpu", "--disable-3d-apis")
PATIENCE = 90.0  # s for one answer


def chromium() -> str:
    """Return the browser of this machine: $CHROMIUM, or one on PATH; skip the test without."""
    found = os.environ.get("CHROMIUM") or next(filter(None, map(shutil.which, NAMES)), None)
    if not found:
        pytest.skip("no Chromium: install it (tools/apt_install.sh chromium) or set CHROMIUM")
    return found


def _pipe() -> tuple[int, int]:
    """A pipe whose ends have numbers above 9, so that neither is 3 or 4."""
    ends = os.pipe()
    high = [fcntl.fcntl(end, fcntl.F_DUPFD_CLOEXEC, 10) for end in ends]
    for end in ends:
        os.close(end)
    return high[0], high[1]


class Browser:
    """One Chromium with one tab; use it as a context."""

    def __init__(self, profile: Path, *flags: str, dark: bool = False) -> None:
        self.events: list[dict[str, Any]] = []
        self._number, self._buffer = 0, b""
        there, self._write = _pipe()
        self._read, back = _pipe()

        def as_three_and_four() -> None:
            os.dup2(there, 3)
            os.dup2(back, 4)

        command = [
            chromium(),
            "--headless=new",
            "--no-sandbox",
            "--remote-debugging-pipe",
            "--no-first-run",
            "--hide-scrollbars",
            "--disable-background-networking",
            "--disable-component-update",
            f"--user-data-dir={profile}",
            *flags,
        ]
        self._log = open(profile.with_suffix(".log"), "wb")  # noqa: SIM115
        self._process = subprocess.Popen(
            command,
            pass_fds=(3, 4),
            preexec_fn=as_three_and_four,
            stdout=self._log,
            stderr=self._log,
        )
        os.close(there)
        os.close(back)
        self._session = ""
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        attached = self.call("Target.attachToTarget", targetId=target, flatten=True)
        self._session = attached["sessionId"]
        for domain in ("Page", "Runtime", "Network", "Log"):
            self.call(f"{domain}.enable")
        self._scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self.reduce_motion(True)
        self.size(1280, 900)

    def __enter__(self) -> "Browser":
        return self

    def __exit__(self, *_: object) -> None:
        os.close(self._write)
        try:
            self._process.wait(5)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        os.close(self._read)
        self._log.close()

    def reduce_motion(self, asked: bool) -> None:
        """Whether pages are told that the reader wants less motion: then none plays by itself."""
        motion = {"name": "prefers-reduced-motion", "value": "reduce" if asked else ""}
        self.call("Emulation.setEmulatedMedia", features=[self._scheme, motion])

    def call(self, method: str, **parameters: Any) -> dict[str, Any]:
        """Send a command; return its result."""
        self._number += 1
        message: dict[str, Any] = {"id": self._number, "method": method, "params": parameters}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._write, json.dumps(message).encode() + b"\0")
        until = time.monotonic() + PATIENCE
        while True:
            answer = self._next(until)
            if answer.get("id") == self._number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']}")
                return dict(answer["result"])
            self.events.append(answer)

    def _next(self, until: float) -> dict[str, Any]:
        while b"\0" not in self._buffer:
            left = until - time.monotonic()
            if left <= 0 or not select.select([self._read], [], [], left)[0]:
                raise TimeoutError("Chromium does not answer")
            data = os.read(self._read, 1 << 20)
            if not data:
                raise RuntimeError(f"Chromium ended; see {self._log.name}")
            self._buffer += data
        text, self._buffer = self._buffer.split(b"\0", 1)
        return dict(json.loads(text))

    def cpu_seconds(self) -> float:
        """CPU time of all processes of the browser up to now [s]."""
        parent = {}
        ticks = {}
        for stat in Path("/proc").glob("[0-9]*/stat"):
            try:
                fields = stat.read_text().rpartition(")")[2].split()
            except OSError:  # a process that has just ended
                continue
            pid = int(stat.parent.name)
            parent[pid], ticks[pid] = int(fields[1]), int(fields[11]) + int(fields[12])
        own = {self._process.pid}
        while more := {pid for pid, of in parent.items() if of in own} - own:
            own |= more
        return sum(ticks.get(pid, 0) for pid in own) / os.sysconf("SC_CLK_TCK")

    def size(self, width: int, height: int) -> None:
        """Set the size of the window in CSS pixels."""
        self.call(
            "Emulation.setDeviceMetricsOverride",
            width=width,
            height=height,
            deviceScaleFactor=1,
            mobile=False,
        )

    def open(self, page: Path, anchor: str = "") -> float:
        """Open a page and wait until it says that it is ready; return the time it took [s]."""
        began = time.monotonic()
        self.call("Page.navigate", url=page.resolve().as_uri() + anchor)
        self.wait("document.documentElement?.dataset.ready")
        return time.monotonic() - began

    def run(self, expression: str) -> Any:
        """Return the value of an expression in the page; a promise is awaited."""
        found = self.call(
            "Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True
        )
        if "exceptionDetails" in found:
            raise RuntimeError(json.dumps(found["exceptionDetails"]))
        return found["result"].get("value")

    def wait(self, expression: str, seconds: float = PATIENCE) -> Any:
        """Wait until an expression is true."""
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            found = self.run(expression)
            if found:
                return found
            time.sleep(0.02)
        raise TimeoutError(f"never true: {expression}")

    def click(self, selector: str) -> None:
        """Press the mouse in the middle of an element."""
        where = self.run(
            f"(() => {{ const e = document.querySelector({json.dumps(selector)});"
            "e.scrollIntoView({block: 'center'}); const b = e.getBoundingClientRect();"
            "return [b.x + b.width / 2, b.y + b.height / 2]; })()"
        )
        for kind in ("mousePressed", "mouseReleased"):
            self.call(
                "Input.dispatchMouseEvent",
                type=kind,
                x=where[0],
                y=where[1],
                button="left",
                clickCount=1,
            )

    def choose(self, name: str, value: str, kind: str = "change") -> None:
        """Set the value of a field by its id, as a user would."""
        self.run(
            f"(() => {{ const e = document.getElementById({json.dumps(name)});"
            f"e.value = {json.dumps(value)}; e.dispatchEvent(new Event({json.dumps(kind)})); }})()"
        )

    def shades(self, selector: str) -> list[int]:
        """Number of different byte values in each canvas: an empty one has two or three."""
        return list(
            self.run(
                f"[...document.querySelectorAll({json.dumps(selector)})].map((c) => {{"
                "const flat = document.createElement('canvas');"
                "[flat.width, flat.height] = [c.width, c.height];"
                "const pen = flat.getContext('2d'); pen.drawImage(c, 0, 0);"
                "return new Set(pen.getImageData(0, 0, c.width, c.height).data).size; })"
            )
        )

    def key(self, key: str) -> None:
        """Press and release a key."""
        for kind in ("keyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", type=kind, key=key, text=key if key == " " else "")

    def picture(self, path: Path, *, whole: bool = False) -> Path:
        """Write a PNG of the window, or of the whole page."""
        found = self.call("Page.captureScreenshot", captureBeyondViewport=whole)
        path.write_bytes(base64.b64decode(found["data"]))
        return path

    def pdf(self, path: Path) -> Path:
        """Print to PDF."""
        found = self.call("Page.printToPDF", printBackground=True)
        path.write_bytes(base64.b64decode(found["data"]))
        return path

    def errors(self) -> list[str]:
        """Texts of errors that the page has raised, its console and the browser's log."""
        found = []
        for event in self.events:
            told = event.get("params", {})
            if event["method"] == "Runtime.exceptionThrown":
                found.append(json.dumps(told["exceptionDetails"]))
            elif event["method"] == "Runtime.consoleAPICalled" and told["type"] == "error":
                found.append(json.dumps(told["args"]))
            elif event["method"] == "Log.entryAdded" and told["entry"]["level"] == "error":
                found.append(told["entry"]["text"])
        return found

    def requests(self) -> list[str]:
        """Addresses that were asked for, without what the page itself made (blob:, data:)."""
        asked = [e for e in self.events if e["method"] == "Network.requestWillBeSent"]
        urls = [event["params"]["request"]["url"] for event in asked]
        return [url for url in urls if not url.startswith(("blob:", "data:"))]
