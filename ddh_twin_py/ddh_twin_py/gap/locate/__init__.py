"""Where something is missing, and of what form, whatever causes it."""
