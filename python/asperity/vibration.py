"""Stick-slip of a mass on a belt, in dimensionless form: X = x·c/N, τ = ω₀t."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from numbers import Real
from typing import TYPE_CHECKING, Any, ClassVar, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from asperity import _core, _plots
from asperity._arrays import is_chunked, numbers
from asperity._progress import Progress, callback
from asperity._record import Curves
from asperity.errors import warn
from asperity.friction import FrictionProcess
from asperity.laws import Forcing, Numbers, Parameters, Tabulated, VelocityLaw
from asperity.vibration_results import CriticalDamping, Ensemble, Kind, LimitCycle, StabilityMap

if TYPE_CHECKING:
    from matplotlib.axes import Axes

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

    Numbers may also be arrays of Dask: `limit_cycle` and `critical_damping` then return arrays of Dask, which are
    checked and computed chunk by chunk, where Dask computes them.

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

    length_unit_m: Numbers | None = None
    """Unit of displacement N/c in metre, which a process of friction in SI needs; `from_si` sets it."""
    _checked: _core.Oscillator | None = field(init=False, repr=False, compare=False)
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
            length_unit_m=velocity / frequency,
        )

    def __post_init__(self) -> None:
        self._check()
        for message in self._checked.warnings() if self._checked else ():
            warn(message)

    def _check(self) -> None:
        own = {item.name: _owned(getattr(self, item.name)) for item in dataclasses.fields(Parameters)}
        unit = self.length_unit_m
        self.__dict__.update(
            own, length_unit_m=None if unit is None else _positive("length_unit_m", _numbers(_owned(unit)))
        )
        if not isinstance(self.law, get_args(VelocityLaw)):
            laws = ", ".join(law.__name__ for law in get_args(VelocityLaw))
            raise TypeError(f"law is {self.law!r}, expected one of {laws}")
        columns: dict[str, NDArray[np.float64]] = {}

        def common(values: dict[str, Any]) -> dict[str, Any]:
            columns.update((name, value) for name, value in values.items() if _is_array(value))
            return {name: 0.0 if name in columns else _number(name, value) for name, value in values.items()}

        of_law = vars(self.law) if isinstance(self.law, Tabulated) else common(vars(self.law))
        law = {type(self.law).__name__.lower(): of_law}
        numbers = {name: value for name, value in own.items() if name not in ("law", "forcing")}
        parameters = common(numbers) | {"law": law, "forcing": self.forcing and common(vars(self.forcing))}
        try:
            shape = np.broadcast_shapes(*(column.shape for column in columns.values()))
        except ValueError:
            shapes = ", ".join(f"{name} {column.shape}" for name, column in columns.items())
            raise ValueError(f"arrays of these shapes cannot be broadcast together: {shapes}") from None
        self.__dict__.update(_shape=shape if columns else None, _checked=None)
        if not any(map(is_chunked, columns.values())):
            broadcast = [(name, np.broadcast_to(column, shape).ravel()) for name, column in columns.items()]
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


def _number(name: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, (Real, np.generic)):
        raise TypeError(f"{name} is {value!r}, expected a number or an array of numbers")
    if not math.isfinite(value):
        raise ValueError(f"{name} is {value}, expected a finite number")
    return float(value)


def _is_array(value: Any) -> bool:
    return isinstance(value, np.ndarray) or is_chunked(value)


def _numbers(value: Numbers) -> Numbers:
    if is_chunked(value):
        return value
    return numbers(value) if np.ndim(value) else float(value)


def _positive(name: str, value: Numbers) -> Numbers:
    # The machines of chunks are checked later.
    if not is_chunked(value) and not (np.isfinite(value).all() and np.min(value) > 0):
        raise ValueError(f"{name} is {value}, expected a positive number")
    return value


def _owned(value: Any) -> Any:
    """Return arguments whose arrays are copies that do not change. An array without axes is a number."""
    if isinstance(value, Tabulated):
        return Tabulated(points=tuple((float(velocity), float(own)) for velocity, own in value.points))
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return dataclasses.replace(value, **{name: _owned(item) for name, item in vars(value).items()})
    is_array = hasattr(value, "__array__") or isinstance(value, (list, tuple))
    if is_chunked(value) or isinstance(value, np.generic) or not is_array:
        return value
    own = numbers(value).copy()
    own.flags.writeable = False
    return own if own.ndim else own.item()


def _machine(oscillator: Oscillator) -> _core.Oscillator:
    """Return the checked machine or machines."""
    if oscillator._checked is None:
        raise TypeError(
            "only limit_cycle and critical_damping take arrays of Dask; `compute` makes arrays of NumPy of them"
        )
    return oscillator._checked


def _columns(arguments: Any) -> dict[str, Any]:
    """Return the arrays among the numbers of a machine, its law and its force."""
    found: dict[str, Any] = {}
    for item in dataclasses.fields(arguments):
        value = getattr(arguments, item.name)
        if dataclasses.is_dataclass(value):
            found.update(_columns(value))
        elif _is_array(value):
            found[item.name] = value
    return found


def _with_columns(arguments: Any, columns: Mapping[str, Any]) -> dict[str, Any]:
    """Return the numbers of a machine, its law or its force with other arrays."""

    def replaced(name: str, value: Any) -> Any:
        if dataclasses.is_dataclass(value) and not isinstance(value, type):
            return type(value)(**_with_columns(value, columns))
        return columns.get(name, value)

    names = [item.name for item in dataclasses.fields(arguments)]
    return {name: replaced(name, getattr(arguments, name)) for name in names}


def _chunk(
    *blocks: NDArray[Any],
    find: Callable[[Oscillator], LimitCycle | CriticalDamping],
    machine: Parameters,
    names: list[str],
    types: list[tuple[str, Any]],
    block_info: Mapping[Any, Any],
) -> NDArray[Any]:
    """Return the answers about a chunk of machines as a structured array."""
    columns = dict(zip(names, blocks, strict=True))
    try:
        answers = find(Oscillator(**_with_columns(machine, columns)))
    except ValueError as error:
        start = [first for first, _ in block_info[None]["array-location"]]
        raise ValueError(f"chunk from {start}: {error}") from None
    found = np.empty(blocks[0].shape, types)
    for name, _ in types:
        found[name] = getattr(answers, name)
    return found


def _in_chunks(
    find: Callable[[Oscillator], LimitCycle | CriticalDamping], oscillator: Oscillator, types: list[tuple[str, Any]]
) -> dict[str, Any]:
    """Return the numbers of the answers about machines in chunks, of these types, as arrays of Dask."""
    from dask import array

    machine = Parameters(**{item.name: getattr(oscillator, item.name) for item in dataclasses.fields(Parameters)})
    columns = _columns(machine)
    machine = Parameters(**_with_columns(machine, dict.fromkeys(columns)))
    blocks = array.broadcast_arrays(*columns.values())
    found = array.map_blocks(  # type: ignore[no-untyped-call]
        _chunk, *blocks, dtype=types, find=find, machine=machine, names=[*columns], types=types
    )
    return {name: found[name] for name, _ in types}


def limit_cycle(oscillator: Oscillator) -> LimitCycle:
    """Find the vibration that develops from a start in stick, without fluctuation.

    Of an array of machines the attributes are arrays of its shape, with the same bits as one call for each machine:
    ``kind`` has names, ``limit_cycle`` is boolean, and numbers are NaN where a single call gives None.
    ``steady_sliding_unstable`` is boolean, but 1, 0 or NaN (undefined) for machines with a force. If the computation
    fails for some machines, their ``kind`` is empty, their flags are False, their numbers are NaN, and a warning names
    the first of them.

    Parameters
    ----------
    oscillator
        The machine, or an array of machines; the answer is dimensionless.

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
    flags = ["limit_cycle", *(["steady_sliding_unstable"] if oscillator.forcing is None else [])]
    if oscillator._checked is None:
        types = {"kind": KINDS.dtype} | dict.fromkeys(flags, bool)
        names = [item.name for item in dataclasses.fields(LimitCycle)]
        return LimitCycle.from_dict(
            _in_chunks(limit_cycle, oscillator, [(name, types.get(name, float)) for name in names])
        )
    found = _core.limit_cycle(oscillator._checked)
    if isinstance(found["kind"], np.ndarray):
        found["kind"] = KINDS[found["kind"].astype(np.intp)]
        for flag in flags:
            found[flag] = found[flag] == 1
    return LimitCycle.from_dict(found)


def critical_damping(oscillator: Oscillator) -> CriticalDamping:
    """Find the damping ratios at which vibration ends; that of the oscillator and the forcing are ignored.

    Of an array of machines the attributes are arrays of its shape, as those of `limit_cycle`.

    Parameters
    ----------
    oscillator
        The machine, or an array of machines.

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
    if oscillator._checked is None:
        types = [(item.name, float) for item in dataclasses.fields(CriticalDamping)]
        return CriticalDamping.from_dict(_in_chunks(critical_damping, oscillator, types))
    return CriticalDamping.from_dict(_core.critical_damping(oscillator._checked))


@dataclass(frozen=True, kw_only=True, eq=False)
class Trajectory(Curves):
    """Motion of one mass, dimensionless, at the output times, and its events."""

    tau: NDArray[np.float64]
    """Output times τ."""
    displacement: NDArray[np.float64]
    """Displacement X at these times."""
    velocity: NDArray[np.float64]
    """Velocity X′ at these times."""
    events: list[str]
    """Events at which the mass has the velocity of the belt: ``D`` it leaves the belt, ``R`` it sticks again, ``O``
    over-slip begins or ends."""
    event_tau: NDArray[np.float64]
    """Times of the events."""
    event_displacement: NDArray[np.float64]
    """Displacement at the events."""
    event_sliding_distance: NDArray[np.float64]
    """Sliding distance ∫|v_rel|dτ up to the events."""

    _curves: ClassVar[Mapping[str, str]] = {"displacement": "tau", "velocity": "tau"}

    def plot(self, *, ax: Axes | None = None) -> Axes:
        """Draw the phase portrait: velocity over displacement.

        Parameters
        ----------
        ax
            Axes of matplotlib; new ones when left out.

        Examples
        --------
        >>> import asperity
        >>> law = asperity.Coulomb(kinetic=0.2)
        >>> machine = asperity.Oscillator(static_friction=0.2, law=law, damping_ratio=0, belt_velocity=1)
        >>> asperity.trajectory(machine, [0, 1, 2]).plot().get_xlabel()
        'displacement X'
        """
        return _plots.phase_portrait(self, ax)


def trajectory(
    oscillator: Oscillator,
    tau: ArrayLike,
    process: FrictionProcess | None = None,
    *,
    start: tuple[float, float] | None = None,
    friction_std: float | None = None,
    correlation_length: float | None = None,
    marginal: str | None = None,
    seed: int = 1,
    index: int = 0,
    drive: Literal["distance", "time"] = "distance",
    allow_clipping: bool = False,
) -> Trajectory:
    """Simulate one mass from a state, without fluctuation or over one realisation of it.

    Parameters
    ----------
    oscillator
        The machine.
    tau
        Output times, rising from 0 on, shape (n,). Events are found between them too.
    process, friction_std, correlation_length, marginal, drive, allow_clipping
        See `ensemble`; without them friction does not fluctuate.
    start
        Displacement X and velocity X′ at τ = 0; X = 0.97 μ_st − 2ζV in stick when left out.
    seed, index
        Realisation of the fluctuation, that of trajectory number `index` of `ensemble`.

    Raises
    ------
    ValueError
        The times do not rise, a number is out of its range, or friction does not stay positive.

    Examples
    --------
    >>> import asperity, numpy as np
    >>> law = asperity.Coulomb(kinetic=0.2)
    >>> machine = asperity.Oscillator(static_friction=0.2, law=law, damping_ratio=0, belt_velocity=1)
    >>> found = asperity.trajectory(machine, np.linspace(0, 2 * np.pi, 100), start=(0.5, 0))
    >>> bool(abs(found.displacement - (0.2 + 0.3 * np.cos(found.tau))).max() < 1e-12)
    True
    """
    fluctuation: tuple[Any, Any, Any] = (None, 0.0, 0.0)
    if any(value is not None for value in (process, friction_std, correlation_length, marginal)):
        fluctuation = _fluctuation(oscillator, process, friction_std, correlation_length, marginal)
    times = numbers(tau)
    if times.ndim != 1:
        raise ValueError(f"tau has the shape {times.shape}, expected (n,)")
    found = _core.trajectory(
        _machine(oscillator),
        times,
        start,
        *(fluctuation or (None, 0.0, 0.0)),
        allow_clipping,
        seed,
        index,
        drive,
    )
    return Trajectory(**found)


def ensemble(
    oscillator: Oscillator,
    process: FrictionProcess | None = None,
    *,
    trajectories: int,
    duration: float,
    seed: int,
    friction_std: Numbers | None = None,
    correlation_length: Numbers | None = None,
    marginal: str | None = None,
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
    process
        Fluctuation in SI, of a machine that knows its `length_unit_m`. The mean of the process does not count: the
        machine has its own friction. Or state the next three.
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
    settings = (allow_clipping, trajectories, duration, seed, drive, callback(progress))
    given, stds, lengths = _fluctuation(oscillator, process, friction_std, correlation_length, marginal)
    machine = _machine(oscillator)
    shape = np.broadcast_shapes(oscillator._shape or (), np.shape(stds), np.shape(lengths))
    if oscillator._shape is None and not (np.ndim(stds) or np.ndim(lengths)):
        return Ensemble.from_dict(_core.ensemble(machine, given, stds, lengths, *settings))
    if oscillator._shape != shape:
        ratios = np.broadcast_to(oscillator.damping_ratio, shape)
        machine = _machine(dataclasses.replace(oscillator, damping_ratio=ratios))
    of_std, of_length = (np.broadcast_to(own, shape).ravel().tolist() for own in (stds, lengths))
    found = _core.ensembles(machine, given, of_std, of_length, *settings)
    for name in ("reattachments", "releases", "periods"):
        found[name]["sample"] = np.empty((*shape, 0))
    return Ensemble.from_dict(found)


def stability_map(
    oscillator: Oscillator,
    process: FrictionProcess | None = None,
    *,
    trajectories: int,
    duration: float,
    seed: int,
    friction_std: float | None = None,
    correlation_length: float | None = None,
    marginal: str | None = None,
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
    process, friction_std, correlation_length, marginal, trajectories, duration, seed, allow_clipping, progress
        See `ensemble`; `trajectories` per point of the map.
    damping_ratios, belt_velocities, friction_stds, loads
        Two axes, each as least value, largest value and cells of the first grid: damping ratios with belt velocities or
        with standard deviations of friction, or belt velocities with loads over the load of the machine.
    depth
        Number of times that cells at the front are halved.

    Raises
    ------
    ValueError
        The axes are no such pair, a number is out of its range, or more than 5 % of the friction values would be
        clipped.

    Examples
    --------
    >>> import asperity
    >>> law = asperity.Stribeck(kinetic=0.1, decay=4.2)
    >>> machine = asperity.Oscillator(static_friction=0.1, law=law, damping_ratio=0.1, belt_velocity=0.003)
    >>> fluctuation = {"friction_std": 0.001, "correlation_length": 0.01, "marginal": "normal"}
    >>> axes = {"damping_ratios": (0.1, 0.3, 1), "belt_velocities": (0.002, 0.004, 1), "depth": 0}
    >>> found = asperity.stability_map(machine, **fluctuation, trajectories=4, duration=100, seed=1, **axes)
    >>> [(point.x, point.sustained.value) for point in found.points[:2]]
    [(0.1, 1.0), (0.3, 0.0)]
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
    fluctuation = _fluctuation(oscillator, process, friction_std, correlation_length, marginal)
    found = _core.stability_map(
        _machine(oscillator), *fluctuation, allow_clipping, settings, trajectories, duration, seed, callback(progress)
    )
    return StabilityMap.from_dict(found)


def _fluctuation(
    oscillator: Oscillator,
    process: FrictionProcess | None,
    friction_std: Numbers | None,
    correlation_length: Numbers | None,
    marginal: str | None,
) -> tuple[Any, Any, Any]:
    """Return a distribution with standard deviation and correlation length, or a process with its unit of length."""
    stated = {"friction_std": friction_std, "correlation_length": correlation_length, "marginal": marginal}
    missing = [name for name, value in stated.items() if value is None]
    if process is None:
        if friction_std is None or correlation_length is None or marginal is None:
            raise ValueError(f"state {', '.join(missing)}, or a process")
        return marginal, _numbers(friction_std), _numbers(correlation_length)
    if not isinstance(process, FrictionProcess):
        raise TypeError(f"process is {process!r}, expected a FrictionProcess")
    if len(missing) < len(stated):
        raise ValueError(f"state a process, or {', '.join(stated)}, not both")
    if oscillator.length_unit_m is None:
        raise ValueError("a process in SI needs a machine with length_unit_m, such as one of Oscillator.from_si")
    return process.to_dict(), 0.0, oscillator.length_unit_m
