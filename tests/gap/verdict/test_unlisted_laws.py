"""One law that no catalogue lists against what listed effects do together."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.estimation.sensors import NODE_OF_SENSOR
from ddh_twin_py.gap.drive.learned_terms import terms_at, unlisted_laws
from ddh_twin_py.gap.evidence.linearised import linearise
from ddh_twin_py.gap.evidence.question import Question
from ddh_twin_py.gap.explain.refit import Refit
from ddh_twin_py.gap.explain.search import Found
from ddh_twin_py.gap.locate.free_places import FreePlace
from ddh_twin_py.gap.verdict.unknown import Unknown
from ddh_twin_py.gap.verdict.unlisted_laws import UnlistedLaw, beside_law, best_unlisted, place_of
from ddh_twin_py.rig import load_rig
from ddh_twin_py.rig.sheet import FIELD_OF_PATH
from support.first_order import EFFECTS, FirstOrder

GAIN, LAG, OFFSET = EFFECTS


class WithLaws(FirstOrder):
    """The flow loop that knows laws beyond its catalogue."""

    laws = (OFFSET,)

    def unlisted_laws(self):
        return self.laws


def searched(model, listed, leading):
    """What a search for listed effects leaves, led by a set of them, and that set."""
    with ThreadPoolExecutor(2) as pool:
        linearised = linearise(Question(model, listed), np.zeros(3), pool)
    refit = Refit(linearised)
    columns = [next(c for c in linearised.columns if c.effect.id == name) for name in leading]
    none, best = refit.of([], np.zeros(3), np.zeros(0)), refit.of(columns, np.zeros(3), np.ones(len(columns)))
    return Found(linearised, {best.effects: 0.99, (): 0.01}, {(): none, best.effects: best}), best


def law_of(model, listed, leading, gap=lambda fitted: 1.0):
    found, best = searched(model, listed, leading)
    return best_unlisted(model, found, best, gap)


def test_a_law_that_explains_more_than_a_listed_pair_is_what_is_believed():
    law = law_of(WithLaws(np.zeros(3), [(OFFSET, 0, 0.2)], seed=2), [GAIN, LAG], [GAIN.id, LAG.id])
    assert law.effect is OFFSET and law.probability > 0.99 and law.ahead > 10.0
    assert law.fitted.x[0] == pytest.approx(0.2, abs=0.02)


def test_held_out_data_that_speak_against_a_law_are_heard():
    model = WithLaws(np.zeros(3), [(OFFSET, 0, 0.2)], seed=2)
    assert law_of(model, [GAIN, LAG], [GAIN.id, LAG.id], lambda fitted: 3.0 if OFFSET.id in fitted.effects else 1.2) is None


def test_where_they_speak_against_the_law_of_most_evidence_the_next_is_asked():
    model = WithLaws(np.zeros(3), [(OFFSET, 0, 0.2)], seed=2)
    twin = replace(OFFSET, id="meter.twin", lowest=-0.19, highest=0.19)
    model.laws = (OFFSET, twin)
    assert law_of(model, [GAIN, LAG], [GAIN.id, LAG.id]).effect is OFFSET
    law = law_of(model, [GAIN, LAG], [GAIN.id, LAG.id], lambda fitted: 3.0 if OFFSET.id in fitted.effects else 1.2)
    assert law.effect is twin and law.probability > 0.99


def test_a_listed_effect_that_acts_keeps_what_it_has():
    law = law_of(WithLaws(np.zeros(3), [(GAIN, 0, 0.3)], seed=2), [GAIN, LAG], [GAIN.id])
    assert law is None or law.probability < 1e-3


def test_of_a_law_and_a_listed_effect_that_do_the_same_the_listed_one_is_likelier():
    """The same law in the catalogue and beyond it: two of three go to the catalogue."""
    law = law_of(WithLaws(np.zeros(3), [(OFFSET, 0, 0.2)], seed=2), [OFFSET], [OFFSET.id])
    assert abs(law.ahead) < 0.1 and law.probability < 0.1


def test_a_model_without_such_laws_is_asked_nothing():
    model = WithLaws(np.zeros(3), [(OFFSET, 0, 0.2)], seed=2)
    model.laws = ()
    assert law_of(model, [GAIN, LAG], [GAIN.id]) is None


def law(probability):
    model = WithLaws(np.zeros(3), [(OFFSET, 0, 0.2)], seed=2)
    return UnlistedLaw(searched(model, [OFFSET], [OFFSET.id])[1], probability, 3.0)


def test_a_likely_law_says_where_and_takes_the_form_of_what_no_effect_leaves():
    beside, of_none = Unknown(0.1, ["of the pair"], 0.0, "1", off="flow"), Unknown(0.9, ["of none"], 0.0, "1")
    told = beside_law(beside, law(0.8), of_none, ["a", "b"], "offset 0.2 m3/s")
    assert told.probability == pytest.approx(1.0 - 0.9 * 0.2) and told.forms == ["of none"] and told.off == "flow"
    assert "better than a and b" in told.notes[-1] and "offset 0.2 m3/s" in told.notes[-1]
    hardly = beside_law(beside, law(0.2), of_none, ["a", "b"], "offset 0.2 m3/s")
    assert hardly.probability == pytest.approx(1.0 - 0.9 * 0.8) and hardly.forms == ["of the pair"] and not hardly.notes
    own, other = place_of(law(0.8), [FreePlace("meter", "hydraulic", 9.0, 0.7, None), FreePlace("valve", "hydraulic", 3.0, 0.3, None)])
    assert (own.component, own.share, other.component) == ("meter", 0.8, "valve") and other.share == pytest.approx(0.2)
    assert own.departure * own.column.x == pytest.approx(0.2, abs=0.02) and own.relative > 0.0


@pytest.mark.parametrize("number", [1, 2])
def test_a_pump_s_filling_is_a_law_and_a_term_of_its_place(number):
    laws = {one.id for one in unlisted_laws() if one.component == f"pump_{number}"}
    assert len(laws) == 2 and laws <= {term.id for term in terms_at(f"pump_{number}", "hydraulic")}
    for one in unlisted_laws():
        record = load_rig().parameters
        one.laws[0](record, 0.5 * one.highest)
        moved = [name for name in record.dtype.names if record[name][0] != load_rig().parameters[name][0]]
        field = f"{'measurement' if one.reading else one.component}.{one.parameter}"
        field = {"oil": "oil.walther_a", "drive": f"motor.{one.parameter.replace('_', '_loop_')}"}.get(one.component, field)
        assert moved == [FIELD_OF_PATH[field]]


@pytest.mark.parametrize("share", [-0.3, 0.44])
def test_an_oil_of_another_grade_is_a_law_by_which_its_viscosity_at_40_degc_is_another(share):
    record, (law,) = load_rig().parameters, [one for one in unlisted_laws() if one.component == "oil"]
    law.laws[0](record, share)

    def viscosity(of, kelvin):
        return 10.0 ** 10.0 ** float(of["oil_walther_a"][0] - of["oil_walther_b"][0] * np.log10(kelvin)) - 0.7

    assert viscosity(record, 313.15) == pytest.approx(viscosity(load_rig().parameters, 313.15) * (1.0 + share))
    assert (viscosity(record, 293.15) > viscosity(load_rig().parameters, 293.15)) == (share > 0.0)
    assert law.reference(record) == 1.0 and ("less" if share < 0.0 else "more") in law.happens(share)


def test_a_drive_that_misses_its_command_is_a_law_of_the_drive():
    record = load_rig().parameters
    gain, zero = (one for one in unlisted_laws() if one.component == "drive")
    gain.laws[0](record, -0.02)
    zero.laws[0](record, 0.3)
    assert (record["motor_speed_loop_gain"][0], record["motor_speed_loop_zero"][0]) == (0.98, 0.3)
    assert gain.reference(load_rig().parameters) == 1.0 and "slower" in gain.happens(-0.02) and "at rest" in zero.happens(0.3)


def test_each_temperature_sensor_s_zero_is_a_law_of_its_reading():
    zeros = {one.reading: one for one in unlisted_laws() if one.reading}
    assert zeros.keys() == {f"temperature/{name}" for name in NODE_OF_SENSOR} and all(one.component == "sensor" for one in zeros.values())
    assert "tank_oil reads too warm" in zeros["temperature/tank_oil"].happens(3.0)
    assert "tank_oil reads too cold" in zeros["temperature/tank_oil"].happens(-3.0)


def test_a_law_of_one_reading_names_it():
    found = law(0.8)
    column = replace(found.fitted.columns[0], effect=replace(OFFSET, component="sensor", reading="temperature/tank_oil"))
    own, *_ = place_of(replace(found, fitted=replace(found.fitted, columns=(column,))), [])
    assert (own.component, own.signal) == ("sensor", "temperature/tank_oil")
