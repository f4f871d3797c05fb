"""The error of every bag that cannot be used."""


class BagError(ValueError):
    """A bag that cannot be used; one line that names file, topic and what is wrong."""
