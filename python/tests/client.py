"""A program of a user, which mypy --strict accepts. It fails if an ignored error is none."""

import numpy as np
from numpy.typing import NDArray

import asperity


def contact_fraction(path: str) -> float:
    surface = asperity.HeightMap.read(path).level("plane", outliers=5.0)
    low, high = surface.statistics().Sq_m_interval
    found = asperity.solve_contact(surface, youngs_modulus_pa=210e9, mean_pressure_pa=20e6)
    return found.contact_fraction * float(np.max(found.pressure_pa)) / float(high - low)


def period(damping_ratio: float) -> float | None:
    law = asperity.Stribeck(kinetic=0.1, decay=4.2)
    machine = asperity.Oscillator(static_friction=0.1, law=law, damping_ratio=damping_ratio, belt_velocity=0.003)
    return asperity.limit_cycle(machine).period


def vibrating_share(damping_ratios: NDArray[np.float64]) -> float:
    law = asperity.Stribeck(kinetic=0.1, decay=4.2)
    machines = asperity.Oscillator(static_friction=0.1, law=law, damping_ratio=damping_ratios, belt_velocity=0.003)
    return float(np.mean(asperity.limit_cycle(machines).limit_cycle))


def friction(path: str) -> list[float | None]:
    results = asperity.run_study(path, progress=False)
    return [level.mean for level in results.friction.levels] if results.friction else []


def misspelt() -> list[object]:
    return [
        asperity.contact_solution,  # type: ignore[attr-defined]
        asperity.figures.figure_6,  # type: ignore[attr-defined]
    ]
