"""What holds for every check on the machine, said once wherever checks are told."""

BEFORE = "Before a check on the machine."
"""Title."""
SAFETY = (
    "Qualified people only. Lower the load, or secure it by more than its oil; lock the drive out while "
    "anybody works on the unit; relieve the pressure, and see on a gauge that it is gone, before anything is opened. Gauges, hoses and "
    "plugs are rated for the unit's highest pressure, and tests stay below the relief valve's setting. A pump's outlet is never closed "
    "without a relief valve between; in this circuit only the rod side has one."
)
"""In words."""
