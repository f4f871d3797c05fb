"""Many recordings of many rigs: each diagnosed in its own process, one row each, trends over time."""
