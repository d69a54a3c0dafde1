"""Stick-slip of a mass on a belt, in dimensionless form: X = x·c/N, τ = ω₀t."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, field
from typing import Any, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from asperity import _core
from asperity._arrays import numbers
from asperity._progress import Progress, callback
from asperity.errors import warn
from asperity.laws import Forcing, Numbers, Parameters, Tabulated, VelocityLaw
from asperity.vibration_results import CriticalDamping, Ensemble, Kind, LimitCycle, StabilityMap

Axis = tuple[float, float, int]


# Kinds of motion by their number; the first is that of a machine without an answer.
KINDS = np.array(["", *get_args(Kind)])


@dataclass(frozen=True, kw_only=True, eq=False)
class Oscillator(Parameters):
    """Mass, spring and damper on a moving belt with dry friction, or an array of such machines.

    Every number, also of the law and of the force (type ``Numbers``), is a float or an array with a value of each
    machine. Arrays are broadcast together as by a function of NumPy, and copied as doubles that do not change.
    `limit_cycle` and `critical_damping` compute all machines in one call, on all cores. The points of a `Tabulated`
    law are those of all machines.

    Raises
    ------
    ValueError
        A number is out of its range; of an array, the message states the indices of the first such machine. Or the
        arrays cannot be broadcast together.

    Examples
    --------
    >>> import asperity, numpy as np
    >>> law = asperity.Stribeck(kinetic=0.1, decay=4.2)
    >>> machine = asperity.Oscillator(static_friction=0.1, law=law, damping_ratio=0.17, belt_velocity=0.003)
    >>> asperity.limit_cycle(machine).kind
    'stick_slip'
    >>> ratios = np.linspace(0.1, 0.3, 5)
    >>> machines = asperity.Oscillator(static_friction=0.1, law=law, damping_ratio=ratios, belt_velocity=0.003)
    >>> asperity.limit_cycle(machines).limit_cycle
    array([ True,  True,  True, False, False])
    """

    _checked: _core.Oscillator = field(init=False, repr=False, compare=False)
    _shape: tuple[int, ...] | None = field(init=False, repr=False, compare=False)

    @classmethod
    def from_si(
        cls,
        *,
        mass_kg: Numbers,
        natural_frequency_rad_per_s: Numbers,
        normal_force_n: Numbers,
        belt_velocity_m_per_s: Numbers,
        static_friction: Numbers,
        law: VelocityLaw,
        damping_ratio: Numbers,
        forcing: Forcing | None = None,
    ) -> Oscillator:
        """Return the oscillator of values in SI; each may be an array.

        Results are in its units: time in 1/ω₀, displacement in N/c with the spring c = mω₀², and velocity in N/(mω₀).

        Parameters
        ----------
        mass_kg, natural_frequency_rad_per_s, normal_force_n
            Mass m, natural angular frequency ω₀ and normal force N, all positive.
        belt_velocity_m_per_s
            Velocity v_b of the belt.
        static_friction, damping_ratio
            μ_st and ζ = d/(2mω₀).
        law
            Velocity law of velocities in m/s: `decay` and `slope` in s/m, `stribeck_velocity` and the velocities of
            `points` in m/s.
        forcing
            Harmonic force with its amplitude in N and its frequency in rad/s.

        Raises
        ------
        ValueError
            A number is out of its range, or the unit of velocity of a `Tabulated` law is an array.

        Examples
        --------
        >>> import asperity
        >>> machine = asperity.Oscillator.from_si(
        ...     mass_kg=15,
        ...     natural_frequency_rad_per_s=628.3,
        ...     normal_force_n=10e3,
        ...     belt_velocity_m_per_s=0.02,
        ...     static_friction=0.38,
        ...     law=asperity.Stribeck(kinetic=0.38, decay=0.3),
        ...     damping_ratio=0.03,
        ... )
        >>> round(machine.law.decay, 4), round(machine.belt_velocity, 5)
        (0.3183, 0.01885)
        """
        scales = (
            ("mass_kg", mass_kg),
            ("natural_frequency_rad_per_s", natural_frequency_rad_per_s),
            ("normal_force_n", normal_force_n),
        )
        mass, frequency, force = (_positive(name, _numbers(value)) for name, value in scales)
        velocity = force / (mass * frequency)
        if forcing is not None:
            forcing = Forcing(
                amplitude=_numbers(forcing.amplitude) / force, frequency=_numbers(forcing.frequency) / frequency
            )
        return cls(
            static_friction=static_friction,
            law=_dimensionless(law, velocity),
            damping_ratio=damping_ratio,
            belt_velocity=_numbers(belt_velocity_m_per_s) / velocity,
            forcing=forcing,
        )

    def __post_init__(self) -> None:
        self._check()
        for message in self._checked.warnings():
            warn(message)

    def _check(self) -> None:
        own = {item.name: _owned(getattr(self, item.name)) for item in dataclasses.fields(Parameters)}
        self.__dict__.update(own)
        columns: dict[str, NDArray[np.float64]] = {}

        def common(values: dict[str, Any]) -> dict[str, Any]:
            columns.update((name, value) for name, value in values.items() if isinstance(value, np.ndarray))
            return {name: 0.0 if name in columns else value for name, value in values.items()}

        of_law = vars(self.law) if isinstance(self.law, Tabulated) else common(vars(self.law))
        law = {type(self.law).__name__.lower(): of_law}
        parameters = common(own) | {"law": law, "forcing": self.forcing and common(vars(self.forcing))}
        try:
            shape = np.broadcast_shapes(*(column.shape for column in columns.values()))
        except ValueError:
            shapes = ", ".join(f"{name} {column.shape}" for name, column in columns.items())
            raise ValueError(f"arrays of these shapes cannot be broadcast together: {shapes}") from None
        broadcast = [(name, np.broadcast_to(column, shape).ravel()) for name, column in columns.items()]
        self.__dict__["_shape"] = shape if columns else None
        self.__dict__["_checked"] = _core.Oscillator(parameters, broadcast, self._shape)

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name not in ("_checked", "_shape")}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._check()


def _dimensionless(law: VelocityLaw, velocity: Numbers) -> VelocityLaw:
    """Return a law of velocities in m/s as one of multiples of a unit of velocity."""
    kind = type(law).__name__.lower()
    if isinstance(law, Tabulated):
        if np.ndim(velocity):
            raise ValueError("the points of a table are those of all machines, which need one unit of velocity N/(mω₀)")
        return Tabulated(**_core.rescaled_law({kind: vars(law)}, velocity)[kind])
    # Each parameter is proportional to a power of the unit.
    doubled = _core.rescaled_law({kind: dict.fromkeys(vars(law), 1.0)}, 2.0)[kind]
    powers = {name: round(np.log2(value)) for name, value in doubled.items()}
    return dataclasses.replace(
        law, **{name: _numbers(value) * velocity ** powers[name] for name, value in vars(law).items()}
    )


def _numbers(value: Numbers) -> Numbers:
    return numbers(value) if np.ndim(value) else float(value)


def _positive(name: str, value: Numbers) -> Numbers:
    if not (np.isfinite(value).all() and np.min(value) > 0):
        raise ValueError(f"{name} is {value}, expected a positive number")
    return value


def _owned(value: Any) -> Any:
    """Return arguments whose arrays are copies that do not change. An array without axes is a number."""
    if isinstance(value, Tabulated):
        return Tabulated(points=tuple((float(velocity), float(own)) for velocity, own in value.points))
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return dataclasses.replace(value, **{name: _owned(item) for name, item in vars(value).items()})
    if isinstance(value, np.generic) or not (hasattr(value, "__array__") or isinstance(value, (list, tuple))):
        return value
    own = numbers(value).copy()
    own.flags.writeable = False
    return own if own.ndim else own.item()


def limit_cycle(oscillator: Oscillator) -> LimitCycle:
    """Find the vibration that develops from a start in stick, without fluctuation.

    Of an array of machines the attributes are arrays of its shape, with the same bits as one call for each machine:
    ``kind`` has names, ``limit_cycle`` is boolean, and numbers are NaN where a single call gives None.
    ``steady_sliding_unstable`` is boolean, but 1, 0 or NaN (undefined) for machines with a force. If the computation
    fails for some machines, their ``kind`` is empty, their flags are False, their numbers are NaN, and a warning names
    the first of them.

    Raises
    ------
    NotConvergedError, ValueError
        The computation fails for a single machine.

    Examples
    --------
    >>> import asperity
    >>> law = asperity.Stribeck(kinetic=0.1, decay=4.2)
    >>> machine = asperity.Oscillator(static_friction=0.1, law=law, damping_ratio=0.17, belt_velocity=0.003)
    >>> round(asperity.limit_cycle(machine).period, 9)
    6.372163484
    """
    found = _core.limit_cycle(oscillator._checked)
    if isinstance(found["kind"], np.ndarray):
        found["kind"] = KINDS[found["kind"].astype(np.intp)]
        for flag in ["limit_cycle", *(["steady_sliding_unstable"] if oscillator.forcing is None else [])]:
            found[flag] = found[flag] == 1
    return LimitCycle.from_dict(found)


def critical_damping(oscillator: Oscillator) -> CriticalDamping:
    """Find the damping ratios at which vibration ends; that of the oscillator and the forcing are ignored.

    Of an array of machines the attributes are arrays of its shape, as those of `limit_cycle`.

    Raises
    ------
    NotConvergedError, ValueError
        The computation fails for a single machine.

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
    friction_std: Numbers,
    correlation_length: Numbers,
    marginal: str,
    trajectories: int,
    duration: float,
    seed: int,
    drive: Literal["distance", "time"] = "distance",
    allow_clipping: bool = False,
    progress: Progress = False,
) -> Ensemble:
    """Simulate many trajectories over a random fluctuation of friction.

    Of arrays, which are broadcast together, the numbers of the result are arrays of their shape, with the bits of one
    call for each machine: intervals have a last axis of two, numbers are NaN where a single call gives None, and what
    is undefined for all machines is None. The samples are empty; ``failures`` have the indices of their ``machine``. If
    some ensembles fail, their numbers are NaN, and a warning names the first of them.

    Parameters
    ----------
    oscillator
        The machine, or an array of machines.
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

    Raises
    ------
    ValueError
        A number is out of its range, or more than 5 % of the friction values would be clipped.

    Examples
    --------
    >>> import asperity
    >>> law = asperity.Stribeck(kinetic=0.1, decay=4.2)
    >>> machines = asperity.Oscillator(static_friction=0.1, law=law, damping_ratio=[0.1, 0.3], belt_velocity=0.003)
    >>> fluctuation = {"friction_std": 0.001, "correlation_length": 0.01, "marginal": "normal"}
    >>> found = asperity.ensemble(machines, **fluctuation, trajectories=8, duration=300, seed=1)
    >>> found.passages.late_share.mean
    array([1., 0.])
    """
    stds, lengths = _numbers(friction_std), _numbers(correlation_length)
    shape = np.broadcast_shapes(oscillator._shape or (), np.shape(stds), np.shape(lengths))
    settings = (trajectories, duration, seed, drive, callback(progress))
    if oscillator._shape is None and not (np.ndim(stds) or np.ndim(lengths)):
        fluctuation = _fluctuation(stds, lengths, marginal, allow_clipping)
        return Ensemble.from_dict(_core.ensemble(oscillator._checked, fluctuation, *settings))
    if oscillator._shape != shape:
        ratios = np.broadcast_to(oscillator.damping_ratio, shape)
        oscillator = dataclasses.replace(oscillator, damping_ratio=ratios)
    of_std, of_length = (np.broadcast_to(own, shape).ravel().tolist() for own in (stds, lengths))
    fluctuation = _fluctuation(0.0, 0.0, marginal, allow_clipping)
    found = _core.ensembles(oscillator._checked, of_std, of_length, fluctuation, *settings)
    for name in ("reattachments", "releases", "periods"):
        found[name]["sample"] = np.empty((*shape, 0))
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
    friction_std: Numbers, correlation_length: Numbers, marginal: str, allow_clipping: bool
) -> dict[str, object]:
    return {
        "friction_std": friction_std,
        "correlation_length": correlation_length,
        "marginal": marginal,
        "allow_clipping": allow_clipping,
    }
