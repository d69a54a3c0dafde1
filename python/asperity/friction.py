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
        """Read a process that a study, or ``asperity friction fit --out``, wrote.

        Parameters
        ----------
        path
            JSON file.

        Raises
        ------
        OSError
            The file cannot be read.
        FormatError
            The file is no process.

        Examples
        --------
        >>> import asperity, pathlib, tempfile
        >>> process = asperity.friction_process(mean=0.2, std=0.01, correlation_length_m=250e-6)
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     process.write(path := pathlib.Path(folder, "process.json"))
        ...     asperity.FrictionProcess.read(path) == process
        True
        """
        return FrictionProcess.from_dict(_core.read_friction_process(path))

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write the process to a file.

        Parameters
        ----------
        path
            JSON file; it is replaced if it exists.

        Raises
        ------
        OSError
            The file cannot be written.

        Examples
        --------
        >>> import asperity, pathlib, tempfile
        >>> process = asperity.friction_process(mean=0.2, std=0.01, correlation_length_m=250e-6)
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     process.write(pathlib.Path(folder, "process.json"))
        """
        pathlib.Path(path).write_text(json.dumps(self.to_dict(), indent=2) + "\n", encoding="utf-8")

    def simulate(self, *, length_m: float, step_m: float, seed: int, index: int = 0) -> NDArray[np.float64]:
        """Draw values of μ at equal steps.

        Parameters
        ----------
        length_m, step_m
            Sliding distance and step.
        seed, index
            Realisation number `index` of the seed.

        Returns
        -------
            Friction coefficient at the distances 0, `step_m`, … `length_m`, shape (n,).

        Raises
        ------
        ValueError
            A length is not positive, there are more than 1e9 values, or the process does not state what varies.

        Examples
        --------
        >>> import asperity
        >>> process = asperity.friction_process(mean=0.2, std=0.01, correlation_length_m=250e-6)
        >>> process.simulate(length_m=1e-3, step_m=1e-5, seed=1).shape
        (101,)
        """
        values: NDArray[np.float64] = _core.simulate_friction(self.to_dict(), length_m, step_m, seed, index)
        return values

    def plot(self, *, length_m: float | None = None, seed: int = 1, ax: Axes | None = None) -> Axes:
        """Draw one realisation over the sliding distance.

        Parameters
        ----------
        length_m
            Sliding distance; 20 correlation lengths when left out.
        seed
            Seed of the realisation.
        ax
            Axes of matplotlib; new ones when left out.

        Raises
        ------
        ValueError
            The process does not vary, or `length_m` is not positive.

        Examples
        --------
        >>> import asperity
        >>> process = asperity.friction_process(mean=0.2, std=0.01, correlation_length_m=250e-6)
        >>> process.plot().get_ylabel()
        'friction coefficient'
        """
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

    Parameters
    ----------
    mean, std
        Mean and standard deviation of the friction coefficient.
    correlation_length_m
        Sliding distance at which the correlation is 1/e.
    marginal
        Shape of the distribution of μ, such as ``normal`` or ``beta:2.1,5``.
    correlation
        ``exponential`` or ``squared_exponential``.
    stribeck_s_per_m
        Coefficient a of μ/(1 + a|v|), if known.

    Raises
    ------
    ValueError
        A number is out of its range, or a name is not known.

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
    marginal: str = "auto",
    detrend: str = "none",
    low_pass_m: float | None = None,
    decimation: int = 1,
) -> FrictionProcess:
    """Fit a process to a measured record: moments, distribution and correlation, with 95 % intervals.

    Parameters
    ----------
    friction
        Friction coefficient at equal steps of the sliding distance, shape (n,); NaN marks gaps.
    step_m
        Step.
    marginal
        Distribution: ``auto``, ``normal``, ``lognormal``, ``weibull``, ``beta``, ``johnson`` or ``empirical``.
    detrend
        Trend to remove: ``none``, ``mean``, ``linear``, ``polynomial:DEGREE`` or ``high_pass:LENGTH``.
    low_pass_m
        Cut-off length of a Gaussian filter that removes shorter waves.
    decimation
        Number of consecutive values to replace by their mean.

    Raises
    ------
    ValueError
        A name is not known, or a number is out of its range.
    NotConvergedError
        The record has too few values.

    Examples
    --------
    >>> import asperity
    >>> process = asperity.friction_process(mean=0.2, std=0.01, correlation_length_m=250e-6)
    >>> record = process.simulate(length_m=0.1, step_m=25e-6, seed=1)
    >>> low, high = asperity.fit_friction_record(record, step_m=25e-6, marginal="normal").std_interval
    >>> low < 0.01 < high
    True
    """
    found = _core.fit_friction_record(numbers(friction), step_m, marginal, detrend, low_pass_m, decimation)
    return FrictionProcess.from_dict(found)
