"""The drawing of the circuit: every component of the contract, well-formed, coloured as told."""

from xml.etree import ElementTree

import pytest
import yaml
from ddh_twin_py.report.circuit_drawing import COMPONENTS, STEPS, Tint, circuit_drawing, step_of


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


def test_a_component_that_is_none_is_named():
    with pytest.raises(ValueError, match="no component 'pump_3'"):
        circuit_drawing({"pump_3": Tint(1, "")}, "x")


def test_steps_rise_with_the_share():
    steps = [step_of(share) for share in (0.0, 1e-6, 0.1, 0.3, 0.5, 1.0)]
    assert steps == [0, 1, 2, 3, 4, 5] and STEPS == 6
