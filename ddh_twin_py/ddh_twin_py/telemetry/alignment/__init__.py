"""Streams cut into ticks that all of them share."""
