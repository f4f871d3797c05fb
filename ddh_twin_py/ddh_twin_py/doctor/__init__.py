"""What is wrong with an installation or a running machine, and what to do."""
