"""The smoothed temperatures of a replay: table, charts, JSON."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ddh_twin_py.estimation.sensors import SENSOR_OF_NODE
from ddh_twin_py.physics.thermal_network import NODES
from ddh_twin_py.report.page import document as doc
from ddh_twin_py.report.page.charts import Chart, Trace
from ddh_twin_py.report.replay.agreement import SETTLING
from ddh_twin_py.report.times import starts
from ddh_twin_py.report.units import ZERO_CELSIUS, celsius, number, words

if TYPE_CHECKING:
    from ddh_twin_py.estimation.replay_result import ReplayResult

_MOST_CHARTS = 4
NOTE = (
    "Smoothed: each instant from all readings before and after it (fixed-interval smoother over the filter's steps); fused: from "
    "those before it, as a live twin has it. At the end of the recording both are the same. σ is one standard deviation, its mean "
    "over the recording."
)


def smoothed_json(result: ReplayResult) -> dict:
    """Per node: mean standard deviation of fused and smoothed estimate, smoothed temperature at start and end."""
    rows = result.smoothed_row
    if not rows.size:
        return {}
    fused = result.fused_std[rows].mean(axis=0)
    return {
        "instants": int(rows.size),
        "nodes": [
            {
                "node": node, "sensor": SENSOR_OF_NODE.get(node), "fused_std_mean_K": float(fused[i]),
                "smoothed_std_mean_K": float(result.smoothed_std[:, i].mean()),
                "smoothed_first_degC": float(result.smoothed[0, i] - ZERO_CELSIUS),
                "smoothed_first_std_K": float(result.smoothed_std[0, i]),
                "smoothed_last_degC": float(result.smoothed[-1, i] - ZERO_CELSIUS),
                "rms_difference_K": float(np.sqrt(np.mean((result.smoothed[:, i] - result.fused[rows, i]) ** 2))),
            }
            for i, node in enumerate(NODES)
        ],
    }


def smoothed_table(result: ReplayResult) -> doc.Html:
    """How much the readings that came later tell, node by node."""
    columns = (
        doc.Column("Thermal node", number=False), doc.Column("First, smoothed ± σ", "°C"), doc.Column("σ fused", "K, mean"),
        doc.Column("σ smoothed", "K, mean"), doc.Column("Difference", "K, RMS"), doc.Column("Sensor", number=False),
    )
    rows = [
        (
            words(row["node"]), f"{celsius(row['smoothed_first_degC'] + ZERO_CELSIUS)} ± {number(row['smoothed_first_std_K'], 2)}",
            number(row["fused_std_mean_K"], 2), number(row["smoothed_std_mean_K"], 2), number(row["rms_difference_K"], 2),
            words(row["sensor"]) if row["sensor"] else "none",
        )
        for row in smoothed_json(result)["nodes"]
    ]
    return doc.table(columns, rows)


def smoothed_charts(result: ReplayResult, time: np.ndarray) -> list[Chart]:
    """Nodes that no sensor of the recording reads and that are known least: the fused estimate with its band, and the smoothed one."""
    read = {c.node for c in result.sensors.values() if c.used}
    hidden = [i for i, node in enumerate(NODES) if node not in read]
    hidden.sort(key=lambda i: -result.fused_std[result.smoothed_row, i].mean())
    rows = result.smoothed_row
    return [
        Chart(
            words(NODES[i]).capitalize(), "°C", time[rows],
            (
                Trace("fused ± 2σ", "fused", result.fused[rows, i] - ZERO_CELSIUS, spread=2.0 * result.fused_std[rows, i]),
                Trace("smoothed", "c2", result.smoothed[:, i] - ZERO_CELSIUS),
            ),
            height=190, unsettled=[(time[k], time[k] + SETTLING) for k in starts(result.time)],
        )
        for i in hidden[:_MOST_CHARTS]
    ]
