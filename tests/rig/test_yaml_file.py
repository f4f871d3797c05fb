"""Files that people write: what is wrong with one is told with its line."""

import pytest
from ddh_twin_py.rig import RigError
from ddh_twin_py.rig.yaml_file import parse_yaml, read_yaml

_COLON = "a value holds a ':' with a blank behind it; put the value in quotes"
_BEHIND = "something stands behind a closing quote; a value with one kind of quotes in it stands in the other"


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
    ("a: 1\nb: *c\n", 2, "found undefined alias 'c'; if a value begins with '*', put the value in quotes"),
    ("a: 1\nb: \x01\n", 2, "it holds the character '\\x01'"),
    ("a: 1\nb: 2026-13-45\n", 2, "'2026-13-45' is no timestamp: month must be in 1..12"),
    ("a: !!bool perhaps\n", 1, "'perhaps' is no bool"),
    ("a: !!int ''\n", 1, "'' is no int"),
    ("a: !!timestamp now\n", 1, "'now' is no timestamp"),
    ("a: 1\nb: c: d\n", 2, _COLON),
    ("a:\n  b: value: 0.45\n", 2, _COLON),
    ("a: 1\nb: {c: 1, d: e: f}\n", 2, f"a comma is missing, or {_COLON}"),
    ("a: 1\nb: [c: d: e]\n", 2, f"a comma is missing, or {_COLON}"),
    ("a 1\nb: 2\n", 1, "a ':' is missing"),
    ("a:\n  - 1\n  2\n  - 3\n", 3, "a '-' is missing"),
    ("a: 1\nb: {c: 'it's'}\n", 2, _BEHIND),
    ("a: \"b\" c\n", 1, _BEHIND),
    ("a: {b: c # d}\n", 1, "a bracket is not closed, or a comma is missing by line 1; "
     "what stands behind ' #' is a comment, unless it is in quotes"),
    ("a: {b: 1}}\n", 1, "there is a '}' too many"),
    ("a:\n    b: 1\n  c: 2\n", 3, "a line is indented otherwise than those that it belongs to"),
    ("a: | b\n", 1, "'|' and '>' begin a text of lines of its own; if it is none, put the value in quotes"),
    ("a: ? b\n", 1, "character '?' begins no value; put it in quotes"),
    ("a: !b\n", 1, "there is no kind '!b'; if a value begins with '!', put the value in quotes"),
    ('a: "C:\\crane"\n', 1, "a '\\' in double quotes begins a sign of another kind; in single quotes it is itself"),
    ("a: {value:0.45, unit: m}\n", 1, "a blank is missing after the ':' of 'value:0.45'"),
    ("a:\n\u00a0 b: 1\n", 2, "the name '\\xa0 b' begins or ends with a blank that is none of YAML's"),
])
def test_a_mistake_is_told_with_the_line_in_which_it_was_made(text, line, words):
    with pytest.raises(RigError) as error:
        parse_yaml(text, "own.yaml", RigError)
    assert str(error.value) == f"own.yaml: is not YAML (line {line}): {words}"


@pytest.mark.parametrize(("content", "said"), [
    ("a: 1\nb: Krän\n".encode("latin1"), "it is no UTF-8: line 2 holds the byte 0xe4; save it as UTF-8"),
    ("a: 1\n".encode("utf16"), "it is UTF-16, UTF-8 is needed"),
])
def test_a_file_in_another_encoding_is_told_with_its_line(tmp_path, content, said):
    file = tmp_path / "own.yaml"
    file.write_bytes(content)
    with pytest.raises(RigError) as error:
        read_yaml(file, "rig file", RigError)
    assert str(error.value) == f"{file}: cannot be read as a rig file: {said}"


def test_a_mark_of_byte_order_and_line_ends_of_another_system_are_no_mistake(tmp_path):
    file = tmp_path / "own.yaml"
    file.write_bytes(b"\xef\xbb\xbfa: 1\r\nb: |\r\n  c\r\n  d\r\n")
    assert read_yaml(file, "rig file", RigError) == {"a": 1, "b": "c\nd\n"}
