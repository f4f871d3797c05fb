"""The drawing of the circuit: every component of the contract, well-formed, coloured as told."""

import re
from importlib import resources
from xml.etree import ElementTree

import pytest
import yaml
from ddh_twin_py.report.page.circuit_drawing import COMPONENTS, STEPS, Tint, circuit_drawing, step_of


def groups(svg):
    return {g.attrib["data-component"]: g for g in ElementTree.fromstring(svg).iter("g")}


def test_every_component_of_the_contract_is_drawn(shared_dir):
    contract = yaml.safe_load((shared_dir / "effects.yaml").read_text())
    assert set(COMPONENTS) == set(contract["components"])
    drawn = groups(circuit_drawing({}, "plain"))
    assert set(drawn) == set(COMPONENTS)
    assert all(g.attrib["class"] == "q0" and len(list(g)) > 1 for g in drawn.values())


def test_colour_and_words_stand_at_their_component():
    for name in COMPONENTS:
        svg = circuit_drawing({name: Tint(4, "−1 <L/min>", "said & meant")}, "one")
        drawn = groups(svg)
        assert drawn[name].attrib["class"] == "q4"
        assert [g for g in drawn if drawn[g].attrib["class"] != "q0"] == [name]
        assert drawn[name].find("title").text == "said & meant"
        assert sum("−1 <L/min>" in "".join(t.itertext()) for t in ElementTree.fromstring(svg).iter("text")) == 1


def test_words_stay_inside_and_apart():
    """With a value at every component, no two labels overlap and none leaves the drawing (7.6 units a letter of 16)."""
    svg = ElementTree.fromstring(circuit_drawing({name: Tint(1, "−0.432 ± 0.018 L/min") for name in COMPONENTS}, "all"))
    _, _, width, height = map(float, svg.attrib["viewBox"].split())
    boxes = []
    for words in svg.iter("text"):
        if words.attrib.get("class") in ("tag", "symbol"):
            continue
        said, x, y = "".join(words.itertext()), float(words.attrib["x"]), float(words.attrib["y"])
        long = 7.6 * len(said)
        left = {"start": x, "middle": x - long / 2, "end": x - long}[words.attrib["text-anchor"]]
        assert 0.0 <= left and left + long <= width and 12.0 <= y <= height, said
        boxes.append((said, left, left + long, y - 11.0, y + 2.0))
    for i, (a, l1, r1, t1, b1) in enumerate(boxes):
        for b, l2, r2, t2, b2 in boxes[i + 1:]:
            assert r1 <= l2 or r2 <= l1 or b1 <= t2 or b2 <= t1, (a, b, l1, l2, t1, t2)


def test_only_sensors_that_were_recorded_are_drawn():
    def letters(recorded):
        drawn = groups(circuit_drawing({}, "plain", recorded))["sensor"].iter("text")
        return [(t.text, t.attrib["x"]) for t in drawn]

    assert len(letters(None)) == 7
    assert letters({"temperature/tank_oil", "speed"}) == [("T", "714")]
    assert sorted(t for t, _ in letters({"pressure_rod_side", "temperature/motor_winding"})) == ["T", "p"]


def pieces(path):
    """Straight pieces of a path of M, h, v, H and V, as x and y of both ends."""
    x = y = 0.0
    for letter, numbers in re.findall(r"([MhvHV])([-\d. ]+)", path):
        values = [float(n) for n in numbers.split()]
        at = {"M": values[:2], "h": [x + values[0], y], "v": [x, y + values[0]], "H": [values[0], y], "V": [x, values[0]]}[letter]
        if letter != "M":
            yield x, y, *at
        x, y = at


@pytest.mark.parametrize("name", ["relief valve", "check valves"])
def test_no_pipe_goes_through_the_name_of_a_valve(name):
    svg = circuit_drawing({}, "plain")
    words = next(t for t in ElementTree.fromstring(svg).iter("text") if t.text == name)
    x, y, long = float(words.attrib["x"]), float(words.attrib["y"]), 7.6 * len(name)
    left = x - long if words.attrib["text-anchor"] == "end" else x
    thin = [p.attrib["d"] for p in ElementTree.fromstring(svg).iter("path") if p.attrib.get("class") == "thin"]
    assert len(thin) == 3
    for x1, y1, x2, y2 in (piece for path in thin for piece in pieces(path)):
        apart = max(x1, x2) < left or min(x1, x2) > left + long or max(y1, y2) < y - 12.0 or min(y1, y2) > y + 3.0
        assert apart, (name, x1, y1, x2, y2)


def test_a_component_that_is_none_is_named():
    with pytest.raises(ValueError, match="no component 'pump_3'"):
        circuit_drawing({"pump_3": Tint(1, "")}, "x")


def test_steps_rise_with_the_share():
    steps = [step_of(share) for share in (0.0, 1e-6, 0.1, 0.3, 0.5, 1.0)]
    assert steps == [0, 1, 2, 3, 4, 5] and STEPS == 6


def luminance(colour):
    """Relative luminance of WCAG 2 of #rrggbb."""
    channels = [int(colour[n:n + 2], 16) / 255.0 for n in (1, 3, 5)]
    return sum(w * (c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4)
               for w, c in zip((0.2126, 0.7152, 0.0722), channels, strict=True))


@pytest.mark.parametrize("theme, sign", [("", -1), ('[data-theme="dark"]', 1)])
def test_colours_are_told_apart_by_lightness_alone(theme, sign):
    """Read alike with any colour vision and in grey: each step is lighter or darker than the one before by 1.1 in contrast."""
    style = resources.files("ddh_twin_py.report").joinpath("assets/style.css").read_text("utf-8")
    rule = next(r for r in re.findall(re.escape(":root" + theme) + r" \{([^}]*)\}", style) if "--q0" in r)
    found = dict(re.findall(r"--(q\d): (#[0-9a-f]{6})", rule))
    light = [luminance(found[f"q{i}"]) + 0.05 for i in range(STEPS)]
    ratios = [(b / a) ** sign for a, b in zip(light, light[1:], strict=False)]
    assert all(r > 1.1 for r in ratios), ratios


def test_of_sensors_only_those_that_err_take_the_colour():
    drawn = groups(circuit_drawing({"sensor": Tint(5, "all")}, "one", erring=("rod_velocity",)))["sensor"]
    plain = [c.attrib["cx"] for c in drawn.iter("circle") if c.attrib.get("class") == "q0"]
    assert drawn.attrib["class"] == "q5" and len(plain) == 6 and "592" not in plain
    drawn = groups(circuit_drawing({"sensor": Tint(5, "all")}, "one"))["sensor"]
    assert not [c for c in drawn.iter("circle") if "class" in c.attrib]


def test_the_drawing_fits_a_phone():
    style = (resources.files("ddh_twin_py.report") / "assets" / "style.css").read_text()
    (least,) = re.findall(r"^\.circuit \{[^}]*min-width: (\d+)px", style, re.MULTILINE)
    assert int(least) <= 390 - 2 * 14  # less the page's padding
