"""Which sensors and readings are not believed, and since when they are again."""
