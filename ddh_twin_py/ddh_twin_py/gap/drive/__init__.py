"""The direct driven hydraulic unit as the diagnosis sees it."""
