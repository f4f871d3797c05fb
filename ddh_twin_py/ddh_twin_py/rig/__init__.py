"""The rig: its data sheet, units, tolerances and where each number comes from."""

from ddh_twin_py.rig.sheet import Quantity, Rig, RigError, load_rig

__all__ = ["Quantity", "Rig", "RigError", "load_rig"]
