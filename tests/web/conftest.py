"""A server of the page with a board that a test fills."""

from concurrent.futures import Future

import pytest
from ddh_twin_py.web.board import Board
from ddh_twin_py.web.server import PageServer


class Served:
    """The server, its board, and what pages have asked for."""

    def __init__(self, **given):
        self.board, self.asked = Board(), []
        self.refusal = ""
        given = {"host": "127.0.0.1", "port": 0, "token": ""} | given
        self.server = PageServer(self.board, command=self._command, details=lambda name: [("age [s]", name)], **given)
        self.server.start()

    @property
    def url(self):
        return self.server.access.url

    def _command(self, name, value):
        self.asked.append((name, value))
        answer = Future()
        answer.set_result(self.refusal)
        return answer


@pytest.fixture
def serve():
    made = []

    def make(**given):
        made.append(Served(**given))
        return made[-1]

    yield make
    for served in made:
        served.server.stop()


@pytest.fixture
def served(serve):
    return serve()
