"""Stick-slip of a mass on a belt, in dimensionless form: X = x·c/N, τ = ω₀t."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from typing import Any, Literal

from asperity import _core
from asperity._progress import Progress, callback
from asperity.errors import warn
from asperity.laws import Parameters
from asperity.vibration_results import CriticalDamping, Ensemble, LimitCycle, StabilityMap

Axis = tuple[float, float, int]


@dataclass(frozen=True, kw_only=True)
class Oscillator(Parameters):
    """Mass, spring and damper on a moving belt with dry friction.

    Examples
    --------
    >>> import asperity
    >>> law = asperity.Stribeck(kinetic=0.1, decay=4.2)
    >>> machine = asperity.Oscillator(static_friction=0.1, law=law, damping_ratio=0.17, belt_velocity=0.003)
    >>> asperity.limit_cycle(machine).kind
    'stick_slip'
    """

    _checked: _core.Oscillator = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        self._check()
        for message in self._checked.warnings():
            warn(message)

    def _check(self) -> None:
        values = {own.name: getattr(self, own.name) for own in dataclasses.fields(Parameters)}
        law = {type(self.law).__name__.lower(): dataclasses.asdict(self.law)}
        parameters = values | {"law": law, "forcing": self.forcing and dataclasses.asdict(self.forcing)}
        object.__setattr__(self, "_checked", _core.Oscillator(parameters))

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name != "_checked"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._check()


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
