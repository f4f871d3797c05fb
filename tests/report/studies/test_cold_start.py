"""The sentence of a cold start study."""

from types import SimpleNamespace

from ddh_twin_py.report.studies.cold_start import verdict


def test_the_sentence_counts_what_becomes_of_the_starts():
    outcomes = [SimpleNamespace(verdict=name) for name in ("overheats", "full at once", "overheats", "reaches full speed")]
    assert verdict(outcomes) == "4 starts: full at once 1, reaches full speed 1, overheats 2."
