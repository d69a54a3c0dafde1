import dataclasses
import pickle
import subprocess
import sys

import numpy as np
import pytest

import asperity
from asperity import HeightMap
from support import PROGRAM, SCAN


def test_statistics_equal_those_of_the_command_line(program):
    expected = program("surface", "stats", SCAN, "--level", "plane", "--quiet")
    found = HeightMap.read(SCAN).level("plane").statistics().to_dict()
    assert found == {key: value for key, value in expected.items() if key in found}
    assert {"Sq_m", "Sdq_interval", "hurst_se"} < found.keys()
    assert expected.keys() - found.keys() == {"format", "channel", "warnings"} & expected.keys()


def test_statistics_have_companions_and_survive_a_dictionary():
    found = HeightMap.read(SCAN).level("plane").statistics()
    low, high = found.Sq_m_interval
    assert low < found.Sq_m < high
    assert "Sq_m_se" in dir(found)
    assert type(found).from_dict(found.to_dict()) == found
    with pytest.raises(AttributeError, match="Sq_mm"):
        _ = found.Sq_mm


def test_a_wave_has_its_statistics():
    x = 1e-6 * np.arange(256)
    wave = 1e-6 * np.sin(2 * np.pi * x / 32e-6) * np.ones((64, 1))
    heights = HeightMap.from_array(wave, dx_m=1e-6, dy_m=2e-6)
    found = heights.statistics()
    assert found.Sq_m == pytest.approx(1e-6 / 2**0.5, rel=1e-12)
    assert (found.nx, found.ny, found.dy_m) == (256, 64, 2e-6)
    correlation = heights.acf()
    assert correlation.acf_x[32] == pytest.approx(1, abs=1e-9)
    assert correlation.acf_x[16] == pytest.approx(-1, abs=1e-9)
    assert correlation.variance_m2 == pytest.approx(0.5e-12, rel=1e-12)
    assert correlation.lag_y_m[1] == 2e-6
    spectrum = heights.psd()
    peak = spectrum.q_rad_per_m[np.argmax(spectrum.psd_m4)]
    assert peak == pytest.approx(2 * np.pi / 32e-6, rel=0.1)


def test_heights_are_copied_once_and_keep_their_values(rough):
    for z in (rough, np.asfortranarray(rough), rough[:, ::-1], rough[::2, 1:]):
        found = HeightMap.from_array(z, dx_m=1e-6)
        assert np.array_equal(found.heights, z)
        assert not np.shares_memory(found.heights, z)
        assert not found.heights.flags.writeable
        assert found.heights.flags.c_contiguous
    assert found.shape == (32, 63)


def test_a_map_made_directly_is_checked_and_owns_its_heights(rough):
    own = rough.copy()
    found = HeightMap(own, 1e-6, 2e-6)
    own[0, 0] = 1.0
    assert found == HeightMap.from_array(rough, dx_m=1e-6, dy_m=2e-6)
    for pitch_m in (-1.0, 0.0, np.nan, np.inf):
        with pytest.raises(ValueError, match="pixel size"):
            HeightMap(rough, pitch_m, 1e-6)
        with pytest.raises(ValueError, match="pixel size"):
            HeightMap(rough, 1e-6, pitch_m)
    for shape in ((), (16,), (2, 2, 2)):
        with pytest.raises(ValueError, match="expected"):
            HeightMap.from_array(np.zeros(shape), dx_m=1e-6)


def test_arrays_of_the_library_are_not_copied(rough, monkeypatch):
    found = HeightMap.from_array(rough, dx_m=1e-6)
    monkeypatch.delattr(asperity._core, "height_map")
    assert found.level("mean").shape == rough.shape
    assert HeightMap.read(SCAN).heights.size > 0


def test_numpy_takes_a_map_as_its_heights(rough):
    found = HeightMap.from_array(rough, dx_m=1e-6)
    assert np.asarray(found) is found.heights
    assert np.array(found).flags.writeable
    assert np.asarray(found, dtype=np.float32).dtype == np.float32
    assert np.std(found) == np.std(rough)


def test_maps_are_equal_by_heights_and_pitch(rough):
    rough[0, 0] = np.nan
    found = HeightMap(rough, 1e-6, 1e-6)
    assert found == HeightMap(rough, 1e-6, 1e-6)
    assert found != HeightMap(rough, 1e-6, 2e-6)
    assert found != HeightMap(rough[::-1], 1e-6, 1e-6)
    assert found != "map"
    with pytest.raises(TypeError, match="unhashable"):
        hash(found)


def test_a_second_preparation_forgets_nothing(rough):
    rough[3, 3:5] = 1e-3
    once = HeightMap(rough, 1e-6, 1e-6).level("polynomial:6", outliers=5)
    twice = once.level("none")
    assert once.statistics() == twice.statistics() == pickle.loads(pickle.dumps(twice)).statistics()
    assert once.statistics().outliers >= 2
    assert dataclasses.replace(once, dx_m=2e-6).statistics().outliers == once.statistics().outliers
    more = twice.level("mean", outliers=2).statistics()
    assert more.outliers == more.missing_points > once.statistics().outliers
    y, x = np.mgrid[:64, :64]
    ball = HeightMap(rough - 1e-12 * (x**2 + y**2) / 2e-2, 1e-6, 1e-6).level("sphere")
    radius_m = ball.statistics().form_radius_m
    assert radius_m is not None
    assert ball.level("plane").statistics().form_radius_m == radius_m


def test_missing_heights_stay_missing():
    found = HeightMap.from_array([[0.0, np.nan, 1.0], [np.inf, 2.0, 5.0]], dx_m=1e-6)
    assert np.isnan(found.heights).sum() == 2
    assert repr(found) == "HeightMap(3 × 2 points, 1e-06 × 1e-06 m, 2 missing)"
    assert found.statistics().missing_points == 2


def test_wrong_maps_and_files_raise_by_kind(tmp_path):
    with pytest.raises(ValueError, match="at least 2 × 2"):
        HeightMap.from_array([[1.0]], dx_m=1e-6)
    with pytest.raises(ValueError, match="pixel size"):
        HeightMap.from_array(np.ones((3, 3)), dx_m=-1)
    for heights in ([[0, 1e200], [1, 2]], [[0, 1e-200], [0, 0]]):
        with pytest.raises(ValueError, match="none may exceed"):
            HeightMap(np.array(heights), 1e-6, 1e-6).acf()
    with pytest.raises(FileNotFoundError, match=r"gone\.x3p"):
        HeightMap.read(tmp_path / "gone.x3p")
    damaged = tmp_path / "damaged.x3p"
    damaged.write_bytes(SCAN.read_bytes()[:2000])
    with pytest.raises(asperity.FormatError, match=r"damaged\.x3p"):
        HeightMap.read(damaged)
    with pytest.raises(ValueError, match="`cone`"):
        HeightMap.read(SCAN).level("cone")


def test_a_map_is_an_array_of_xarray(rough):
    pytest.importorskip("xarray")
    found = HeightMap.from_array(rough, dx_m=1e-6, dy_m=2e-6).to_xarray()
    assert found.attrs["units"] == "m"
    assert float(found.y[1]) == 3e-6
    assert float(found.x[0]) == 0.5e-6


def test_curves_are_frames_and_data_sets_with_units(rough):
    pytest.importorskip("pandas")
    pytest.importorskip("xarray")
    heights = HeightMap.from_array(rough[:32], dx_m=1e-6)
    found = heights.acf()
    frame = found.to_dataframe()
    assert list(frame) == ["lag_x_m", "acf_x", "lag_y_m", "acf_y"]
    assert frame["acf_x"].tolist() == found.acf_x.tolist()
    assert frame["acf_y"].dropna().tolist() == found.acf_y.tolist()
    curves = found.to_xarray()
    assert float(curves.acf_y.sel(lag_y_m=2e-6)) == found.acf_y[2]
    assert (curves.acf_x.attrs["units"], curves.lag_x_m.attrs["units"]) == ("1", "m")
    assert curves.attrs["variance_m2"] == found.variance_m2
    spectrum = heights.psd()
    curves = spectrum.to_xarray()
    assert (curves.psd_m4.attrs["units"], curves.q_rad_per_m.attrs["units"]) == ("m^4", "rad/m")
    assert spectrum.to_dataframe()["psd_m4"].tolist() == curves.psd_m4.to_numpy().tolist() == spectrum.psd_m4.tolist()


def test_undefined_statistics_are_nan_in_a_frame():
    pytest.importorskip("pandas")
    found = HeightMap.from_array(1e-6 * np.arange(16.0).reshape(4, 4), dx_m=1e-6).statistics()
    assert found.hurst is None
    frame = found.to_dataframe()
    assert frame.shape[0] == 1
    assert np.isnan(frame["hurst"].item())
    assert frame["Sq_m"].item() == found.Sq_m


def test_one_void_hardly_changes_the_spectrum() -> None:
    whole = asperity.artificial_surface(
        rms_height_m=1e-6, hurst=0.95, size_m=256e-6, points=256, correlation_length_m=5e-5, seed=1
    )
    heights = whole.heights.copy()
    heights[90, 100] = np.nan
    found, wanted = asperity.HeightMap.from_array(heights, dx_m=whole.dx_m).psd(), whole.psd()
    assert found.method == wanted.method == "periodogram"
    np.testing.assert_allclose(found.psd_m4, wanted.psd_m4, rtol=0.01)
    assert np.all((found.psd_low_m4 < found.psd_m4) & (found.psd_m4 < found.psd_high_m4))
    heights[60:120, 60:120] = np.nan
    assert asperity.HeightMap.from_array(heights, dx_m=whole.dx_m).psd().method == "correlogram"


@pytest.mark.parametrize("ratio", [1, 2, 3, 5])
def test_spectra_integrate_to_the_windowed_mean_square(ratio: int) -> None:
    heights = np.random.default_rng(1).standard_normal((48, 64))
    found = asperity.HeightMap.from_array(heights, dx_m=1e-6, dy_m=ratio * 1e-6).psd()
    window = np.outer(*(np.sin(np.pi * (np.arange(n) + 0.5) / n) ** 4 for n in heights.shape))
    wanted = (window * (heights - heights.mean()) ** 2).sum() / window.sum()
    total = (found.coefficients * found.psd_m4).sum() / (64e-6 * 48e-6 * ratio) + found.psd_corners_m2
    assert total == pytest.approx(wanted, rel=1e-12)


def test_a_filled_map_is_that_of_the_command_line(program, tmp_path, rough):
    heights = rough.copy()
    heights[10:13, 20:30] = np.nan
    scan = HeightMap(heights, 1e-6, 1e-6)
    file, filled = tmp_path / "scan.gwy", tmp_path / "filled.gwy"
    scan.write(file)
    subprocess.run([PROGRAM, "surface", "fill", file, "--out", filled, "--seed", "3", "--quiet"], check=True)
    found = scan.fill(seed=3)
    assert found == HeightMap.read(filled)
    present = ~np.isnan(heights)
    assert np.array_equal(found.heights[present], heights[present])
    assert np.isfinite(found.heights).all()
    assert scan.fill(seed=4) != found


def test_slices_are_maps_with_their_pitch(rough):
    scan = HeightMap(rough, 1e-6, 2e-6)
    part = scan[4:20, 3:31:3]
    assert np.array_equal(part.heights, rough[4:20, 3:31:3])
    assert (part.dx_m, part.dy_m) == (3e-6, 2e-6)
    assert scan[:, :] == scan
    assert scan.level("plane")[:32, :].is_prepared
    for wrong in (3, slice(None), (slice(None), 3), (slice(None),) * 3):
        with pytest.raises(TypeError, match="expected slices of rows and columns"):
            scan[wrong]
    for wrong in ((slice(None, None, -1), slice(None)), (slice(3, 3), slice(None))):
        with pytest.raises(ValueError, match="expected rising slices inside"):
            scan[wrong]


def test_the_maps_of_a_file_are_listed(tmp_path, rough):
    first, second = rough, 2 * rough
    np.savez(tmp_path / "two.npz", first=first, second=second)
    assert HeightMap.channels(tmp_path / "two.npz") == ["first", "second"]
    found = [HeightMap.read(tmp_path / "two.npz", channel=name, dx_m=1e-6) for name in ("second", 2)]
    assert found[0] == found[1]
    assert np.array_equal(found[0].heights, second)
    np.save(tmp_path / "one.npy", first)
    assert HeightMap.channels(tmp_path / "one.npy") == []
    with pytest.raises(FileNotFoundError):
        HeightMap.channels(tmp_path / "none.npy")


def test_pooled_statistics_are_those_of_the_command_line(program, tmp_path):
    like = {"rms_height_m": 1e-6, "hurst": 0.8, "size_m": 1e-4, "points": 64, "correlation_length_m": 5e-6}
    scans = [asperity.artificial_surface(**like, seed=seed) for seed in range(3)]
    files = [tmp_path / f"{place}.gwy" for place in range(3)]
    for scan, file in zip(scans, files, strict=True):
        scan.write(file)
    expected = program("surface", "stats", *files, "--level", "plane")
    found = asperity.pooled_statistics([scan.level("plane") for scan in scans]).to_dict()
    for own in (*found["scans"], *expected["scans"]):
        del own["file"]
    assert found == {key: expected[key] for key in found}
    with pytest.raises(ValueError, match="at least 2"):
        asperity.pooled_statistics(scans[:1])


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="peak memory as Linux states it")
@pytest.mark.parametrize(
    ("call", "most"),
    [
        ("scan.level('plane')", 3.5),
        ("scan.level('quadratic', outliers=5)", 3.5),
        ("scan.level('plane', l_filter_m=2e-4)", 5.0),
        ("scan.statistics()", 4.0),
        ("asperity.solve_contact(scan, mean_pressure_pa=2e7, modulus_pa=1e11)", 8.0),
    ],
)
def test_large_maps_need_a_few_times_their_memory(call, most):
    program = f"""
import asperity, gc, numpy as np
n = 2048
scan = asperity.HeightMap.from_array(np.random.default_rng(1).normal(size=(n, n)), dx_m=1e-6)
small = asperity.HeightMap.from_array(np.random.default_rng(1).normal(size=(64, 64)), dx_m=1e-6)
def kilobytes(name):
    return next(int(line.split()[1]) for line in open("/proc/self/status") if line.startswith(name))
small.statistics()
gc.collect()
open("/proc/self/clear_refs", "w").write("5")
before = kilobytes("VmRSS")
found = {call}
print((kilobytes("VmHWM") - before) / (8 * n * n / 1024))
"""
    found = subprocess.run([sys.executable, "-c", program], capture_output=True, check=True, text=True)
    assert float(found.stdout) < most
