"""The rig: its data sheet, units, tolerances and where each number comes from."""

from ddh_twin_py.rig.sheet import LARGEST_PAYLOAD, OIL_GRADE, PAYLOADS, Quantity, Rig, RigError, is_payload, load_rig

__all__ = ["LARGEST_PAYLOAD", "OIL_GRADE", "PAYLOADS", "Quantity", "Rig", "RigError", "is_payload", "load_rig"]
