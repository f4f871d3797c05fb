"""Where free inputs say that something unknown acts."""

from dataclasses import replace

import numpy as np
import pytest
from ddh_twin_py.gap.drive.case import reader_of
from ddh_twin_py.gap.drive.learned_terms import terms, terms_at
from ddh_twin_py.gap.explain.refit import Refit
from ddh_twin_py.gap.explain.search import Found
from ddh_twin_py.gap.findings import Lack
from ddh_twin_py.gap.locate.free_places import FreePlace
from ddh_twin_py.gap.verdict.places import located, sized, unknown_places
from ddh_twin_py.gap.verdict.unknown import Unknown
from support.first_order import EFFECTS, FirstOrder
from support.free_inputs import linearised_with, misread, places_in

GAIN, LAG, _ = EFFECTS


def places(model, effects, off=""):
    return places_in(linearised_with(model, effects), off)


def test_a_fault_of_one_direction_alone_lies_where_its_input_enters():
    """No law says so: the gain is larger while the command is positive."""
    model = FirstOrder(np.zeros(3))
    with_more = model.run_one(1, np.zeros(3), [(GAIN, 0, 0.2)])
    plain = model.run_one(1, np.zeros(3))
    for name in plain:
        misread(model, name, lambda share, name=name: np.where(plain[name] > 0.0, with_more[name] - plain[name], 0.0))
    found = places(model, [GAIN, LAG])
    assert (found[0].component, found[0].domain) == ("valve", "hydraulic") and found[0].column.effect is GAIN
    assert found[0].departure > 0.0 and 0.0 < found[0].relative < 0.5
    assert sum(place.share for place in found) == pytest.approx(1.0)
    assert [p.share for p in found] == sorted((p.share for p in found), reverse=True) and found[0].share > 0.9
    assert len({p.component for p in found}) == len(found)


def test_a_reading_that_drifts_away_alone_lies_in_its_meter():
    model = FirstOrder(np.zeros(3))
    misread(model, "other_flow", lambda share: 0.2 * share)
    first = places(model, [GAIN, LAG])[0]
    assert (first.component, first.signal, first.column) == ("other_flow meter", "other_flow", None) and first.share > 0.9


def test_an_input_goes_no_further_than_its_law_allows():
    """Two valves have the same law, and the gain rose by four times of what one of them can."""
    narrow = replace(GAIN, id="stop.gain", component="stop", lowest=-0.05, highest=0.05)
    found = places(FirstOrder(np.zeros(3), [(GAIN, 0, 0.2)]), [GAIN, narrow])
    assert [place.component for place in found if place.column is not None][0] == "valve"
    alone = next(place for place in found if place.component == "stop")
    assert alone.log_evidence < found[0].log_evidence - 1.0


def test_a_place_explains_the_signal_that_surely_is_off():
    """One meter drifts far, the other a little; it is the latter of which something is known."""
    model = FirstOrder(np.zeros(3))
    misread(model, "flow", lambda share: 0.5 * share)
    misread(model, "other_flow", lambda share: 0.1 * share)
    assert places(model, [GAIN, LAG])[0].signal == "flow"
    found = places(model, [GAIN, LAG], off="other_flow")
    assert found[0].signal == "other_flow" and "flow" not in [place.signal for place in found]
    assert places(model, [GAIN, LAG], off="read by nothing")[0].signal == "flow"


def test_where_nothing_is_off_no_place_is_sure():
    assert places(FirstOrder(np.zeros(3)), [GAIN, LAG])[0].share < 0.7


def test_what_no_effect_is_asked_of_can_be_lacking_at_every_part_with_a_balance():
    at = {(term.component, term.domain) for term in terms()}
    assert {("pump_1", "hydraulic"), ("line_b", "hydraulic"), ("motor", "mechanical"), ("tank", "thermal")} <= at
    assert {("motor", "electrical"), ("load", "mechanical"), ("oil", "hydraulic"), ("ambient", "thermal")} <= at
    assert all(terms_at(*place) for place in at) and terms_at("sensor", "measurement") == []
    assert len({term.id for term in terms()}) == len(terms())
    assert reader_of("speed") == "drive" and reader_of("temperature/line_a") == "sensor"


@pytest.mark.parametrize(("shares", "rows"), [([0.6, 0.36, 0.04], ["a", "b"]), ([1.0], ["a", "a", "a", "a"])])
def test_each_of_several_likely_places_has_one_row_and_a_sure_one_its_phases(shares, rows):
    model = FirstOrder(np.zeros(3))
    misread(model, "other_flow", lambda share: 0.2 * share)
    linearised = linearised_with(model, [GAIN, LAG])
    none = Refit(linearised).of([], np.zeros(3), np.zeros(0))
    likely = [FreePlace(name, "measurement", 0.0, share, None, signal="other_flow") for name, share in zip("abc", shares, strict=False)]
    lacking = unknown_places(model, Found(linearised, {(): 1.0}, {(): none}), Unknown(1.0, [], 0.1, "m3/s", places=likely), none)
    assert [row.component for row in lacking] == rows and sum(row.share for row in lacking) == pytest.approx(1.0)
    assert len({row.phase for row in lacking if row.component == "a"}) == rows.count("a")


def test_what_is_unknown_is_as_large_as_what_its_place_lacks():
    at = [FreePlace("sensor", "measurement", 9.0, 0.7, None), FreePlace("tank", "thermal", 5.0, 0.3, None)]
    left = Unknown(0.9, [], 0.099, "A", places=at)
    rows = [Lack("tank", "thermal", "all", "", 40.0, 4.0, "W", 0.3), Lack("sensor", "measurement", "holding", "", 0.0, 0.0, "Pa", 0.4),
            Lack("sensor", "measurement", "lifting", "", -24870.0, 100.0, "Pa", 0.3)]
    assert sized(left, rows).entry() == {"component": "sensor", "domain": "measurement", "size": 24870.0, "unit": "Pa", "depends_on": []}
    none = sized(left, rows[:2])
    assert (none.size, none.unit) == (0.0, "Pa")


def test_a_reading_that_errs_is_as_large_as_it_errs_also_where_its_mean_is_nothing():
    model = FirstOrder(np.zeros(3))
    misread(model, "other_flow", lambda share: 0.4 * (share - 0.5))
    linearised = linearised_with(model, [GAIN, LAG])
    found = places_in(linearised)
    none = Refit(linearised).of([], np.zeros(3), np.zeros(0))
    unknown = located(Unknown(1.0, [], 7.0, "K"), linearised, found)
    rows = unknown_places(model, Found(linearised, {(): 1.0}, {(): none}), unknown, none)
    assert sized(unknown, rows) is unknown and unknown.places[0].signal == "other_flow"
    assert unknown.size == pytest.approx(0.4 / 12.0**0.5, rel=0.15) and unknown.unit == model.signals[1]["other_flow"].unit
