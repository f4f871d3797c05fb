"""How far a test would tell apart the hypotheses that are left."""
