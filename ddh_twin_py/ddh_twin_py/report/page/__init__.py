"""What pages are made of: document, charts, drawings."""
