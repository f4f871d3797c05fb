"""What the twin is timed against: the same model in general solvers, and other Kalman filters."""
