"""Exceptions of asperity. Wrong arguments raise ValueError, files that cannot be read or written OSError."""


class FormatError(ValueError):
    """A file is damaged, or of a format that is not read."""


class NotConvergedError(RuntimeError):
    """A computation did not converge, or too few of its samples are valid."""


class ResourceError(RuntimeError):
    """Memory, disk or threads do not suffice."""
