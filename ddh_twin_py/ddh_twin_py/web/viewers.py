"""The browsers that look at the page: each gets frames at its own pace, and none holds anything up.

A page acknowledges frames. One that has `WINDOW` of them not acknowledged, or whose socket holds bytes or is still being sent to, gets
nothing until it has caught up; then it gets the newest state instead of what it has missed. So nothing piles up: neither here nor in the
browser.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping
from typing import Protocol

WINDOW = 20
"""Frames on their way to one browser, 1 s."""


class Socket(Protocol):
    """What is needed of a WebSocket."""

    async def send_bytes(self, data: bytes) -> None:
        """Send a frame."""

    async def send_str(self, data: str) -> None:
        """Send a document."""

    def waiting(self) -> int:
        """Bytes that the system has not taken yet."""

    async def close(self) -> None:
        """Say good-bye."""


class Viewer:
    """One browser."""

    def __init__(self, socket: Socket, documents: set[str]) -> None:
        self._socket = socket
        self._owed = set(documents)
        self._unseen = 0
        self._behind = True
        self._sending = False
        self.skipped = 0

    def owe(self, keys: list[str]) -> None:
        """Documents that have changed and are to be sent, in their newest form, when there is room."""
        self._owed.update(keys)

    def acknowledge(self, frames: int) -> None:
        """The page has shown this many frames more."""
        self._unseen = max(0, self._unseen - frames)

    async def leave(self) -> None:
        """The server ends."""
        await self._socket.close()

    async def show(self, frame: bytes, snapshot: Callable[[], bytes], texts: Mapping[str, str]) -> None:
        """Send what is owed, and a frame; nothing where the browser has not caught up."""
        if self._sending or self._unseen >= WINDOW or self._socket.waiting():
            self._behind = True
            self.skipped += 1
            return
        due, new = sorted(self._owed & texts.keys()), snapshot() if self._behind else frame
        self._owed.difference_update(due)
        self._unseen += 1
        self._behind, self._sending = False, True
        try:
            for key in due:
                await self._socket.send_str(texts[key])
            await self._socket.send_bytes(new)
        finally:
            self._sending = False


class Viewers:
    """All browsers."""

    def __init__(self) -> None:
        self.all: set[Viewer] = set()

    async def show(self, frame: bytes, changed: list[str], snapshot: Callable[[], bytes], texts: Callable[[], Mapping[str, str]]) -> None:
        """Send one frame and the documents that have changed to everybody; encoded once."""
        made: list[bytes] = []

        def state() -> bytes:
            if not made:
                made.append(snapshot())
            return made[0]

        for viewer in list(self.all):
            viewer.owe(changed)
        known = texts() if self.all else {}

        async def show(viewer: Viewer) -> None:
            try:
                await viewer.show(frame, state, known)
            except (ConnectionError, RuntimeError):  # it is leaving; its own handler takes it off the list
                self.all.discard(viewer)

        await asyncio.gather(*(show(viewer) for viewer in list(self.all)))
