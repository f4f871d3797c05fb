"""A described rig through the whole engine: what acts is found, built in, and then nothing is left."""

from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.estimation.fitting.comparison import Comparison, Discrepancy
from ddh_twin_py.gap import answer
from ddh_twin_py.gap.evidence.slopes import slopes_of
from ddh_twin_py.real_rigs.controls import on_real, on_simulated
from ddh_twin_py.real_rigs.diagnose import diagnose, found_by, rounds
from ddh_twin_py.real_rigs.rig_model import RigModel
from support.heated_block import DESCRIPTION, block

OFFSET, BEND, DRAUGHT = DESCRIPTION.effects
LEFT = {OFFSET.id: 0.4, BEND.id: 0.3, DRAUGHT.id: 0.3}


@pytest.mark.parametrize("effect, x", [(OFFSET, 0.3), (OFFSET, -0.3), (BEND, 0.06), (DRAUGHT, 0.4)])
def test_what_acts_is_found_and_then_nothing_more(effect, x):
    outcomes = rounds(block([(effect, 0, x)]))
    assert [o.verdict for o in outcomes] == ["explained", "no_gap"] and outcomes[0].believed == (effect.id,)
    gap = outcomes[0].diagnosis.report["gap"]
    assert gap["after"] < gap["before"]
    model, fitted = outcomes[-1].model, outcomes[-1].plain
    assert found_by(outcomes) == [effect.id]
    found = next(p for p in model.fitted_parameters(fitted.theta, np.ones(model.size)) if p.name.startswith(effect.id))
    assert abs(found.value - x) < LEFT[effect.id] * abs(x)
    assert on_simulated(model, fitted.theta).passed


def test_none_is_none_and_parameters_are_found():
    outcome = diagnose(block(theta=(0.5, -0.5)))
    assert outcome.verdict == "no_gap" and outcome.believed == ()
    assert outcome.plain.theta == pytest.approx([0.5, -0.5], abs=0.15)
    assert {p.name: p.unit for p in outcome.diagnosis.parameters} == {"gain": "K/W", "lag": "s"}


def test_what_held_out_data_ask_of_the_rig_is_told_and_progress_goes_on(monkeypatch):
    monkeypatch.setattr(answer, "asked_of_rig", lambda *_: "gain")
    shares = []
    outcome = diagnose(block(theta=(0.5, -0.5)), shares.append)
    assert any("with another gain" in note for note in outcome.diagnosis.report["notes"])
    assert shares == sorted(shares) and shares[-1] == 1.0 and any(0.9 < share < 1.0 for share in shares)


def test_what_nobody_listed_is_told_with_its_place_its_size_and_on_what_it_depends():
    clean, odd = block(seed=3), block()
    for run in odd.field:
        reading = run.signals["temperature"]
        run.signals["temperature"] = replace(reading, measured=reading.measured + np.where(run.command > 1.0, 0.4, 0.0))
    outcome = diagnose(RigModel(replace(DESCRIPTION, effects=()), odd.field, commissioning=clean.field))
    found = outcome.diagnosis.report["unknown"]
    assert outcome.verdict == "unknown" and (found["component"], found["domain"]) == DESCRIPTION.places["temperature"]
    assert 0.05 < found["size"] < 0.4 and found["unit"] == "K" and "warmth" in found["depends_on"]


def test_neutral_values_are_the_baseline_exactly():
    model = block()
    plain = model.run(np.zeros(2))[0]["temperature"]
    for effect in DESCRIPTION.effects:
        np.testing.assert_array_equal(model.run(np.zeros(2), [(effect, 0, 0.0)])[0]["temperature"], plain)


def test_an_effect_built_in_acts_as_it_did():
    model = block()
    built = model.with_effects(np.zeros(2), [(BEND, 0, 0.05)], [0.01])
    np.testing.assert_allclose(built.run(np.zeros(3))[0]["temperature"], model.run(np.zeros(2), [(BEND, 0, 0.05)])[0]["temperature"])
    assert built.size == 3 and BEND not in built.effects
    again = built.with_effects(np.array([0.0, 0.0, 1.0]), [(OFFSET, 0, 0.1)], [0.02])
    assert [b.effect.id for b in again.built_in] == [BEND.id, OFFSET.id] and again.built_in[0].x == pytest.approx(0.08)


def test_sensitivities_are_differences_of_runs():
    from concurrent.futures import ThreadPoolExecutor

    model = block()
    comparison = Comparison(model.signals[0], model.run(np.zeros(2))[0], Discrepancy())
    with ThreadPoolExecutor(2) as pool:
        (rows,) = slopes_of(model, pool, np.zeros(2), [comparison], [0])
    moved = comparison.features(model.run(np.array([0.0, 0.3]))[0]) - comparison.features(model.run(np.zeros(2))[0])
    assert np.corrcoef(rows[:, 1], moved)[0, 1] > 0.99


def test_a_wrong_belief_on_real_data_is_told():
    outcome = diagnose(block([(OFFSET, 0, 0.3)]))
    assert on_real(outcome, lambda o: (1.0, 0.5)).passed
    assert not on_real(outcome, lambda o: (1.0, 1.5)).passed
