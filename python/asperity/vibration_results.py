"""Results of stick-slip. Made by scripts/generate_python_results.py; do not edit.

They are dimensionless: X = x·c/N, τ = ω₀t. An undefined number is None, and an interval is [low, high] at 95 %.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from asperity._methods import EnsembleMethods, MachineMethods, StabilityMapMethods
from asperity._record import Record

MotionKind = Literal["stick_slip", "overtaking", "slip_cycle", "flutter", "divergence", "none"]
"""Kind of motion."""


@dataclass(frozen=True, kw_only=True, eq=False)
class LimitCycle(MachineMethods):
    """Motion that develops from a start in stick. Numbers of the cycle are absent if there is none."""

    kind: MotionKind
    """Kind of motion."""
    limit_cycle: bool
    """Whether the motion is periodic vibration."""
    steady_sliding_unstable: bool | None
    """Whether steady sliding is unstable; `null` under a harmonic force."""
    kick: float | None
    """Smallest velocity that starts vibration from stable steady sliding; `null` if none is needed or none suffices."""
    period: float | None = None
    """Period in τ."""
    slip_duration: float | None = None
    """Time of slip per period."""
    reattachment_displacement: float | None = None
    """Displacement X at the last re-attachment of the period; none if the mass never sticks."""
    displacement_min: float | None = None
    """Least X."""
    displacement_max: float | None = None
    """Largest X."""
    velocity_min: float | None = None
    """Least X′."""
    velocity_max: float | None = None
    """Largest X′."""
    slips: int | None = None
    """Number of detachments per period: 1 without forcing, 0 for a cycle without stick."""


@dataclass(frozen=True, kw_only=True, eq=False)
class CriticalDamping(MachineMethods):
    """Damping ratios at which vibration ends."""

    critical_damping_ratio: float
    """ζ_c of the grazing–sliding fold: the slip orbit from a detachment touches the belt velocity. Above ζ_c no
    stick-slip cycle exists.
    """
    hopf_damping_ratio: float
    """ζ_H of the Hopf bifurcation, 2ζ_H = −dμ/d|v| at the belt velocity. Above ζ_H steady sliding is stable. ζ_H is
    negative where friction rises with the speed.
    """
    limit_damping_ratio: float | None
    """ζ_v, above which no vibration persists; `null` if the search failed."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Count(Record):
    """Mean, standard deviation and standard error of a number over trajectories."""

    mean: float
    """Mean."""
    std: float
    """Standard deviation over trajectories, divisor n − 1."""
    se: float
    """Standard error of the mean."""


@dataclass(frozen=True, kw_only=True, eq=False)
class SampleDistribution(Record):
    """Distribution of a quantity that occurs many times along many trajectories, such as the displacement at re-
    attachment. Values of one trajectory are correlated when a slip is not much longer than the correlation
    length. `normality_p` assumes independent values, so it is a lower bound of the p-value.
    """

    count: int
    """Number of values; the moments use all of them."""
    mean: float | None
    """Mean."""
    std: float | None
    """Standard deviation."""
    skewness: float | None
    """Skewness."""
    excess_kurtosis: float | None
    """Excess kurtosis."""
    normality_p: float | None
    """p-value of D'Agostino and Pearson's test of normality on `sample`; none for fewer than 20 values."""
    sample: NDArray[np.float64]
    """All values in order of trajectory and time if they are few enough; otherwise a simple random sample of them in
    the same order.
    """


@dataclass(frozen=True, kw_only=True, eq=False)
class Estimate(Record):
    """Value with its 95 % interval."""

    value: float
    """Value."""
    interval: list[float]
    """95 % interval: of a rate exact for a Poisson count (Garwood 1936), of a fraction Wilson's."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Passages(Record):
    """Passages between vibration and steady sliding over all trajectories, which start in stick, vibrating. All
    kinds of vibration count: slips that reach ẋ < 0 and end in stick (cycles of stick-slip) or pass the velocity
    of the belt without stick (overtaking). If a slip cycle attracts the motion, swings slower than the belt also
    count if they exceed the level midway between this cycle and the border of its basin. Vibration is lost when
    the mass slips for three natural periods without finishing a swing; the loss is dated to the end of the last
    swing. Vibration returns at the end of the next swing.
    """

    trajectories: int
    """Number of trajectories."""
    exits: int
    """Number of exits from vibration."""
    entries: int
    """Number of returns to vibration."""
    share_in_cycle: float
    """Fraction of the time in vibration."""
    kinds: dict[str, float]
    """Fraction of the time in each kind of motion."""
    late_share: Count
    """Fraction of the second half of the time in vibration, over the trajectories. Its mean is φ."""
    exit_rate: Estimate | None
    """Exits per unit of τ in vibration."""
    entry_rate: Estimate | None
    """Entries per unit of τ out of vibration."""
    left: Estimate
    """Fraction of the trajectories that leave vibration at least once."""
    sustained: Estimate
    """Fraction of the trajectories that vibrate for at least half of the second half of their time."""
    first_exits: list[float]
    """Times τ of the first exit, rising, of the trajectories that leave vibration."""

    _nested: ClassVar[Mapping[str, type[Record]]] = {
        "late_share": Count,
        "exit_rate": Estimate,
        "entry_rate": Estimate,
        "left": Estimate,
        "sustained": Estimate,
    }


@dataclass(frozen=True, kw_only=True, eq=False)
class Ensemble(EnsembleMethods):
    """Statistics of many trajectories over a random friction fluctuation."""

    trajectories: int
    """Number of requested trajectories."""
    cycles: Count
    """Finished slips per trajectory that reached a negative velocity."""
    micro_slips: Count
    """Other finished slips per trajectory."""
    cycles_deterministic: int
    """Number of cycles of the same oscillator without fluctuation in the same time."""
    difference_mean: float
    """Difference of the numbers of cycles without and with fluctuation."""
    difference_interval: list[float]
    """95 % interval of `difference_mean` (Student)."""
    reattachments: SampleDistribution
    """Displacements X at which cycles stick again."""
    releases: SampleDistribution
    """Displacements X at which the mass leaves the belt, except the first one of each trajectory."""
    periods: SampleDistribution
    """Times τ from the start of a cycle to the start of the next, unless vibration is lost in between. The mean is
    the period, the standard deviation its jitter. A cycle starts with a detachment or where over-slip ends
    without stick.
    """
    stick_share: Count
    """Fraction of the time in stick, per trajectory."""
    passages: Passages
    """Vibration over time: exits, entries and fractions of the time."""
    failures: list[dict[str, Any]]
    """Trajectories that failed."""
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


@dataclass(frozen=True, kw_only=True, eq=False)
class MapPoint(Record):
    """Point of the map."""

    x: float
    """First parameter."""
    y: float
    """Second parameter."""
    sustained: Estimate
    """Fraction of the trajectories that sustain vibration."""
    trajectories: int
    """Number of trajectories of this fraction; 1 without fluctuation."""
    limit_damping_ratio: float | None
    """Largest damping ratio at which the machine vibrates without fluctuation, if there is one."""
    damping_ratio: float
    """Damping ratio ζ of the machine."""

    _nested: ClassVar[Mapping[str, type[Record]]] = {"sustained": Estimate}


@dataclass(frozen=True, kw_only=True, eq=False)
class MapContour(Record):
    """Contour of the map."""

    level: float
    """Probability."""
    lines: list[list[list[float]]]
    """Lines (x, y)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class StabilityMap(StabilityMapMethods):
    """Probability of sustained vibration over two parameters."""

    axes: list[str]
    """Names of the parameters x and y."""
    points: list[MapPoint]
    """All points, by y and then by x."""
    cells: list[dict[str, Any]]
    """Cells that were not halved."""
    contours: list[MapContour]
    """Contours at 5, 50 and 95 %. The contours of 5 and 95 % omit the cells that do not resolve the transition."""
    limit: list[list[list[float]]]
    """Lines (x, y) at which vibration without fluctuation ends."""
    resolution: dict[str, float]
    """Widths of the smallest cells, and how many of them do not resolve the transition."""
    clipped_fraction: float
    """Largest fraction of friction values that were raised so that friction stays positive."""

    _nested: ClassVar[Mapping[str, type[Record]]] = {"points": MapPoint, "contours": MapContour}


Kind = MotionKind
