"""YAML in which no key of a mapping may be given twice; of two, YAML's own reader silently keeps the later."""

from __future__ import annotations

import yaml


class DuplicateKeyError(ValueError):
    """A key that a mapping has twice; the message is its dotted path and both lines."""


def read_unique(text: str) -> object:
    """What the text holds, as `yaml.safe_load` reads it.

    Raises:
        DuplicateKeyError: for a key given twice. yaml.YAMLError, ValueError: for what is not YAML.
    """
    loader = yaml.SafeLoader(text)
    try:
        node = loader.get_single_node()
        if node is None:
            return None
        _check(node, "", set())
        return loader.construct_document(node)
    finally:
        loader.dispose()


def _check(node: yaml.Node, path: str, seen: set[int]) -> None:
    if id(node) in seen:  # an alias
        return
    seen.add(id(node))
    if isinstance(node, yaml.SequenceNode):
        for child in node.value:
            _check(child, path, seen)
    if not isinstance(node, yaml.MappingNode):
        return
    lines: dict[str, int] = {}
    for key, child in node.value:
        name = key.value if isinstance(key, yaml.ScalarNode) else ""
        whole = f"{path}.{name}" if path else name
        line = key.start_mark.line + 1
        if name and name in lines:
            raise DuplicateKeyError(f"{whole}: given twice, in lines {lines[name]} and {line}")
        lines[name] = line
        _check(child, whole, seen)
