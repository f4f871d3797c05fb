"""What of a bag is due, and how its player is steered, watched and waited for."""
