"""The running verdict in words."""

import math

from ddh_twin_py.gap.watch.watch import UNITS
from ddh_twin_py.web.gap_news import PLACES, SignalNews, gap_document

NAN = math.nan


def news(signal, statistic=0.0, opened=False, floors=NAN, since=0.0, tested=True, learned=1.0):
    return SignalNews(signal, UNITS[signal], tested, learned, 2e4, statistic, 10.0 if tested else NAN, opened, since,
                      floors * 2e4, 1e3 if opened else NAN, floors)  # fmt: skip


def test_while_it_learns_nothing_is_said_of_a_gap():
    told = gap_document("", "", [news("speed", tested=False, learned=0.3), news("current", tested=False, learned=0.25)], 50.0, 1000.0)
    assert told["state"] == "learning" and told["verdict"] == "Learning what is normal, 30 %; nothing is tested before."


def test_no_gap_and_what_is_on_its_way_comes_first():
    told = gap_document("", "", [news("speed", 1.0), news("current", 7.0)], 50.0, 1000.0)
    assert told["state"] == "none" and "agree in 2 signals" in told["verdict"]
    assert [(row["signal"], row["share"]) for row in told["signals"]] == [("current", 0.7), ("speed", 0.1)]


def test_an_open_gap_with_where_how_large_and_since_when():
    signals = [news("speed", 1.0), news("temperature/tank_oil", 12.0, True, 1.5, 900.0), news("pressure_rod_side", 30.0, True, -4.0, 300.0)]
    told = gap_document("sensor", "it reads wrong", signals, 1000.0, 1000.0)
    assert told["state"] == "open"
    assert told["verdict"] == (
        "A gap is open in pressure rod side, tank oil, for 12 min of data; largest 4.0 times the noise floor. It points to: sensor."
    )
    first, second, third = told["signals"]
    assert (first["signal"], first["place"], first["size"], first["since"]) == ("pressure_rod_side", "line_b", "−0.80 ± 0.01 bar", 300.0)
    assert second["place"] == "tank_oil" and not third["opened"] and third["since"] is None and third["size"] == ""


def test_every_signal_has_a_place_on_the_drawing():
    assert set(PLACES) | {name for name in UNITS if name.startswith("temperature/")} == set(UNITS)
