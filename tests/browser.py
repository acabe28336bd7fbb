"""A browser for tests: Chromium, driven by its DevTools protocol over a pipe; nothing but the standard library."""

import base64
import contextlib
import json
import os
import select
import shutil
import subprocess
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

CHROMIUM = next(
    (path for name in ("chromium", "chromium-browser", "google-chrome") if (path := shutil.which(name))), None
)
OPTIONS = (
    *("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--hide-scrollbars"),
    *("--no-first-run", "--disable-extensions", "--disable-background-networking", "--disable-sync", "--mute-audio"),
    *("--disable-component-update", "--force-color-profile=srgb", "--remote-debugging-pipe", "about:blank"),
)


class Browser:
    """A running browser with one page; everything that the page says or asks for is kept in `events`."""

    def __init__(self, folder: Path):
        self._in, child_out = os.pipe()
        child_in, self._out = os.pipe()
        self._rest, self._last, self.events = b"", 0, []

        def place() -> None:  # the browser reads from 3 and writes to 4
            one, two = os.dup(child_in), os.dup(child_out)
            os.dup2(one, 3)
            os.dup2(two, 4)

        assert CHROMIUM is not None
        command = [CHROMIUM, *OPTIONS[:-1], f"--user-data-dir={folder}", OPTIONS[-1]]
        quiet = subprocess.DEVNULL
        self.process = subprocess.Popen(
            command, preexec_fn=place, close_fds=False, stdin=quiet, stdout=quiet, stderr=quiet, start_new_session=True
        )
        os.close(child_in)
        os.close(child_out)
        self.session = None
        targets = self("Target.getTargets")["targetInfos"]
        target = next(target["targetId"] for target in targets if target["type"] == "page")
        self.session = self("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Network", "Log"):
            self(f"{domain}.enable")

    def __call__(self, method: str, **parameters: Any) -> dict[str, Any]:
        """Send a command and wait for its result."""
        self._last += 1
        message: dict[str, Any] = {"id": self._last, "method": method, "params": parameters}
        if self.session is not None:
            message["sessionId"] = self.session
        os.write(self._out, json.dumps(message).encode() + b"\0")
        number = self._last
        while True:
            found = self._message(30.0)
            if found.get("id") == number:
                assert "error" not in found, (method, found["error"])
                return found["result"]
            self.events.append(found)

    def _message(self, seconds: float) -> dict[str, Any]:
        until = time.monotonic() + seconds
        while b"\0" not in self._rest:
            ready, _, _ = select.select([self._in], [], [], max(0.0, until - time.monotonic()))
            assert ready, "the browser does not answer"
            got = os.read(self._in, 1 << 20)
            assert got, "the browser has ended"
            self._rest += got
        first, _, self._rest = self._rest.partition(b"\0")
        return json.loads(first)

    def open(self, url: str, width: int = 1280, height: int = 900, dark: bool = False) -> None:
        """Open a page at a size."""
        self("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=width < 500)
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self("Emulation.setEmulatedMedia", features=[scheme])
        self("Page.navigate", url="about:blank")
        self("Page.navigate", url=url)

    def js(self, expression: str) -> Any:
        """The value of an expression in the page; promises are waited for."""
        settings = {"expression": expression, "returnByValue": True, "awaitPromise": True}
        found = self("Runtime.evaluate", **settings)
        assert "exceptionDetails" not in found, found["exceptionDetails"]
        return found["result"].get("value")

    def wait(self, expression: str, seconds: float = 30.0) -> Any:
        """Wait until an expression of the page is true; its value."""
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            found = self.js(f"(() => {{ try {{ return {expression}; }} catch (error) {{ return null; }} }})()")
            if found:
                return found
            time.sleep(0.03)
        raise AssertionError(f"not within {seconds} s: {expression}")

    def key(self, key: str, text: str = "") -> None:
        """Press and release a key."""
        code = {"ArrowRight": 39, "ArrowLeft": 37, "ArrowUp": 38, "ArrowDown": 40, "Tab": 9, "Enter": 13}.get(key, 0)
        more = {"text": text} if text else {}
        self("Input.dispatchKeyEvent", type="keyDown", key=key, code=key, windowsVirtualKeyCode=code, **more)
        self("Input.dispatchKeyEvent", type="keyUp", key=key, code=key, windowsVirtualKeyCode=code)

    def mouse(self, kind: str, x: float, y: float) -> None:
        """kind: mousePressed, mouseMoved or mouseReleased"""
        self("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", buttons=1, clickCount=1)

    def click(self, x: float, y: float) -> None:
        """Press and release the mouse."""
        self.mouse("mousePressed", x, y)
        self.mouse("mouseReleased", x, y)

    def picture(self, path: Path, whole: bool = True) -> Path:
        """A picture of the page, or of what is seen of it."""
        size = self("Page.getLayoutMetrics")["cssContentSize"]
        clip = {"x": 0, "y": 0, "width": size["width"], "height": size["height"], "scale": 1}
        settings = {"clip": clip, "captureBeyondViewport": True} if whole else {}
        path.write_bytes(base64.b64decode(self("Page.captureScreenshot", format="png", **settings)["data"]))
        return path

    def complaints(self) -> list[str]:
        """What the console said at the level of warnings and errors, uncaught exceptions, and requests to a network."""
        texts = []
        for event in self.events:
            method, given = event.get("method"), event.get("params", {})
            if method == "Runtime.exceptionThrown":
                texts.append(str(given["exceptionDetails"]))
            elif method == "Runtime.consoleAPICalled" and given["type"] in ("error", "warning", "assert"):
                texts.append(str(given["args"]))
            elif method == "Log.entryAdded" and given["entry"]["level"] in ("error", "warning"):
                texts.append(str(given["entry"]))
            elif method == "Network.requestWillBeSent":
                url = given["request"]["url"]
                if not url.startswith(("file:", "blob:", "data:", "about:")):
                    texts.append(f"asked for {url}")
        return texts

    def close(self) -> None:
        """End the browser."""
        with contextlib.suppress(Exception):
            self.session = None
            self("Browser.close")
        with contextlib.suppress(subprocess.TimeoutExpired):
            self.process.wait(10)
        if self.process.poll() is None:
            self.process.kill()
            self.process.wait()
        os.close(self._in)
        os.close(self._out)


@contextlib.contextmanager
def browser() -> Iterator[Browser]:
    """A browser for the `with` block."""
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        found = Browser(Path(folder))
        try:
            yield found
        finally:
            found.close()
