"""Two cascaded water tanks, measured by Schoukens and Noël."""
