"""Parameters of a node, declared once: name, default, unit, bounds, description."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from dataclasses import dataclass

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.exceptions import (
    InvalidParameterTypeException,
    InvalidParameterValueException,
    ParameterUninitializedException,
)
from rclpy.node import Node

from ddh_twin_py.names import cited

_BOUNDLESS = 1e18
_ANY = "any"  # in words, of what has no bounds


class NodeError(Exception):
    """A node cannot start or go on; the message is one line for people."""


@dataclass(frozen=True)
class Parameter:
    """One parameter.

    The type is that of `default` (a tuple of strings is a string array). `lowest` and `highest`
    bound a number, `choices` a string. A parameter that is not `read_only` may change at run time.
    """

    name: str
    default: bool | int | float | str | tuple[str, ...]
    description: str
    unit: str = ""
    lowest: float | None = None
    highest: float | None = None
    choices: tuple[str, ...] = ()
    read_only: bool = True

    @property
    def type_name(self) -> str:
        """As ROS calls it."""
        names = {bool: "bool", int: "integer", float: "double", str: "string", tuple: "string array"}
        return names[type(self.default)]

    def descriptor(self) -> ParameterDescriptor:
        """What `ros2 param describe` shows."""
        text = self.description + (f" [{self.unit}]" if self.unit else "")
        descriptor = ParameterDescriptor(description=text, read_only=self.read_only)
        if self.choices:
            descriptor.additional_constraints = "one of " + ", ".join(repr(c) for c in self.choices)
        lowest = -_BOUNDLESS if self.lowest is None else self.lowest
        highest = _BOUNDLESS if self.highest is None else self.highest
        bounded = self.lowest is not None or self.highest is not None
        if bounded and isinstance(self.default, float):
            descriptor.floating_point_range = [FloatingPointRange(from_value=float(lowest), to_value=float(highest))]
        elif bounded:
            descriptor.integer_range = [IntegerRange(from_value=int(lowest), to_value=int(highest), step=1)]
        return descriptor

    def bounds(self) -> str:
        """What is allowed, in words."""
        if self.choices:
            return "one of " + ", ".join(repr(choice) for choice in self.choices)
        if self.lowest is not None and self.highest is not None:
            return f"{self.lowest:g} to {self.highest:g}"
        if self.lowest is not None:
            return f"{self.lowest:g} or more"
        return f"{self.highest:g} or less" if self.highest is not None else _ANY

    def must_be(self, given: object) -> str:
        """What is asked of a value, in words, where one was given that cannot be used."""
        hint = f"; write {float(given)}" if self.type_name == "double" and type(given) is int else ""
        allowed = "" if self.bounds() == _ANY else f" and {self.bounds()}"
        return f"it must be of type {self.type_name}{allowed}{hint}"

    def takes(self, given: object) -> bool:
        """Whether ROS takes a value from a parameter file, as `parameter_file` reads it."""
        if isinstance(self.default, tuple):
            return isinstance(given, list) and all(isinstance(entry, str) for entry in given)
        if type(given) is not type(self.default):
            return False
        if isinstance(given, str):
            return not self.choices or given in self.choices
        return (self.lowest is None or given >= self.lowest) and (self.highest is None or given <= self.highest)


def declare(node: Node, parameters: Iterable[Parameter]) -> dict[str, object]:
    """Declare all parameters and return their values by name.

    Raises NodeError naming parameter, value given and what is allowed.
    """
    values = {}
    overrides = node._parameter_overrides  # what the command line and parameter files gave
    for parameter in parameters:
        default = list(parameter.default) if isinstance(parameter.default, tuple) else parameter.default
        given = overrides.get(parameter.name)
        try:
            node.declare_parameter(parameter.name, default, parameter.descriptor())
            chosen = node.get_parameter(parameter.name).value
        except (InvalidParameterTypeException, InvalidParameterValueException, ParameterUninitializedException):
            shown = given.value if given is not None else None
            raise NodeError(f"parameter {parameter.name} is {cited(shown)}, {parameter.must_be(shown)}") from None
        if parameter.choices and chosen not in parameter.choices:
            raise NodeError(f"parameter {parameter.name} is {cited(chosen)}, it must be {parameter.bounds()}")
        values[parameter.name] = list(chosen) if isinstance(default, list) else chosen
    for name in overrides:
        near = difflib.get_close_matches(name, sorted(values), n=1, cutoff=0.75)
        if near and not node.has_parameter(name):  # one that is nothing like ours may be meant for another node
            node.get_logger().warning(f"there is no parameter {name}, it is ignored; nearest is {near[0]}")
    return values
