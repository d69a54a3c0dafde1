"""Studies made of objects."""

import copy
import dataclasses
import pickle

import numpy as np
import pytest
from scipy import stats

import asperity
from asperity.inputs import Friction, Material, Pressure, Surface, Verdict, Vibration
from support import ROOT, SCAN

pytestmark = pytest.mark.filterwarnings("ignore::asperity.AsperityWarning")

MACHINE = {
    "mass": 1,
    "natural_frequency": "50 Hz",
    "damping_ratio": 0.1,
    "normal_force": 100,
    "nominal_area": 1e-4,
    "belt_velocity": 0.02,
}
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


def test_maps_of_the_same_bytes_and_another_shape_are_two():
    heights = 1e-6 * np.random.default_rng(1).standard_normal(64 * 256).cumsum()
    maps = [asperity.HeightMap.from_array(heights.reshape(shape), dx_m=1e-6) for shape in ((64, 256), (256, 64))]
    first, second = (Surface(file=own).to_dict()["file"] for own in maps)
    assert asperity.HeightMap.read(first) == maps[0] != maps[1] == asperity.HeightMap.read(second)


def test_what_the_caller_changes_later_does_not_change_a_study():
    lengths, pressures = [20e-6, 20e-6], np.array([2e6, 3e6])
    surface = Surface(
        covariance="exponential", marginal="normal", rms_height=np.array(1e-6), correlation_length=lengths
    )
    slid = Friction(mean_pressures=pressures, percentiles=(own for own in (5.0, 50.0)), points=[np.int64(256), 16])
    lengths[0], pressures[0] = 90e-6, 9e6
    assert surface.correlation_length == (20e-6, 20e-6)
    assert surface.rms_height == 1e-6
    assert slid.to_dict() == slid.to_dict()
    assert slid.mean_pressures == (2e6, 3e6)
    assert slid.percentiles == (5.0, 50.0)
    table = Vibration(friction_table=[(0, 0.4), ("0.1 m/s", 0.3)], **MACHINE).to_dict()["friction_table"]
    assert table == [["0.0 m/s", 0.4], ["0.1 m/s", 0.3]]
    form = Material(youngs_modulus=asperity.uncertain(stats.lognorm(0.1, scale=2e9), unknown=True)).to_dict()
    assert form == {"youngs_modulus": {"lognormal": ["2000000000.0 Pa", 0.1], "unknown": True}}


def test_a_stated_value_is_no_longer_unstated():
    study = dataclasses.replace(machine(), unstated=["vibration.kinetic_share", "vibration.velocity_law"])
    changed = study.with_values(kinetic_share=0.9, seed=3)
    assert (changed.unstated, changed.seed) == (("vibration.velocity_law",), 3)
    assert "kinetic_share" not in changed.with_values(kinetic_share=None).to_dict()["vibration"]


def test_sections_are_objects_and_maps_are_as_measured():
    with pytest.raises(TypeError, match=r"surface: found dict, expected asperity\.inputs\.Surface"):
        asperity.Study(seed=1, surface={"rms_height": "1 um"})
    scan = asperity.HeightMap.from_array(np.random.default_rng(2).standard_normal((32, 32)) * 1e-6, dx_m=1e-6)
    with pytest.raises(ValueError, match="height_unit: the heights and the pixel size of a HeightMap are in m"):
        Surface(file=scan, height_unit="nm")
    with pytest.warns(asperity.AsperityWarning, match="the map was levelled or filtered before"):
        Surface(file=[scan.level("plane")])
    with pytest.raises(TypeError, match="found 3, expected a frozen distribution"):
        asperity.uncertain(3)


def test_dictionaries_take_maps_and_paths(tmp_path):
    scan = asperity.HeightMap.from_array(np.random.default_rng(2).standard_normal((64, 64)) * 1e-6, dx_m=1e-6)
    scan.write(tmp_path / "scan.gwy")
    found = [
        asperity.run_study({"seed": 1, "surface": {"file": own}}, only="surface", progress=False)
        for own in (scan, tmp_path / "scan.gwy", str(tmp_path / "scan.gwy"), [scan])
    ]
    assert len({own.surface.covariance.std_m for own in found}) == 1
    with pytest.raises(TypeError, match="found bytes"):
        asperity.run_study({"seed": 1, "surface": {"file": b"scan.gwy"}}, only="surface", progress=False)
