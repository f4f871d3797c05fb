"""Has a gap opened: running tests of a free run against telemetry."""
