"""A diagnosis from bags: the gap engine on files."""
