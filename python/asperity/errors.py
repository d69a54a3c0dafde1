"""Exceptions and warnings of asperity.

Wrong arguments raise ValueError, files that cannot be read or written OSError.
"""

from __future__ import annotations

import sys
import warnings
from types import FrameType


class FormatError(ValueError):
    """A file is damaged, or of a format that is not read."""


class NotConvergedError(RuntimeError):
    """A computation did not converge, or too few of its samples are valid."""


class ResourceError(RuntimeError):
    """Memory, disk or threads do not suffice."""


class AsperityWarning(UserWarning):
    """An input is implausible or was changed, or a result is less accurate than it could be."""


def warn(message: str) -> None:
    """Issue a warning at the line of the user that called the package."""
    level = 2
    frame: FrameType | None = sys._getframe(1)
    while frame and frame.f_globals.get("__name__", "").partition(".")[0] == "asperity":
        frame, level = frame.f_back, level + 1
    warnings.warn(message, AsperityWarning, stacklevel=level)
