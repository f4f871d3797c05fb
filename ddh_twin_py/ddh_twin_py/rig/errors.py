"""What is raised for a rig that cannot be used."""


class RigError(ValueError):
    """A rig file that cannot be used; the message names file, entry and value."""
