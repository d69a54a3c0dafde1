"""Oscillator and its velocity laws. Made by scripts/generate_python_results.py; do not edit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from asperity._record import Arguments

Numbers = float | NDArray[Any]
"""A number, or an array with a number of each machine."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Stribeck(Arguments):
    """Velocity weakening μ = μ_k/(1 + a|v|), the law of Gaus et al. 2016 (there μ_k is the static coefficient)."""

    kinetic: Numbers
    """μ_k, the coefficient at vanishing sliding velocity."""
    decay: Numbers
    """a ≥ 0, per unit of dimensionless velocity."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Coulomb(Arguments):
    """Constant coefficient."""

    kinetic: Numbers
    """μ_k."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Linear(Arguments):
    """Linear weakening μ = μ_k − b|v|. The law is invalid from |v| = μ_k/b on, which is reported as an error."""

    kinetic: Numbers
    """μ_k, the coefficient at vanishing sliding velocity."""
    slope: Numbers
    """b ≥ 0, per unit of dimensionless velocity."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Exponential(Arguments):
    """Exponential weakening μ = μ_∞ + (μ_k − μ_∞)e^{−|v|/v₀}."""

    kinetic: Numbers
    """μ_k, the coefficient at vanishing sliding velocity."""
    high_speed: Numbers
    """0 < μ_∞ ≤ μ_k, the coefficient at high velocity."""
    stribeck_velocity: Numbers
    """v₀ > 0, the Stribeck velocity."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Tabulated(Arguments):
    """Kinetic friction law through points (|v|, μ): monotone cubics between them, constant beyond the last."""

    points: Sequence[tuple[float, float]]
    """Points (|v|, μ) by rising velocity, the first at 0."""


VelocityLaw = Stribeck | Coulomb | Linear | Exponential | Tabulated


@dataclass(frozen=True, kw_only=True, eq=False)
class Forcing(Arguments):
    """Harmonic force q cos ητ on the mass."""

    amplitude: Numbers
    """q = Q/N."""
    frequency: Numbers
    """η = Ω/ω₀ > 0."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Parameters(Arguments):
    """Dimensionless parameters of an oscillator."""

    static_friction: Numbers
    """μ_st, the stick limit."""
    law: VelocityLaw
    """Kinetic friction law μ(|v|)."""
    damping_ratio: Numbers
    """ζ = d/(2mω₀)."""
    belt_velocity: Numbers
    """V = v_b·mω₀/N."""
    forcing: Forcing | None = None
    """Harmonic force, if any."""


__all__ = ["Coulomb", "Exponential", "Forcing", "Linear", "Stribeck", "Tabulated"]
