"""In which unit readings are told."""
