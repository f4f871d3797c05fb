"""What was measured, and whether to believe it."""
