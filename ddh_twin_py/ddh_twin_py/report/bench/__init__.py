"""The sealed bench of the diagnosis: page and table."""
