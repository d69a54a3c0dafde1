"""What the notebooks of the gallery say holds for their numbers."""

import pathlib
import runpy
from types import SimpleNamespace

import numpy as np
import pytest

import asperity

pytest.importorskip("matplotlib")
GALLERY = pathlib.Path(__file__).parents[1] / "gallery"


@pytest.fixture
def notebook(monkeypatch):
    """Return a function that runs a notebook in its folder and returns its names."""
    monkeypatch.chdir(GALLERY)
    monkeypatch.setenv("MPLBACKEND", "agg")
    return lambda name: SimpleNamespace(**runpy.run_path(str(GALLERY / f"{name}.py")))


@pytest.mark.filterwarnings("ignore")
def test_measure_a_surface(notebook):
    own = notebook("01_measure_a_surface")
    assert round(own.before.Sku) == 8
    assert own.before.Sku_interval is None
    assert abs(np.interp(own.x_m, own.acf.lag_x_m, own.acf.acf_x) - np.exp(-1)) < 0.01
    assert own.x_m > 1.3 * own.y_m
    assert np.isclose(own.shortest_m, 4 * own.surface.dx_m)
    assert np.isclose(own.longest_m, own.surface.shape[1] * own.surface.dx_m / 2)
    assert own.found.Sdq > own.rms_slope[8e-06] > own.rms_slope[1.6e-05]
    assert np.isclose(np.sum(own.rings), own.found.Sq_m**2, rtol=0.1)


@pytest.mark.filterwarnings("ignore")
def test_twins(notebook):
    own = notebook("02_twins")
    assert own.found.fractal_dimension is None
    assert own.resolved < own.slopes["spectral"] < own.found.Sdq
    assert own.slopes["karhunen_loeve"] < own.slopes["spectral"]
    assert np.isclose(own.models["spectral"].rms_height_m, own.found.Sq_m, rtol=0.05)
    assert np.isclose(own.exponent, -1.8, atol=0.04)
    assert np.isclose(own.fractal.heights.std(), 1e-06, rtol=0.1)


@pytest.mark.filterwarnings("ignore")
def test_contact(notebook):
    own = notebook("03_contact")
    assert np.allclose([own.a_m, own.p0_pa, own.delta_m], [6.875344e-05, 1010072300.0, 4.727036e-07], rtol=1e-06)
    assert np.isclose(own.ball.penetration_m, own.delta_m, rtol=0.002)
    assert 0.8 < own.order < 1.3
    assert own.area_error[0] < 0.02
    assert (own.area_error[1:] < 0.005).all()
    assert np.allclose([each.contact_fraction for each in own.waves], own.width, atol=2 / own.points)
    assert np.allclose([each.mean_gap_m / own.amplitude_m for each in own.waves], own.gap, rtol=0.001)
    assert np.allclose([each.max_pressure_pa / own.p_star_pa for each in own.waves], 2 * np.sqrt(own.ratio), rtol=0.01)
    assert np.allclose(own.force, [0.98526, 0.91633, 0.76164], rtol=0.001)
    assert np.allclose(own.area, [1.012, 1.083, 1.274], atol=0.005)


@pytest.mark.filterwarnings("ignore")
def test_pressure_distribution(notebook):
    own = notebook("04_pressure_distribution")
    assert own.pressure.contact_probability <= 0.5
    assert own.contact.values.max() <= 0.5
    assert own.border > own.inner
    assert own.low < own.known_high
    assert own.known_low < own.high
    assert own.gain * 500 > 4 * own.work
    assert own.own["default"].ks_distance < 0.25 * own.own["polynomial_chaos"].ks_distance
    assert own.yielding > 0.8
    assert np.all(np.diff(own.table["reference"]) >= 0)


@pytest.mark.filterwarnings("ignore")
def test_friction_process(notebook):
    own = notebook("05_friction_process")
    assert all(0.00032 < length < 0.00037 for length in own.fitted.values())
    assert np.isclose(np.trapezoid(own.triangle, own.lag_m), own.window_m / 2, rtol=0.001)
    assert np.isclose(own.kept(0.0006), 0.51761, atol=1e-05)
    assert np.allclose(own.variances, own.kept(own.windows_m), rtol=0.05)
    # Fewer than 15 of 20 have a probability below 1 in 3,000 if the coverage is 95 %.
    assert min(own.covered.values()) >= 15
    assert np.all(np.diff(own.table["correlation_length_m"]) < 0)
    assert own.results.friction.operating_point.mean >= 385 / 2000


@pytest.mark.filterwarnings("ignore")
def test_stick_slip_map(notebook):
    own = notebook("06_stick_slip_map")
    assert np.isclose(own.period, own.cycle.period, atol=0.005)
    assert np.isclose(own.cycle.period, 6.372163483739709, rtol=1e-09)
    assert np.isclose(own.cycle.reattachment_displacement, 0.09679568922228761, rtol=1e-09)
    assert np.isclose(own.critical[0], 0.2048301505845232, rtol=1e-09)
    assert np.allclose([each.hopf_damping_ratio for each in own.limits], own.hopf, rtol=1e-09)
    assert np.allclose(own.critical, own.averaged, rtol=0.01)
    assert np.isclose(
        asperity.limit_cycle(own.coulomb).period, 2 * np.pi - 2 * np.arctan(own.jump) + 2 * own.jump, rtol=1e-09
    )
    assert own.runs[0].cycles_deterministic == 99
    assert round(own.runs[0].difference_mean) == 30
    assert own.runs[2].cycles_deterministic == 0
    assert own.runs[2].cycles.mean > 20
    for run, known in zip(own.runs, (68.99, 45.21, 34.31, 17.18), strict=True):
        assert abs(run.cycles.mean - known) < 4 * np.hypot(run.cycles.se, 0.1)


@pytest.mark.filterwarnings("ignore")
def test_brake_verdict(notebook):
    own = notebook("07_brake_verdict")
    assert round(own.margin.cdf(0), 4) == 0.3274
    assert round(own.enough, 4) == 0.0684
    assert own.known.probability_interval[0] < own.margin.cdf(0) < own.known.probability_interval[1]
    assert np.isclose(own.share["vibration.linear_weakening"], 0.8, atol=0.01)
    assert np.isclose(own.share["vibration.damping_ratio"], 0.2, atol=0.01)
    assert np.allclose([own.reach[0.05], own.reach[0.01]], [own.enough, 0.0760094], rtol=0.01)
    assert own.low < own.found.probability < own.high
    assert np.mean(own.vibrates == (own.margins["damping_margin"] < 0)) > 0.95
    assert np.corrcoef(own.hardness, own.mu)[0, 1] < -0.9
    assert np.all(own.mu >= 0.99 * 38 / own.hardness)
    assert 0.95 < sum(driver.first_order for driver in own.found.drivers) < 1.02
    assert own.guess.probability_at_q05 < own.found.probability < own.guess.probability_at_q95
    assert 0.05 < own.targets[0].value < own.targets[1].value


@pytest.mark.filterwarnings("ignore")
def test_from_other_tools(notebook):
    for package in ("SALib", "SurfaceTopography", "openturns", "surfalize", "tamaas"):
        pytest.importorskip(package)
    own = notebook("08_from_other_tools")
    assert own.plane.rms_height_from_area() == pytest.approx(own.statistics.Sq_m, rel=1e-12)
    assert own.plane.rms_gradient() == pytest.approx(own.statistics.Sdq, rel=1e-12)
    # Means over bins of one spectrum under one window.
    inside = (own.wavenumber > 2e4) & (own.wavenumber < 8e5)
    ours = np.interp(np.log(own.wavenumber[inside]), np.log(own.spectrum.q_rad_per_m), np.log(own.spectrum.psd_m4))
    assert np.mean(ours - np.log(own.density[inside])) == pytest.approx(0, abs=0.1)
    for name, theirs, mine in zip(own.names[:-1], own.theirs, own.ours, strict=False):
        assert theirs == pytest.approx(mine, rel=0.01), name
    assert abs(own.theirs[-1] - own.ours[-1]) == pytest.approx(90, abs=5)
    np.testing.assert_allclose(own.traction, own.contact.pressure_pa, rtol=0, atol=1e-6 * own.contact.max_pressure_pa)
    errors = {name: np.abs(np.array(found) - own.exact).max() for name, found in own.found.items()}
    assert errors["asperity"] < 5e-4
    assert errors["OpenTURNS"] < 5e-4
    assert errors["SALib"] < 0.02
