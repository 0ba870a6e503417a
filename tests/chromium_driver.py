"""A small driver for headless Chromium: the DevTools protocol over its debugging pipe, nothing to install."""

from __future__ import annotations

import base64
import json
import os
import select
import shutil
import subprocess
import sys
import time
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

_NAMES = ("chromium", "chromium-browser", "google-chrome", "chrome")
_FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--hide-scrollbars",
    "--disable-background-networking", "--disable-component-update", "--disable-sync", "--disable-extensions",
    "--remote-debugging-pipe",
)  # fmt: skip


def chromium() -> str:
    """Where Chromium is; skips the test, saying so, where there is none or no pipe can be handed to it."""
    if os.name != "posix":
        pytest.skip("the browser tests hand pipes to Chromium by number, which needs a POSIX system")
    for name in (os.environ.get("CHROMIUM", ""), *_NAMES):
        found = shutil.which(name) if name else None
        if found:
            return found
    pytest.skip("no Chromium on this machine")


class PageLeftError(RuntimeError):
    """The page was left for another one before it answered."""


_LEFT = ("navigated or closed", "Cannot find context", "context was destroyed")


class Browser:
    """A headless Chromium; its pages are closed with it."""

    def __init__(self, profile: Path) -> None:
        binary = chromium()
        to_child, ours_out = os.pipe()
        ours_in, from_child = os.pipe()
        # Chromium reads from 3 and writes to 4: a Python in between puts our pipes there.
        launch = "import os, sys; os.dup2(int(sys.argv[1]), 5); os.dup2(int(sys.argv[2]), 6)"
        launch += "; os.dup2(5, 3); os.dup2(6, 4); os.execv(sys.argv[3], sys.argv[3:])"
        command = [sys.executable, "-c", launch, str(to_child), str(from_child)]
        self.process = subprocess.Popen(
            [*command, binary, *_FLAGS, f"--user-data-dir={profile}", "about:blank"],
            pass_fds=(to_child, from_child),
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        os.close(to_child)
        os.close(from_child)
        self._in, self._out, self._buffer, self._last = ours_in, ours_out, b"", 0
        self.events: list[dict[str, Any]] = []
        self.page: Page | None = None  # the one opened last

    def close(self) -> None:
        try:
            self.call("Browser.close", timeout=5.0)
            self.process.wait(timeout=5.0)
        except (OSError, TimeoutError, subprocess.TimeoutExpired):
            self.process.kill()
            self.process.wait()
        os.close(self._in)
        os.close(self._out)

    def call(
        self, method: str, params: Mapping[str, Any] | None = None, session: str | None = None, timeout: float = 30.0
    ) -> dict[str, Any]:
        """One command and its answer."""
        self._last += 1
        message: dict[str, Any] = {"id": self._last, "method": method, "params": dict(params or {})}
        if session:
            message["sessionId"] = session
        os.write(self._out, json.dumps(message).encode() + b"\0")
        deadline = time.monotonic() + timeout
        while True:
            answer = self._read(deadline)
            if answer.get("id") == self._last:
                if "error" in answer:
                    why = answer["error"]["message"]
                    raise (PageLeftError if any(each in why for each in _LEFT) else RuntimeError)(f"{method}: {why}")
                return dict(answer["result"])
            self.events.append(answer)

    def _read(self, deadline: float) -> dict[str, Any]:
        while b"\0" not in self._buffer:
            ready, _, _ = select.select([self._in], [], [], max(0.0, deadline - time.monotonic()))
            chunk = os.read(self._in, 1 << 16) if ready else b""
            if not chunk:
                raise TimeoutError("Chromium does not answer")
            self._buffer += chunk
        message, self._buffer = self._buffer.split(b"\0", 1)
        return dict(json.loads(message))

    def open(self, path: Path, **screen: Any) -> Page:
        """A page of a file on disk, in place of the one before; `screen` as in `Page.resize`."""
        # one tab for all: no page plays on beside the next one, and none needs a process of its own
        (tab,) = (each for each in self.call("Target.getTargets")["targetInfos"] if each["type"] == "page")
        session = self.call("Target.attachToTarget", {"targetId": tab["targetId"], "flatten": True})["sessionId"]
        page = Page(self, session)
        page.run("addEventListener('beforeunload', event => event.stopImmediatePropagation(), true)")  # left unasked
        page.call("Page.navigate", {"url": "about:blank"})
        page.wait("location.href === 'about:blank'")
        for domain in ("Page", "Runtime", "Log", "Network"):
            page.call(f"{domain}.enable")
        page.resize(**screen)
        page.call("Page.navigate", {"url": path.resolve().as_uri()})
        page.wait("document.readyState === 'complete' && location.href !== 'about:blank'")
        self.page = page
        return page


class Page:
    """One page: scripts, pointers, keys and pictures."""

    def __init__(self, browser: Browser, session: str) -> None:
        self.browser, self.session = browser, session

    def call(self, method: str, params: Mapping[str, Any] | None = None) -> dict[str, Any]:
        return self.browser.call(method, params, self.session)

    def resize(
        self, width: int = 1366, height: int = 768, scale: float = 0.5, dark: bool = False, touch: bool = False
    ) -> None:
        """The screen and the colour scheme."""
        screen = {"width": width, "height": height, "deviceScaleFactor": scale, "mobile": touch}
        self.call("Emulation.setDeviceMetricsOverride", screen)
        self.call("Emulation.setTouchEmulationEnabled", {"enabled": touch})
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self.call("Emulation.setEmulatedMedia", {"features": [scheme]})

    def run(self, script: str) -> Any:
        """The value of an expression."""
        script = f"{{{script}}}" if script.startswith("const ") else script  # a scope of its own
        asked = {"expression": script, "returnByValue": True, "awaitPromise": True, "userGesture": True}
        answer = self.call("Runtime.evaluate", asked)
        if "exceptionDetails" in answer:
            raise RuntimeError(answer["exceptionDetails"]["exception"].get("description", script))
        return answer["result"].get("value")

    def wait(self, condition: str, timeout: float = 30.0) -> None:
        """Waits until an expression is true."""
        deadline = time.monotonic() + timeout
        while True:
            with suppress(PageLeftError):
                if self.run(f"Boolean({condition})"):
                    return
            if time.monotonic() > deadline:
                raise TimeoutError(f"never came true: {condition}")
            time.sleep(0.02)

    def settle(self) -> None:
        """Waits until what was asked for is drawn, or the page is left for what a click led to."""
        with suppress(PageLeftError):
            self.run("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")

    def box(self, selector: str) -> tuple[float, float, float, float]:
        """Left, top, width, height of an element, scrolled into view."""
        found = self.run(
            f"const e = document.querySelector({json.dumps(selector)}); e.scrollIntoView({{block: 'center'}});"
            "const b = e.getBoundingClientRect(); [b.left, b.top, b.width, b.height]"
        )
        return tuple(found)  # type: ignore[return-value]

    def click(self, selector: str) -> None:
        left, top, width, height = self.box(selector)
        self.drag([(left + width / 2, top + height / 2)])

    def drag(self, points: list[tuple[float, float]], modifiers: int = 0) -> None:
        """Presses at the first point, goes through the others, lets go at the last."""
        self._mouse("mouseMoved", points[0], modifiers)
        self._mouse("mousePressed", points[0], modifiers, clickCount=1)
        for point in points[1:]:
            self._mouse("mouseMoved", point, modifiers)
        self._mouse("mouseReleased", points[-1], modifiers, clickCount=1)
        self.settle()

    def touch(self, *fingers: list[tuple[float, float]]) -> None:
        """Fingers go down at their first places, through the others together, and up."""
        for k in range(len(fingers[0])):
            points = [{"x": finger[k][0], "y": finger[k][1], "id": n} for n, finger in enumerate(fingers)]
            kind = "touchMove" if k else "touchStart"
            self.call("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
        self.call("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
        self.settle()

    def hover(self, x: float, y: float) -> None:
        self._mouse("mouseMoved", (x, y), 0)
        self.settle()

    def _mouse(self, kind: str, point: tuple[float, float], modifiers: int, **more: Any) -> None:
        buttons = 0 if kind == "mouseMoved" and not more else 1
        self.call(
            "Input.dispatchMouseEvent",
            {
                "type": kind, "x": point[0], "y": point[1], "button": "left", "buttons": buttons,
                "modifiers": modifiers, **more,
            },
        )  # fmt: skip

    def key(self, key: str, modifiers: int = 0) -> None:
        """One key; modifiers: 2 Ctrl, 8 Shift."""
        text = {"text": key} if len(key) == 1 and not modifiers & 2 else {}
        for kind in ("keyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", {"type": kind, "key": key, "modifiers": modifiers, **text})
        self.settle()

    def screenshot(self, path: Path, whole: bool = False) -> None:
        shot = self.call("Page.captureScreenshot", {"format": "png", "captureBeyondViewport": whole})
        path.write_bytes(base64.b64decode(shot["data"]))

    @property
    def complaints(self) -> list[str]:
        """Console errors and warnings, uncaught exceptions, and what the browser itself logged."""
        self.run("0")  # takes in what is under way
        found = []
        for event in self.browser.events:
            if event.get("sessionId") != self.session:
                continue
            params = event["params"]
            if event["method"] == "Runtime.exceptionThrown":
                found.append(str(params["exceptionDetails"].get("exception", {}).get("description", params)))
            elif event["method"] == "Runtime.consoleAPICalled" and params["type"] in ("error", "warning", "assert"):
                found.append(str(params["args"]))
            elif event["method"] == "Log.entryAdded" and params["entry"]["level"] in ("error", "warning"):
                found.append(str(params["entry"]))
        return found

    @property
    def requests(self) -> list[str]:
        """Addresses that the page asked for, itself and what it holds left out."""
        return [
            event["params"]["request"]["url"]
            for event in self.browser.events
            if event.get("sessionId") == self.session
            and event["method"] == "Network.requestWillBeSent"
            and event["params"]["type"] != "Document"
            and not event["params"]["request"]["url"].startswith(("data:", "blob:"))
        ]
