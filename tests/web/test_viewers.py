"""A slow browser gets the newest state when it has caught up, and holds nobody up."""

import asyncio

import pytest
from ddh_twin_py.web.viewers import WINDOW, Viewer, Viewers


class FakeSocket:
    def __init__(self):
        self.sent, self.full, self.gone = [], False, False

    def waiting(self):
        if self.gone:
            raise ConnectionError("closed")
        return 100 if self.full else 0

    async def send_bytes(self, data):
        self.sent.append(data)

    async def send_str(self, data):
        self.sent.append(data)


class Stage:
    """Two browsers on one board, of which the second may be slow."""

    def __init__(self):
        self.viewers, self.snapshots, self.number = Viewers(), 0, 0
        self.fast, self.slow = FakeSocket(), FakeSocket()
        self.seats = {socket: Viewer(socket, {"page"}) for socket in (self.fast, self.slow)}
        self.viewers.all |= set(self.seats.values())
        self.texts = {"page": "page", "gap": "gap 0"}

    def snapshot(self):
        self.snapshots += 1
        return b"state %d" % self.number

    def show(self, changed=()):
        self.number += 1
        asyncio.run(self.viewers.show(b"frame %d" % self.number, list(changed), self.snapshot, lambda: dict(self.texts)))


@pytest.fixture
def stage():
    made = Stage()
    made.show()
    return made


def test_it_begins_with_the_documents_and_the_state_made_once_for_all(stage):
    assert stage.fast.sent == stage.slow.sent == ["page", b"state 1"]
    assert stage.snapshots == 1
    stage.show()
    assert stage.fast.sent[-1] == b"frame 2"


def test_a_browser_whose_socket_is_full_is_passed_over_and_gets_the_state_afterwards(stage):
    stage.slow.full = True
    for text in ("gap 1", "gap 2"):
        stage.texts["gap"] = text
        stage.show(changed=["gap"])
    assert stage.slow.sent == ["page", b"state 1"]
    assert stage.fast.sent[2:] == ["gap 1", b"frame 2", "gap 2", b"frame 3"]
    stage.slow.full = False
    stage.show()
    assert stage.slow.sent[2:] == ["gap 2", b"state 4"]  # the newest document alone
    stage.show()
    assert stage.slow.sent[-1] == b"frame 5"
    assert stage.seats[stage.slow].skipped == 2 and stage.seats[stage.fast].skipped == 0


def test_a_browser_that_acknowledges_nothing_gets_no_more_than_the_window(stage):
    for _ in range(3 * WINDOW):
        stage.seats[stage.fast].acknowledge(1)
        stage.show()
    frames = [sent for sent in stage.slow.sent if isinstance(sent, bytes)]
    assert len(frames) == WINDOW
    assert len([sent for sent in stage.fast.sent if isinstance(sent, bytes)]) == 3 * WINDOW + 1
    stage.seats[stage.slow].acknowledge(WINDOW)
    stage.show()
    assert stage.slow.sent[-1].startswith(b"state ")


def test_acknowledging_more_than_was_sent_opens_no_larger_window(stage):
    stage.seats[stage.slow].acknowledge(10**9)
    for _ in range(3 * WINDOW):
        stage.show()
    assert len([sent for sent in stage.slow.sent if isinstance(sent, bytes)]) <= WINDOW + 1


def test_a_browser_that_leaves_is_forgotten_and_the_others_go_on(stage):
    stage.slow.gone = True
    stage.show()
    assert len(stage.viewers.all) == 1 and stage.fast.sent[-1] == b"frame 2"


def test_a_browser_that_is_still_being_sent_to_delays_nobody(stage):
    async def three_frames():
        taken, send = asyncio.Event(), stage.slow.send_bytes

        async def slowly(data):
            await taken.wait()
            await send(data)

        stage.slow.send_bytes = slowly
        shown = []
        for number in (2, 3, 4):
            shown.append(asyncio.create_task(stage.viewers.show(b"frame %d" % number, [], stage.snapshot, lambda: dict(stage.texts))))
            await asyncio.sleep(0)
            await asyncio.sleep(0)
        assert stage.fast.sent[2:] == [b"frame 2", b"frame 3", b"frame 4"]
        taken.set()
        await asyncio.gather(*shown)

    asyncio.run(three_frames())
    assert stage.slow.sent[2:] == [b"frame 2"] and stage.seats[stage.slow].skipped == 2
    stage.show()
    assert stage.slow.sent[-1] == b"state 2"
