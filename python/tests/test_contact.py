import numpy as np
import pytest

import asperity


@pytest.mark.parametrize(
    ("options", "settings"),
    [
        (("--penetration", "1um"), {"penetration_m": 1e-6}),
        (("--load", "0.5N", "--stiffness"), {"load_n": 0.5, "stiffness": True}),
        (
            (
                "--load",
                "0.5N",
                "--layer-thickness",
                "20um",
                "--base-youngs-modulus",
                "70GPa",
                "--base-poisson-ratio",
                0.4,
            ),
            {"load_n": 0.5, "layer_thickness_m": 20e-6, "base_youngs_modulus_pa": 70e9, "base_poisson_ratio": 0.4},
        ),
        (("--load", "0.5N", "--layer-thickness", "20um", "--rigid-base"), {"load_n": 0.5, "layer_thickness_m": 20e-6}),
        (("--load", "0.5N", "--counterface", "other"), {"load_n": 0.5, "counterface": True}),
        (
            (
                "--load",
                "0.5N",
                "--counterface",
                "other",
                "--counterface-as-laid",
                "--counterface-youngs-modulus",
                "10GPa",
            ),
            {
                "load_n": 0.5,
                "counterface": True,
                "counterface_as_laid": True,
                "counterface_youngs_modulus_pa": 10e9,
            },
        ),
    ],
)
def test_a_contact_equals_that_of_the_command_line(program, rough, tmp_path, options, settings):
    file, other = tmp_path / "rough.npy", tmp_path / "other.npy"
    np.save(file, rough)
    np.save(other, 0.3 * rough**2 / rough.std())
    pressed = ("--youngs-modulus", "210GPa", "--hardness", "5GPa", "--boundary", "periodic")
    scan = ("--pixel-size", "1um", "--height-unit", "m", "--quiet", "--level", "none", "--out", tmp_path / "fields.npz")
    named = [other if option == "other" else option for option in options]
    expected = program("contact", file, *scan, *pressed, *named)
    if "counterface" in settings:
        settings = settings | {"counterface": asperity.HeightMap(np.load(other), 1e-6, 1e-6)}
    found = asperity.solve_contact(rough, dx_m=1e-6, youngs_modulus_pa=210e9, hardness_pa=5e9, **settings)
    assert {*expected} - {*found.to_dict()} == {"converged", "channel", "format", "warnings"}
    numbers = {key: value for key, value in found.to_dict().items() if key in expected}
    assert numbers == {key: expected[key] for key in numbers}
    fields = np.load(tmp_path / "fields.npz")
    assert found.cluster_labels.max() == found.clusters > 0
    np.testing.assert_array_equal(found.cluster_labels, fields["clusters"])
    np.testing.assert_array_equal(found.pressure_pa, fields["pressure_pa"])


def test_a_sphere_is_pressed_as_by_hertz():
    x = np.linspace(-100e-6, 100e-6, 129)
    radius_m, modulus_pa, load_n = 10e-3, 230e9, 10.0
    sphere = -(x**2 + x[:, None] ** 2) / (2 * radius_m)
    found = asperity.solve_contact(sphere, dx_m=x[1] - x[0], modulus_pa=modulus_pa, load_n=load_n, boundary="free")
    area = np.pi * (0.75 * load_n * radius_m / modulus_pa) ** (2 / 3)
    assert found.max_pressure_pa == pytest.approx(1.5 * load_n / area, rel=0.01)
    assert found.load_n == pytest.approx(load_n, rel=1e-7)
    assert found.penetration_m == pytest.approx(area / np.pi / radius_m, rel=0.01)


def test_fields_satisfy_the_conditions_of_contact(rough):
    found = asperity.solve_contact(rough, dx_m=1e-6, modulus_pa=1e11, mean_pressure_pa=1e9, hardness_pa=8e9)
    pressed = found.pressure_pa > 0
    assert (found.gap_m[pressed] == 0).all()
    assert (found.gap_m[~pressed] >= 0).all()
    assert found.pressure_pa.max() <= 8e9
    assert (found.plastic_displacement_m[found.pressure_pa < 8e9] == 0).all()
    assert found.pressure_pa.mean() == pytest.approx(1e9, rel=1e-7)
    assert found.contact_fraction == pressed.mean()


def test_wrong_problems_raise_by_kind(rough):
    def solve(**settings):
        return asperity.solve_contact(rough, **{"dx_m": 1e-6, "modulus_pa": 1e11, "load_n": 1.0, **settings})

    for settings, message in [
        ({"load_n": None}, "exactly one"),
        ({"percentile": 50.0}, "exactly one"),
        ({"modulus_pa": None}, "modulus_pa"),
        ({"modulus_pa": -1.0}, "modulus"),
        ({"load_n": float("nan")}, "not a finite number"),
        ({"boundary": "open"}, "`open` is not a valid boundary"),
        ({"dx_m": None}, "dx_m"),
        ({"layer_thickness_m": 1e-6}, "a layer and an elastic counterface need"),
        ({"base_youngs_modulus_pa": 1e9, "modulus_pa": None, "youngs_modulus_pa": 1e9}, "a base needs a layer"),
        ({"counterface_poisson_ratio": 0.3}, "counterface_poisson_ratio is given without"),
        ({"counterface": np.zeros((3, 3))}, "3"),
    ]:
        with pytest.raises(ValueError, match=message):
            solve(**settings)
    with pytest.raises(ValueError, match="missing"):
        asperity.solve_contact(np.where(rough > 1e-6, np.nan, rough), dx_m=1e-6, modulus_pa=1e11, load_n=1.0)
    with pytest.raises(asperity.NotConvergedError, match="not converged after"):
        solve(tolerance=1e-300)
    huge = np.broadcast_to(rough[:1, :1], (1 << 15, 1 << 15))
    with pytest.raises((asperity.ResourceError, MemoryError)):
        asperity.solve_contact(huge, dx_m=1e-6, modulus_pa=1e11, load_n=1.0)


def test_a_solution_is_a_data_set_of_xarray(rough):
    pytest.importorskip("xarray")
    found = asperity.solve_contact(rough, dx_m=1e-6, modulus_pa=1e11, load_n=1.0)
    fields = found.to_xarray()
    assert fields.pressure_pa.attrs["units"] == "Pa"
    assert set(fields) == {"pressure_pa", "displacement_m", "gap_m", "plastic_displacement_m"}
    assert fields.gap_m.attrs["units"] == "m"
    assert found.to_dataframe()["load_n"].item() == found.load_n
    assert "pressure_pa" in found._repr_html_()


def test_several_loads_are_solved_in_one_call(rough):
    loads = [1e8, 3e8, 1e9]
    pressed = {"dx_m": 1e-6, "modulus_pa": 1e11, "hardness_pa": 8e9}
    found = asperity.solve_contact(rough, mean_pressure_pa=loads, **pressed)
    single = [asperity.solve_contact(rough, mean_pressure_pa=load, **pressed) for load in loads]
    assert found[0] == single[0]
    for one, own in zip(single, map(found.__getitem__, range(3)), strict=True):
        assert own.residual < 1e-8
        assert own.mean_pressure_pa == pytest.approx(one.mean_pressure_pa, rel=1e-7)
        assert np.abs(own.pressure_pa - one.pressure_pa).max() < 1e-5 * one.max_pressure_pa
    assert found.pressure_pa.shape == (3, *rough.shape)
    assert (np.diff(found.contact_fraction) > 0).all()
    curve = found.to_xarray()
    assert dict(curve.sizes) == {"mean_pressure_pa": 3, "y": 64, "x": 64}
    assert curve.contact_fraction.dims == ("mean_pressure_pa",)
    assert curve.mean_pressure_pa.attrs == {"units": "Pa"}
    assert np.array_equal(curve.gap_m.sel(mean_pressure_pa=3e8), found[1].gap_m)
    table = found.to_dataframe()
    assert list(table.mean_pressure_pa) == loads
    assert list(table.contact_fraction) == list(found.contact_fraction)
    for wrong in ({"load_n": [1.0, 2.0], "mean_pressure_pa": [1e8]}, {"load_n": [[1.0]]}, {"percentile": []}):
        with pytest.raises(ValueError, match="one quantity may have several values, in one dimension"):
            asperity.solve_contact(rough, **wrong, **pressed)
    with pytest.raises(TypeError, match="one prescribed value"):
        single[0][0]
