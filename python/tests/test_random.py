import itertools
import subprocess

import numpy as np
import pytest

import asperity
from asperity import Covariance, HeightMap
from support import PROGRAM, SCAN

SPECIFICATION = """seed = 3
size = ["64 um", "32 um"]
points = [32, 16]
[surface]
rms_height = "1 um"
"""
ISOTROPIC = """covariance = "exponential"
correlation_length = ["10 um", "5 um"]
"""
COMMON = {"size_m": (64e-6, 32e-6), "points": (32, 16), "rms_height_m": 1e-6}
EXPONENTIAL = Covariance(model="exponential", correlation_length_m=(10e-6, 5e-6))
SURFACES = {
    "spectral": (
        'generator = "spectral"\nmarginal = "normal"\n' + ISOTROPIC,
        lambda: asperity.Spectral(covariance=EXPONENTIAL, **COMMON),
    ),
    "karhunen_loeve": (
        'modes = 40\nmarginal = "normal"\n' + ISOTROPIC,
        lambda: asperity.KarhunenLoeve(covariance=EXPONENTIAL, modes=40, **COMMON),
    ),
    "translation": (
        'generator = "spectral"\nmarginal = "beta:2.1,5"\n' + ISOTROPIC,
        lambda: asperity.Translation(covariance=EXPONENTIAL, marginal="beta:2.1,5", **COMMON),
    ),
    "weierstrass_mandelbrot": (
        'generator = "weierstrass_mandelbrot"\nfractal_dimension = 2.3\n',
        lambda: asperity.WeierstrassMandelbrot(fractal_dimension=2.3, **COMMON),
    ),
}


@pytest.mark.parametrize("kind", SURFACES)
@pytest.mark.filterwarnings("ignore")
def test_maps_equal_those_of_the_command_line(kind, tmp_path):
    if not PROGRAM.exists():
        pytest.skip(f"{PROGRAM} is not built")
    text, surface = SURFACES[kind]
    (tmp_path / "spec.toml").write_text(SPECIFICATION + text)
    command = [PROGRAM, "surface", "generate", "spec.toml", "--count", "2", "--out", "maps", "--quiet"]
    subprocess.run(command, cwd=tmp_path, check=True)
    expected = [HeightMap.read(file).heights for file in sorted((tmp_path / "maps").glob("*.x3p"))]
    found = surface().sample(seed=3, count=2)
    assert len(expected) == 2
    for own, other in zip(found, expected, strict=True):
        assert np.array_equal(own.heights, other)
    assert (found[0].dx_m, found[0].dy_m) == (2e-6, 2e-6)


def test_samples_depend_on_seed_and_index_alone():
    surface = asperity.Spectral(covariance=EXPONENTIAL, **COMMON)
    many, few, other = surface.sample(1, 5), surface.sample(1, 2), surface.sample(2)
    assert np.array_equal(many[1].heights, few[1].heights)
    assert not np.array_equal(many[0].heights, other[0].heights)
    assert not np.array_equal(many[0].heights, many[1].heights)


@pytest.mark.filterwarnings("ignore:.*Karhunen")
def test_a_map_is_linear_in_the_normal_variables():
    surface = asperity.KarhunenLoeve(covariance=EXPONENTIAL, modes=5, **COMMON)
    assert surface.xi_len == 5
    xi = np.array([1.0, -2.0, 0.5, 0.0, 3.0])
    units = [surface.generate(unit).heights for unit in np.eye(5)]
    assert surface.generate(xi).heights == pytest.approx(np.tensordot(xi, units, 1), abs=1e-18)
    with pytest.raises(ValueError, match="expected 5"):
        surface.generate([1.0])


def test_an_artificial_surface_has_its_variance_and_spectrum():
    q = 2 * np.pi * np.fft.fftfreq(256, 1e-3 / 256)
    radius = np.hypot(q, q[:, None])
    model = (1 + (radius * 20e-6) ** 2) ** -1.8
    variances, density = [], np.zeros((256, 256))
    for seed in range(4):
        found = asperity.artificial_surface(
            rms_height_m=1e-6, hurst=0.8, size_m=1e-3, points=256, correlation_length_m=20e-6, seed=seed
        )
        variances.append(float(np.var(found.heights)))
        density += np.abs(np.fft.fft2(found.heights)) ** 2
    assert np.mean(variances) == pytest.approx(1e-12, rel=0.1)
    # Rings below a third of the Nyquist wavenumber, where aliasing is small.
    edges = np.geomspace(0.02, 0.33, 6) * q.max()
    rings = [(radius > low) & (radius < high) for low, high in itertools.pairwise(edges)]
    ratios = np.array([(density[ring] / model[ring]).mean() for ring in rings])
    assert ratios / ratios.mean() == pytest.approx(np.ones(5), abs=0.15)


def test_a_model_fitted_to_a_scan_has_its_height_and_covariance():
    scan = HeightMap.read(SCAN).level("plane")
    model = asperity.SurfaceModel.fit(scan, generator="spectral", marginal="normal")
    assert model.rms_height_m == pytest.approx(scan.statistics().Sq_m, rel=1e-12)
    assert model.covariance is not None
    assert model.covariance.std_m == pytest.approx(model.rms_height_m, rel=1e-12)
    maps = model.on_grid(size_m=200e-6, points=64).sample(seed=1, count=2)
    assert maps[0].shape == (64, 64)


def test_wrong_surfaces_are_refused():
    with pytest.raises(ValueError, match="needs hurst"):
        asperity.Spectral(covariance=Covariance(model="self_affine", correlation_length_m=1e-5), **COMMON)
    with pytest.raises(ValueError, match="length"):
        asperity.Spectral(covariance=Covariance(model="exponential", correlation_length_m=-1e-5), **COMMON)
    with pytest.raises(ValueError, match="colour"):
        asperity.Translation(covariance=EXPONENTIAL, marginal="colour", **COMMON)
