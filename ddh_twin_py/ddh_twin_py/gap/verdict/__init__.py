"""From fitted hypotheses to what is said: what held-out data allow, what is unknown, how probable each is."""
