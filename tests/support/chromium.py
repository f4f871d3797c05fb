"""Chromium without a window, steered over its DevTools protocol.

What the page asks for is noted in `requests`, so that a test can say that nothing leaves the machine.
"""

from __future__ import annotations

import asyncio
import base64
import json
import shutil
import subprocess
import tempfile
import threading
import time
from collections.abc import Mapping
from pathlib import Path

import aiohttp

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
OPTIONS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync", "--disable-dev-shm-usage", "--mute-audio", "--hide-scrollbars",
    "--no-proxy-server", "--remote-debugging-port=0",
)  # fmt: skip
KEYS = {
    " ": ("Space", 32), "Tab": ("Tab", 9), "Enter": ("Enter", 13), "ArrowLeft": ("ArrowLeft", 37), "ArrowRight": ("ArrowRight", 39),
    "ArrowDown": ("ArrowDown", 40), "Home": ("Home", 36),
}  # fmt: skip


def executable() -> str | None:
    """Where a Chromium is, None without one."""
    return next((found for name in NAMES if (found := shutil.which(name))), None)


class Chromium:
    """One browser with one page at a time; a context manager."""

    def __init__(self) -> None:
        self._folder = tempfile.mkdtemp(prefix="ddh_chromium_")
        self._process = subprocess.Popen(
            [executable(), *OPTIONS, f"--user-data-dir={self._folder}", "about:blank"],
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        self._loop = asyncio.new_event_loop()
        threading.Thread(target=self._loop.run_forever, daemon=True).start()
        self._number = 0
        self._answers: dict[int, asyncio.Future] = {}
        self.requests: list[str] = []
        self.errors: list[str] = []
        try:
            self._do(self._connect(self._port()))
        except BaseException:
            self._end()
            raise
        for domain in ("Page", "Runtime", "Network", "Log"):
            self.call(f"{domain}.enable")

    def __enter__(self) -> Chromium:
        return self

    def __exit__(self, *_: object) -> None:
        self._do(self._close())
        self._end()

    def _end(self) -> None:
        self._process.terminate()
        try:
            self._process.wait(5.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._loop.call_soon_threadsafe(self._loop.stop)
        shutil.rmtree(self._folder, ignore_errors=True)

    def _port(self) -> int:
        file = Path(self._folder) / "DevToolsActivePort"
        deadline = time.monotonic() + 30.0
        while time.monotonic() < deadline:
            if file.exists() and (lines := file.read_text().split()):
                return int(lines[0])
            assert self._process.poll() is None, f"Chromium ended with {self._process.returncode}"
            time.sleep(0.05)
        raise AssertionError("Chromium: no DevTools within 30 s")

    def _do(self, coroutine):
        return asyncio.run_coroutine_threadsafe(coroutine, self._loop).result(40.0)

    async def _connect(self, port: int) -> None:
        self._session = aiohttp.ClientSession()
        async with self._session.get(f"http://127.0.0.1:{port}/json") as answer:
            target = next(t for t in json.loads(await answer.text()) if t["type"] == "page")
        self._socket = await self._session.ws_connect(target["webSocketDebuggerUrl"], max_msg_size=0)
        self._reader = asyncio.create_task(self._read())

    async def _close(self) -> None:
        await self._socket.close()
        await self._session.close()

    async def _read(self) -> None:
        async for message in self._socket:
            said = json.loads(message.data)
            if "id" in said:
                future = self._answers.pop(said["id"], None)
                if future is not None and not future.done():
                    future.set_result(said)
                continue
            method, given = said.get("method", ""), said.get("params", {})
            if method == "Network.requestWillBeSent":
                self.requests.append(given["request"]["url"])
            elif method == "Network.webSocketCreated":
                self.requests.append(given["url"])
            elif method == "Runtime.exceptionThrown":
                details = given["exceptionDetails"]
                self.errors.append(details.get("exception", {}).get("description") or details["text"])
            elif method == "Log.entryAdded" and given["entry"]["level"] == "error":
                self.errors.append(f"{given['entry']['text']} {given['entry'].get('url', '')}")

    def call(self, method: str, **given: object) -> dict:
        """One command of the protocol; its result."""

        async def ask() -> dict:
            self._number += 1
            future = self._loop.create_future()
            self._answers[self._number] = future
            await self._socket.send_str(json.dumps({"id": self._number, "method": method, "params": given}))
            return await asyncio.wait_for(future, 30.0)

        answer = self._do(ask())
        assert "error" not in answer, f"{method}: {answer.get('error')}"
        return answer["result"]

    # --- what a person does -----------------------------------------------------------------

    def open(self, url: str) -> None:
        """Go to a page and wait until its script has begun."""
        self.call("Page.navigate", url=url)
        self.wait("document.documentElement.dataset.ready === 'yes'", 30.0)

    def screen(self, width: int, height: int, phone: bool = False, dark: bool = False, still: bool = False, vision: str = "none") -> None:
        """Size of the screen, and what the person prefers; `vision` such as deuteranopia."""
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=2 if phone else 1, mobile=phone)
        self.call("Emulation.setEmulatedMedia", features=[
            {"name": "prefers-color-scheme", "value": "dark" if dark else "light"},
            {"name": "prefers-reduced-motion", "value": "reduce" if still else "no-preference"},
        ])  # fmt: skip
        self.call("Emulation.setEmulatedVisionDeficiency", type=vision)

    def value(self, script: str) -> object:
        """Value of an expression on the page; a promise is waited for."""
        result = self.call("Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in result, f"{script}: {result['exceptionDetails'].get('exception', {}).get('description')}"
        return result["result"].get("value")

    def text(self, selector: str) -> str:
        """Text of the first element that matches, '' where there is none."""
        return self.value(f"document.querySelector({json.dumps(selector)})?.textContent ?? ''")

    def wait(self, script: str, seconds: float = 15.0) -> object:
        """Wait until an expression is true; its value."""
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline:
            if found := self.value(f"(() => {{ try {{ return {script} }} catch (e) {{ return false }} }})()"):
                return found
            time.sleep(0.1)
        seen = self.value("document.body?.innerText.slice(0, 300)")
        raise AssertionError(f"not within {seconds:g} s: {script}\nerrors on the page: {self.errors}\nit begins: {seen}")

    def press(self, key: str) -> None:
        """Press and let go one key."""
        code, number = KEYS[key] if key in KEYS else (f"Key{key.upper()}" if key.isalpha() else f"Digit{key}", ord(key.upper()))
        more = {"text": key} if len(key) == 1 else {"text": "\r"} if key == "Enter" else {}
        for kind in ("keyDown", "keyUp"):
            text = more if kind == "keyDown" else {}
            self.call("Input.dispatchKeyEvent", type=kind, key=key, code=code, windowsVirtualKeyCode=number, **text)

    def picture(self, path: str | Path, whole: bool = False, clip: Mapping[str, float] | None = None) -> Path:
        """A screenshot as PNG, of the whole page, of a part of it (x, y, width, height) or of what the screen holds."""
        if whole:
            size = self.call("Page.getLayoutMetrics")["cssContentSize"]
            clip = {"x": 0, "y": 0, "width": size["width"], "height": size["height"]}
        given = {"captureBeyondViewport": True, "clip": {**clip, "scale": 1}} if clip else {}
        data = self.call("Page.captureScreenshot", format="png", **given)["data"]
        Path(path).write_bytes(base64.b64decode(data))
        return Path(path)
