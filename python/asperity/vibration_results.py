"""Results of stick-slip, in dimensionless form: X = x·c/N, τ = ω₀t."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from asperity import _plots
from asperity._record import Record

if TYPE_CHECKING:
    import pandas
    from matplotlib.axes import Axes

Kind = Literal["stick_slip", "overtaking", "slip_cycle", "none"]


@dataclass(frozen=True, kw_only=True)
class LimitCycle(Record):
    """Motion that develops from a start in stick. Numbers of the cycle are None if there is none."""

    kind: Kind
    """Kind of motion."""
    limit_cycle: bool
    """Whether the motion is periodic vibration."""
    steady_sliding_unstable: bool | None
    """Whether steady sliding is unstable; None under a harmonic force."""
    kick: float | None
    """Smallest velocity that starts vibration from stable steady sliding; None if none is needed or none suffices."""
    period: float | None = None
    """Period in τ."""
    slip_duration: float | None = None
    """Time of slip per period."""
    reattachment_displacement: float | None = None
    """Displacement X at the last re-attachment of the period; None if the mass never sticks."""
    displacement_min: float | None = None
    """Least X."""
    displacement_max: float | None = None
    """Largest X."""
    velocity_min: float | None = None
    """Least X′."""
    velocity_max: float | None = None
    """Largest X′."""
    slips: int | None = None
    """Number of detachments per period."""


@dataclass(frozen=True, kw_only=True)
class CriticalDamping(Record):
    """Damping ratios at which vibration ends."""

    critical_damping_ratio: float
    """ζ_c, above which no stick-slip cycle exists."""
    hopf_damping_ratio: float
    """ζ_H, above which steady sliding is stable."""
    limit_damping_ratio: float | None
    """ζ_v, above which no vibration persists; None if the search failed."""


@dataclass(frozen=True, kw_only=True)
class Count(Record):
    """Mean over the trajectories."""

    mean: float
    std: float
    """Standard deviation over trajectories."""
    se: float
    """Standard error of the mean."""


@dataclass(frozen=True, kw_only=True)
class SampleDistribution(Record):
    """Distribution of a quantity that occurs many times along many trajectories."""

    count: int
    mean: float | None
    std: float | None
    skewness: float | None
    excess_kurtosis: float | None
    normality_p: float | None
    """p-value of D'Agostino and Pearson's test of normality."""
    sample: NDArray[np.float64]
    """The values, or a random sample of them."""


@dataclass(frozen=True, kw_only=True)
class Estimate(Record):
    """Value with its 95 % interval."""

    value: float
    interval: list[float]


@dataclass(frozen=True, kw_only=True)
class Passages(Record):
    """Passages between vibration and steady sliding over all trajectories, which start vibrating."""

    trajectories: int
    exits: int
    """Number of exits from vibration."""
    entries: int
    """Number of returns to vibration."""
    share_in_cycle: float
    """Fraction of the time in vibration."""
    kinds: dict[str, float]
    """Fraction of the time in each kind of motion."""
    late_share: Count
    """Fraction of the second half of the time in vibration."""
    exit_rate: Estimate | None
    """Exits per unit of τ in vibration."""
    entry_rate: Estimate | None
    """Entries per unit of τ out of vibration."""
    left: Estimate
    """Fraction of the trajectories that leave vibration at least once."""
    sustained: Estimate
    """Fraction of the trajectories that vibrate for at least half of the second half of their time."""
    first_exits: list[float]
    """Times τ of the first exit, rising."""

    _nested: ClassVar[Mapping[str, type[Record]]] = {
        "late_share": Count,
        "exit_rate": Estimate,
        "entry_rate": Estimate,
        "left": Estimate,
        "sustained": Estimate,
    }


@dataclass(frozen=True, kw_only=True)
class Ensemble(Record):
    """Statistics of many trajectories over a random friction fluctuation."""

    trajectories: int
    cycles: Count
    """Finished slips per trajectory that reached a negative velocity."""
    micro_slips: Count
    """Other finished slips per trajectory."""
    cycles_deterministic: int
    """Number of cycles of the same machine without fluctuation."""
    difference_mean: float
    """Difference of the numbers of cycles without and with fluctuation."""
    difference_interval: list[float]
    """Its 95 % interval."""
    reattachments: SampleDistribution
    """Displacements X at which cycles stick again."""
    releases: SampleDistribution
    """Displacements X at which the mass leaves the belt."""
    periods: SampleDistribution
    """Times τ from the start of a cycle to the start of the next."""
    stick_share: Count
    """Fraction of the time in stick."""
    passages: Passages
    """Vibration over time."""
    failures: list[dict[str, Any]]
    """Trajectories that failed, with the reason."""
    clipped_fraction: float
    """Fraction of the friction values that were raised so that friction stays positive."""

    _nested: ClassVar[Mapping[str, type[Record]]] = {
        "cycles": Count,
        "micro_slips": Count,
        "reattachments": SampleDistribution,
        "releases": SampleDistribution,
        "periods": SampleDistribution,
        "stick_share": Count,
        "passages": Passages,
    }

    def plot(self, *, ax: Axes | None = None) -> Axes:
        """Draw the distribution of the displacements at which the mass sticks again."""
        return _plots.ensemble(self, ax)


@dataclass(frozen=True, kw_only=True)
class MapPoint(Record):
    """Point of a stability map."""

    x: float
    y: float
    sustained: Estimate
    """Fraction of the trajectories that sustain vibration."""
    trajectories: int
    """Number of trajectories of this fraction; 1 without fluctuation."""
    limit_damping_ratio: float | None
    """Largest damping ratio at which the machine vibrates without fluctuation."""
    damping_ratio: float
    """Damping ratio of the machine."""

    _nested: ClassVar[Mapping[str, type[Record]]] = {"sustained": Estimate}


@dataclass(frozen=True, kw_only=True)
class MapContour(Record):
    """Contour of a stability map."""

    level: float
    """Probability."""
    lines: list[list[list[float]]]
    """Lines of points [x, y]."""


@dataclass(frozen=True, kw_only=True)
class StabilityMap(Record):
    """Probability of sustained vibration over two parameters."""

    axes: list[str]
    """Names of the parameters x and y."""
    points: list[MapPoint]
    """All points, by y and then by x."""
    cells: list[dict[str, Any]]
    """Cells that were not halved: ends along x and y, and the mean probability at the corners."""
    contours: list[MapContour]
    """Contours at 5, 50 and 95 %."""
    limit: list[list[list[float]]]
    """Lines of points [x, y] at which vibration without fluctuation ends."""
    resolution: dict[str, float]
    """Widths of the smallest cells, and the fraction of the front that they do not resolve."""
    clipped_fraction: float
    """Largest fraction of friction values that were raised so that friction stays positive."""

    _nested: ClassVar[Mapping[str, type[Record]]] = {"points": MapPoint, "contours": MapContour}

    def to_pandas(self) -> pandas.DataFrame:
        """Return the points as a data frame."""
        import pandas

        return pandas.json_normalize([point.to_dict() for point in self.points])

    def plot(self, *, ax: Axes | None = None) -> Axes:
        """Draw the probability with its contours and the limit without fluctuation."""
        return _plots.stability_map(self, ax)
