"""Oscillator and its velocity laws. Made by scripts/generate_python_results.py; do not edit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Stribeck:
    """Velocity weakening μ = μ_k/(1 + a|v|), the law of Gaus et al. 2016 (there μ_k is the static coefficient)."""

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
    """Linear weakening μ = μ_k − b|v|. The law is invalid from |v| = μ_k/b on, which is reported as an error."""

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
    """v₀ > 0, the Stribeck velocity."""


@dataclass(frozen=True, kw_only=True)
class Tabulated:
    """Kinetic friction law through points (|v|, μ): monotone cubics between them, constant beyond the last."""

    points: Sequence[tuple[float, float]]
    """Points (|v|, μ) by rising velocity, the first at 0."""


VelocityLaw = Stribeck | Coulomb | Linear | Exponential | Tabulated


@dataclass(frozen=True, kw_only=True)
class Forcing:
    """Harmonic force q cos ητ on the mass."""

    amplitude: float
    """q = Q/N."""
    frequency: float
    """η = Ω/ω₀ > 0."""


@dataclass(frozen=True, kw_only=True)
class Parameters:
    """Dimensionless parameters of an oscillator."""

    static_friction: float
    """μ_st, the stick limit."""
    law: VelocityLaw
    """Kinetic friction law μ(|v|)."""
    damping_ratio: float
    """ζ = d/(2mω₀)."""
    belt_velocity: float
    """V = v_b·mω₀/N."""
    forcing: Forcing | None = None
    """Harmonic force, if any."""


__all__ = ["Coulomb", "Exponential", "Forcing", "Linear", "Stribeck", "Tabulated"]
