"""Which fields of an operating point add up to the loss of a component."""

from __future__ import annotations

LOSSES = {
    "motor": ("loss_copper", "loss_iron", "loss_motor_friction"),
    "pump_1": ("loss_pump_1",),
    "pump_2": ("loss_pump_2",),
    "line_a": ("loss_line_a",),
    "line_b": ("loss_line_b",),
    "cylinder": ("loss_cylinder",),
    "relief_valve": ("loss_relief_valve",),
    "check_valve": ("loss_check_valve",),
}
"""Component to the fields of an operating point (`balance.OPERATING_FIELDS`) that add up to its loss, W."""
