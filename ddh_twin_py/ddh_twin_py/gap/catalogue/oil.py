"""The oil itself."""

from __future__ import annotations

import math

import numpy as np

from ddh_twin_py.gap.effect import Beside, Effect, added, value_of

_KEPT_AT = math.log10(313.15)
_GRADE = 0.1 / math.sqrt(3.0)
"""Standard deviation of a share that is as likely anywhere within a tenth, where ISO 3448 has a grade's viscosity at 40 degC; fitted as a
Gaussian of it that ends at the tenth."""


def _slope(record: np.ndarray, x: float) -> None:
    """Walther's B with the viscosity at 40 degC kept."""
    record["oil_walther_b"] += x
    record["oil_walther_a"] += x * _KEPT_AT


def more_viscous(record: np.ndarray, share: float) -> None:
    """A share more viscous at 40 degC, Walther's slope as it is."""
    record["oil_walther_a"] += math.log10(math.log10(_viscosity(record) * (1.0 + share) + 0.7)) - _loglog(record)


def _of_its_grade(record: np.ndarray, deviations: float) -> None:
    """Another oil of the grade."""
    more_viscous(record, _GRADE * deviations)


def _loglog(record: np.ndarray) -> float:
    return float((record["oil_walther_a"] - record["oil_walther_b"] * _KEPT_AT)[0])


def _viscosity(record: np.ndarray) -> float:
    """At 40 degC, mm2/s."""
    return 10.0 ** 10.0 ** _loglog(record) - 0.7


EFFECTS = (
    Effect(
        id="oil.viscosity_temperature", component="oil", domain="hydraulic", parameter="viscosity_index_slope", unit="1",
        title="oil: viscosity over temperature",
        reference=value_of("oil_walther_b"), laws=(_slope,), step=0.05, lowest=-0.9, highest=0.9,
        about="The oil's viscosity changes with temperature otherwise than {reference} (another grade in the tank).",
        law="log10 log10(nu + 0.7) = A - B log10 T, viscosity at 40 degC kept, to within the 10 % of a grade (ISO 3448)",
        signature="Leakage, viscous friction and line drop change together, and with the oil's temperature.",
        check="Draw a sample from the tank, at rest and depressurised, and measure its viscosity at two temperatures.",
        confused_with=(
            "pump_1.leakage", "pump_2.leakage", "pump_1.friction", "pump_2.friction", "line_a.pressure_drop", "line_b.pressure_drop",
        ),
        beside=Beside(_of_its_grade, math.sqrt(3.0), _viscosity,
                      "At 40 degC the oil is {change} viscous than it was: oils of one grade differ by up to a tenth to either side."),
    ),
    Effect(
        id="oil.air_content", component="oil", domain="hydraulic", parameter="volume_fraction", unit="1",
        reference=value_of("oil_air_fraction"), laws=(added("oil_air_fraction"),), step=0.005, lowest=-0.006, highest=0.25,
        about="Entrained air makes the oil softer at low pressure.",
        about_below="There is less air in the oil than {reference}, which makes it stiffer at low pressure.",
        law="1/K = 1/K_liquid + (phi/(n p)) (p_0/p)^(1/n)",
        signature="Pressure rises later at the start of a stroke; strokes lose a little; nothing when steady.",
        check="Look at the oil in the sight glass; repeat after an hour of rest.",
        confused_with=("pump_1.leakage", "line_b.compliance", "drive.speed_lag", "sensor.time_skew"),
    ),
)
