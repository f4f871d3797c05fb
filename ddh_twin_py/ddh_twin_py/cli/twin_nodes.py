"""The nodes that a twin is made of, for whoever starts them."""

MODELS = ("hydraulic_model", "machine_thermal", "temperature_fusion")
TWIN = (*MODELS, "gap_monitor")
"""Nodes that always run."""
FLUSH_AFTER = 1.0
"""s without a message after which models work off what they hold: a bag that has ended, or was paused, gives nothing more."""
