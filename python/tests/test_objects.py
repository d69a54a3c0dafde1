"""Studies made of objects."""

import copy
import dataclasses
import pickle

import pytest
from scipy import stats

import asperity
from asperity.inputs import Friction, Material, Pressure, Surface, Verdict, Vibration
from support import ROOT, SCAN

pytestmark = pytest.mark.filterwarnings("ignore::asperity.AsperityWarning")

TEXT = """seed = 1
[vibration]
mass = "1 kg"
natural_frequency = "50 Hz"
damping_ratio = "0.21 ± 0.02"
normal_force = { lognormal = ["2.5 kN", 0.1], unknown = true }
nominal_area = "833 mm^2"
belt_velocity = "24 mm/s"
stribeck = "0.5 s/m .. 0.6 s/m"
static_friction = { triangular = [0.08, 0.1, 0.13] }
friction_std = 0.0
friction_marginal = "normal"
friction_correlation_length = "250 um"
[verdict]
evaluations = 1000
remedies = [{ input = "vibration.damping_ratio", range = [0.01, 0.5] }]
"""


def machine() -> asperity.Study:
    """Return the study of the text, from numbers in SI units and distributions."""
    force = asperity.uncertain(stats.lognorm(0.1, scale=2500.0), unit="N", unknown=True)
    vibration = Vibration(
        mass=1,
        natural_frequency="50 Hz",
        damping_ratio=stats.norm(0.21, 0.02),
        normal_force=force,
        nominal_area=833e-6,
        belt_velocity=24e-3,
        stribeck="0.5 s/m .. 0.6 s/m",
        static_friction={"triangular": (0.08, 0.1, 0.13)},
        friction_std=0.0,
        friction_marginal="normal",
        friction_correlation_length=250e-6,
    )
    remedies = [{"input": "vibration.damping_ratio", "range": (0.01, 0.5)}]
    return asperity.Study(seed=1, vibration=vibration, verdict_plan=Verdict(evaluations=1000, remedies=remedies))


def test_a_verdict_from_objects_has_the_bits_of_the_file(tmp_path):
    file = tmp_path / "study.toml"
    file.write_text(TEXT, encoding="utf-8")
    found = machine().verdict(progress=False)
    assert found.to_dict() == asperity.verdict(file, progress=False).to_dict()
    assert 0.01 < found.probability < 0.99
    read = asperity.Study.read(file)
    assert read.vibration.damping_ratio == "0.21 ± 0.02"
    assert read.verdict(progress=False) == found
    file.write_text(machine().to_toml(), encoding="utf-8")
    assert asperity.verdict(file, progress=False) == found
    drier = machine().with_values(damping_ratio=stats.uniform(0.3, 0.1))
    assert drier.verdict(progress=False).probability < found.probability
    assert drier.to_dict()["vibration"]["damping_ratio"] == {"uniform": [0.3, 0.3 + 0.1]}


def test_a_map_in_place_of_a_file_gives_the_same_numbers(tmp_path):
    material = Material(youngs_modulus=10e9, hardness=100e6)
    whole, file = asperity.HeightMap.read(SCAN), tmp_path / "scan.gwy"
    scan = asperity.HeightMap.from_array(whole.heights[:96, :96], dx_m=whole.dx_m)
    scan.write(file)
    assert asperity.HeightMap.read(file) == scan
    plan = Pressure(size=(64e-6, 64e-6), points=(12, 12), mean_pressure=2e6, boundary="periodic", fine_solves=20)
    found = [
        asperity.pressure_distribution(surface, material, plan, seed=3, progress=False)
        for surface in (scan, Surface(file=file), Surface(file=str(file)))
    ]
    assert found[0] == found[1] == found[2]
    slid = Friction(strip=(600e-6, 40e-6), points=(256, 16), window=60e-6, mean_pressures=(2e6,), realisations=4)
    levels = [
        asperity.friction_distribution(own, Material(youngs_modulus=10e9, shear_strength=38e6), slid, progress=False)
        for own in (scan, Surface(file=file))
    ]
    assert levels[0].levels[0].mean == levels[1].levels[0].mean > 0
    with pytest.raises(TypeError, match="found str with sections"):
        asperity.pressure_distribution(str(file), material, plan)


def test_paths_of_a_file_are_those_of_its_folder(monkeypatch, tmp_path):
    study = ROOT / "studies" / "quickstart.toml"
    monkeypatch.chdir(tmp_path)
    read = asperity.Study.read(study)
    assert read.surface.file == str(SCAN)
    found = read.check()
    assert [stage["stage"] for stage in found.stages] == ["surface", "pressure", "friction", "vibration", "verdict"]
    assert found.problems == []
    assert read.run(only="surface", progress=False).surface == asperity.run_study(study, only="surface").surface


def test_a_study_is_a_value():
    study = machine()
    assert study == machine() == pickle.loads(pickle.dumps(study)) == copy.deepcopy(study)
    assert study != study.with_values(mass=2)
    assert study.with_values(vibration__mass=2).vibration == dataclasses.replace(study.vibration, mass=2)
    assert study.with_values(mass=2).with_values(mass=1) == study


def test_wrong_values_are_refused_where_they_are_stated():
    study = machine()
    with pytest.raises(ValueError, match="damping_ratio: found -1, expected zero or a positive value"):
        study.with_values(damping_ratio=-1)
    with pytest.raises(ValueError, match="no section of the study has the key hardness"):
        study.with_values(hardness=1e9)
    with pytest.raises(TypeError, match="unexpected keyword argument 'masss'"):
        Vibration(masss=1)
    with pytest.raises(ValueError, match="damping_ratio: a study has no form for gamma"):
        study.with_values(damping_ratio=stats.gamma(2))
    with pytest.raises(TypeError, match="mass: found <object"):
        study.with_values(mass=object())
    two = asperity.Study.read(ROOT / "studies" / "quickstart.toml")
    with pytest.raises(ValueError, match="the sections friction, pressure have the key boundary"):
        two.with_values(boundary="free")
    assert two.with_values(friction__boundary="free").friction.boundary == "free"
