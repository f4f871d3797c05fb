"""Colours of the page: enough contrast, and told apart by people who see colours otherwise, in light and in dark."""

import itertools
import re
from pathlib import Path

import ddh_twin_py.web as web
import numpy as np
import pytest

ASSETS = Path(web.__file__).parent / "assets"
# Machado, Oliveira, Fernandes (2009), severity 1, on linear RGB.
VISION = {
    "all colours": np.eye(3),
    "protanopia": np.array([[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]),
    "deuteranopia": np.array([[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]),
    "tritanopia": np.array([[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]]),
}  # fmt: skip


def variables(theme):
    css = (ASSETS / "page.css").read_text()
    block = re.search(r':root\[data-theme="dark"\] \{(.*?)\}' if theme == "dark" else r":root \{(.*?)\}", css, re.DOTALL)[1]
    return {name: rgb(value) for name, value in re.findall(r"--([\w-]+): (#[0-9a-f]{6});", block)}


def rgb(text):
    return np.array([int(text[i : i + 2], 16) for i in (1, 3, 5)]) / 255.0


def linear(colour):
    return np.where(colour <= 0.04045, colour / 12.92, ((colour + 0.055) / 1.055) ** 2.4)


def contrast(one, other):
    """WCAG 2.2."""
    light = sorted(float(linear(colour) @ [0.2126, 0.7152, 0.0722]) for colour in (one, other))
    return (light[1] + 0.05) / (light[0] + 0.05)


def lab(colour):
    xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]) @ colour
    f = np.cbrt(np.maximum(xyz / [0.9505, 1.0, 1.089], 0.008856))
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


def apart(one, other, vision):
    """Difference of two colours (CIE 1976) as somebody with that vision sees them."""
    return float(np.linalg.norm(lab(np.clip(VISION[vision] @ linear(one), 0, 1)) - lab(np.clip(VISION[vision] @ linear(other), 0, 1))))


def test_the_measure_itself():
    assert contrast(rgb("#000000"), rgb("#ffffff")) == pytest.approx(21.0)
    red, green = rgb("#b04030"), rgb("#407030")
    assert apart(red, green, "all colours") > 60.0 > 25.0 > apart(red, green, "deuteranopia")


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_words_and_marks_stand_out(theme):
    colours = variables(theme)
    for paper in ("paper", "card"):
        for ink in ("ink", "ink-2", "good", "fair", "poor", "accent", "power"):
            assert contrast(colours[ink], colours[paper]) >= 4.5, (ink, paper)
        for line in ("r-measured", "r-twin", "r-fused", "r-soft"):
            assert contrast(colours[line], colours[paper]) >= 3.0, (line, paper)


@pytest.mark.parametrize("vision", VISION)
@pytest.mark.parametrize("theme", ["light", "dark"])
def test_lines_of_one_chart_are_told_apart(theme, vision):
    """What may stand in one chart: measured, free run and fused; soft sensor and free run. They differ in dashes too."""
    colours = variables(theme)
    for one, other in (("r-measured", "r-twin"), ("r-measured", "r-fused"), ("r-fused", "r-twin"), ("r-soft", "r-twin")):
        assert apart(colours[one], colours[other], vision) > 15.0, (one, other)


@pytest.mark.parametrize("vision", VISION)
def test_cool_and_warm_are_told_apart(vision):
    stops = re.search(r"const STOPS = \[(.*?)\];", (ASSETS / "colours.js").read_text(), re.DOTALL)[1]
    scale = [np.array([float(part) for part in stop.split(",")]) / 255.0 for stop in re.findall(r"\[(\d+, \d+, \d+)\]", stops)]
    assert len(scale) == 6
    for one, other in itertools.pairwise(scale):
        assert apart(one, other, vision) > 12.0
    assert apart(scale[0], scale[-1], vision) > 40.0


def test_no_state_is_told_by_colour_alone():
    """Every state of a sensor or a node has a mark of its own shape, or is one of failure alike."""
    marks = dict(re.findall(r'(\w+): "(.)"', re.search(r"const MARKS = \{(.*?)\}", (ASSETS / "health.js").read_text())[1]))
    assert set(marks) == {"ok", "warn", "error", "stopped", "silent", "absent", "paused"}
    assert len({marks[state] for state in ("ok", "warn", "error", "absent", "paused")}) == 5
