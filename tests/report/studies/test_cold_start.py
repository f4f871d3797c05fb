"""The sentence of a cold start study."""

import math
from types import SimpleNamespace

from ddh_twin_py.report.studies.cold_start import cold_start_document, flips, verdict
from ddh_twin_py.rig import load_rig
from ddh_twin_py.twin.cold_start import Case


def test_the_sentence_counts_what_becomes_of_the_starts():
    outcomes = [SimpleNamespace(verdict=name) for name in ("overheats", "full at once", "overheats", "reaches full speed")]
    assert verdict(outcomes) == "4 starts: full at once 1, reaches full speed 1, overheats 2."


def started(ambient, verdict, **more):
    given = {"viscosity": 100.0, "first_raise": 1.0, "first_lower": 1.0, "first_limit": "", "final_share": 0.5, "cavitating": 0.0,
             "time_to_full": math.nan, "extrapolated": False, "tank_oil": 30.0, "pump_oil": 31.0, "winding": 138.0, "winding_peak": 149.0}
    return SimpleNamespace(case=Case(ambient, "ISO VG 32", "mixed"), verdict=verdict, **given, **more)


def test_of_what_overheats_it_is_said_what_and_when():
    over = {-10: 1620.0, 0: 1500.0, 20: 80.0}
    outcomes = [started(t, "overheats", time_over_limit=over[t]) if t in over else started(t, "stays slow") for t in (-30, -10, 0, 10, 20)]
    assert flips(outcomes) == [(
        "mixed", "ISO VG 32", "stays slow at -30 degC; overheats at -10 to 0 degC (the winding, after 25 min to 27 min); stays slow at 10 "
        "degC; overheats at 20 degC (the winding, after 80 s)")]


def test_the_map_of_the_winding_holds_what_is_judged():
    """149 of a winding that is at 138 in the last cycle: the limit of 145 was passed."""
    page = cold_start_document(load_rig(), [started(-10, "overheats", time_over_limit=1620.0)], 8.0, 1.0).html()
    assert ">149<" in page and ">138<" not in page
