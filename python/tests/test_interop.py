import math
import warnings

import numpy as np
import pytest

import asperity
from asperity import HeightMap
from support import SCAN

STUDY = {
    "seed": 3,
    "vibration": {
        "mass": "1 kg",
        "natural_frequency": "316 rad/s",
        "nominal_area": "833 mm^2",
        "friction_std": 0,
        "static_friction": 0.2,
        "dimensionless_belt_velocity": 0.1,
    },
    "verdict": {"evaluations": 1000},
}


def package(name):
    # Packages warn while they are imported.
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return pytest.importorskip(name)


@pytest.fixture
def corner():
    """Return a map of 4 rows and 6 columns with a peak in the upper right corner and a missing point below it."""
    z = 1e-6 * np.random.default_rng(1).standard_normal((4, 6))
    z[0, -1] = 1e-3
    z[1, -1] = np.nan
    return HeightMap.from_array(z, dx_m=0.7e-6, dy_m=0.3e-6)


@pytest.fixture
def oblique():
    """Return a map of valleys that rise by 30° from left to right, with more waves along x than along y."""
    row, column = np.mgrid[:96, :128]
    phase = 2 * np.pi * (column * math.sin(math.radians(30)) + row * math.cos(math.radians(30))) / 16
    return HeightMap.from_array(1e-6 * np.sin(phase), dx_m=1e-6)


def test_a_map_returns_from_surfacetopography(corner):
    package("SurfaceTopography")
    found = corner.to_surfacetopography()
    back = HeightMap.from_surfacetopography(found)
    assert np.array_equal(back.heights, corner.heights, equal_nan=True)
    assert (back.dx_m, back.dy_m) == pytest.approx((0.7e-6, 0.3e-6), rel=3e-16, abs=0)
    assert (found.unit, found.nb_grid_pts, found.is_periodic) == ("m", (6, 4), False)
    assert found.physical_sizes == pytest.approx((4.2e-6, 1.2e-6))
    # The first index is that of the column.
    assert found.heights()[-1, 0] == 1e-3
    assert np.ma.is_masked(found.heights()[-1, 1])
    assert corner.to_surfacetopography(periodic=True).is_periodic


def test_units_of_surfacetopography_become_metre(corner):
    topographies = package("SurfaceTopography")
    found = HeightMap.from_surfacetopography(corner.to_surfacetopography().to_unit("nm"))
    np.testing.assert_array_max_ulp(found.heights, corner.heights, 2)
    assert (found.dx_m, found.dy_m) == pytest.approx((0.7e-6, 0.3e-6), rel=1e-15, abs=0)
    with pytest.raises(ValueError, match="has no unit"):
        HeightMap.from_surfacetopography(topographies.Topography(np.ones((3, 3)), (1.0, 1.0)))
    with pytest.raises(ValueError, match="line scan"):
        HeightMap.from_surfacetopography(topographies.UniformLineScan(np.ones(3), 1.0, unit="m"))


def test_a_scan_of_surfacetopography_is_that_of_asperity():
    topographies = package("SurfaceTopography")
    found = HeightMap.from_surfacetopography(topographies.read_topography(str(SCAN)))
    expected = HeightMap.read(SCAN)
    # SurfaceTopography adds the offset of the file, 12 um, before it scales the heights: an error of some 1e-16 of it.
    np.testing.assert_allclose(found.heights, expected.heights, rtol=0, atol=1e-20)
    assert (found.dx_m, found.dy_m) == (expected.dx_m, expected.dy_m)


def test_statistics_of_surfacetopography_agree(oblique):
    package("SurfaceTopography")
    found = oblique.to_surfacetopography()
    assert found.Sq() == pytest.approx(oblique.statistics().Sq_m, rel=1e-12)
    # The slope along x is smaller.
    # SurfaceTopography leaves out the last row and the last column.
    steps = np.diff(oblique.heights[:-1], axis=1), np.diff(oblique.heights[:, :-1], axis=0)
    slopes = [np.sqrt(np.mean(step**2)) / 1e-6 for step in steps]
    assert found.Rdq() == pytest.approx(slopes[0], rel=1e-12)
    assert found.transpose().Rdq() == pytest.approx(slopes[1], rel=1e-12)
    assert slopes[1] > 1.5 * slopes[0]


@pytest.mark.filterwarnings("ignore:The surface has different pixel size")
def test_a_map_returns_from_surfalize(corner):
    package("surfalize")
    found = corner.to_surfalize()
    back = HeightMap.from_surfalize(found)
    np.testing.assert_array_max_ulp(back.heights, corner.heights, 1)
    assert (back.dx_m, back.dy_m) == pytest.approx((0.7e-6, 0.3e-6), rel=3e-16, abs=0)
    assert (found.step_x, found.step_y) == pytest.approx((0.7, 0.3))
    # surfalize counts y from the bottom of the surface.
    assert found.get_horizontal_profile(found.height_um).data[-1] == pytest.approx(1000)
    found.mask[2:, :3] = True
    masked = HeightMap.from_surfalize(found)
    assert np.isnan(masked.heights[2:, :3]).all()
    assert np.isnan(masked.heights).sum() == 7


def test_a_scan_of_surfalize_is_that_of_asperity():
    surfaces = package("surfalize")
    found, expected = surfaces.Surface.load(SCAN), HeightMap.read(SCAN)
    assert np.array_equal(found.data, expected.to_surfalize().data, equal_nan=True)
    assert (found.step_x, found.step_y) == pytest.approx((2.0, 2.0))
    np.testing.assert_array_max_ulp(HeightMap.from_surfalize(found).heights, expected.heights, 1)


def test_statistics_of_surfalize_agree(oblique):
    package("surfalize")
    found, expected = oblique.to_surfalize(), oblique.statistics()
    assert found.Sq() == pytest.approx(1e6 * expected.Sq_m, rel=1e-12)
    # Counter-clockwise from x as the map is seen: the direction of the waves in steps of 0.5°, and that of the lay.
    assert found.Std() == pytest.approx(90 + 30, abs=1)
    assert math.degrees(expected.Std_rad) == pytest.approx(30, abs=1)


def test_a_map_returns_from_xarray(corner):
    package("xarray")
    array = corner.to_xarray()
    for own in (array, array.transpose("x", "y")):
        back = HeightMap.from_xarray(own)
        assert np.array_equal(back.heights, corner.heights, equal_nan=True)
        assert (back.dx_m, back.dy_m) == (corner.dx_m, corner.dy_m)
    # Coordinates may fall: y of images often does.
    falling = array.isel(y=slice(None, None, -1), x=slice(None, None, -1))
    assert HeightMap.from_xarray(falling) == corner
    window = HeightMap.from_xarray(array.isel(x=slice(2, None)))
    assert np.array_equal(window.heights, corner.heights[:, 2:], equal_nan=True)
    assert (window.dx_m, window.dy_m) == pytest.approx((0.7e-6, 0.3e-6), rel=1e-15, abs=0)


def test_arrays_that_are_no_map_are_refused(corner):
    package("xarray")
    array = corner.to_xarray()
    for wrong, message in [
        (array.isel(x=[0, 1, 3]), "coordinates x have no equal steps"),
        (array.isel(y=[1, 0, 2]), "coordinates y have no equal steps"),
        (array.assign_coords(x=[str(x) for x in range(array.sizes["x"])]), "coordinates x are of the type <U1"),
        (array.assign_coords(y=np.arange(array.sizes["y"]).astype("datetime64[s]")), "y are of the type datetime64"),
        (array.isel(x=[2]), "at least 2 × 2"),
        (array.rename(x="length"), "dimensions y, length"),
        (array.drop_vars("x"), "x has no coordinates"),
        (array.assign_attrs(units="um"), "heights are in um"),
        (array.assign_coords(x=array.x.assign_attrs(units="mm")), "coordinates x are in mm"),
    ]:
        with pytest.raises(ValueError, match=message):
            HeightMap.from_xarray(wrong)


def distributions(openturns):
    """Return every form of an uncertain value as a distribution, and as a study file states it."""
    stated = [
        ("damping_ratio", openturns.Normal(0.21, 0.02), "0.21 ± 0.02"),
        ("static_friction", openturns.Uniform(0.15, 0.25), {"uniform": [0.15, 0.25]}),
        ("stribeck", openturns.Beta(2.0, 5.0, 3.0, 6.0), {"beta": [2.0, 5.0, 3.0, 6.0]}),
        ("dimensionless_belt_velocity", openturns.Triangular(0.05, 0.1, 0.2), {"triangular": [0.05, 0.1, 0.2]}),
        (
            "normal_force",
            asperity.uncertain(openturns.LogNormal(math.log(2.5), 0.1), unit="kN", unknown=True),
            {"lognormal": ["2.5 kN", 0.1], "unknown": True},
        ),
        (
            "natural_frequency",
            asperity.uncertain(openturns.Distribution(openturns.Normal(316.0, 5.0)), unit="rad/s"),
            "316 ± 5 rad/s",
        ),
    ]
    studies = [{key: (own, text)[form] for key, own, text in stated} for form in (0, 1)]
    return [{**STUDY, "vibration": {**STUDY["vibration"], **values}} for values in studies]


def test_a_verdict_over_openturns_has_the_bits_of_the_texts():
    found, expected = (
        asperity.verdict(study, progress=False).to_dict() for study in distributions(package("openturns"))
    )
    assert found == expected
    assert 0.01 < found["probability"] < 0.99
    assert sum(own["kind"] in ("uncertain", "unknown") for own in found["rests_on"]) == 6


def test_values_in_a_list_may_be_distributions():
    openturns = package("openturns")
    machine = {
        **STUDY["vibration"],
        "model": "mode_coupling",
        "normal_force": "2.5 kN",
        "static_friction": "0.7 ± 0.05",
        "damping_ratio": 0,
    }
    verdicts = [
        asperity.verdict({**STUDY, "vibration": {**machine, "spring_angles": angles}}, progress=False)
        for angles in ((150.0, openturns.Normal(30.0, 1.0)), [150.0, "30 ± 1"])
    ]
    assert verdicts[0].to_dict() == verdicts[1].to_dict()


@pytest.mark.filterwarnings("default")
def test_a_cluster_takes_distributions():
    openturns, distributed = package("openturns"), package("distributed")
    from asperity import dask

    surface = {"covariance": "self_affine", "marginal": "normal", "rms_height": "1 um", "correlation_length": "20 um"}
    found, expected = (
        {"seed": 1, "surface": {**surface, "hurst": own}} for own in (openturns.Uniform(0.7, 0.9), "0.7 .. 0.9")
    )
    with (
        distributed.LocalCluster(n_workers=1, threads_per_worker=1, processes=False, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        assert (
            dask.run(found, client, only="surface").to_dict() == asperity.run_study(expected, only="surface").to_dict()
        )


def test_distributions_without_a_form_are_refused():
    openturns = package("openturns")
    for wrong in (openturns.WeibullMin(), openturns.LogNormal(0.0, 0.1, 0.5), openturns.Normal(2)):
        with pytest.raises(
            ValueError, match="use a normal, uniform, triangular or beta distribution, or a lognormal one without"
        ):
            asperity.uncertain(wrong)
        study = {**STUDY, "vibration": {**STUDY["vibration"], "damping_ratio": wrong}}
        with pytest.raises(ValueError, match=r"^vibration\.damping_ratio: a study has no form for"):
            asperity.run_study(study)
    study = {**STUDY, "vibration": {**STUDY["vibration"], "normal_force": openturns.Normal(2500.0, 100.0)}}
    with pytest.raises(ValueError, match=r"normal_force: `2500\.0` has no unit"):
        asperity.run_study(study)


def test_distributions_of_scipy_with_parameters_are_stated():
    stats = package("scipy.stats")
    if not hasattr(stats, "Normal"):
        pytest.skip("an older SciPy has frozen distributions alone")
    assert asperity.uncertain(stats.Normal(mu=2.0, sigma=0.25), unit="GPa") == {"normal": ["2.0 GPa", "0.25 GPa"]}
    assert asperity.uncertain(stats.Uniform(a=0.1, b=0.3)) == {"uniform": [0.1, 0.3]}
    with pytest.raises(ValueError, match="no form for ShiftedScaledDistribution"):
        asperity.uncertain(2 * stats.Uniform(a=0.1, b=0.3))
    own, frozen = [stats.Normal(mu=1.0, sigma=2.0)], [stats.norm(1.0, 2.0)]
    points = asperity.design("sobol", samples=64, variables=1, seed=1, distributions=own)
    np.testing.assert_allclose(
        points, asperity.design("sobol", samples=64, variables=1, seed=1, distributions=frozen), rtol=1e-14
    )
    found = asperity.Expansion.fit(points, points[:, 0] ** 2, degree=2, distributions=own)
    # Mean and variance of x² for a normal x: m² + s², 2s⁴ + 4m²s².
    assert (found.mean, found.variance) == pytest.approx((5.0, 48.0), rel=1e-9)
