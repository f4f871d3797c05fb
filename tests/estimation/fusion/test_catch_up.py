"""A model that missed what drives it is brought back to fused temperatures, however late these are told."""

import numpy as np
import pytest
from ddh_twin_py.bags.damage import without_samples
from ddh_twin_py.bags.reader import read_recording
from ddh_twin_py.estimation.fusion.catch_up import FOLLOWS, FROM, CatchUp
from ddh_twin_py.estimation.replay import replay
from ddh_twin_py.physics.thermal_network import MOTOR_NODES, N
from ddh_twin_py.rig import load_rig

SECOND = 1_000_000_000
BEGIN = 100 * SECOND
SURE = np.full(N, 0.3)


@pytest.mark.parametrize(("before", "missed", "told"), [
    (0.0, 12.0, []),  # it had not begun yet
    (10.0, 4.0, []),
    (10.0, 12.0, [12.0]),
    (10.0, 40.0, []),  # readings tell anew
])  # fmt: skip
def test_what_is_missed(before, missed, told):
    driven = np.concatenate([np.ones(round(before)), np.zeros(round(missed)), np.ones(5)]).astype(bool)
    assert [seconds for _, seconds in CatchUp(1.0).missed(driven)] == told
    parts = CatchUp(1.0)
    assert [s for part in np.array_split(driven, 4) for _, s in parts.missed(part)] == told


def run(lag, until=40, fused=330.0, deviation=SURE):
    """A model at 300 K that warms by 0.1 K/s and follows; fused temperatures, which do the same, are told ``lag`` s late."""
    catch_up, temperature = CatchUp(1.0), np.full(N, 300.0)
    catch_up.begin(BEGIN)
    for k in range(until):
        temperature += 0.1
        catch_up.ran(BEGIN + k * SECOND, (temperature,))
        if k >= lag:
            catch_up.take_up(BEGIN + (k - lag) * SECOND, fused + 0.1 * (k - lag) + np.zeros(N), deviation, (temperature,))
    return temperature


@pytest.mark.parametrize("lag", [0, 3, 25])
def test_it_is_as_warm_as_what_is_fused_by_what_both_were_at_that_time(lag):
    assert run(lag, until=60) == pytest.approx(330.0 + 5.9, abs=0.01)


def test_it_follows_neither_at_once_nor_for_ever_nor_what_is_not_known():
    assert run(0, until=int(FROM) - 1) == pytest.approx(300.0 + 0.1 * (FROM - 1.0))
    catch_up, temperature = CatchUp(1.0), np.full(N, 300.0)
    catch_up.begin(BEGIN)
    for k in range(60):
        catch_up.ran(BEGIN + k * SECOND, (temperature,))
        catch_up.take_up(BEGIN + k * SECOND, np.full(N, 310.0 + 5.0 * (k >= FOLLOWS)), SURE, (temperature,))
    assert temperature == pytest.approx(310.0, abs=0.01)
    unsure = np.where(np.arange(N) < 3, 31.0, 0.3)  # K, and it is 30 K off
    after = run(0, deviation=unsure)
    assert after[:3] == pytest.approx(304.0) and after[3:] == pytest.approx(333.9, abs=0.35)


def test_without_anything_fused_it_gives_up():
    catch_up, temperature = CatchUp(1.0), np.full(N, 300.0)
    catch_up.begin(BEGIN)
    for k in range(100):
        catch_up.ran(BEGIN + k * SECOND, (temperature,))
    catch_up.take_up(BEGIN + 99 * SECOND, np.full(N, 310.0), SURE, (temperature,))
    assert temperature == pytest.approx(300.0)


def test_a_replay_of_which_seconds_are_missing_is_soon_where_the_whole_one_is(paper_cycle_bag):
    whole = read_recording(paper_cycle_bag).between(0.0, 80.0)
    missing = whole
    for topic in ("drive/telemetry", "hydraulics/telemetry"):
        missing = without_samples(missing, topic, 20.0, 45.0)
    truth, result = replay(whole, load_rig()), replay(missing, load_rig())
    motor = slice(len(MOTOR_NODES))
    off = np.abs(result.free_temperature - truth.free_temperature)[:, motor].max(axis=1)
    assert off[np.searchsorted(result.time, 46.0)] > 3.0
    assert off[result.time > 45.0 + FOLLOWS + 0.5].max() < 1.2
    (said,) = (f.message for f in result.recording.findings if "no speed_command is known" in f.message)
    assert said.endswith("or until they are brought back to what is fused or read, after 5 s of it or more")
    winding = result.sensors["motor_winding"]
    late = winding.time > 45.0 + FOLLOWS + 5.0
    assert np.abs(winding.measured - winding.predicted)[late].max() < 1.0
