"""What recordings say about a rig: page and summary."""
