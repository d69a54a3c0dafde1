"""Objects of all public classes are values: they are compared, copied and pickled."""

import copy
import dataclasses
import inspect
import pickle

import numpy as np
import pytest

import asperity
from asperity import Covariance, HeightMap
from test_study import MACHINE

STATIC = {"size_m": 64e-6, "points": 32, "rms_height_m": 1e-6}
EXPONENTIAL = Covariance(model="exponential", correlation_length_m=10e-6)
XI = asperity.design("sobol", seed=1, samples=40, variables=2)


def oscillator(damping_ratio=0.17):
    law = asperity.Stribeck(kinetic=0.1, decay=4.2)
    return asperity.Oscillator(static_friction=0.1, law=law, damping_ratio=damping_ratio, belt_velocity=0.003)


def scan(seed=1):
    return asperity.Spectral(covariance=EXPONENTIAL, **STATIC).sample(seed)[0]


def study_without_sweep():
    machine = {name: value for name, value in MACHINE["vibration"].items() if name != "damping_sweep"}
    return asperity.Study.from_dict({**MACHINE, "vibration": machine})


# Two functions for each class, whose objects differ.
MAKERS = {
    "ContactSolution": [
        lambda load_n=load_n: asperity.solve_contact(scan(), modulus_pa=1e11, load_n=load_n) for load_n in (0.1, 0.2)
    ],
    "Coulomb": [lambda: asperity.Coulomb(kinetic=0.1), lambda: asperity.Coulomb(kinetic=0.2)],
    "Covariance": [lambda: EXPONENTIAL, lambda: Covariance(model="exponential", correlation_length_m=20e-6)],
    "Expansion": [
        lambda kinds=kinds: asperity.Expansion.fit(XI, XI[:, 0] * XI[:, 1], degree=3, distributions=kinds)
        for kinds in (["normal", "normal:0,1.01"], None)
    ],
    "Exponential": [
        lambda v=v: asperity.Exponential(kinetic=0.2, high_speed=0.1, stribeck_velocity=v) for v in (0.1, 0.2)
    ],
    "Forcing": [
        lambda frequency=frequency: asperity.Forcing(amplitude=0.1, frequency=frequency) for frequency in (1, 2)
    ],
    "FrictionProcess": [
        lambda std=std: asperity.friction_process(mean=0.2, std=std, correlation_length_m=1e-4) for std in (0.01, 0.02)
    ],
    "HeightMap": [scan, lambda: scan(2)],
    "KarhunenLoeve": [
        lambda modes=modes: asperity.KarhunenLoeve(covariance=EXPONENTIAL, modes=modes, **STATIC) for modes in (30, 40)
    ],
    "Linear": [lambda: asperity.Linear(kinetic=0.1, slope=0.1), lambda: asperity.Linear(kinetic=0.1, slope=0.2)],
    "Oscillator": [oscillator, lambda: oscillator(0.2)],
    "Spectral": [
        lambda points=points: asperity.Spectral(covariance=EXPONENTIAL, **{**STATIC, "points": points})
        for points in (32, 64)
    ],
    "Study": [lambda seed=seed: asperity.Study.from_dict({**MACHINE, "seed": seed}) for seed in (1, 2)],
    "Stribeck": [lambda: asperity.Stribeck(kinetic=0.1, decay=4), lambda: asperity.Stribeck(kinetic=0.1, decay=5)],
    "SurfaceModel": [
        lambda seed=seed: asperity.SurfaceModel.fit(scan(seed), generator="spectral", marginal="normal")
        for seed in (1, 2)
    ],
    "Tabulated": [
        lambda points=points: asperity.Tabulated(points=points)
        for points in ([(0.0, 0.1), (0.1, 0.08)], [(0.0, 0.1), (0.1, 0.09)])
    ],
    "Translation": [
        lambda marginal=marginal: asperity.Translation(covariance=EXPONENTIAL, marginal=marginal, **STATIC)
        for marginal in ("beta:2,5", "beta:2,6")
    ],
    "WeierstrassMandelbrot": [
        lambda dimension=dimension: asperity.WeierstrassMandelbrot(fractal_dimension=dimension, **STATIC)
        for dimension in (2.3, 2.4)
    ],
    # Results that no name of the package is the class of.
    "Autocorrelation": [lambda: scan().acf(), lambda: scan(2).acf()],
    "PartStatistics": [lambda seed=seed: asperity.pooled_statistics([scan(), scan(seed)]) for seed in (2, 3)],
    "StudyCheck": [lambda: asperity.Study.from_dict(MACHINE).check(), lambda: study_without_sweep().check()],
    "Trajectory": [lambda end=end: asperity.trajectory(oscillator(), [0, end]) for end in (10, 20)],
    "RadialSpectrum": [lambda: scan().psd(), lambda: scan(2).psd()],
    "SurfaceStatistics": [lambda: scan().statistics(), lambda: scan(2).statistics()],
    "SobolIndices": [
        lambda row=row: asperity.Expansion.fit(XI, XI[:, row], degree=2).sobol_indices() for row in (0, 1)
    ],
    "StudyResults": [
        lambda seed=seed: asperity.run_study(MACHINE, seed=seed, progress=False) for seed in (1, 2)
    ],
    "RandomSurface": [
        lambda points=points: MAKERS["SurfaceModel"][0]().on_grid(size_m=1e-4, points=points) for points in (32, 64)
    ],
}  # fmt: skip


def test_every_public_class_is_among_them():
    public = {name for name in asperity.__all__ if inspect.isclass(getattr(asperity, name))}
    raised = {name for name in public if issubclass(getattr(asperity, name), Exception)}
    assert public - raised <= MAKERS.keys()
    for name in raised:
        error = pickle.loads(pickle.dumps(getattr(asperity, name)("message")))
        assert str(error) == str(copy.copy(error)) == "message"


@pytest.mark.parametrize("name", MAKERS)
@pytest.mark.filterwarnings("ignore::asperity.AsperityWarning")
def test_objects_are_compared_copied_and_pickled(name):
    first, second = (make() for make in MAKERS[name])
    assert type(first).__name__ == name
    assert first == MAKERS[name][0]()
    assert first != second
    assert first != name
    for same in (copy.copy(first), copy.deepcopy(first), pickle.loads(pickle.dumps(first))):
        assert same == first
        assert type(same) is type(first)


@pytest.mark.filterwarnings("ignore::asperity.AsperityWarning")
def test_surfaces_and_expansions_from_another_process_compute_the_same():
    for name in ("KarhunenLoeve", "Translation", "WeierstrassMandelbrot", "RandomSurface"):
        surface = MAKERS[name][0]()
        assert pickle.loads(pickle.dumps(surface)).sample(3) == surface.sample(3)
    for make in MAKERS["Expansion"]:
        expansion = make()
        assert np.array_equal(pickle.loads(pickle.dumps(expansion)).evaluate(XI), expansion.evaluate(XI))


def test_results_with_arrays_are_equal_by_their_values(rough):
    found = HeightMap.from_array(rough, dx_m=1e-6).psd()
    undefined = [dataclasses.replace(found, psd_m4=np.where(found.psd_m4 == found.psd_m4[3], np.nan, found.psd_m4))] * 2
    assert undefined[0] == dataclasses.replace(undefined[1], psd_m4=undefined[1].psd_m4.copy())
    assert undefined[0] != found
    assert found != dataclasses.replace(found, upper_limit="noise_floor")
