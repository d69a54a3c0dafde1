import dataclasses
import math
import pickle
import typing

import numpy as np
import pytest

import asperity
from asperity import AsperityWarning, Oscillator, Stribeck
from asperity.laws import VelocityLaw

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


def element(value, shape, index):
    """Return the machine at an index of an array of machines."""
    if dataclasses.is_dataclass(value):
        fields = [field.name for field in dataclasses.fields(value) if field.init]
        return dataclasses.replace(value, **{name: element(getattr(value, name), shape, index) for name in fields})
    return np.broadcast_to(value, shape)[index].item() if isinstance(value, np.ndarray) else value


def check_each(function, machines):
    """Check that the answers about an array of machines have the bits of single calls, and return them."""
    found = function(machines)
    columns = dict(found._values())
    (shape,) = {column.shape for column in columns.values()}
    for index in np.ndindex(shape):
        single = function(element(machines, shape, index))
        for name, column in columns.items():
            wanted, value = getattr(single, name), column[index]
            assert np.isnan(value) if wanted is None else value == wanted, (index, name)
    return found


def bell(belt_velocity, damping_ratio):
    speeds = np.linspace(0.0, 0.3, 61)
    points = list(zip(speeds.tolist(), (0.3 + 0.1 * np.exp(-((speeds / 0.08) ** 2))).tolist(), strict=True))
    law = asperity.Tabulated(points=points)
    return Oscillator(static_friction=0.4, law=law, damping_ratio=damping_ratio, belt_velocity=belt_velocity)


def test_arrays_of_machines_have_the_bits_of_single_calls_for_every_kind_of_motion():
    law = Stribeck(kinetic=np.array([[0.1], [0.09], [0.05]]), decay=4.2)
    ratios, velocities = np.array([0.0, 0.17, 0.2048, 0.5]), np.array([[[0.003]], [[0.5]]])
    paper = Oscillator(static_friction=0.1, law=law, damping_ratio=ratios, belt_velocity=velocities)
    bells = bell(np.array([0.056, 0.11, 0.12]), np.array([[0.0], [0.2], [0.27], [0.3]]))
    # The first amplitude is no force.
    force = asperity.Forcing(amplitude=np.array([0.0, 0.02, 0.1]), frequency=np.array([[0.3], [0.9]]))
    coulomb = asperity.Coulomb(kinetic=0.3)
    forced = Oscillator(static_friction=0.4, law=coulomb, damping_ratio=0.01, belt_velocity=0.1, forcing=force)
    found = [check_each(asperity.limit_cycle, machines) for machines in (paper, bells, forced)]
    kinds = set().union(*(np.unique(answer.kind) for answer in found))
    assert kinds == {"stick_slip", "overtaking", "slip_cycle", "none"}
    irregular = (found[2].kind != "none") & ~found[2].limit_cycle
    assert irregular.any()
    assert found[0].kind.shape == (2, 3, 4)
    assert [answer.steady_sliding_unstable.dtype.kind for answer in found] == ["b", "b", "f"]
    assert np.array_equal(np.isnan(found[2].steady_sliding_unstable), [[False, True, True]] * 2)
    for machines in (paper, bells, forced):
        check_each(asperity.critical_damping, machines)


def test_every_number_of_a_machine_may_be_an_array():
    laws = [
        Stribeck(kinetic=0.3, decay=1.5),
        asperity.Coulomb(kinetic=0.3),
        asperity.Linear(kinetic=0.3, slope=0.2),
        asperity.Exponential(kinetic=0.3, high_speed=0.2, stribeck_velocity=0.1),
        asperity.Tabulated(points=[(0.0, 0.3), (0.1, 0.2)]),
    ]
    assert {type(law) for law in laws} == set(typing.get_args(VelocityLaw))
    force = asperity.Forcing(amplitude=0.02, frequency=0.8)
    for law in laws:
        machine = Oscillator(static_friction=0.4, law=law, damping_ratio=0.1, belt_velocity=0.05, forcing=force)
        for part, changed in (("law", law), ("forcing", force), (None, machine)):
            for name, value in vars(changed).items():
                if not isinstance(value, float):
                    continue
                varied = dataclasses.replace(changed, **{name: np.array([value, 0.95 * value])})
                machines = dataclasses.replace(machine, **{part: varied}) if part else varied
                found = check_each(asperity.limit_cycle, machines)
                assert found.displacement_max[0] != found.displacement_max[1], name


def test_machines_without_axes_are_single_and_empty_arrays_have_no_answer():
    single = asperity.limit_cycle(paper())
    for ratio in (np.array(0.17), np.float64(0.17), np.ma.array(0.17)):
        assert paper(ratio) == paper()
        assert asperity.limit_cycle(paper(ratio)) == single
        assert isinstance(single.period, float)
    empty = asperity.limit_cycle(paper(np.zeros((3, 0))))
    assert {column.shape for column in empty._values().values()} == {(3, 0)}
    assert len(asperity.critical_damping(paper(np.zeros(0))).to_dataframe()) == 0


def test_other_types_of_numbers_are_machines_of_doubles():
    singles = np.array([0.25, 1.0], dtype=np.float32)
    assert paper(singles) == paper(singles.astype(float))
    assert paper(np.array([0, 1])) == paper(np.array([0.0, 1.0]))
    assert paper(np.ma.array([0.1, 0.2], mask=[False, False])) == paper(np.array([0.1, 0.2]))
    with pytest.raises(ValueError, match=r"machine \[1\]: damping_ratio is NaN"):
        paper(np.ma.array([0.1, 0.2], mask=[False, True]))


def test_refused_machines_and_shapes_are_named():
    with pytest.raises(ValueError, match=r"machine \[1, 2\]: damping_ratio is -1"):
        paper(np.array([[0.1, 0.2, 0.3], [0.1, 0.2, -1.0]]))
    law = Stribeck(kinetic=np.array([0.1, 0.09, 0.08]), decay=4.2)
    with pytest.raises(ValueError, match=r"kinetic \(3,\), damping_ratio \(2,\)"):
        dataclasses.replace(paper(np.array([0.1, 0.2])), law=law)
    with pytest.raises(ValueError, match="single oscillator"):
        asperity.stability_map(
            paper(np.array([0.1])), friction_std=1e-3, correlation_length=0.01, marginal="normal", trajectories=2,
            duration=9, seed=1, damping_ratios=(0.1, 0.2, 2), belt_velocities=(0.1, 0.2, 2),
        )  # fmt: skip
    with pytest.warns(AsperityWarning, match=r"damping ratio 2 .*\(2 of 3 machines\)"):
        paper(np.array([0.1, 2.0, 3.0]))


def test_a_machine_without_answer_leaves_those_of_the_others():
    # On this slope friction falls below zero at the speeds of slip.
    law = asperity.Linear(kinetic=0.4, slope=np.array([0.3, 3.0, 30.0, 0.1]))
    machines = Oscillator(static_friction=0.4, law=law, damping_ratio=0.001, belt_velocity=0.1)
    with pytest.raises(ValueError, match="must stay positive"):
        asperity.limit_cycle(element(machines, (4,), 1))
    with pytest.warns(AsperityWarning, match=r"2 of 4 machines have no answer .* the first is \[1\]: the friction"):
        found = asperity.limit_cycle(machines)
    assert found.kind.tolist() == ["stick_slip", "", "", "stick_slip"]
    assert found.limit_cycle.tolist() == [True, False, False, True]
    assert np.isnan(found.period).tolist() == [False, True, True, False]
    assert found.period[3] == asperity.limit_cycle(element(machines, (4,), 3)).period


def test_arrays_of_machines_are_values_that_do_not_change():
    ratios = np.array([0.1, 0.2, 0.3])
    machines = paper(ratios)
    found = asperity.limit_cycle(machines)
    ratios[0] = 0.5
    assert machines == paper(np.array([0.1, 0.2, 0.3])) != paper(ratios)
    sent = pickle.loads(pickle.dumps(machines))
    assert sent == machines
    assert asperity.limit_cycle(sent) == found == pickle.loads(pickle.dumps(found))
    assert found != asperity.limit_cycle(paper(ratios))
    for array in (machines.damping_ratio, sent.damping_ratio):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0.5
    assert hash(paper()) == hash(paper(np.array(0.17)))


def test_answers_about_machines_are_tables_and_data_sets():
    pytest.importorskip("xarray")
    found = asperity.limit_cycle(paper(np.array([0.1, 0.3])))
    frame = found.to_dataframe()
    assert frame["kind"].tolist() == ["stick_slip", "none"]
    assert np.array_equal(frame["period"], found.period, equal_nan=True)
    grid = asperity.critical_damping(paper(np.full((2, 3), 0.1))).to_xarray()
    assert grid.limit_damping_ratio.dims == ("dim_0", "dim_1")
    assert grid.limit_damping_ratio.attrs["units"] == "1"
    assert asperity.limit_cycle(paper()).to_xarray().period == asperity.limit_cycle(paper()).period
    many = asperity.critical_damping(paper(np.full(2000, 0.1)))
    assert "array (2000,)" in many._repr_html_()
    assert max(map(len, (repr(many), many._repr_html_(), repr(paper(np.full(2000, 0.1)))))) < 2000


def test_blocks_of_dask_are_arrays_of_machines():
    array = pytest.importorskip("dask.array")
    ratios = np.linspace(0.05, 0.2, 10)
    period = array.from_array(ratios, chunks=4).map_blocks(lambda own: asperity.limit_cycle(paper(own)).period)
    assert np.array_equal(period.compute(scheduler="threads"), asperity.limit_cycle(paper(ratios)).period)


def test_points_of_a_law_are_copied_and_lists_are_arrays():
    points = np.array([[0, 0.1], [0.1, 0.099], [1, 0.09]])
    law = asperity.Tabulated(points=points)
    own = asperity.Oscillator(static_friction=0.1, law=law, damping_ratio=0.001, belt_velocity=0.003)
    points[2, 1] = 0.02
    assert own == pickle.loads(pickle.dumps(own))
    assert asperity.limit_cycle(own) == asperity.limit_cycle(pickle.loads(pickle.dumps(own)))
    law = asperity.Stribeck(kinetic=0.1, decay=4.2)
    machines = asperity.Oscillator(static_friction=0.1, law=law, damping_ratio=[0.1, 0.3], belt_velocity=0.003)
    assert list(asperity.limit_cycle(machines).limit_cycle) == [True, False]


SI = ["--mass", "15kg", "--natural-frequency", "100Hz", "--normal-force", "10kN"]


@pytest.mark.parametrize(
    ("law", "options"),
    [
        (asperity.Stribeck(kinetic=0.38, decay=0.3), ["--stribeck", "0.3s/m"]),
        (asperity.Linear(kinetic=0.38, slope=0.1), ["--linear-weakening", "0.1s/m"]),
        (
            asperity.Exponential(kinetic=0.38, high_speed=0.3, stribeck_velocity=0.5),
            ["--stribeck-velocity", "0.5m/s", "--high-speed-friction", "0.3"],
        ),
    ],
)
def test_an_oscillator_of_si_values_is_that_of_the_command_line(program, law, options):
    own = asperity.Oscillator.from_si(
        mass_kg=15,
        natural_frequency_rad_per_s=2 * np.pi * 100,
        normal_force_n=10e3,
        belt_velocity_m_per_s=0.02,
        static_friction=0.38,
        law=law,
        damping_ratio=0.03,
    )
    line = ["vibration", "cycle", *SI, *options, "--belt-velocity", "20mm/s"]
    expected = program(*line, "--static-friction", "0.38", "--damping-ratio", "0.03")
    found = asperity.limit_cycle(own)
    assert found.kind == expected["kind"]
    assert found.period == pytest.approx(expected["period"], rel=1e-12)


def test_si_values_may_be_arrays_and_forces_and_tables_have_their_units():
    table = asperity.Tabulated(points=[(0.0, 0.38), (0.5, 0.3)])
    common = {"natural_frequency_rad_per_s": 600.0, "normal_force_n": 3e3, "static_friction": 0.38}
    common |= {"belt_velocity_m_per_s": 0.1, "damping_ratio": 0.03}
    force = asperity.Forcing(amplitude=30.0, frequency=300.0)
    own = asperity.Oscillator.from_si(mass_kg=10, law=table, forcing=force, **common)
    # N/(mω₀) = 0.5 m/s.
    assert own.belt_velocity == pytest.approx(0.2)
    np.testing.assert_allclose(own.law.points, [(0.0, 0.38), (1.0, 0.3)], rtol=1e-15)
    assert (own.forcing.amplitude, own.forcing.frequency) == pytest.approx((0.01, 0.5))
    law = asperity.Stribeck(kinetic=0.38, decay=0.3)
    many = asperity.Oscillator.from_si(mass_kg=np.array([10.0, 20.0]), law=law, **common)
    for place, mass in enumerate([10.0, 20.0]):
        single = asperity.Oscillator.from_si(mass_kg=mass, law=law, **common)
        assert (many.belt_velocity[place], many.law.decay[place]) == (single.belt_velocity, single.law.decay)
    with pytest.raises(ValueError, match="one unit of velocity"):
        asperity.Oscillator.from_si(mass_kg=np.array([10.0, 20.0]), law=table, **common)
    for wrong in (0.0, -1.0, float("nan"), [1.0, 0.0]):
        with pytest.raises(ValueError, match="mass_kg is"):
            asperity.Oscillator.from_si(mass_kg=wrong, law=law, **common)


def flat(found, path=""):
    """Return the numbers of a result by their paths."""
    for name, value in found.items():
        if isinstance(value, dict):
            yield from flat(value, f"{path}{name}.")
        elif name not in ("sample", "failures", "first_exits"):
            yield f"{path}{name}", value


def test_ensembles_of_arrays_have_the_bits_of_single_ones():
    settings = {"marginal": "normal", "trajectories": 8, "duration": 200.0, "seed": 3}
    law = asperity.Stribeck(kinetic=0.1, decay=4.2)
    common = {"static_friction": 0.1, "law": law, "belt_velocity": 0.003}
    damping, stds = np.array([0.1, 0.2, 0.3]), np.array([[0.001], [0.004]])
    many = asperity.ensemble(
        Oscillator(damping_ratio=damping, **common), friction_std=stds, correlation_length=0.01, **settings
    )
    assert many.difference_interval.shape == (2, 3, 2)
    arrays = dict(flat(many.to_dict()))
    for row, column in np.ndindex(2, 3):
        machine = Oscillator(damping_ratio=float(damping[column]), **common)
        single = asperity.ensemble(
            machine, friction_std=float(stds[row, 0]), correlation_length=0.01, **settings
        ).to_dict()
        for path, value in flat(single):
            # An undefined estimate has no numbers of its own.
            owns = [own for name, own in arrays.items() if name == path or name.startswith(f"{path}.")]
            assert owns, path
            for own in owns:
                found = np.nan if own is None else np.asarray(own, dtype=float)[row, column]
                np.testing.assert_array_equal(found, np.nan if value is None else value, path)
    with pytest.raises(ValueError, match="broadcast"):
        asperity.ensemble(
            Oscillator(damping_ratio=damping, **common), friction_std=[0.1, 0.2], correlation_length=1.0, **settings
        )


BRAKE = {
    "mass_kg": 15,
    "natural_frequency_rad_per_s": 628.3,
    "normal_force_n": 10e3,
    "belt_velocity_m_per_s": 0.02,
    "static_friction": 0.38,
    "law": Stribeck(kinetic=0.38, decay=0.3),
    "damping_ratio": 0.03,
}


def test_an_ensemble_over_a_process_is_that_of_a_study(tmp_path):
    process = asperity.friction_process(mean=0.38, std=0.004, correlation_length_m=250e-6)
    process.write(tmp_path / "process.json")
    vibration = {
        "mass": "15 kg",
        "natural_frequency": "628.3 rad/s",
        "damping_ratio": 0.03,
        "normal_force": "10 kN",
        "belt_velocity": "20 mm/s",
        "nominal_area": "5000 mm^2",
        "friction_process": tmp_path / "process.json",
        "stribeck": "0.3 s/m",
        "trajectories": 16,
        "duration": 100,
    }
    with pytest.warns(AsperityWarning, match="does not say over which area"):
        wanted = asperity.run_study({"seed": 3, "vibration": vibration}, progress=False).vibration.area
    settings = {"trajectories": 16, "duration": 100, "seed": 3}
    machine = Oscillator.from_si(**BRAKE)
    found = asperity.ensemble(machine, process, **settings)
    assert found.passages.share_in_cycle == wanted.motion.share_in_cycle
    assert found.reattachments.mean == pytest.approx(wanted.reattachment.mean, rel=1e-14)
    both = Oscillator.from_si(**{**BRAKE, "mass_kg": [15, 16]})
    assert asperity.ensemble(both, process, **settings).cycles.mean[0] == found.cycles.mean

    # A map over damping has the share of the machine at its own damping ratio.
    axes = {"damping_ratios": (0.02, 0.04, 2), "belt_velocities": (machine.belt_velocity, 2 * machine.belt_velocity, 2)}
    points = asperity.stability_map(machine, process, depth=0, **axes, **settings).points
    own = [point for point in points if (point.x, point.y) == (0.03, machine.belt_velocity)]
    assert [point.sustained.value for point in own] == [found.passages.sustained.value]

    with pytest.raises(ValueError, match="state friction_std, correlation_length, marginal, or a process"):
        asperity.ensemble(machine, **settings)
    with pytest.raises(ValueError, match="not both"):
        asperity.ensemble(machine, process, marginal="normal", **settings)
    with pytest.raises(ValueError, match="length_unit_m"):
        asperity.ensemble(paper(), process, **settings)
    with pytest.raises(TypeError, match="expected a FrictionProcess"):
        asperity.ensemble(machine, process.to_dict(), **settings)


def test_a_trajectory_follows_coulomb_friction_and_counts_the_cycles_of_its_ensemble():
    tau = np.linspace(0, 6, 601)
    free = Oscillator(static_friction=0.2, law=asperity.Coulomb(kinetic=0.2), damping_ratio=0, belt_velocity=1)
    found = asperity.trajectory(free, tau, start=(0.7, 0.3))
    np.testing.assert_allclose(found.displacement, 0.2 + 0.5 * np.cos(tau) + 0.3 * np.sin(tau), atol=1e-12)
    np.testing.assert_allclose(found.velocity, 0.3 * np.cos(tau) - 0.5 * np.sin(tau), atol=1e-12)
    assert not found.events
    assert list(found.to_dataframe().columns) == ["tau", "displacement", "velocity"]
    assert found.to_xarray().velocity.dims == ("tau",)
    assert pickle.loads(pickle.dumps(found)) == found

    fluctuation = {"friction_std": 0.001, "correlation_length": 0.01, "marginal": "normal"}
    wanted = asperity.ensemble(paper(), **fluctuation, trajectories=3, duration=200, seed=5)
    found = [asperity.trajectory(paper(), [200], **fluctuation, seed=5, index=index) for index in range(3)]
    sticks = sum(own.events.count("R") for own in found)
    assert sticks == 3 * (wanted.cycles.mean + wanted.micro_slips.mean)
    restuck = [x for own in found for x, kind in zip(own.event_displacement, own.events, strict=True) if kind == "R"]
    nearest = np.abs(np.subtract.outer(wanted.reattachments.sample, restuck)).min(axis=1)
    assert nearest.max() < 1e-12

    with pytest.raises(ValueError, match="tau is 0, but must be rising"):
        asperity.trajectory(paper(), [1, 0])
    with pytest.raises(ValueError, match=r"tau has the shape \(\), expected \(n,\)"):
        asperity.trajectory(paper(), 5)
    with pytest.raises(ValueError, match="start velocity is NaN"):
        asperity.trajectory(paper(), [0, 1], start=(0, math.nan))


@pytest.mark.parametrize("wrong", [True, "0.1", None])
def test_what_is_no_number_is_named(wrong):
    with pytest.raises(TypeError, match=r"damping_ratio is .*, expected a number or an array"):
        paper(wrong)
    with pytest.raises(TypeError, match=r"law is .*, expected one of Stribeck, Coulomb"):
        Oscillator(static_friction=0.1, law=wrong, damping_ratio=0.1, belt_velocity=1)
    with pytest.raises(ValueError, match="damping_ratio is nan, expected a finite number"):
        paper(math.nan)
