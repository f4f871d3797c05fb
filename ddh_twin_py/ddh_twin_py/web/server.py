"""Serves the page: files, look back, health in full, and a WebSocket for everything that changes.

The server runs in a thread of its own. What is sent is encoded once for all browsers, and each gets it at its own pace.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import logging
import threading
from collections.abc import Awaitable, Callable
from concurrent.futures import Future
from functools import partial

import numpy as np
from aiohttp import WSCloseCode, WSMsgType, web
from aiohttp.http_exceptions import HttpProcessingError

from ddh_twin_py.web.access import Access
from ddh_twin_py.web.board import Board
from ddh_twin_py.web.history import LEVELS
from ddh_twin_py.web.page_files import Asset, assets, version
from ddh_twin_py.web.streams import PLACE
from ddh_twin_py.web.viewers import Viewer, Viewers

MOST_VIEWERS = 50
_LONGEST_MESSAGE = 4096  # bytes from a browser
_HEARTBEAT = 15.0  # s
_FAREWELL = 1.0  # s that a browser has to answer that the server ends
_MOST_COLUMNS = 64
_LONGEST_LOOK = 1e6  # s that are looked back
_START = 10.0  # s until the port is bound, or is not
_ANSWER = 10.0  # s that a command may take
_MOST_ASKED = 8  # commands of one browser that are not answered yet
_LOG = logging.getLogger("ddh_twin_py.web")
_LOG.addFilter(lambda record: not (record.exc_info and isinstance(record.exc_info[1], HttpProcessingError)))  # what is no HTTP: a scanner
_HEADERS = {
    "X-Content-Type-Options": "nosniff", "X-Frame-Options": "DENY", "Referrer-Policy": "no-referrer", "Cache-Control": "no-cache",
}  # fmt: skip
_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self' ws://{host}; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
Command = Callable[[str, object], "Future[str]"]
"""Does what a page asks for (name, value); the future holds '' or why it was refused."""


class ServerError(Exception):
    """The page cannot be served; one line."""


class PageServer:
    """The server of one board.

    Args:
        host, port: where to bind; port 0 takes any that is free. token: to be known by whoever looks, see `Access.of`.
        command: does what a page asks for. details: the values behind a line of the health, by its name.
    """

    def __init__(self, board: Board, host: str, port: int, token: str, command: Command, details: Callable[[str], object]) -> None:
        self._board, self._command, self._details = board, command, details
        self._files = assets()
        self._given = host, port, token
        self._viewers = Viewers()
        self._showing: set[asyncio.Task] = set()
        self._loop = asyncio.new_event_loop()
        self._runner: web.AppRunner | None = None
        self.access = Access.of(host, port, token)

    # --- life --------------------------------------------------------------------------------

    def start(self) -> None:
        """Bind and serve. Raises ServerError where the address cannot be bound."""
        bound: Future[int] = Future()
        self._thread = threading.Thread(target=self._serve, args=(bound,), name="live page", daemon=True)
        self._thread.start()
        host, port, token = self._given
        try:
            taken = bound.result(_START)
        except (OSError, ValueError) as error:  # a name of a host can be none; TimeoutError is an OSError
            reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error) or "no answer"
            raise ServerError(f"the page cannot be served at {host}:{port}: {reason}") from None
        self.access = Access.of(host, taken, token)

    def _serve(self, bound: Future[int]) -> None:
        asyncio.set_event_loop(self._loop)
        try:
            bound.set_result(self._loop.run_until_complete(self._bind()))
        except (OSError, ValueError) as error:
            bound.set_exception(error)
            return
        self._loop.run_forever()
        self._loop.run_until_complete(self._unbind())
        self._loop.close()

    async def _bind(self) -> int:
        application = web.Application(middlewares=[self._guard])
        application.add_routes([
            web.get("/", partial(self._file, "index.html")), web.get("/ws", self._socket), web.get("/history", self._history),
            web.get("/health", self._health), web.get("/state", self._state), web.get("/{name}", self._named),
        ])  # fmt: skip
        self._runner = web.AppRunner(application, access_log=None, logger=_LOG, shutdown_timeout=1.0)
        await self._runner.setup()
        site = web.TCPSite(self._runner, self._given[0], self._given[1])
        await site.start()
        return self._runner.addresses[0][1]

    async def _unbind(self) -> None:
        await asyncio.gather(*(viewer.leave() for viewer in list(self._viewers.all)), return_exceptions=True)
        await self._runner.cleanup()

    def stop(self) -> None:
        """Close all connections and end the thread."""
        if self._thread.is_alive():
            self._loop.call_soon_threadsafe(self._loop.stop)
            self._thread.join(5.0)

    @property
    def running(self) -> bool:
        """Whether the thread of the server still runs."""
        return self._thread.is_alive()

    @property
    def viewers(self) -> int:
        """How many browsers are connected."""
        return len(self._viewers.all)

    @property
    def skipped(self) -> int:
        """Frames that were left out because a browser had not caught up."""
        return sum(viewer.skipped for viewer in list(self._viewers.all))

    # --- frames ------------------------------------------------------------------------------

    def show(self) -> None:
        """Send what is new on the board; returns at once. What the last call has not sent yet is not waited for."""
        frame, changed = self._board.frame(), self._board.changed()
        self._loop.call_soon_threadsafe(self._show, frame, changed)

    def _show(self, frame: bytes, changed: list[str]) -> None:
        task = self._loop.create_task(self._viewers.show(frame, changed, self._board.snapshot, self._board.texts))
        self._showing.add(task)  # a loop alone does not keep a task
        task.add_done_callback(self._showing.discard)

    # --- requests ----------------------------------------------------------------------------

    @web.middleware
    async def _guard(self, request: web.Request, handler: Callable[[web.Request], Awaitable[web.StreamResponse]]) -> web.StreamResponse:
        access = self.access
        refusal = access.refusal(request.headers)
        if refusal:
            return web.Response(status=403, text=f"{refusal}\n")
        offered = request.query.get("token")
        if access.token and offered is not None and access.knows_token(offered):
            if request.path != "/":
                return await handler(request)
            answer = web.Response(status=303, headers={"Location": "/"})
            answer.set_cookie(access.cookie, offered, httponly=True, samesite="Lax")
            return answer
        if not access.knows_token(request.cookies.get(access.cookie)):
            return web.Response(status=401, text="This page needs its token: open the address that web_view has printed.\n")
        return await handler(request)

    async def _named(self, request: web.Request) -> web.Response:
        return await self._file(request.match_info["name"], request)

    async def _file(self, name: str, request: web.Request) -> web.Response:
        asset: Asset | None = self._files.get(name)
        if asset is None:
            raise web.HTTPNotFound(text=f"there is no {request.path}\n")
        headers = {**_HEADERS, "Content-Type": asset.media_type, "ETag": f'"{asset.tag}"'}
        if name.endswith(".html"):
            headers["Content-Security-Policy"] = _POLICY.format(host=request.headers.get("Host", ""))
        if request.headers.get("If-None-Match") == headers["ETag"]:
            return web.Response(status=304, headers=headers)
        return web.Response(body=asset.content, headers=headers)

    async def _history(self, request: web.Request) -> web.Response:
        """`?level=0&seconds=30&columns=a,b`: int64 number of the first value, then float32 value by value."""
        names = [name for name in request.query.get("columns", "").split(",") if name]
        unknown = [name for name in names if name not in PLACE]
        try:
            level, seconds = int(request.query.get("level", "0")), float(request.query.get("seconds", "30"))
        except ValueError:
            raise web.HTTPBadRequest(text="level is a whole number and seconds a number\n") from None
        wrong = [f"no column {name!r}" for name in unknown[:1]]
        if not 0 < len(names) <= _MOST_COLUMNS:
            wrong.append(f"{len(names)} columns, allowed are 1 to {_MOST_COLUMNS} columns")
        if not 0 <= level < len(LEVELS):
            wrong.append(f"level is {level}, allowed are levels 0 to {len(LEVELS) - 1}")
        if not 0.0 < seconds < _LONGEST_LOOK:
            wrong.append(f"seconds is {seconds:g}, allowed are above 0 and below {_LONGEST_LOOK:g}")
        if wrong:
            raise web.HTTPBadRequest(text=f"{'; '.join(wrong)}\n")
        first, values = self._board.look_back(level, names, seconds)
        body = np.array([first], "<i8").tobytes() + np.ascontiguousarray(values.T, "<f4").tobytes()
        return web.Response(body=body, headers={**_HEADERS, "Content-Type": "application/octet-stream"})

    async def _health(self, request: web.Request) -> web.Response:
        """`?name=ddh/gap_monitor: clock`: the values behind one line of the health."""
        return web.json_response(self._details(request.query.get("name", "")), headers=_HEADERS)

    async def _state(self, request: web.Request) -> web.Response:
        return web.json_response(self._board.state(), headers=_HEADERS)

    # --- WebSocket ---------------------------------------------------------------------------

    async def _socket(self, request: web.Request) -> web.StreamResponse:
        if self.viewers >= MOST_VIEWERS:
            return web.Response(status=503, text=f"{MOST_VIEWERS} browsers look at the page already\n")
        socket = web.WebSocketResponse(timeout=_FAREWELL, heartbeat=_HEARTBEAT, compress=False, max_msg_size=_LONGEST_MESSAGE)
        await socket.prepare(request)
        viewer = Viewer(_Connection(socket, request), set(self._board.texts()))
        await socket.send_str(json.dumps({"doc": "version", "data": version(self._files)}))
        self._viewers.all.add(viewer)
        asked: set[asyncio.Task[None]] = set()
        try:
            async for message in socket:
                if message.type is WSMsgType.TEXT:
                    await self._hear(socket, viewer, message.data, asked)
        finally:
            self._viewers.all.discard(viewer)
            for task in asked:
                task.cancel()
        return socket

    async def _hear(self, socket: web.WebSocketResponse, viewer: Viewer, text: str, asked: set[asyncio.Task[None]]) -> None:
        """`{"seen": 5}` acknowledges frames; `{"do": "pause", "value": true, "id": 1}` asks for something, and nobody waits for it."""
        try:
            said = json.loads(text)
            if "seen" in said:
                viewer.acknowledge(int(said["seen"]))
                return
            name, value, number = str(said["do"]), said.get("value"), said.get("id")
        except (ValueError, KeyError, TypeError, OverflowError, RecursionError):
            await socket.close(code=WSCloseCode.UNSUPPORTED_DATA, message=b"not understood")
            return
        if len(asked) >= _MOST_ASKED:
            await _answer(socket, name, number, f"{_MOST_ASKED} commands are still waiting")
            return
        task = self._loop.create_task(self._do(socket, name, value, number))
        asked.add(task)
        task.add_done_callback(asked.discard)

    async def _do(self, socket: web.WebSocketResponse, name: str, value: object, number: object) -> None:
        try:
            refused = await asyncio.wait_for(asyncio.wrap_future(self._command(name, value)), _ANSWER)
        except TimeoutError:
            refused = f"no answer to {name} within {_ANSWER:g} s"
        with contextlib.suppress(ConnectionError, RuntimeError):  # it has left
            await _answer(socket, name, number, refused)


async def _answer(socket: web.WebSocketResponse, name: str, number: object, refused: str) -> None:
    await socket.send_str(json.dumps({"doc": "answer", "data": {"id": number, "do": name, "refused": refused}}))


class _Connection:
    """A WebSocket of aiohttp as a `Socket`."""

    def __init__(self, socket: web.WebSocketResponse, request: web.Request) -> None:
        self._socket, self._request = socket, request
        self.send_bytes, self.send_str = socket.send_bytes, socket.send_str

    def waiting(self) -> int:
        transport = self._request.transport
        if transport is None or self._socket.closed:
            raise ConnectionError("closed")
        return transport.get_write_buffer_size()

    async def close(self) -> None:
        await self._socket.close(code=WSCloseCode.GOING_AWAY)
