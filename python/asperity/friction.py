"""The friction coefficient as a random process along the sliding distance."""

from __future__ import annotations

import json
import os
import pathlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from asperity import _core, _plots
from asperity._arrays import numbers
from asperity._record import Record

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True, kw_only=True, eq=False)
class FrictionCorrelation(Record):
    """Correlation of the friction coefficient along the sliding distance."""

    model: str
    """Name of the model."""
    nu: float | None = None
    """Smoothness of a Matérn model."""
    length_m: float
    """Length of the model."""
    length_m_interval: list[float] | None = None
    """Its 95 % interval."""
    window_m: float | None = None
    """Window over which friction was averaged, if known."""
    length_without_window_m: float | None = None
    """Length without the effect of that window."""


@dataclass(frozen=True, kw_only=True, eq=False)
class FrictionProcess(Record):
    """Friction coefficient μ(s); the content of the file that ``[vibration] friction_process`` names."""

    format: str
    version: int
    mean: float
    """Mean of μ."""
    mean_interval: list[float] | None = None
    """Its 95 % interval."""
    std: float
    """Standard deviation of μ."""
    std_interval: list[float] | None = None
    """Its 95 % interval."""
    marginal: Any = None
    """Distribution of μ by name, with its parameters."""
    correlation: FrictionCorrelation | None = None
    """Correlation along the sliding distance."""
    generator: str | None = None
    """Generator of realisations, if chosen."""
    stribeck_s_per_m: float | None = None
    """Coefficient a of μ/(1 + a|v|), if known."""
    averaged_over_m: list[float] | None = None
    """Length and width of the area over which friction is averaged, if known."""
    mean_pressure_pa: float | None = None
    """Mean pressure, if known."""
    origin: Mapping[str, Any]
    """Source of the process."""

    _nested: ClassVar[Mapping[str, type[Record]]] = {"correlation": FrictionCorrelation}

    @staticmethod
    def read(path: str | os.PathLike[str]) -> FrictionProcess:
        """Read a process that a study, or ``asperity friction fit --out``, wrote."""
        return FrictionProcess.from_dict(_core.read_friction_process(path))

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write the process to a file."""
        pathlib.Path(path).write_text(json.dumps(self.to_dict(), indent=2) + "\n", encoding="utf-8")

    def simulate(self, *, length_m: float, step_m: float, seed: int, index: int = 0) -> NDArray[np.float64]:
        """Draw values of μ at equal steps; realisation number `index` of the seed."""
        values: NDArray[np.float64] = _core.simulate_friction(self.to_dict(), length_m, step_m, seed, index)
        return values

    def plot(self, *, length_m: float | None = None, seed: int = 1, ax: Axes | None = None) -> Axes:
        """Draw one realisation; `length_m` is 20 correlation lengths when left out."""
        return _plots.friction_process(self, length_m, seed, ax)


def friction_process(
    *,
    mean: float,
    std: float,
    correlation_length_m: float,
    marginal: str = "normal",
    correlation: str = "exponential",
    stribeck_s_per_m: float | None = None,
) -> FrictionProcess:
    """State a friction process.

    Examples
    --------
    >>> import asperity
    >>> process = asperity.friction_process(mean=0.2, std=0.01, correlation_length_m=250e-6)
    >>> process.simulate(length_m=1e-3, step_m=1e-5, seed=1).shape
    (101,)
    """
    data = {
        "format": "asperity friction process",
        "version": 1,
        "mean": mean,
        "mean_interval": None,
        "std": std,
        "std_interval": None,
        "marginal": marginal,
        "correlation": {"model": correlation, "length_m": correlation_length_m},
        "stribeck_s_per_m": stribeck_s_per_m,
        "origin": {"kind": "stated", "description": "stated in a Python program"},
    }
    return FrictionProcess.from_dict(_core.friction_process(data))


def fit_friction_record(
    friction: ArrayLike,
    *,
    step_m: float,
    law: str = "auto",
    detrend: str = "none",
    low_pass_m: float | None = None,
    decimation: int = 1,
) -> FrictionProcess:
    """Fit a process to a measured record: moments, distribution and correlation, with 95 % intervals.

    Parameters
    ----------
    friction
        Friction coefficient at equal steps of the sliding distance; NaN marks gaps.
    step_m
        Step.
    law
        Distribution: ``auto``, ``normal``, ``lognormal``, ``weibull``, ``beta``, ``johnson`` or ``empirical``.
    detrend
        Trend to remove: ``none``, ``mean``, ``linear``, ``polynomial:DEGREE`` or ``high_pass:LENGTH``.
    low_pass_m
        Cut-off length of a Gaussian filter that removes shorter waves.
    decimation
        Number of consecutive values to replace by their mean.

    Raises
    ------
    NotConvergedError
        The record has too few values.
    """
    found = _core.fit_friction_record(numbers(friction), step_m, law, detrend, low_pass_m, decimation)
    return FrictionProcess.from_dict(found)
