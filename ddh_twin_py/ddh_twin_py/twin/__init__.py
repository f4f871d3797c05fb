"""Runs the model: on measured telemetry, on commands alone, or as a simulated rig."""
