"""Diagnoses of bags: the gap engine on files, here or in a process of its own."""
