"""Which hypotheses explain a gap: the leaders fitted in full, effects that cannot be told apart, terms that are learned."""
