"""What is believed about the unit's temperatures, and how surely."""
