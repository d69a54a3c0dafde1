"""Names and warnings of the package."""

import copy
import inspect
import pickle
import subprocess
import sys

import pytest

import asperity
from asperity import AsperityWarning
from test_study import MACHINE


def test_the_names_of_the_package_are_those_of_its_users():
    shown = set(dir(asperity))
    assert {"run_study", "verdict", "run_campaign", "pressure_distribution", "figures", "dask", "inputs"} <= shown
    assert {name for name in shown if not name.startswith("__")} == {*asperity.__all__, "figures", "dask", "inputs"}
    for name in shown:
        assert getattr(asperity, name) is not None
    with pytest.raises(AttributeError, match="contact_solution"):
        _ = asperity.contact_solution


def test_studies_load_late():
    program = (
        "import asperity, sys; print([name for name in sys.modules if name in ('asperity.study', 'asperity.dask')])"
    )
    found = subprocess.run([sys.executable, "-c", program], capture_output=True, check=True, text=True)
    assert found.stdout == "[]\n"


def line_above():
    """Return the number of the line above the one that calls."""
    return inspect.currentframe().f_back.f_lineno - 1


def messages(found, line):
    """Return the messages of warnings, which name a line of this file."""
    assert all(issubclass(own.category, AsperityWarning) for own in found)
    assert {(own.filename, own.lineno) for own in found} == {(__file__, line)}
    return [str(own.message) for own in found]


def test_an_implausible_machine_has_the_warnings_of_the_command_line(program):
    settings = {"static_friction": 2, "damping_ratio": 3, "belt_velocity": 0.003}
    flags = [part for name, value in settings.items() for part in (f"--{name.replace('_', '-')}", value)]
    expected = program("vibration", "cycle", *flags, "--stribeck", 4.2)["warnings"]
    with pytest.warns(AsperityWarning) as found:
        machine = asperity.Oscillator(law=asperity.Stribeck(kinetic=2, decay=4.2), **settings)
    line = line_above()
    assert messages(found, line) == expected
    assert len(expected) == 2
    # The same machine was warned of before.
    assert pickle.loads(pickle.dumps(machine)) == copy.copy(machine) == machine


def test_warnings_of_the_library_name_the_line_of_the_user(rough):
    covariance = asperity.Covariance(model="exponential", correlation_length_m=10e-6)
    size = {"size_m": 64e-6, "points": 32}
    with pytest.warns(AsperityWarning, match="Karhunen") as found:
        asperity.KarhunenLoeve(covariance=covariance, rms_height_m=1e-6, modes=5, **size)
    line = line_above()
    assert messages(found, line)


@pytest.mark.parametrize("run", [asperity.run_study, asperity.verdict])
def test_a_run_issues_each_of_its_warnings_once(run):
    machine = MACHINE["vibration"] | {"static_friction": 2.5, "damping_ratio": "1.5 ± 0.1"}
    del machine["damping_sweep"]
    study = {**MACHINE, "vibration": machine}
    with pytest.warns(AsperityWarning) as found:
        results = run(study)
    line = line_above()
    shown = messages(found, line)
    assert len(shown) == len(set(shown))
    assert any("friction coefficient 2.5" in message for message in shown)
    if run is asperity.run_study:
        assert shown == results.warnings


def test_a_campaign_issues_the_warnings_of_its_members(tmp_path):
    text = "".join(f"{key} = {value!r}\n" for key, value in MACHINE["vibration"].items())
    (tmp_path / "study.toml").write_text(f"seed = 1\n[vibration]\n{text}")
    file = tmp_path / "campaign.toml"
    file.write_text('study = "study.toml"\n[values]\nvibration.damping_ratio = [0.17, 1.5]\n')
    with pytest.warns(AsperityWarning, match=r"damping ratio 1\.5 .*\(1 of 2 members\)") as found:
        results = asperity.run_campaign(file, progress=False)
    line = line_above()
    assert len(messages(found, line)) == len(results.warnings) + len(results.member_warnings)
