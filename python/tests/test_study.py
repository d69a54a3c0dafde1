import json

import numpy as np
import pytest

import asperity
from support import ROOT

# Small studies are coarse.
pytestmark = pytest.mark.filterwarnings("ignore::asperity.AsperityWarning")

MACHINE = {
    "seed": 4,
    "vibration": {
        "mass": "1 kg",
        "natural_frequency": "316 rad/s",
        "damping_ratio": 0.17,
        "normal_force": "2.5 kN",
        "nominal_area": "833 mm^2",
        "dimensionless_belt_velocity": 0.003,
        "stribeck": 4.2,
        "static_friction": 0.1,
        "friction_std": 0.001,
        "friction_correlation_length": "250 um",
        "friction_marginal": "beta:2.1,5",
        "trajectories": 20,
        "duration": 60.0,
        "damping_sweep": [0.1, 0.2, 2],
    },
}
STUDY = """seed = 5
[surface]
covariance = "exponential"
marginal = "normal"
rms_height = "1 um"
correlation_length = "20 um"
[material]
youngs_modulus = "210 GPa"
hardness = "2 GPa"
[pressure]
size = ["100 um", "100 um"]
points = [16, 16]
percentile = 50.0
fine_solves = 30
methods = [
    "monte_carlo", "latin_hypercube", "sobol", "polynomial_chaos", "polynomial_chaos_log", "polynomial_chaos_local",
]
reference_samples = 100
"""


def test_a_study_equals_the_run_of_the_command_line(program, tmp_path):
    file = tmp_path / "study.toml"
    file.write_text(STUDY)
    expected = program("run", file, "--out", tmp_path / "run", "--quiet")
    seen = []
    found = asperity.run_study(file, progress=lambda *report: seen.append(report))
    assert found.to_dict() == json.loads((tmp_path / "run" / "results.json").read_text()) == expected
    assert found.pressure.contact_probability == expected["pressure"]["contact_probability"]
    assert all(0 <= done <= total for _, done, total in seen)
    columns = (tmp_path / "run" / "tables" / "pressure_cdf.csv").read_text().splitlines()
    assert list(found.tables["pressure_cdf"]) == columns[0].split(",")
    assert float(columns[-1].split(",")[0]) == found.tables["pressure_cdf"]["pressure_pa"][-1]
    for name, field in found.fields.items():
        stored = np.load(tmp_path / "run" / "fields" / f"{name}.npz")
        (array,) = set(stored) - {"dx_m", "dy_m"}
        assert np.array_equal(field.values, stored[array], equal_nan=True)
        assert (stored["dx_m"][0], stored["dy_m"][0]) == (field.dx_m, field.dy_m)
    other = asperity.run_study(file, seed=6, only="surface")
    assert (other.seed, other.pressure) == (6, None)


def test_a_run_folder_has_the_results_and_is_never_replaced(program, tmp_path):
    found = asperity.run_study(MACHINE, out=tmp_path / "run")
    assert found.to_dict() == json.loads((tmp_path / "run" / "results.json").read_text())
    assert (tmp_path / "run" / "COMPLETE").exists()
    assert "STATUS" not in program("status", tmp_path / "run")
    with pytest.raises(ValueError, match="not empty"):
        asperity.run_study(MACHINE, out=tmp_path / "run")


def sizes(folder):
    """Return the sizes of the files of stored blocks by name."""
    return {path.name: path.stat().st_size for path in folder.glob(".asperity-blocks/*/*.blocks")}


def test_an_interrupted_run_goes_on_from_its_blocks(program, tmp_path):
    file = tmp_path / "study.toml"
    file.write_text(STUDY.replace("reference_samples = 100", "reference_samples = 4000"))
    out = tmp_path / "run"

    def interrupt(task, done, total):
        if done > 0:
            raise InterruptedError

    with pytest.raises(InterruptedError):
        asperity.run_study(file, progress=interrupt, out=out)
    assert not out.exists()
    blocks = sizes(tmp_path)
    assert blocks
    expected = asperity.run_study(file, progress=False)
    assert asperity.run_study(file, progress=False, out=out).to_dict() == expected.to_dict()
    # Only the missing blocks were computed and written.
    asperity.run_study(file, progress=False, out=tmp_path / "whole" / "run")
    rest = sum(size for name, size in sizes(tmp_path).items() if name not in blocks)
    assert rest < sum(sizes(tmp_path / "whole").values())
    provenance = json.loads((out / "provenance.json").read_text())
    assert provenance["started_unix_s"] > 0
    assert len(provenance["program"]["sha256"]) == len(provenance["inputs"]["study.toml"]) == 64


def test_a_campaign_equals_that_of_the_command_line(program, tmp_path):
    (tmp_path / "study.toml").write_text(STUDY)
    file = tmp_path / "campaign.toml"
    file.write_text('study = "study.toml"\n[values]\nmaterial.hardness = ["2 GPa", "3 GPa"]\n')
    expected = program("campaign", file, "--out", tmp_path / "campaign", "--quiet")
    found = asperity.run_campaign(file, progress=False, out=tmp_path / "own")
    assert found.to_dict() == expected
    frame = found.to_dataframe()
    assert frame["material.hardness"].tolist() == [2e9, 3e9]
    assert np.isnan(frame["friction_mean"]).all()
    assert (tmp_path / "own" / "members.csv").read_text() == (tmp_path / "campaign" / "members.csv").read_text()
    with pytest.raises(ValueError, match=r"found a campaign; asperity\.run_campaign"):
        asperity.run_study(file)
    with pytest.raises(ValueError, match=r"found a study; asperity\.run_study"):
        asperity.run_campaign(tmp_path / "study.toml")


def test_results_are_tables_of_pandas_and_html():
    pytest.importorskip("pandas")
    found = asperity.run_study(MACHINE)
    assert found.vibration is not None
    assert found.to_dataframe()["vibration.critical_damping_ratio"].item() == found.vibration.critical_damping_ratio
    table = next(iter(found.tables.values())).to_dataframe()
    assert len(table.columns) > 1
    assert "critical_damping_ratio" in found._repr_html_()


def test_pressure_and_verdict_are_stages_of_a_study(program, tmp_path):
    file = tmp_path / "study.toml"
    file.write_text(STUDY)
    found = asperity.pressure_distribution(file, progress=False)
    assert found == asperity.run_study(file, progress=False).pressure
    machine = {
        "seed": 1,
        "vibration": {
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
        },
    }
    # The machine vibrates if its damping ratio is below half the weakening: at the median of 0.1.
    found = asperity.verdict(machine, progress=False)
    assert found.probability == pytest.approx(0.5, abs=0.03)
    assert isinstance(found.drivers[0].total, float)


def test_the_friction_process_of_a_study_is_that_of_its_run_folder(tmp_path):
    study = {
        "seed": 2,
        "surface": {
            "covariance": "exponential",
            "marginal": "normal",
            "rms_height": "1 um",
            "correlation_length": "20 um",
        },
        "material": {"youngs_modulus": "210 GPa", "hardness": "2 GPa", "shear_strength": "385 MPa"},
        "friction": {
            "strip": ["3 mm", "50 um"],
            "points": [512, 8],
            "window": "200 um",
            "percentiles": [25.0],
            "realisations": 4,
        },
    }
    found = asperity.run_study(study, progress=False, out=tmp_path / "run")
    expected = asperity.FrictionProcess.read(tmp_path / "run" / "friction_process.json")
    assert found.friction_process == expected
    assert found.friction is not None
    assert expected.mean == found.friction.operating_point.mean


def test_every_error_has_its_kind(tmp_path):
    file = tmp_path / "study.toml"
    for text, message in [
        (STUDY.replace("hardness", "hardnes"), r"study\.toml:9: unknown key `hardnes`; did you mean `hardness`"),
        (STUDY.replace("210 GPa", "210 Gpa"), r"study\.toml:8: "),
        (STUDY.replace("50.0", "150.0"), r"study\.toml:13: "),
    ]:
        file.write_text(text)
        with pytest.raises(ValueError, match=message):
            asperity.run_study(file)
    with pytest.raises(ValueError, match="unknown key `colour`"):
        asperity.run_study({**MACHINE, "colour": 1})
    with pytest.raises(ValueError, match="found -1, expected a whole number"):
        asperity.run_study(MACHINE, seed=-1)
    with pytest.raises(ValueError, match="not a valid stage"):
        asperity.run_study(MACHINE, only="report")
    with pytest.raises(ValueError, match="pressure"):
        asperity.run_study(MACHINE, only="pressure")
    with pytest.raises(FileNotFoundError):
        asperity.run_study(tmp_path / "gone.toml")
    with pytest.raises(FileNotFoundError):
        asperity.run_study({"seed": 1, "surface": {"file": str(tmp_path / "gone.x3p")}})
    file.write_text(STUDY.replace("[16, 16]", "[8192, 8192]"))
    with pytest.raises(asperity.ResourceError, match="of memory are free"):
        asperity.run_study(file)


def test_an_error_of_the_progress_callback_ends_the_run():
    def stop(*_):
        raise LookupError("stop")

    long = {**MACHINE, "vibration": {**MACHINE["vibration"], "trajectories": 20000}}
    with pytest.raises(LookupError, match="stop"):
        asperity.run_study(long, progress=stop)


def test_the_examples_are_valid_as_dictionaries():
    tomllib = pytest.importorskip("tomllib")
    study = tomllib.loads((ROOT / "studies" / "paper_fig5.toml").read_text())
    with pytest.raises(ValueError, match="pressure"):
        asperity.run_study(study, only="pressure")


def test_a_notebook_has_one_output_that_changes(monkeypatch):
    display = pytest.importorskip("IPython.display")
    shown = []

    class Handle:
        def update(self, text):
            shown[-1].append(text.data)

    def display_text(text, display_id):
        assert display_id
        shown.append([text.data])
        return Handle()

    monkeypatch.setattr("asperity._progress._in_notebook", lambda: True)
    monkeypatch.setattr(display, "display", display_text)
    monkeypatch.setattr("asperity._progress._TICK_S", 0.0)
    asperity.run_study(MACHINE)
    ((first, *others),) = shown
    assert first.startswith("0 s; ")
    assert any("vibration (area): 4 of 4" in text for text in [first, *others])


def test_a_notebook_shows_the_answer_first():
    found = asperity.run_study(MACHINE, progress=False)
    shown = found._repr_html_()
    (sentence, *_) = found.summary
    assert shown.startswith(f"<p>{sentence}</p>")
    assert sentence.startswith("The machine vibrates (stick-slip)")
    order = [shown.index(part) for part in ("<table><tr><th>damping ratio at", "<img alt=", "<details><summary>")]
    assert order == sorted(order)
    assert len(found._main()) <= 6
    surface = {"covariance": "exponential", "rms_height": "1 um", "correlation_length": "20 um", "marginal": "normal"}
    assert asperity.run_study({"seed": 7, "surface": surface})._repr_html_().startswith("<table><tr><th>rms height (m)")


def test_a_channel_is_a_name_or_a_number(tmp_path):
    scan = asperity.artificial_surface(
        rms_height_m=1e-6, hurst=0.8, size_m=1e-4, points=64, correlation_length_m=5e-6, seed=1
    )
    scan.write(tmp_path / "scan.gwy")
    results = [
        asperity.run_study({"seed": 1, "surface": {"file": tmp_path / "scan.gwy", "channel": channel}}, progress=False)
        for channel in ("Height", "1", 1)
    ]
    assert results[0] == results[1] == results[2]
    with pytest.raises(ValueError, match="a name, or a number counted from 1"):
        asperity.run_study({"seed": 1, "surface": {"file": tmp_path / "scan.gwy", "channel": 1.5}})
