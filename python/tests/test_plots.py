import subprocess
import sys

import numpy as np
import pytest
import tomllib

import asperity
from support import ROOT

# Small studies are coarse.
pytestmark = pytest.mark.filterwarnings("ignore::asperity.AsperityWarning")

matplotlib = pytest.importorskip("matplotlib")
matplotlib.use("Agg")

MAP = {"over": "damping_velocity", "x": [0.1, 0.3, 4], "y": [0.001, 0.01, 4], "depth": 1, "trajectories": 64}


@pytest.fixture(autouse=True)
def _closed_figures():
    yield
    matplotlib.pyplot.close("all")


def study(name, section, **changes):
    with open(ROOT / "studies" / name, "rb") as file:
        found = tomllib.load(file)
    found[section] |= changes
    return asperity.run_study(found, progress=False)


@pytest.fixture(scope="module")
def fig2():
    return study("paper_fig2.toml", "pressure", points=[24, 24], fine_solves=300, reference_samples=300)


@pytest.fixture(scope="module")
def fig3():
    small = {"points": [1024, 16], "percentiles": [10.0, 30.0, 50.0], "realisations": 4}
    return study("paper_fig3.toml", "friction", **small)


@pytest.fixture(scope="module")
def fig5():
    return study("paper_fig5.toml", "vibration", trajectories=64, damping_sweep=[0.14, 0.25, 4], map=MAP)


def drawn(ax, label):
    """Return the points of the curve with this label."""
    (line,) = (line for line in ax.get_lines() if line.get_label() == label)
    return np.asarray(line.get_xydata())


def test_a_map_has_its_extent_its_unit_and_its_first_row_at_the_top():
    heights = np.zeros((3, 5))
    heights[0, 0] = 2e-6
    ax = asperity.HeightMap.from_array(heights, dx_m=1e-6, dy_m=2e-6).plot()
    (image,) = ax.get_images()
    assert image.get_extent() == pytest.approx([0, 5, 6, 0])
    assert image.origin == "upper"
    assert image.get_array()[0, 0] == pytest.approx(2)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("x (µm)", "y (µm)")
    assert image.colorbar.ax.get_ylabel() == "height (µm)"


def test_spectra_and_correlations_draw_their_data(rough):
    surface = asperity.HeightMap.from_array(rough, dx_m=1e-6)
    spectrum, correlation = surface.psd(), surface.acf()
    ax = spectrum.plot()
    np.testing.assert_array_equal(drawn(ax, "measured"), np.transpose([spectrum.q_rad_per_m, spectrum.psd_m4]))
    assert (ax.get_xscale(), ax.get_yscale()) == ("log", "log")
    ax = correlation.plot()
    np.testing.assert_allclose(
        drawn(ax, "along x"), np.transpose([1e6 * correlation.lag_x_m, correlation.acf_x]), rtol=1e-12
    )
    assert ax.get_xlabel() == "lag (µm)"


def test_a_solution_draws_each_field(rough):
    found = asperity.solve_contact(rough, dx_m=1e-6, modulus_pa=1e11, mean_pressure_pa=1e8)
    for field, unit in [("pressure_pa", "GPa"), ("gap_m", "µm")]:
        (image,) = found.plot(field).get_images()
        assert image.colorbar.ax.get_ylabel() == f"{field.rpartition('_')[0]} ({unit})"
        scale = {"GPa": 1e-9, "µm": 1e6}[unit]
        np.testing.assert_allclose(image.get_array(), scale * getattr(found, field), rtol=1e-12)
    with pytest.raises(ValueError, match="found pressure, expected one of pressure_pa"):
        found.plot("pressure")


def test_indices_have_the_names_of_their_variables():
    expansion = asperity.Expansion.of(lambda xi: xi[0] + 2 * xi[1], variables=2, degree=1, samples=20, seed=1)
    ax = expansion.sobol_indices().plot(["load", "hardness"])
    assert [text.get_text() for text in ax.get_yticklabels()] == ["load", "hardness"]
    widths = [bar.get_width() for bar in ax.containers[1]]
    assert widths == pytest.approx([0.2, 0.8])
    with pytest.raises(ValueError, match="1 names for 2 variables"):
        expansion.sobol_indices().plot(["load"])


def test_a_process_draws_its_realisation():
    process = asperity.friction_process(mean=0.2, std=0.01, correlation_length_m=250e-6)
    ax = process.plot(seed=3)
    path = drawn(ax, "one realisation")
    assert path[-1, 0] == pytest.approx(5)
    assert ax.get_xlabel() == "sliding distance (mm)"
    np.testing.assert_array_equal(path[:, 1], process.simulate(length_m=5e-3, step_m=5e-6, seed=3))


def test_ensembles_and_stability_maps_draw_what_they_hold():
    law = asperity.Stribeck(kinetic=0.1, decay=4.2)
    machine = asperity.Oscillator(static_friction=0.1, law=law, damping_ratio=0.17, belt_velocity=0.003)
    noise = {"friction_std": 0.001, "correlation_length": 0.01, "marginal": "normal"}
    found = asperity.ensemble(machine, **noise, trajectories=20, duration=100, seed=1)
    ax = found.plot()
    area = sum(bar.get_width() * bar.get_height() for bar in ax.patches)
    assert area == pytest.approx(1)
    axes = {"damping_ratios": (0.1, 0.3, 4), "belt_velocities": (0.001, 0.01, 4)}
    stability = asperity.stability_map(machine, **noise, **axes, depth=1, trajectories=64, duration=200, seed=1)
    ax = stability.plot()
    (shades,) = ax.collections
    assert len(shades.get_array()) == len(stability.cells)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("damping ratio", "belt velocity")
    np.testing.assert_array_equal(drawn(ax, "limit without fluctuation"), stability.limit[0])


def test_the_figures_of_the_paper_draw_the_tables_of_their_studies(fig2, fig3, fig5):
    (ax,) = asperity.figures.figure_2(fig2).axes
    table = fig2.tables["pressure_cdf"]
    np.testing.assert_array_equal(drawn(ax, "Monte Carlo")[:, 1], table["monte_carlo"])
    assert ax.get_xlabel() == "contact pressure (GPa)"
    levels, law = fig3.tables["friction_levels"], fig3.tables["friction_acf"]
    axes = asperity.figures.figure_3(fig3).axes
    np.testing.assert_array_equal(
        np.sort(axes[2].get_lines()[0].get_ydata()), np.sort(levels["coefficient_of_variation"])
    )
    np.testing.assert_array_equal(drawn(axes[3], "exponential")[:, 1], law["fit"])
    path = fig5.tables["trajectory"]
    left, right = asperity.figures.figure_4(fig5).axes
    np.testing.assert_array_equal(left.get_lines()[0].get_ydata(), path["displacement"])
    np.testing.assert_array_equal(drawn(right, "without")[:, 1], fig5.tables["limit_cycle"]["velocity"])
    axes = asperity.figures.figure_5(fig5).axes
    cycles = fig5.tables["cycles_over_damping"]
    np.testing.assert_array_equal(drawn(axes[2], "with fluctuation")[:, 1], cycles["paper_cycles_mean"])
    np.testing.assert_array_equal(drawn(axes[2], "without fluctuation")[:, 1], cycles["cycles_deterministic"])
    assert fig5.plot("stability_map").get_xlabel() == "damping ratio"
    assert fig2.fields["pressure_sample"].plot().get_images()


def test_a_figure_without_results_is_refused_with_those_that_can_be_drawn(fig2):
    with pytest.raises(ValueError, match=r"no results for this figure; these can be drawn: pressure_cdf$"):
        fig2.plot("limit_cycle")
    with pytest.raises(ValueError, match="no figure has this name"):
        fig2.plot("pressure")
    for figure in (asperity.figures.figure_3, asperity.figures.figure_4, asperity.figures.figure_5):
        with pytest.raises(ValueError, match="no results for this figure"):
            figure(fig2)
    assert not matplotlib.pyplot.get_fignums()


def test_a_verdict_draws_its_margins_and_drivers():
    machine = {
        "mass": "1 kg",
        "natural_frequency": "316 rad/s",
        "normal_force": "2.5 kN",
        "nominal_area": "833 mm^2",
        "friction_std": 0,
        "dimensionless_belt_velocity": 0.1,
        "static_friction": 0.3,
        "velocity_law": "linear",
        "linear_weakening": "0.1 ± 0.02",
        "damping_ratio": 0.05,
    }
    found = asperity.run_study({"seed": 1, "vibration": machine}, only="verdict", progress=False)
    ax = found.plot("verdict_margin")
    margin = np.asarray(found.tables["verdict_samples"]["damping_margin"])
    counts = [sum(bar.get_height() for bar in bars) for bars in ax.containers]
    assert counts == [np.sum(margin < 0), np.sum(margin >= 0)]
    assert max(bar.get_x() for bar in ax.containers[0] if bar.get_height()) < 0
    ax = found.plot("drivers")
    assert [text.get_text() for text in ax.get_yticklabels()] == ["vibration.linear_weakening"]


def test_missing_and_infinite_values_are_left_blank():
    empty = asperity.study.Field("gap", np.full((2, 3), np.nan), 1e-6, 1e-6, "m")
    (image,) = empty.plot().get_images()
    assert np.ma.getmaskarray(image.get_array()).all()
    partial = asperity.HeightMap.from_array([[1e-6, np.nan], [2e-6, np.inf]], dx_m=1e-6).plot()
    (image,) = partial.get_images()
    assert np.ma.getmaskarray(image.get_array()).tolist() == [[False, True], [False, True]]
    assert image.colorbar.ax.get_ylabel() == "height (µm)"


def test_matplotlib_is_not_loaded_with_the_package():
    code = "import sys, asperity; assert 'matplotlib' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)
