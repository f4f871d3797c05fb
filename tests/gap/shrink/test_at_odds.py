"""Recordings that do not go together are asked about."""

from types import SimpleNamespace

import numpy as np
import pytest
from ddh_twin_py.gap.shrink.at_odds import at_odds

FLOOR = {"flow": 1.0}


def signal(off):
    return {"flow": SimpleNamespace(measured=np.full(50, off), noise=1.0, binning=SimpleNamespace(bin=np.zeros(50, int)))}


def asked(field, held, as_is=4.0, before=3.0, **recordings):
    """Questions where the field is so many floors off as fitted, and held-out data as run, with the sheet and as commissioned."""
    model = SimpleNamespace(signals=[signal(1.0), signal(field)], altered=[False, True],
                            recordings={"field": ["f"], "commissioning": ["c"], "validation": ["v"]} | recordings)
    best = SimpleNamespace(predictions=[{"flow": np.zeros(50)}] * 2)
    runs = SimpleNamespace(floor=FLOOR, gap=lambda fitted: held)
    return at_odds(model, best, runs, as_is, before)


def test_a_validation_of_which_the_field_shows_nothing_is_asked_about():
    (said,) = asked(1.0, 7.2)
    assert said.startswith("v: it lies 7.2 times the floor off with what explains the field recording to 1.0; is it of the same rig")


@pytest.mark.parametrize(("field", "held"), [(3.0, 7.2), (1.0, 1.4)])
def test_a_field_that_is_off_too_or_a_validation_that_is_not_is_not(field, held):
    assert asked(field, held) == []


def test_the_end_of_the_field_recording_is_no_validation():
    model = SimpleNamespace(signals=[signal(1.0)], altered=[True], recordings={"field": ["f"]})
    runs = SimpleNamespace(floor=FLOOR, gap=lambda fitted: 7.2)
    assert at_odds(model, SimpleNamespace(predictions=[{"flow": np.zeros(50)}]), runs, 4.0, 4.0) == []


def test_a_commissioning_that_makes_things_worse_is_asked_about():
    (said,) = asked(3.0, 3.0, as_is=6.0, before=6.3)
    assert said.startswith("c: fitted to it, the twin is farther off what was recorded later (6.3 times the floor) than with the sheet's")
