"""What falls silent is named in the log, once until it comes again."""

from types import SimpleNamespace

import numpy as np
import pytest
from ddh_twin_py.nodes.tasks.silent_inputs import SILENCE, SilentInputs

DRIVE, TANK = "/ddh/drive/telemetry", "/ddh/temperature/tank_oil"


@pytest.fixture
def made():
    """An instance, what it said, and whether a player holds."""
    said, held = [], []
    node = SimpleNamespace(get_logger=lambda: SimpleNamespace(warning=said.append))
    return SilentInputs(node, lambda wall: bool(held)), said, held


def run(silent, seconds, arrivals, usual=2.0):
    """Once a second from 0, with the times of the last messages of both, s, NaN: none ever came."""
    for wall in range(seconds):
        for name, came in arrivals.items():
            silent.note(name, wall - came(wall), usual, float(wall))


def test_those_that_fall_silent_together_are_named_in_one_line_once(made):
    silent, said, _ = made
    run(silent, 100, {DRIVE: lambda wall: min(wall, 20), TANK: lambda wall: min(wall, 21)})
    assert said == [f"nothing comes any more on {DRIVE}, {TANK}"]


def test_what_comes_again_and_falls_silent_again_is_named_again(made):
    silent, said, _ = made
    run(silent, 100, {DRIVE: lambda wall: min(wall, 20) if wall < 50 else min(wall, 60), TANK: lambda wall: wall})
    assert said == [f"nothing comes any more on {DRIVE}"] * 2


@pytest.mark.parametrize(("came", "usual"), [
    (lambda wall: wall - SILENCE, 2.0), (lambda wall: wall - 25.0, 30.0), (lambda wall: np.nan, 2.0),
])  # fmt: skip
def test_what_comes_seldom_or_never_came_is_not_silent(made, came, usual):
    silent, said, _ = made
    run(silent, 60, {DRIVE: came}, usual)
    assert said == []


def test_while_a_player_is_paused_or_at_its_end_nothing_is_due(made):
    silent, said, held = made
    held.append(True)
    run(silent, 60, {DRIVE: lambda wall: min(wall, 20)})
    assert said == []


def test_what_comes_again_is_not_silent_to_a_node_that_stood_still_and_was_busy_then(made):
    silent, said, _ = made
    run(silent, 20, {DRIVE: lambda wall: wall, TANK: lambda wall: wall})
    for wall, came in ((45.0, 19.0), (48.5, 48.4), (49.5, 49.4)):  # stood still until 45 s, and took in what came meanwhile until 48.5 s
        for name in (DRIVE, TANK):
            silent.note(name, wall - came, 2.0, wall)
    assert said == []


def test_what_comes_some_seconds_after_a_node_that_stood_still_goes_on_is_not_silent_and_what_does_not_is(made):
    silent, said, _ = made
    run(silent, 20, {DRIVE: lambda wall: wall, TANK: lambda wall: wall})
    for wall in range(45, 70):
        silent.note(DRIVE, wall - (19.0 if wall < 52 else wall), 2.0, float(wall))
        silent.note(TANK, wall - 19.0, 2.0, float(wall))
    assert said == [f"nothing comes any more on {TANK}"]
