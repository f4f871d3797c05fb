"""Messages composed and parsed, and the one place where units change."""
