"""Where telemetry comes from: each source is one file here, chosen by its name."""
