"""How far a gap shrinks on data that took no part in finding or fitting it."""
