"""Digital twin of a direct driven hydraulic unit."""
