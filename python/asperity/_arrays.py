"""Arrays of users as arrays of the library."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray


def numbers(values: ArrayLike) -> NDArray[np.float64]:
    """Return values as aligned doubles; masked values are NaN."""
    if isinstance(values, np.ma.MaskedArray):
        values = np.ma.filled(values.astype(np.float64), np.nan)
    return np.require(values, np.float64, ["A"])


def is_chunked(value: Any) -> bool:
    """Return whether a value is an array of Dask, whose chunks are computed later."""
    module = sys.modules.get("dask.array")
    return module is not None and isinstance(value, module.Array)
