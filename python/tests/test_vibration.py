import dataclasses
import math
import pickle

import numpy as np
import pytest

import asperity
from asperity import Oscillator, Stribeck

PAPER = ("--static-friction", 0.1, "--stribeck", 4.2, "--belt-velocity", 0.003)


def paper(damping_ratio: float = 0.17) -> Oscillator:
    law = Stribeck(kinetic=0.1, decay=4.2)
    return Oscillator(static_friction=0.1, law=law, damping_ratio=damping_ratio, belt_velocity=0.003)


def test_cycle_and_critical_damping_equal_those_of_the_command_line(program):
    expected = program("vibration", "cycle", *PAPER, "--damping-ratio", 0.17)
    found = asperity.limit_cycle(paper()).to_dict()
    del expected["warnings"]
    assert {key: found[key] for key in expected} == expected
    expected = program("vibration", "critical-damping", *PAPER)
    found = asperity.critical_damping(paper()).to_dict()
    assert found == {key: expected[key] for key in found}


def test_linear_weakening_ends_at_half_its_slope():
    law = asperity.Linear(kinetic=0.4, slope=0.3)
    found = asperity.critical_damping(Oscillator(static_friction=0.4, law=law, damping_ratio=0, belt_velocity=0.1))
    assert found.hopf_damping_ratio == pytest.approx(0.15, abs=1e-14)
    assert found.critical_damping_ratio == pytest.approx(0.15, abs=1e-12)


def test_coulomb_friction_without_damping_and_jump_slides_or_sticks_at_the_natural_period():
    law = asperity.Coulomb(kinetic=0.2)
    found = asperity.limit_cycle(Oscillator(static_friction=0.4, law=law, damping_ratio=0.0, belt_velocity=0.05))
    # The orbit from the detachment is a circle about X = 0.2 with the radius √(0.2² + 0.05²).
    radius = math.hypot(0.2, 0.05)
    assert found.displacement_max == pytest.approx(0.2 + radius, rel=1e-9)
    assert found.velocity_min == pytest.approx(-radius, rel=1e-9)


def test_an_ensemble_equals_that_of_the_command_line(program):
    fluctuation = {"friction_std": 0.001, "correlation_length": 0.01, "marginal": "beta:2.1,5"}
    size = {"trajectories": 40, "duration": 60.0, "seed": 3}
    settings = {**fluctuation, **size}
    flags = [part for key, value in settings.items() for part in (f"--{key.replace('_', '-')}", value)]
    expected = program("vibration", "ensemble", *PAPER, "--damping-ratio", 0.17, *flags, "--quiet")
    found = asperity.ensemble(paper(), **fluctuation, **size)
    assert (found.cycles.mean, found.cycles.se) == (expected["cycles_mean"], expected["cycles_se"])
    assert found.difference_interval == expected["difference_mean_interval"]
    assert found.reattachments.skewness == expected["reattachment_skewness"]
    assert found.passages.sustained.value == expected["sustained_share"]
    assert found.passages.kinds == expected["kind_shares"]
    assert isinstance(found.reattachments.sample, np.ndarray)
    assert found.reattachments.sample.mean() == pytest.approx(found.reattachments.mean, rel=1e-12)
    assert np.array_equal(found.to_xarray().periods, found.periods.sample)
    frame = found.to_dataframe()
    assert frame["reattachments.mean"].item() == found.reattachments.mean
    assert "reattachments.sample" not in frame


def test_a_map_falls_from_vibration_to_sliding_over_damping():
    found = asperity.stability_map(
        paper(), friction_std=1e-4, correlation_length=0.05, marginal="normal", trajectories=8, duration=60, seed=1,
        damping_ratios=(0.125, 0.375, 2), belt_velocities=(0.003, 0.004, 1), depth=0,
    )  # fmt: skip
    assert found.axes == ["damping_ratio", "belt_velocity"]
    shares = {point.x: point.sustained.value for point in found.points if point.y == 0.003}
    assert shares == {0.125: 1.0, 0.25: 0.0, 0.375: 0.0}
    frame = found.to_dataframe()
    assert frame["sustained.value"].tolist() == [point.sustained.value for point in found.points]
    limits = [point.limit_damping_ratio for point in found.points if point.y == 0.003]
    assert limits == pytest.approx([asperity.critical_damping(paper()).limit_damping_ratio] * 3)
    with pytest.raises(ValueError, match="damping_ratios with"):
        asperity.stability_map(
            paper(), friction_std=1e-4, correlation_length=0.05, marginal="normal", trajectories=8, duration=60, seed=1
        )


def test_machines_and_results_are_copied_and_sent_to_other_processes():
    machine = pickle.loads(pickle.dumps(paper()))
    assert machine == paper()
    assert asperity.limit_cycle(machine) == pickle.loads(pickle.dumps(asperity.limit_cycle(paper())))
    damped = dataclasses.replace(machine, damping_ratio=0.3)
    assert asperity.limit_cycle(damped).kind == "none"


def test_wrong_parameters_are_named():
    with pytest.raises(ValueError, match="damping_ratio is -1"):
        paper(-1.0)
    with pytest.raises(ValueError, match="trajectories is 1"):
        asperity.ensemble(
            paper(), friction_std=1e-3, correlation_length=0.01, marginal="normal", trajectories=1, duration=9, seed=1
        )
    settings = {"correlation_length": 0.01, "trajectories": 2, "duration": 9, "seed": 1}
    with pytest.raises(ValueError, match="found -1, expected a whole number"):
        asperity.ensemble(paper(), friction_std=1e-3, marginal="normal", **{**settings, "seed": -1})
    with pytest.raises(TypeError):
        asperity.ensemble(paper(), friction_std=1e-3, marginal="normal", **{**settings, "trajectories": 2.5})
    with pytest.raises(ValueError, match="allow_clipping"):
        asperity.ensemble(paper(), friction_std=0.1, marginal="normal", **settings)
    with pytest.raises(ValueError, match="colour"):
        asperity.ensemble(paper(), friction_std=0.1, marginal="colour", **settings)
    with pytest.warns(UserWarning, match="were clipped"):
        asperity.ensemble(paper(), friction_std=0.1, marginal="normal", allow_clipping=True, **settings)


def test_a_tabulated_law_is_that_of_its_points():
    # μ falls by 0.3 per unit of velocity, as on the line.
    points = [(0.0, 0.1), (0.05, 0.085), (0.1, 0.07)]
    tabulated = Oscillator(
        static_friction=0.1, law=asperity.Tabulated(points=points), damping_ratio=0.05, belt_velocity=0.003
    )
    linear = dataclasses.replace(tabulated, law=asperity.Linear(kinetic=0.1, slope=0.3))
    assert asperity.limit_cycle(tabulated).period == pytest.approx(asperity.limit_cycle(linear).period, rel=1e-9)
