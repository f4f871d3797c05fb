"""What a page asks of the player, whatever it asks: an answer, and never an error in the node."""

import pytest
from ddh_twin_py.nodes.player.player_client import PlayerClient


class NoPlayer:
    """A node in whose namespace nobody plays."""

    def create_client(self, kind, name):
        return self

    def service_is_ready(self):
        return False

    def get_namespace(self):
        return "/ddh"


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("seek", 12.5, "nobody plays a bag in /ddh"),
        ("seek", 10**400, "seek: value is '1000000000000000000000000000000000000000', it must be a number"),
        ("seek", None, "seek: value is 'None', it must be a number"),
        ("rate", [1], "rate: value is '[1]', it must be a number"),
        ("pause", "false", "pause: value is 'false', it must be true or false"),
        ("pause", True, "nobody plays a bag in /ddh"),
        ("stop", True, "there is no 'stop'; valid are pause, seek, rate"),
    ],
    ids=lambda value: str(value)[:12],
)
def test_every_wish_is_answered(name, value, said):
    client = PlayerClient(NoPlayer())
    answer = client.ask(name, value)
    client.work()
    assert answer.result(0.0) == said


def test_whoever_has_left_gets_no_answer():
    client = PlayerClient(NoPlayer())
    answer, other = client.ask("seek", 1.0), client.ask("seek", 2.0)
    assert answer.cancel()
    client.work()
    assert answer.cancelled() and other.done()
