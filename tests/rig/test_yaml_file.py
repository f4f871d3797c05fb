"""Files that people write: what is wrong with one is told with its line."""

import pytest
from ddh_twin_py.rig import RigError
from ddh_twin_py.rig.yaml_file import parse_yaml


@pytest.mark.parametrize(("text", "line", "words"), [
    ("rig_id: x\n\ta: 1\n", 2, "there is a tab where blanks are needed"),
    ("rig_id: x\ncylinder\nmotor: 1\n", 2, "a ':' is missing"),
    ("rig_id:crane_1\ncylinder: {}\n", 1, "a blank is missing after the ':'"),
    ("rig_id: x\n  cylinder: 1\n", 2, "there is a ':' too many, or a line is indented too far"),
    ("rig_id: 'x\ncylinder: 1\n\n", 1, "a quote is not closed"),
    ("a: 1\nrig_id: [\n\n\n", 2, "a bracket is not closed"),
    ("a: {b: 1\nc: 2\nd: 3\n", 1, "a bracket is not closed, or a comma is missing by line 2"),
    ("a: [1, 2\n", 1, "a bracket is not closed, or a comma is missing by line 1"),
    ("a: 1\nb: @x\n", 2, "character '@' begins no value; put it in quotes"),
    ("a: 1\n---\nb: 2\n", 2, "a second document begins"),
    ("a: 1\nb: *c\n", 2, "found undefined alias 'c'"),
    ("a: 1\nb: \x01\n", 2, "it holds the character '\\x01'"),
    ("a: 1\nb: 2026-13-45\n", 2, "'2026-13-45' is no timestamp: month must be in 1..12"),
    ("a: !!bool perhaps\n", 1, "'perhaps' is no bool"),
    ("a: !!int ''\n", 1, "'' is no int"),
    ("a: !!timestamp now\n", 1, "'now' is no timestamp"),
])
def test_a_mistake_is_told_with_the_line_in_which_it_was_made(text, line, words):
    with pytest.raises(RigError) as error:
        parse_yaml(text, "own.yaml", RigError)
    assert str(error.value) == f"own.yaml: is not YAML (line {line}): {words}"
