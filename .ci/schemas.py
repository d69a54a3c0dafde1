"""Validates results and studies against the schemas of `asperity schema`, and compares the study schema with what the program accepts.

The argument K/N compares one of N parts of the values only. Needs the program that the tests built, and the run of .ci/quickstart.py.
"""

import concurrent.futures
import copy
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import tomllib

import jsonschema

PROGRAM = pathlib.Path("target/debug/asperity").resolve()
STUDIES = pathlib.Path("studies").resolve()
QUICKSTART = pathlib.Path("target/quickstart/results.json")

MACHINE = """seed = 1
[vibration]
mass = "1 kg"
natural_frequency = "316 rad/s"
normal_force = "2.5 kN"
nominal_area = "833 mm^2"
friction_std = 0
"""
RUNS = {
    "mode coupling": MACHINE
    + """model = "mode_coupling"
dimensionless_belt_velocity = 0.5
static_friction = "0.7 ± 0.05"
damping_ratio = 0
[verdict]
""",
    "verdict": MACHINE
    + """dimensionless_belt_velocity = 0.1
static_friction = 0.3
velocity_law = "linear"
linear_weakening = "0.1 ± 0.02"
damping_ratio = { normal = [0.055, 0.005], unknown = true }
[verdict]
remedies = [{ input = "vibration.damping_ratio", range = [0.01, 0.5] }, { input = "vibration.linear_weakening", range = [0.01, 0.2] }]
""",
    "two scans": f"""seed = 1
[surface]
file = ["{STUDIES}/brake_disc.x3p", "{STUDIES}/brake_disc.x3p"]
[counterface]
covariance = "exponential"
marginal = "normal"
rms_height = "0.5 um"
correlation_length = "20 um"
""",
}
# Members of a campaign over the study "verdict" with the remedies of a study that states none, and a warning of few evaluations.
CAMPAIGN = """study = "study.toml"
[values]
seed = [1, 9007199254740993]
vibration.normal_force = ["2 kN", "4 ± 0.5 kN"]
vibration.damping_ratio = [0.05]
verdict.evaluations = [1000]
"""
# Objects whose keys are names of data.
BY_NAME = {"parameters", "marginal_parameter_intervals", "kinds", "kind_shares"}

# Every section of a study.
STUDY = """seed = 1
[surface]
covariance = "exponential"
marginal = "normal"
rms_height = "1 um"
correlation_length = "20 um"
[counterface]
covariance = "exponential"
rms_height = "0.5 um"
correlation_length = "20 um"
[material]
youngs_modulus = "210 GPa"
shear_strength = "385 MPa"
[pressure]
size = ["200 um", "200 um"]
points = [64, 64]
percentile = 50.0
[friction]
realisations = 4
[friction.uncertainty]
rms_height = "5 %"
[vibration]
mass = "1 kg"
natural_frequency = "316 rad/s"
damping_ratio = "0.17 ± 0.02"
normal_force = "2.5 kN"
nominal_area = "833 mm^2"
belt_velocity = "23.7 mm/s"
[vibration.map]
over = "damping_velocity"
x = [0.05, 0.3, 4]
y = [0.1, 0.5, 4]
[uncertainty]
surface = true
[verdict]
remedies = [{ input = "vibration.damping_ratio", range = [0.01, 0.5] }]
"""
# Each of these is tried as the value of every key.
VALUES = """0.5; 2; -1; true; "0.5"; "5"; "5 um"; "210 GPa"; "316 rad/s"; "1 kg"; "2 kN"; "1 m/s"; "1 s/m"; "1 mm^2"; "1e-15 m/Pa"; "2 s"
"0.17 ± 0.02"; "0.1 .. 0.2"; "2 ± 0.2 GPa"; "900 MPa .. 2 GPa"; "5 +/- 1 um"; "5 um ± 1"; "5 %"; "8 GPa ± 10 %"; "5 % ± 1 %"; "5 ± 1 %"; "5 % ± 1"; "1 % .. 5"; "1–5 %"; { uniform = ["10 %", "20 %"] }
"80–150 MPa"; "0.1–0.2"; "5 +- 1 um"; "unknown"; "measured"; "surface"; "normal"
"spectral"; "periodic"; "mean"; "polynomial:3"; "polynomial:13"; "stribek"; ["5 um"]; ["5 um", "6 um"]; ["5 um", "5 um ± 1 um"]
[1, 2]; [0.1, 0.2]; [0.1, "0.2 ± 0.1"]; [0.1, 0.3, 4]; [64, 64, 64]; ["1 MPa"]; [["0 m/s", 1.0]]; [["a.b", "c.d", 0.5]]
{ normal = [0.5, 0.1] }; { lognormal = ["2 GPa", 0.2], unknown = true }; { uniform = ["4 um", "5 um"] }; { beta = [2, 5, 0, 1] }
{ triangular = [0.1, 0.2, 0.3] }; { normal = [0.5] }; { normal = [0.5, 0.1], known = true }; { normal = [0.5, 0.1], uniform = [0, 1] }
{ samples = 3 }; {}"""
# Keys with free text, which the schema does not check further.
TEXTS = {"channel", "file", "height_unit", "marginal", "friction_marginal", "friction_process", "input"}
# Errors about the type of a value. The schema knows no errors about its size and about other keys.
OF_TYPE = re.compile(
    "unknown (key|value)|is not a|no unit|does not start with a number|needs a list|names a CSV file|exactly one distribution|"
    "cannot be uncertain|found [0-9]+ values?, expected|missing field|no percentage|no number|no form|is true or false|"
    "is no value|with both numbers or with none|state the unit or|has a percentage"
)


def asperity(*arguments: str, cwd: str | None = None) -> subprocess.CompletedProcess:
    return subprocess.run([PROGRAM, *arguments], cwd=cwd, capture_output=True, text=True)


def validator(name: str) -> jsonschema.protocols.Validator:
    schema = json.loads(asperity("schema", name).stdout)
    kind = jsonschema.validators.validator_for(schema)
    kind.check_schema(schema)
    return kind(schema)


def errors(schema: jsonschema.protocols.Validator, value: object) -> str:
    return "; ".join(f"{error.json_path}: {error.message:.200}" for error in schema.iter_errors(value))


def objects(value: object, path: tuple = ()) -> list[tuple]:
    """Paths of all objects in a JSON value."""
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [path] * isinstance(value, dict) + [found for key, own in inner for found in objects(own, (*path, key))]


def at(value: object, path: tuple) -> dict:
    for key in path:
        value = value[key]
    return value


def toml(value: object) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {toml(own)}" for key, own in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    return json.dumps(value, ensure_ascii=False)


def check_results(folder: str) -> list[str]:
    """Results are valid; with an unknown key in any object, or without a key, they are not."""
    schema, found = validator("results"), {"quickstart": json.loads(QUICKSTART.read_text())}
    for name, text in RUNS.items():
        pathlib.Path(folder, "study.toml").write_text(text)
        ended = asperity("run", "study.toml", "--out", name, "--quiet", "--json", cwd=folder)
        found[name] = json.loads(ended.stdout)
    pathlib.Path(folder, "study.toml").write_text(RUNS["verdict"].partition("remedies")[0])
    pathlib.Path(folder, "campaign.toml").write_text(CAMPAIGN)
    found["campaign"] = json.loads(asperity("campaign", "campaign.toml", "--quiet", "--json", cwd=folder).stdout)
    failed = []
    for name, results in found.items():
        failed += [f"{name}: {wrong}" for wrong in [errors(schema, results)] if wrong]
        for path in objects(results):
            changed = copy.deepcopy(results)
            at(changed, path)["colour"] = 1.0
            if not BY_NAME.intersection(path[-1:]) and schema.is_valid(changed):
                failed.append(f"{name}: an unknown key in {path} is valid")
        for key in results:
            changed = {"sed" if own == key else own: value for own, value in results.items()}
            if schema.is_valid(changed):
                failed.append(f"{name}: `sed` in place of {key} is valid")
    without = copy.deepcopy(found["quickstart"])
    del without["surface"]["Sq_m"]
    return failed + ["quickstart: statistics without Sq_m are valid"] * schema.is_valid(without)


def check_studies(folder: str) -> list[str]:
    """The examples are valid, and a value of a wrong type is an error of the schema and of the program."""
    schema, failed = validator("study"), []
    for file in sorted(STUDIES.glob("*.toml")):
        failed += [f"{file}: {wrong}" for wrong in [errors(schema, tomllib.loads(file.read_text()))] if wrong]
    values = [tomllib.loads(f"x = {text}")["x"] for line in VALUES.splitlines() for text in line.split("; ")]
    study, tried = tomllib.loads(STUDY), []
    for path in objects(study):
        section = schema.schema
        for key in path:
            section = section["items"] if isinstance(key, int) else section["properties"][key]
        keys = {key for key, value in section["properties"].items() if "properties" not in value} - TEXTS
        tried += [(path, key, value) for key in sorted(keys | {"colour"}) for value in values]
    part, parts = map(int, (sys.argv[1:] or ["0/1"])[0].split("/"))
    tried = tried[part::parts]

    def compare(index: int) -> str | None:
        path, key, value = tried[index]
        changed = copy.deepcopy(study)
        at(changed, path)[key] = value
        file = pathlib.Path(folder, f"study-{index}.toml")
        file.write_text("".join(f"{name} = {toml(own)}\n" for name, own in changed.items()))
        ended, valid = asperity("check", file.name, cwd=folder), schema.is_valid(changed)
        if valid != (ended.returncode == 0) and (not valid or OF_TYPE.search(ended.stderr)):
            return f"{'.'.join(map(str, path))} {key} = {toml(value)}: valid is {valid}; {ended.stderr.strip()}"
        return None

    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        return failed + [wrong for wrong in pool.map(compare, range(len(tried))) if wrong]


with tempfile.TemporaryDirectory() as folder:
    failed = check_results(folder) + check_studies(folder)
print("\n".join(failed) or "ok    schemas")
sys.exit(bool(failed))
