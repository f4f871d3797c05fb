"""A gap diagnosis: its page, its summary, and the design of a test."""
