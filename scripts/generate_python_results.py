"""Write modules of results and laws of python/asperity from JSON Schemas; with --check, compare them instead."""

from __future__ import annotations

import json
import pathlib
import subprocess
import sys
import textwrap
from typing import Any

from asperity import _core

FOLDER = pathlib.Path(__file__).parents[1] / "python" / "asperity"
IMPORTS = """
from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from asperity._methods import CampaignMethods, EnsembleMethods, MachineMethods, StabilityMapMethods
from asperity._record import Record, WithCompanions
"""
STUDY = '''"""Results of a study. Made by scripts/generate_python_results.py; do not edit.

The attributes are the keys of ``results.json``: SI units, with the unit in the name. An undefined number is None, and
an interval is [low, high] at 95 %.
"""
'''
VIBRATION = '''"""Results of stick-slip. Made by scripts/generate_python_results.py; do not edit.

They are dimensionless: X = x·c/N, τ = ω₀t. An undefined number is None, and an interval is [low, high] at 95 %.
"""
'''
# Classes with methods, by the base that has them.
METHODS = {
    "CampaignResults": "CampaignMethods",
    "CriticalDamping": "MachineMethods",
    "Ensemble": "EnsembleMethods",
    "LimitCycle": "MachineMethods",
    "StabilityMap": "StabilityMapMethods",
}
# Objects that are dictionaries.
DICTIONARIES = {"FailedTrajectory": "Any", "MapCell": "Any", "MapResolution": "float"}
LAWS_HEAD = '''"""Oscillator and its velocity laws. Made by scripts/generate_python_results.py; do not edit."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from asperity._record import Arguments

Numbers = float | NDArray[Any]
"""A number, or an array with a number of each machine."""
'''
INPUTS_HEAD = '''"""Sections of a study. Made by scripts/generate_python_results.py; do not edit.

A quantity is a number in the SI unit that its description states, or a text with any unit, such as ``"210 GPa"``. A
value that may be uncertain is also a frozen distribution of SciPy, a distribution of OpenTURNS, or one of the forms of
a study file: ``"10 ± 0.5 GPa"``, ``"8 GPa .. 12 GPa"``, ``{"lognormal": ["10 GPa", 0.05], "unknown": True}``.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, Literal

from asperity._section import Scan, Section, Uncertain
'''
# Types of values that are no plain texts.
FILES = {"file": "Scan | Sequence[Scan]", "friction_process": "str | os.PathLike[str]"}
SCALARS = {"number": "float", "integer": "int", "string": "str", "boolean": "bool", "null": "None"}
Schema = dict[str, Any]


def name_of(reference: str) -> str:
    """Return the name of a referenced definition."""
    return reference.rpartition("/")[2]


def is_choice(schema: Schema) -> bool:
    """Return whether a definition is a choice of names or types, not an object."""
    return "properties" not in schema


def annotation(schema: Schema) -> str:
    """Return the type of a value."""
    if "x-array" in schema:
        return "NDArray[np.float64]"
    if "$ref" in schema:
        name = name_of(schema["$ref"])
        return f"dict[str, {DICTIONARIES[name]}]" if name in DICTIONARIES else name
    if "oneOf" in schema:
        return f"Literal[{', '.join(json.dumps(option['const']) for option in schema['oneOf'])}]"
    if "anyOf" in schema:
        return " | ".join(annotation(option) for option in schema["anyOf"])
    kinds = schema["type"] if isinstance(schema["type"], list) else [schema["type"]]
    inner = {"array": schema.get("items", {}), "object": schema.get("additionalProperties", {})}
    shapes = {"array": "list[{}]", "object": "dict[str, {}]"}
    return " | ".join(SCALARS.get(kind) or shapes[kind].format(annotation(inner[kind])) for kind in kinds)


def references(schema: Any) -> list[str]:
    """Return the names of all definitions that a value uses."""
    if isinstance(schema, list):
        return [name for item in schema for name in references(item)]
    if not isinstance(schema, dict):
        return []
    own = [name_of(schema["$ref"])] if "$ref" in schema else []
    return own + [name for value in schema.values() for name in references(value)]


def text(description: str, indent: str) -> str:
    """Return a docstring."""
    lines = textwrap.wrap(" ".join(description.replace("\\", "\\\\").split()), 110) or ["…"]
    if len(lines) == 1:
        return f'{indent}"""{lines[0]}"""\n'
    return f'{indent}"""' + f"\n{indent}".join(lines) + f'\n{indent}"""\n'


def dataclass(name: str, schema: Schema, definitions: dict[str, Schema]) -> str:
    """Return the source of a class."""
    required, properties = set(schema.get("required", [])), dict(schema["properties"])
    parts = [definitions[part] for option in schema.get("anyOf", []) for part in references(option)]
    for part in parts:
        for key, value in part["properties"].items():
            properties.setdefault(key, value)
    has_companions = any("patternProperties" in part for part in [schema, *parts])
    base = "WithCompanions" if has_companions else METHODS.get(name, "Record")
    source = f"\n\n@dataclass(frozen=True, kw_only=True, eq=False)\nclass {name}({base}):\n"
    source += text(schema["description"], "    ") + "\n"
    for key, value in properties.items():
        kind = annotation(value)
        optional = key not in required
        if optional and not kind.endswith("None"):
            kind += " | None"
        source += f"    {key}: {kind}{' = None' if optional else ''}\n"
        description = value.get("description") or definitions.get(name_of(value.get("$ref", "")), {}).get("description")
        source += text(description or "…", "    ") if description else ""
    if has_companions:
        source += "    companions: Mapping[str, Any] = field(default_factory=dict)\n"
        source += text("Further keys: intervals ``x_interval``, standard errors ``x_se`` and the like.", "    ")
    used = {
        key: [part for part in references(value) if part not in DICTIONARIES and not is_choice(definitions[part])]
        for key, value in properties.items()
    }
    nested = ", ".join(f'"{key}": {parts[0]}' for key, parts in used.items() if parts)
    return source + (f"\n    _nested: ClassVar[Mapping[str, type[Record]]] = {{{nested}}}\n" if nested else "")


def argument(schema: Schema) -> str:
    """Return the type of an argument."""
    if schema.get("type") == "number":
        return "Numbers"
    if schema.get("type") != "array":
        return annotation(schema)
    items = schema["items"]
    return argument_of(annotation(items) if "minItems" in schema else argument(items), schema)


def argument_of(inner: str, schema: Schema) -> str:
    """Return the type of a list of values of one type."""
    is_pair = schema.get("minItems") == schema.get("maxItems") == 2  # noqa: PLR2004
    return f"tuple[{inner}, {inner}]" if is_pair else f"Sequence[{inner}]"


def arguments(name: str, schema: Schema) -> str:
    """Return the source of a class of keyword arguments."""
    source = f"\n\n@dataclass(frozen=True, kw_only=True, eq=False)\nclass {name}(Arguments):\n"
    source += text(schema["description"].partition("\n\n")[0], "    ") + "\n"
    for key, value in schema["properties"].items():
        absent = "" if key in schema["required"] else " = None"
        source += f"    {key}: {argument(value)}{absent}\n" + text(value["description"], "    ")
    return source


def laws() -> str:
    """Return the source of the parameters of an oscillator, with a class for each law, named like it in one word."""
    parameters: Schema = json.loads(_core.parameters_schema())
    definitions: dict[str, Schema] = parameters["$defs"]
    source, names = LAWS_HEAD, []
    for option in definitions["VelocityLaw"]["oneOf"]:
        ((name, value),) = option["properties"].items()
        names.append(name.capitalize())
        source += arguments(names[-1], definitions[name_of(value["$ref"])])
    source += f"\n\nVelocityLaw = {' | '.join(names)}\n" + arguments("Forcing", definitions["Forcing"])
    exported = json.dumps(sorted([*names, "Forcing"]))
    return source + arguments("Parameters", parameters) + f"\n\n__all__ = {exported}\n"


def forms(schema: Schema) -> list[Schema]:
    """Return the forms of a value."""
    return schema.get("anyOf", [schema])


def unit_of(schema: Schema) -> str | tuple[str, ...] | None:
    """Return the SI unit of the numbers of a quantity or a list, of rows those of the columns; None without a unit."""
    if any(form.get("type") == "number" for form in forms(schema)):
        return None
    for form in forms(schema):
        items = form.get("items")
        if isinstance(items, dict) and isinstance(items.get("items"), list):
            units = tuple(unit_of(item) or "" for item in items["items"])
            return units if any(units) else None
        unit = form.get("x-unit") or (unit_of(items) if isinstance(items, dict) else None)
        if unit:
            return unit  # type: ignore[no-any-return]
    return None


def stated(schema: Schema) -> str:
    """Return the type of a value of a study."""
    kinds: list[str] = []
    for form in forms(schema):
        items = form.get("items")
        if "$ref" in form:
            kinds.append("Uncertain")
        elif "oneOf" in form:
            kinds.append(annotation(form))
        elif "const" in form:
            kinds.append(f"Literal[{json.dumps(form['const'])}]")
        elif form.get("type") == "object":
            kinds.append("Mapping[str, object]")
        elif isinstance(items, list):
            kinds.append(f"tuple[{', '.join(map(stated, items))}]")
        elif items:
            kinds.append(argument_of(stated(items), form))
        else:
            kinds += ["float"] * (unit_of(schema) is not None) + [SCALARS[form["type"]]]
    return " | ".join(dict.fromkeys(kinds))


def section(name: str, schema: Schema) -> str:
    """Return the source of a section of a study."""
    source = f"\n\n@dataclass(frozen=True, kw_only=True, eq=False)\nclass {name}(Section):\n"
    source += text(schema["description"], "    ") + "\n"
    properties = schema["properties"]
    for key, value in properties.items():
        kind = FILES.get(key) or (key.capitalize() if "properties" in value and name == "Sections" else stated(value))
        field = "verdict_plan" if name == "Sections" and key == "verdict" else key
        source += f"    {field}: {kind}{'' if key in schema.get('required', []) else ' | None = None'}\n"
        unit, expected = unit_of(value), value.get("x-expected")
        own_units = ", ".join(filter(None, unit)) if isinstance(unit, tuple) else unit
        notes = [f"A number is in {own_units}." if unit else "", f"It is {expected}." if expected else ""]
        notes.append(f"By default {value['default']}." if "default" in value else "")
        source += text(" ".join([value["description"], *filter(None, notes)]), "    ")
    units = {key: unit_of(value) for key, value in properties.items() if unit_of(value)}
    return source + (f"\n    _units: ClassVar[Mapping[str, str | tuple[str, ...]]] = {units}\n" if units else "")


def inputs() -> str:
    """Return the source of the sections of a study."""
    study: Schema = json.loads(_core.study_schema())
    sections = {key: value for key, value in study["properties"].items() if "properties" in value}
    source = INPUTS_HEAD + "".join(section(key.capitalize(), value) for key, value in sections.items())
    source += section("Sections", study)
    return source + f"\n\n__all__ = {json.dumps(sorted(key.capitalize() for key in sections))}\n"


def module(head: str, schema: Schema, tail: str = "") -> str:
    """Return the source of a module; each class follows those that it uses."""
    definitions: dict[str, Schema] = schema["$defs"]
    source, done = head + IMPORTS, set(DICTIONARIES)

    def add(name: str) -> None:
        nonlocal source
        if name in done:
            return
        done.add(name)
        own = definitions[name]
        for part in references(own):
            add(part)
        if is_choice(own):
            source += f"\n{name} = {annotation(own)}\n" + text(own["description"], "")
        else:
            source += dataclass(name, own, definitions)

    for name in definitions:
        add(name)
    return source + tail


def formatted(source: str) -> str:
    """Return the source of a module as ruff writes it, without the imports that it does not need."""
    for command in (["check", "--fix", "--quiet", "--select", "F401,I"], ["format"]):
        ruff = [sys.executable, "-m", "ruff", *command, "--stdin-filename", str(FOLDER / "results.py"), "-"]
        source = subprocess.run(ruff, input=source, capture_output=True, check=True, text=True).stdout
    return source


if __name__ == "__main__":
    modules = {
        "results.py": module(STUDY, json.loads(_core.results_schema())),
        "vibration_results.py": module(VIBRATION, json.loads(_core.vibration_schema()), "\nKind = MotionKind\n"),
        "laws.py": laws(),
        "inputs.py": inputs(),
    }
    for name, source in modules.items():
        made = formatted(source)
        if "--check" not in sys.argv:
            (FOLDER / name).write_text(made, encoding="utf-8")
        elif (FOLDER / name).read_text(encoding="utf-8") != made:
            sys.exit(f"{FOLDER / name} is not current; run python {__file__}")
