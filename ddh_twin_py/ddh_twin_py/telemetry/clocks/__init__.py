"""Whose clock is believed, and where stamps jump or are wrong."""
