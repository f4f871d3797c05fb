"""How well the twin agrees with a recording: page and summary."""
