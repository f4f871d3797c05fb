from types import SimpleNamespace

import numpy as np
import pytest
from ddh_twin_py.estimation.fitting.binning import HOLDING, LIFTING, TRANSIENT, Binning
from ddh_twin_py.gap.shrink.bin_means import AT_NOISE, beyond_noise

_NOISE = 0.15  # rad/s
_BINS, _EACH = 200, 40


def _signal(offset: np.ndarray, seed: int, broken: int = 0):
    """Reading of a signal that is predicted as nothing, off by so much in each bin, (b,); every fifth bin is of a transient."""
    rng = np.random.default_rng(seed)
    bins = np.repeat(np.arange(_BINS), _EACH)
    measured = rng.normal(0.0, _NOISE, bins.size) + offset[bins]
    measured[: broken * _EACH] = 400.0
    phase = np.where(np.arange(_BINS) % 5 == 0, TRANSIENT, np.where(np.arange(_BINS) % 2, LIFTING, HOLDING))
    binning = Binning(bins, np.full(_BINS, _EACH), np.zeros(_BINS, int), phase, np.arange(_BINS, dtype=float))
    return SimpleNamespace(measured=measured, noise=_NOISE, binning=binning, follows=None)


def _asked(commissioning, field):
    model = SimpleNamespace(signals=[commissioning, field], altered=[False, True], kinematic=("speed", "current"))
    nothing = [{name: np.zeros(s.measured.size) for name, s in own.items()} for own in model.signals]
    return beyond_noise(model, SimpleNamespace(predictions=nothing))


def _sound(seed: int, **kw):
    return _signal(np.zeros(_BINS), seed, **kw)


def test_a_mean_shows_what_single_samples_hide():
    lifting = 0.5 * _NOISE * (np.arange(_BINS) % 2)
    field = _signal(lifting, 2)
    single = np.sqrt(np.mean(field.measured**2)) / _NOISE
    off = _asked({"speed": _sound(1)}, {"speed": field})
    assert single < 1.1 and off["speed"] > 2.0


def test_a_sound_signal_is_at_its_noise_and_a_few_broken_readings_are_no_cause():
    off = _asked({"speed": _sound(1)}, {"speed": _sound(2, broken=2)})
    assert off["speed"] == pytest.approx(1.0, abs=0.1)


def test_a_signal_whose_law_errs_as_built_has_no_say():
    off = 0.3 * _NOISE * np.ones(_BINS)
    assert np.sqrt(1.0 + _EACH * 0.3**2) > AT_NOISE
    assert _asked({"current": _signal(off, 1)}, {"current": _signal(3.0 * off, 2)}) == {}


def test_what_is_off_while_a_motion_begins_has_no_say():
    begins = 5.0 * _NOISE * (np.arange(_BINS) % 5 == 0)
    assert _asked({"speed": _sound(1)}, {"speed": _signal(begins, 2)})["speed"] == pytest.approx(1.0, abs=0.1)


def test_nothing_is_said_of_what_only_one_kind_of_recording_reads():
    assert _asked({}, {"speed": _sound(1)}) == {} == _asked({"speed": _sound(1)}, {})


def test_where_a_signal_follows_no_command_it_has_no_say():
    field = _signal(3.0 * _NOISE * (np.arange(_BINS) < _BINS // 2), 2)
    assert _asked({"speed": _sound(1)}, {"speed": field})["speed"] > 5.0
    field.follows = np.repeat(np.arange(_BINS) >= _BINS // 2, _EACH)
    assert _asked({"speed": _sound(1)}, {"speed": field})["speed"] == pytest.approx(1.0, abs=0.1)
