"""Stick-slip of a mass on a belt, in dimensionless form: X = x·c/N, τ = ω₀t."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from asperity import _core
from asperity._progress import Progress, callback
from asperity._record import Record

if TYPE_CHECKING:
    import pandas

Axis = tuple[float, float, int]
Kind = Literal["stick_slip", "overtaking", "slip_cycle", "none"]


@dataclass(frozen=True, kw_only=True)
class Stribeck:
    """Velocity weakening μ = μ_k/(1 + a|v|)."""

    kinetic: float
    """μ_k, the coefficient at vanishing sliding velocity."""
    decay: float
    """a ≥ 0, per unit of dimensionless velocity."""


@dataclass(frozen=True, kw_only=True)
class Coulomb:
    """Constant coefficient."""

    kinetic: float
    """μ_k."""


@dataclass(frozen=True, kw_only=True)
class Linear:
    """Linear weakening μ = μ_k − b|v|."""

    kinetic: float
    """μ_k, the coefficient at vanishing sliding velocity."""
    slope: float
    """b ≥ 0, per unit of dimensionless velocity."""


@dataclass(frozen=True, kw_only=True)
class Exponential:
    """Exponential weakening μ = μ_∞ + (μ_k − μ_∞)e^{−|v|/v₀}."""

    kinetic: float
    """μ_k, the coefficient at vanishing sliding velocity."""
    high_speed: float
    """0 < μ_∞ ≤ μ_k, the coefficient at high velocity."""
    stribeck_velocity: float
    """v₀ > 0."""


@dataclass(frozen=True, kw_only=True)
class Tabulated:
    """Monotone cubics between points (velocity, coefficient)."""

    points: Sequence[tuple[float, float]]
    """Points by rising velocity, the first at 0."""


VelocityLaw = Stribeck | Coulomb | Linear | Exponential | Tabulated


@dataclass(frozen=True, kw_only=True)
class Forcing:
    """Harmonic force q cos ητ on the mass."""

    amplitude: float
    """q = Q/N."""
    frequency: float
    """η = Ω/ω₀ > 0."""


@dataclass(frozen=True, kw_only=True)
class Oscillator:
    """Mass, spring and damper on a moving belt with dry friction.

    Examples
    --------
    >>> import asperity
    >>> law = asperity.Stribeck(kinetic=0.1, decay=4.2)
    >>> machine = asperity.Oscillator(static_friction=0.1, law=law, damping_ratio=0.17, belt_velocity=0.003)
    >>> asperity.limit_cycle(machine).kind
    'stick_slip'
    """

    static_friction: float
    """μ_st, the stick limit."""
    law: VelocityLaw
    """Kinetic friction over the velocity."""
    damping_ratio: float
    """ζ = d/(2mω₀)."""
    belt_velocity: float
    """V = v_b·mω₀/N."""
    forcing: Forcing | None = None
    """Harmonic force, if any."""
    _checked: _core.Oscillator = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        law: Any = self.law.points if isinstance(self.law, Tabulated) else dataclasses.asdict(self.law)
        parameters = {
            "static_friction": self.static_friction,
            "law": {type(self.law).__name__.lower(): law},
            "damping_ratio": self.damping_ratio,
            "belt_velocity": self.belt_velocity,
            "forcing": self.forcing and dataclasses.asdict(self.forcing),
        }
        object.__setattr__(self, "_checked", _core.Oscillator(parameters))


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


def limit_cycle(oscillator: Oscillator) -> LimitCycle:
    """Find the vibration that develops from a start in stick, without fluctuation.

    Examples
    --------
    >>> import asperity
    >>> law = asperity.Stribeck(kinetic=0.1, decay=4.2)
    >>> machine = asperity.Oscillator(static_friction=0.1, law=law, damping_ratio=0.17, belt_velocity=0.003)
    >>> round(asperity.limit_cycle(machine).period, 9)
    6.372163484
    """
    return LimitCycle.from_dict(_core.limit_cycle(oscillator._checked))


def critical_damping(oscillator: Oscillator) -> CriticalDamping:
    """Find the damping ratios at which vibration ends; that of the oscillator and the forcing are ignored.

    Examples
    --------
    >>> import asperity
    >>> law = asperity.Stribeck(kinetic=0.1, decay=4.2)
    >>> machine = asperity.Oscillator(static_friction=0.1, law=law, damping_ratio=0, belt_velocity=0.003)
    >>> round(asperity.critical_damping(machine).critical_damping_ratio, 6)
    0.20483
    """
    return CriticalDamping.from_dict(_core.critical_damping(oscillator._checked))


def ensemble(
    oscillator: Oscillator,
    *,
    friction_std: float,
    correlation_length: float,
    marginal: str,
    trajectories: int,
    duration: float,
    seed: int,
    drive: Literal["distance", "time"] = "distance",
    allow_clipping: bool = False,
    progress: Progress = False,
) -> Ensemble:
    """Simulate many trajectories over a random fluctuation of friction.

    Parameters
    ----------
    oscillator
        The machine.
    friction_std
        Standard deviation of the friction coefficient.
    correlation_length
        Correlation length in sliding distance, λ = ℓ_μ·c/N.
    marginal
        Shape of the distribution, such as ``normal`` or ``beta:2.1,5``.
    trajectories
        Number of trajectories.
    duration
        Duration τ of each.
    seed
        Seed of every random draw.
    drive
        Argument of the fluctuation.
    allow_clipping
        Allow more than 5 % of the friction values to be clipped to stay positive.
    progress
        See `run_study`.
    """
    fluctuation = _fluctuation(friction_std, correlation_length, marginal, allow_clipping)
    found = _core.ensemble(oscillator._checked, fluctuation, trajectories, duration, seed, drive, callback(progress))
    return Ensemble.from_dict(found)


def stability_map(
    oscillator: Oscillator,
    *,
    friction_std: float,
    correlation_length: float,
    marginal: str,
    trajectories: int,
    duration: float,
    seed: int,
    damping_ratios: Axis | None = None,
    belt_velocities: Axis | None = None,
    friction_stds: Axis | None = None,
    loads: Axis | None = None,
    depth: int = 3,
    allow_clipping: bool = False,
    progress: Progress = False,
) -> StabilityMap:
    """Map the probability of sustained vibration over two parameters.

    Parameters
    ----------
    oscillator
        The machine, whose parameters on the axes do not matter.
    friction_std, correlation_length, marginal, trajectories, duration, seed, allow_clipping, progress
        See `ensemble`; `trajectories` per point of the map.
    damping_ratios, belt_velocities, friction_stds, loads
        Two axes, each as least value, largest value and cells of the first grid: damping ratios with belt velocities or
        with standard deviations of friction, or belt velocities with loads over the load of the machine.
    depth
        Number of times that cells at the front are halved.
    """
    axes = (damping_ratios, belt_velocities, friction_stds, loads)
    match axes:
        case (x, y, None, None) if x and y:
            over = "damping_velocity"
        case (x, None, y, None) if x and y:
            over = "damping_scatter"
        case (None, x, None, y) if x and y:
            over = "velocity_load"
        case _:
            raise ValueError("give damping_ratios with belt_velocities or friction_stds, or belt_velocities with loads")
    settings: dict[str, object] = {"over": over, "depth": depth}
    for name, axis in (("x", x), ("y", y)):
        settings[name] = dict(zip(("from", "to", "cells"), axis, strict=True))
    fluctuation = _fluctuation(friction_std, correlation_length, marginal, allow_clipping)
    found = _core.stability_map(
        oscillator._checked, fluctuation, settings, trajectories, duration, seed, callback(progress)
    )
    return StabilityMap.from_dict(found)


def _fluctuation(
    friction_std: float, correlation_length: float, marginal: str, allow_clipping: bool
) -> dict[str, object]:
    return {
        "friction_std": friction_std,
        "correlation_length": correlation_length,
        "marginal": marginal,
        "allow_clipping": allow_clipping,
    }
