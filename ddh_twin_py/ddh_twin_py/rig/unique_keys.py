"""YAML in which no key of a mapping may be given twice, of two YAML's own reader silently keeps the later, which has an end, and whose
texts are such that they can be written again."""

from __future__ import annotations

import re
import sys

import yaml

from ddh_twin_py.names import cited

CLINGS = re.compile(r"[\w.]+:[^\s/]")
"""A name and its value without the blank between them, no address."""
_OCTAL = re.compile(r"[-+]?0[0-9_]+")
_SURROGATE = re.compile("[\ud800-\udfff]")


class DuplicateKeyError(ValueError):
    """A key that a mapping has twice; the message is its dotted path and both lines."""


class EndlessError(ValueError):
    """An alias to a mapping or a list in which it lies itself; the message is its dotted path and the line of what it names."""


class SurrogateError(ValueError):
    """A text that holds half a character, such as `"\\ud800"`, which no file can hold; the message is its dotted path and the text."""


class Loader(yaml.SafeLoader):
    """YAML's own reader, which tells where a value stands of which it can make nothing, such as the date 2026-13-45."""

    def construct_object(self, node: yaml.Node, deep: bool = False) -> object:
        """See `yaml.SafeLoader`."""
        try:
            return super().construct_object(node, deep)
        except (ValueError, KeyError, IndexError, AttributeError) as cause:
            if not isinstance(node, yaml.ScalarNode):
                raise
            kind = node.tag.rpartition(":")[2]
            why = f": {cause}" if isinstance(cause, ValueError) else ""
            if kind == "int" and len(node.value) > sys.get_int_max_str_digits() > 0:
                why = f": it has {len(node.value)} digits"
            raise yaml.constructor.ConstructorError(None, None, f"{cited(node.value)} is no {kind}{why}", node.start_mark) from None


class DecimalLoader(Loader):
    """A reader to which 007 is no 7, 010 no 8 and 1:30 no 90, as they are to YAML."""

    def construct_yaml_int(self, node: yaml.ScalarNode) -> int:
        """See `yaml.SafeLoader`. Raises ValueError."""
        if _OCTAL.fullmatch(node.value):
            raise ValueError("YAML takes a number that begins with 0 as octal; put a name in quotes, and write a number without that 0")
        _refuse_base_60(node.value)
        return super().construct_yaml_int(node)

    def construct_yaml_float(self, node: yaml.ScalarNode) -> float:
        """See `yaml.SafeLoader`. Raises ValueError."""
        _refuse_base_60(node.value)
        return super().construct_yaml_float(node)


def _refuse_base_60(text: str) -> None:
    if ":" in text:
        raise ValueError("YAML takes numbers with ':' between them as one to the base 60; put a time or a name in quotes")


DecimalLoader.add_constructor("tag:yaml.org,2002:float", DecimalLoader.construct_yaml_float)
DecimalLoader.add_constructor("tag:yaml.org,2002:int", DecimalLoader.construct_yaml_int)


def read_unique(text: str, loader_type: type[Loader] = Loader) -> object:
    """What the text holds, as `yaml.safe_load` reads it where ``loader_type`` does not differ.

    Raises:
        DuplicateKeyError: for a key given twice. EndlessError: for an alias to what it lies in. SurrogateError: for a lone surrogate.
        yaml.YAMLError: for what is not YAML.
    """
    loader = loader_type(text)
    try:
        node = loader.get_single_node()
        if node is None:
            return None
        _check(node, "", set(), set())
        return loader.construct_document(node)
    finally:
        loader.dispose()


def _check(node: yaml.Node, path: str, seen: set[int], around: set[int]) -> None:
    """`seen`: nodes that were looked at. `around`: those of them in which this one lies."""
    if id(node) in around:
        where = f"{path}: " if path else ""
        raise EndlessError(f"{where}is an alias to what it lies in itself, which begins in line {node.start_mark.line + 1}")
    if id(node) in seen:  # an alias
        return
    seen.add(id(node))
    if isinstance(node, yaml.ScalarNode):
        _check_text(node.value, path, "value")
    around = around | {id(node)}
    if isinstance(node, yaml.SequenceNode):
        for child in node.value:
            _check(child, path, seen, around)
    if not isinstance(node, yaml.MappingNode):
        return
    lines: dict[str, int] = {}
    for key, child in node.value:
        name = key.value if isinstance(key, yaml.ScalarNode) else ""
        _check_text(name, path, "key")
        whole = f"{path}.{name}" if path else name
        line = key.start_mark.line + 1
        if name and key.style is None:
            _check_key(name, child, key.start_mark)
        if name and name in lines:
            raise DuplicateKeyError(f"{whole}: given twice, in lines {lines[name]} and {line}")
        lines[name] = line
        _check(child, whole, seen, around)


def _check_key(name: str, child: yaml.Node, mark: yaml.Mark) -> None:
    """Of a key without quotes: that it is one."""
    if CLINGS.match(name) and isinstance(child, yaml.ScalarNode) and not child.value:
        raise yaml.composer.ComposerError(None, None, f"a blank is missing after the ':' of {cited(name)}", mark)
    if name != name.strip():
        raise yaml.composer.ComposerError(None, None, f"the name {cited(name)} begins or ends with a blank that is none of YAML's", mark)


def _check_text(text: str, path: str, what: str) -> None:
    if _SURROGATE.search(text):
        where = f"{path}: " if path else ""
        raise SurrogateError(f"{where}{what} is {cited(text)}, it holds half a character (a lone surrogate)")
