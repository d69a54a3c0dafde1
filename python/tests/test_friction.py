import json

import numpy as np
import pytest

import asperity


def test_a_fit_equals_that_of_the_command_line(program, tmp_path):
    process = asperity.friction_process(mean=0.21, std=0.008, correlation_length_m=250e-6, marginal="beta:2.1,5")
    friction = process.simulate(length_m=50e-3, step_m=1e-5, seed=11)
    rows = "".join(f"{i / 100:.2f},{float(value)!r}\n" for i, value in enumerate(friction))
    (tmp_path / "record.csv").write_text("s [mm],mu [-]\n" + rows)
    columns = ("--column", "mu", "--distance-column", "s", "--out", tmp_path / "process.json", "--quiet")
    program("friction", "fit", tmp_path / "record.csv", *columns)
    expected = asperity.FrictionProcess.read(tmp_path / "process.json")
    found = asperity.fit_friction_record(friction, step_m=1e-5)
    assert (found.mean, found.std, found.marginal) == (expected.mean, expected.std, expected.marginal)
    assert found.correlation.length_m == pytest.approx(expected.correlation.length_m, rel=1e-9)
    low, high = found.mean_interval
    assert low < 0.21 < high
    assert found.correlation.length_m == pytest.approx(250e-6, rel=0.3)


def test_a_simulated_record_equals_that_of_the_command_line(program, tmp_path):
    process = asperity.friction_process(mean=0.2, std=0.01, correlation_length_m=100e-6)
    process.write(tmp_path / "process.json")
    assert asperity.FrictionProcess.read(tmp_path / "process.json") == process
    size = ("--length", "5 mm", "--step", "10 um", "--seed", 3, "--out", tmp_path / "mu.csv")
    program("friction", "simulate", tmp_path / "process.json", *size)
    table = np.genfromtxt(tmp_path / "mu.csv", delimiter=",", names=True)
    found = process.simulate(length_m=5e-3, step_m=10e-6, seed=3)
    assert np.array_equal(found, table["mu"])
    assert json.loads((tmp_path / "process.json").read_text())["format"] == "asperity friction process"


@pytest.mark.parametrize("content", [b'{"format": "asperity fric', b"[1, 2]", b"\xff\xfe\x00", b"[" * 100_000])
def test_a_damaged_process_is_named(tmp_path, content):
    (tmp_path / "process.json").write_bytes(content)
    with pytest.raises(asperity.FormatError, match=r"process\.json: "):
        asperity.FrictionProcess.read(tmp_path / "process.json")
    with pytest.raises(FileNotFoundError, match=r"gone\.json"):
        asperity.FrictionProcess.read(tmp_path / "gone.json")


def test_wrong_processes_and_records_raise_by_kind():
    with pytest.raises(ValueError, match="std"):
        asperity.friction_process(mean=0.2, std=-0.01, correlation_length_m=1e-4)
    with pytest.raises(ValueError, match="colour"):
        asperity.friction_process(mean=0.2, std=0.01, correlation_length_m=1e-4, marginal="colour")
    with pytest.raises(ValueError, match="distance between values is 0e0 m"):
        asperity.fit_friction_record(np.ones(100), step_m=0)
    with pytest.raises(asperity.NotConvergedError):
        asperity.fit_friction_record([0.1, 0.2, 0.1], step_m=1e-5)
    with pytest.raises(ValueError, match="decimation"):
        asperity.fit_friction_record(np.ones(100), step_m=1, decimation=0)
    with pytest.raises(ValueError, match="1e300 m"):
        asperity.fit_friction_record(np.ones(100), step_m=1e300)
