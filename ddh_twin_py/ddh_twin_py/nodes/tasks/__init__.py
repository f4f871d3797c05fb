"""What nodes do beside their main work: diagnostics, limits, state on disk, diagnoses."""
