"""The server over real sockets: files, look back, WebSocket, token, and a browser that does not read."""

import asyncio
import json
import socket
import time
from concurrent.futures import Future

import aiohttp
import numpy as np
import pytest
from ddh_twin_py.web.frames import decode
from ddh_twin_py.web.history import GRID, GRID_NS
from ddh_twin_py.web.server import PageServer, ServerError
from ddh_twin_py.web.streams import NUMBER, STREAMS
from ddh_twin_py.web.viewers import WINDOW

WIDTHS = [len(stream.fields) for stream in STREAMS]


def drive(board, first, count, value=1.0):
    stamps = np.arange(first, first + count, dtype=np.int64) * GRID_NS
    board.take("drive", stamps, np.full((count, WIDTHS[NUMBER["drive"]]), value))


async def fetch(url, **given):
    async with aiohttp.ClientSession(cookie_jar=aiohttp.CookieJar(unsafe=True)) as session, session.get(url, **given) as answer:
        return answer.status, answer.headers, await answer.read()


def get(url, **given):
    return asyncio.run(fetch(url, **given))


def test_the_page_and_all_that_it_asks_for_come_from_here(served):
    status, headers, body = get(served.url)
    assert status == 200 and headers["Content-Type"].startswith("text/html")
    policy = headers["Content-Security-Policy"]
    assert "default-src 'none'" in policy and "http:" not in policy
    for name in ("main.js", "charts.js", "page.css", "circuit.svg", "language.js", "uPlot.iife.min.js", "uPlot.min.css"):
        status, headers, content = get(served.url + name)
        assert status == 200 and content, name
        assert get(served.url + name, headers={"If-None-Match": headers["ETag"]})[0] == 304
        assert b"https://" not in content.replace(b"https://github.com/leeoniya/uPlot", b""), name
    assert b"//" not in body.replace(b"http://www.w3.org/2000/svg", b"").replace(b"'http:", b"")


@pytest.mark.parametrize("path", ["nothing.js", "../server.py", "%2e%2e/server.py", "..%2fserver.py"])
def test_nothing_else_is_given_out(served, path):
    assert get(aiohttp.client.URL(served.url + path, encoded=True))[0] == 404


def test_look_back_of_columns(served):
    drive(served.board, 1000, 101, value=3.0)
    status, _, body = get(f"{served.url}history?level=0&seconds=2&columns=drive.speed,state.speed")
    values = np.frombuffer(body, "<f4", offset=8).reshape(2, -1)
    assert status == 200 and values.shape == (2, round(2 / GRID))
    assert int(np.frombuffer(body, "<i8", 1)[0]) + values.shape[1] - 1 == served.board.now
    assert (values[0] == 3.0).all() and np.isnan(values[1]).all()


@pytest.mark.parametrize(
    ("query", "words"),
    [
        ("columns=drive.sped", "no column 'drive.sped'"), ("", "allowed are 1 to 64 columns"),
        ("columns=drive.speed&seconds=0", "seconds is 0, allowed are above 0"), ("columns=drive.speed&level=9", "level is 9, allowed"),
        ("level=9&columns=drive.speed", "levels 0 to 2"), ("level=x&columns=drive.speed", "level is a whole number"),
        ("seconds=-1&columns=drive.speed", "allowed are"),
        ("seconds=nan&columns=drive.speed", "allowed are"),
    ],
)  # fmt: skip
def test_a_look_back_that_cannot_be_is_refused_in_one_line(served, query, words):
    status, _, body = get(f"{served.url}history?{query}")
    assert status == 400 and words in body.decode() and body.decode().count("\n") == 1


def test_state_and_health_for_other_programs(served):
    served.board.put("gap", {"state": "none"})
    assert json.loads(get(served.url + "state")[2])["gap"] == {"state": "none"}
    assert json.loads(get(served.url + "health?name=ddh/x: clock")[2]) == [["age [s]", "ddh/x: clock"]]


async def receive(ws, wanted, seconds=10.0):
    """The next message of that kind: bytes, or the document of that name."""
    deadline = time.monotonic() + seconds
    while True:
        message = await ws.receive(max(0.01, deadline - time.monotonic()))
        if message.type is aiohttp.WSMsgType.BINARY and wanted is bytes:
            return message.data
        if message.type is aiohttp.WSMsgType.TEXT and (told := json.loads(message.data))["doc"] == wanted:
            return told["data"]
        assert message.type in (aiohttp.WSMsgType.TEXT, aiohttp.WSMsgType.BINARY), message


def test_numbers_documents_and_wishes_over_the_socket(served):
    served.board.put("rig", {"rig_id": "r7"})
    drive(served.board, 1000, 3, value=5.0)

    async def look():
        async with aiohttp.ClientSession() as session, session.ws_connect(served.url + "ws") as ws:
            assert len(await receive(ws, "version")) == 16
            while not served.server.viewers:
                await asyncio.sleep(0.01)
            served.server.show()
            assert await receive(ws, "rig") == {"rig_id": "r7"}
            _, now, blocks = decode(await receive(ws, bytes), WIDTHS)
            assert now == 1001 and blocks[0].values[-1, 0] == 5.0
            await ws.send_str('{"do": "seek", "value": 12.5, "id": 4}')
            assert await receive(ws, "answer") == {"id": 4, "do": "seek", "refused": ""}
            served.refusal = "nobody plays a bag"
            await ws.send_str('{"do": "pause", "value": true, "id": 5}')
            assert (await receive(ws, "answer"))["refused"] == "nobody plays a bag"
            assert served.asked == [("seek", 12.5), ("pause", True)]
            await ws.send_str("rubbish")
            assert (await ws.receive(5.0)).type in (aiohttp.WSMsgType.CLOSE, aiohttp.WSMsgType.CLOSED, aiohttp.WSMsgType.CLOSING)

    asyncio.run(look())


GARBAGE = ["", "rubbish", '"seen"', "[]", "[" * 4000, '{"seen": null}', '{"seen": 1e400}', "{}", "x" * 5000]


@pytest.mark.parametrize("said", GARBAGE, ids=lambda said: said[:20] or "nothing")
def test_what_is_not_understood_ends_that_connection_alone(served, said, caplog):
    async def look():
        async with aiohttp.ClientSession() as session, session.ws_connect(served.url + "ws") as ws:
            await receive(ws, "version")
            await ws.send_str(said)
            assert (await ws.receive(5.0)).data in (aiohttp.WSCloseCode.UNSUPPORTED_DATA, aiohttp.WSCloseCode.MESSAGE_TOO_BIG)
        async with aiohttp.ClientSession() as session, session.ws_connect(served.url + "ws") as ws:
            assert await receive(ws, "version")

    asyncio.run(look())
    assert served.asked == [] and not caplog.records


NO_REQUEST = [b"\x16\x03\x01\r\n\r\n", b"GET /" + b"a" * 9000 + b" HTTP/1.1\r\n\r\n", b"GET / HTTP/1.1\r\nHost: [\r\n\r\n"]


@pytest.mark.parametrize("said", NO_REQUEST, ids=["TLS", "long", "host"])
def test_what_is_no_request_is_refused_without_a_word_in_the_log(served, said, caplog):
    with socket.create_connection(("127.0.0.1", served.server.access.port), 5.0) as connection:
        connection.sendall(said)
        assert connection.recv(20).split()[1] in (b"400", b"403")
    assert not caplog.records


def test_frames_go_on_while_a_wish_is_not_answered(serve):
    served = serve()
    served.server._command = lambda name, value: Future()

    async def look():
        async with aiohttp.ClientSession() as session, session.ws_connect(served.url + "ws") as ws:
            while not served.server.viewers:
                await asyncio.sleep(0.01)
            await ws.send_str('{"do": "seek", "value": 1, "id": 1}')
            for k in range(2 * WINDOW):
                drive(served.board, 1000 + 2 * k, 3)
                served.server.show()
                await receive(ws, bytes)
                await ws.send_str('{"seen": 1}')
                await asyncio.sleep(0.005)
            for k in range(8):
                await ws.send_str(json.dumps({"do": "seek", "value": 1, "id": k}))
            assert (await receive(ws, "answer"))["refused"] == "8 commands are still waiting"

    asyncio.run(look())


def test_a_browser_that_reads_nothing_holds_nobody_up(served):
    """Its window closes; the other one gets every frame, and the sender never waits."""
    rounds = 6 * WINDOW

    async def look():
        seen = 0
        async with aiohttp.ClientSession() as session:
            async with session.ws_connect(served.url + "ws") as lazy, session.ws_connect(served.url + "ws") as keen:
                while served.server.viewers < 2:
                    await asyncio.sleep(0.01)
                for k in range(rounds):
                    drive(served.board, 1000 + 2 * k, 3)
                    served.server.show()
                    await receive(keen, bytes)
                    seen += 1
                    await keen.send_str('{"seen": 1}')
                assert served.server.skipped >= rounds - WINDOW - 1
                frames = 0
                while frames < WINDOW:  # what was on its way, and not one frame more
                    await receive(lazy, bytes)
                    frames += 1
                with pytest.raises(TimeoutError):
                    await receive(lazy, bytes, 0.3)
                await lazy.send_str(json.dumps({"seen": frames}))
                await asyncio.sleep(0.2)
                served.server.show()
                number, now, blocks = decode(await receive(lazy, bytes), WIDTHS)
                assert blocks[0].index.tolist() == [served.board.now] == [now]  # the state, and nothing that was missed
        return seen

    assert asyncio.run(look()) == rounds


def test_a_token_is_asked_for_and_kept_in_a_cookie(serve):
    served = serve(token="secret")
    base = served.url.partition("?")[0]
    assert served.url.endswith("/?token=secret")
    for path in ("", "main.js", "state", "history?columns=drive.speed", "?token=wrong"):
        assert get(base + path)[0] == 401, path
    assert get(base + "state?token=secret")[0] == 200

    async def look():
        async with aiohttp.ClientSession(cookie_jar=aiohttp.CookieJar(unsafe=True)) as session:
            with pytest.raises(aiohttp.WSServerHandshakeError, match="401"):
                await session.ws_connect(base + "ws")
            async with session.get(served.url) as answer:
                assert answer.status == 200 and "token" not in str(answer.url)
                assert "HttpOnly" in answer.history[0].headers["Set-Cookie"]
            async with session.ws_connect(base + "ws") as ws:
                assert await receive(ws, "version")

    asyncio.run(look())


def test_another_site_gets_neither_page_nor_socket(served):
    assert get(served.url, headers={"Host": "evil.example"})[0] == 403
    assert get(served.url + "ws", headers={"Origin": "http://evil.example"})[0] == 403


def test_an_address_that_is_taken_is_said_in_one_line(served):
    with pytest.raises(ServerError, match=r"the page cannot be served at 127\.0\.0\.1:\d+: .*in use") as error:
        PageServer(served.board, "127.0.0.1", served.server.access.port, "", lambda name, value: None, lambda name: []).start()
    assert "\n" not in str(error.value)
    for host in ("192.0.2.1", "a..b"):  # an address of another machine; no name of one
        with pytest.raises(ServerError, match=host) as error:
            PageServer(served.board, host, 0, "", lambda name, value: None, lambda name: []).start()
        assert "no answer" not in str(error.value)


def test_stopping_waits_for_no_browser_and_frees_the_port(serve):
    served = serve()
    port = served.server.access.port
    lazy = [socket.create_connection(("127.0.0.1", port)) for _ in range(12)]  # each a browser that never answers
    for connection in lazy:
        connection.sendall(
            b"GET /ws HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            b"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n"
        )
        assert connection.recv(12) == b"HTTP/1.1 101"
    served.server.stop()
    assert not served.server.running
    for connection in lazy:
        connection.close()
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        probe.bind(("127.0.0.1", port))
