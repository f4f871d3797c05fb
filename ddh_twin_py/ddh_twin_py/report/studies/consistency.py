"""The page of a validation: is the estimate as wrong as it says, on rigs whose truth is known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict

import numpy as np

from ddh_twin_py.estimation.consistency import (
    AS_SAID,
    HIDDEN,
    JUDGED,
    LEVEL,
    TOO_LITTLE,
    Band,
    SeedErrors,
    hot_spot_inside,
    nees_band,
    nis_band,
    verdict,
)
from ddh_twin_py.report.page import document as doc
from ddh_twin_py.report.page.curve_plot import Curve, curve_plot
from ddh_twin_py.report.units import number, words
from ddh_twin_py.rig import Rig

_ASSUMPTIONS = (
    "Each rig is drawn within the sheet's tolerances, with a start, unknown heats, sensor lags, offsets and noise as the filter believes "
    "them: this tests the filter's arithmetic and linearisation, and not whether a real rig is of that kind.",
    "The simulated rigs run the twin's own equations at a finer step.",
    f"Bands are the central {100.0 * LEVEL:.0f} % of the chi-square distribution over the rigs at one instant; instants depend on each "
    "other.",
)


def consistency_end(rig: Rig, errors: Sequence[SeedErrors], first: int, duration: float, duty: str) -> doc.EndMatter:
    """What the numbers rest on."""
    return doc.EndMatter(
        "Nothing was fitted. The truth of each rig is known and is compared with what the estimate said at that time.", rig.file,
        _ASSUMPTIONS, [("Rigs", f"{len(errors)}, seeds {first} to {first + len(errors) - 1}"), ("Length of each", f"{duration:g} s"),
                       ("Duty", duty)],
    )


def consistency_json(rig: Rig, errors: Sequence[SeedErrors], first: int, duration: float, duty: str) -> dict:
    """The machine-readable twin of the page."""
    nees, nis, inside = nees_band(list(errors)), nis_band(list(errors)), hot_spot_inside(list(errors))
    return {
        "report": "consistency", "verdict": verdict(nees, nis, inside, len(errors)),
        "seeds": [first, first + len(errors) - 1], "duration_s": duration, "duty": duty,
        "nees_per_node": asdict(nees), "nis_per_reading": asdict(nis), "hot_spot_inside_95": inside,
        "hot_spot_std_mean_K": float(np.mean([e.hot_spot_std for e in errors])),
        "mean_squared_error_K2": {"filtered": _mean(errors, "squared"), "smoothed": _mean(errors, "smoothed_squared")},
        "end_matter": consistency_end(rig, errors, first, duration, duty).as_json(),
    }


def consistency_document(rig: Rig, errors: Sequence[SeedErrors], first: int, duration: float, duty: str) -> doc.Document:
    """The page: both statistics over time with their bands, the hidden hot spot, filter against smoother."""
    nees, nis, inside = nees_band(list(errors)), nis_band(list(errors)), hot_spot_inside(list(errors))
    said = verdict(nees, nis, inside, len(errors))
    page = doc.Document(
        kind="Validation of the estimate", title=f"{rig.rig_id}: is it as wrong as it says?", verdict=said,
        level=_level(said), end=consistency_end(rig, errors, first, duration, duty),
    )
    filtered, smoothed = (_mean(errors, name) for name in ("squared", "smoothed_squared"))
    page.add("At a glance", doc.figures([
        doc.Figure("Rigs", str(len(errors)), f"{duration:g} s each, {words(duty.rsplit('/', 1)[-1])}"),
        doc.Figure("Errors of all nodes", number(nees.mean, 3), f"1 is as said; {_band(nees)}"),
        doc.Figure("Innovations", number(nis.mean, 3), f"1 is as said; {_band(nis)}"),
        doc.Figure("Hidden hot spot", f"{100.0 * inside:.1f} %", f"within its 95 % interval, {words(HIDDEN)} withheld"),
        doc.Figure("Error, filtered", f"{number(np.sqrt(filtered), 2)} K", "RMS of all nodes"),
        doc.Figure("Error, smoothed", f"{number(np.sqrt(smoothed), 2)} K", "RMS of all nodes"),
    ]))
    time = errors[0].time
    node = np.sum([e.nees for e in errors], axis=0) / (len(errors) * JUDGED.size)
    readings = np.sum([e.readings for e in errors], axis=0)
    innovation = np.sum([e.nis for e in errors], axis=0) / np.maximum(readings, 1)
    page.add(
        "Over time",
        doc.Html('<div class="plots large">' + _over(time, node, nees, "squared errors of nodes over their variance")
                 + _over(time, np.where(readings > 0, innovation, np.nan), nis, "squared innovations over their variance") + "</div>"),
        doc.note("Line: mean over the rigs at one instant. Grey: the band in which it lies in 95 of 100 instants if the estimate is "
                 "exactly as wrong as it says. Above the band it is too sure, below it more wary than it need be."),
    )
    columns = (doc.Column("Statistic", number=False), doc.Column("Mean"), doc.Column("Band of one instant", number=False),
               doc.Column("Instants inside"), doc.Column("Instants"))
    page.add("Numbers", doc.table(columns, [
        (name, number(band.mean, 3), _band(band), f"{100.0 * band.inside:.0f} %", str(band.instants))
        for name, band in (("errors of all nodes, whitened", nees), ("innovations", nis))
    ]))
    return page


def _level(said: str) -> str:
    return "good" if said.startswith(AS_SAID) else "fair" if said.startswith(TOO_LITTLE) else "poor"


def _over(time: np.ndarray, value: np.ndarray, band: Band, title: str) -> doc.Html:
    flat = [np.full(time.size, edge) for edge in (1.0, band.lower, band.upper)]
    return curve_plot([Curve("band", "measured", time, *flat), Curve("mean", "fused", time, value, value, value, band=False)],
                      "time, s", title, width=460, height=210)


def _band(band: Band) -> str:
    return f"{number(band.lower, 3)} to {number(band.upper, 3)}"


def _mean(errors: Sequence[SeedErrors], field: str) -> float:
    return float(np.mean([getattr(e, field) for e in errors]))
