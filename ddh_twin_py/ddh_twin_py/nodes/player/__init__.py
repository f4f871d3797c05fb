"""How a bag player is steered, watched and waited for."""
