"""Errors as large as said, over rigs, starts and unknown heats drawn as the filter believes them; chi-square bands."""

from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.estimation.consistency import JUDGED, TOO_LITTLE, SeedErrors, hot_spot_inside, many_seeds, nees_band, nis_band, verdict
from ddh_twin_py.rig import load_rig
from ddh_twin_py.twin.duty import load_duty
from support.simulated import DUTY

SEEDS, DURATION = range(6), 150.0


@pytest.fixture(scope="module")
def errors():
    return many_seeds(load_rig(), load_duty(DUTY / "mixed.yaml"), SEEDS, DURATION)


def test_normalised_errors_of_all_nodes_lie_in_their_band(errors):
    band = nees_band(errors)
    assert band.lower < band.mean < band.upper, band
    said = verdict(band, nis_band(errors), hot_spot_inside(errors), len(SEEDS))
    assert said.startswith(f"{TOO_LITTLE} (6 rigs, 15 instants of each; 10 and 20 are the least): ")
    assert "errors of all nodes are as large as said; innovations are as large as said" in said


def test_normalised_innovations_lie_in_their_band(errors):
    band = nis_band(errors)
    assert band.lower < band.mean < band.upper and band.inside > 0.6, band


def test_the_hidden_hot_spot_lies_in_its_interval(errors):
    assert hot_spot_inside(errors) >= 0.9  # the draws are the same everywhere
    assert 0.5 < np.mean([e.hot_spot_std for e in errors]) < 12.0  # an interval that says something


def test_a_filter_that_is_too_sure_falls_out():
    """The judgement itself: errors twice too large for what is said, and twice too small."""
    rng = np.random.default_rng(0)
    for factor, holds in ((1.0, True), (2.0, False), (0.5, False)):
        made = []
        for _ in range(10):
            z = factor * rng.standard_normal((20, JUDGED.size))
            square = factor**2 * rng.chisquare(18, 20)
            nees, count = (z**2).sum(axis=1), np.full(20, 18)
            made.append(SeedErrors(np.arange(20.0), nees, square, count, z[:, 0], np.ones(20), np.ones(1), 1.0, 1.0))
        for band in (nees_band(made), nis_band(made)):
            said = verdict(nees_band(made), nis_band(made), 0.95, 10)
            assert ("The estimate is as wrong as it says" in said) is holds and ("larger than said" in said) is (factor > 1.0), said
            assert verdict(nees_band(made), nis_band(made), 0.5, 10).startswith("The estimate is not as wrong as it says")
            few = [verdict(replace(nees_band(made), instants=n), nis_band(made), 0.95, rigs) for n, rigs in ((20, 2), (19, 10), (20, 10))]
            assert [one.startswith(TOO_LITTLE) for one in few] == [holds, holds, False]
            assert (band.inside > 0.8) is holds and bool(band.lower < band.mean < band.upper) is holds
