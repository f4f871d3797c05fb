"""The error of every bag that cannot be used, and which errors pass."""


class BagError(ValueError):
    """A bag that cannot be used; one line that names file, topic and what is wrong."""


def of_the_system(error: BaseException) -> bool:
    """Whether an error is, or was raised from, one of the operating system, such as a full disk, which may be gone the next time."""
    return isinstance(error, OSError) or isinstance(error.__cause__, OSError)
