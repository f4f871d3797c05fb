"""Whether recordings allow a diagnosis, and what is doubtful about them whatever is found."""
