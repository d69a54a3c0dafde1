"""Every public function states its arguments, shapes and errors, and has an example."""

import inspect

import pytest

import asperity
import asperity.dask
import asperity.figures

# Methods of all results, whose module explains them; users rarely call the first.
OF_RESULTS = {"from_dict", "to_dict", "to_dataframe", "to_xarray"}
# Without arguments that could be wrong.
WITHOUT_ERRORS = {
    "ContactSolution.to_dataframe",
    "ContactSolution.to_xarray",
    "Expansion.sobol_indices",
    "HeightMap.plot",
    "HeightMap.to_surfacetopography",
    "HeightMap.to_surfalize",
    "HeightMap.to_xarray",
    "Study.check",
    "Study.to_dict",
    "Study.to_toml",
    "Trajectory.plot",
}
# Made by these; the docstring says so.
ERRORS_ELSEWHERE = {"Study.run": "run_study", "Study.verdict": "verdict", "dask.verdict": "run"}


def functions():
    """Return the public functions and methods by name."""
    modules = {"": asperity, "dask.": asperity.dask, "figures.": asperity.figures}
    named = {f"{prefix}{name}": getattr(module, name) for prefix, module in modules.items() for name in dir(module)}
    found = {}
    for name, own in named.items():
        if name.rpartition(".")[2].startswith("_") or not getattr(own, "__module__", "").startswith("asperity"):
            continue
        if inspect.isfunction(own) and ("." not in name or own.__module__ == f"asperity.{name.partition('.')[0]}"):
            found[name] = own
        if inspect.isclass(own) and "." not in name:
            for method, value in inspect.getmembers(own, inspect.isfunction):
                if not method.startswith("_") and not (method in OF_RESULTS and method not in vars(own)):
                    found[f"{name}.{method}"] = value
    return found | {"Trajectory.plot": asperity.vibration.Trajectory.plot}


FUNCTIONS = functions()


def test_all_functions_are_found():
    assert {"solve_contact", "HeightMap.level", "Spectral.sample", "Study.run", "dask.run", "figures.figure_2"} <= {
        *FUNCTIONS
    }
    assert {*WITHOUT_ERRORS, *ERRORS_ELSEWHERE} <= {*FUNCTIONS}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_docstring_states_arguments_shapes_errors_and_an_example(name):
    function = FUNCTIONS[name]
    doc = inspect.getdoc(function) or ""
    arguments = [own for own in inspect.signature(function).parameters if own not in ("self", "cls")]
    assert ">>> " in doc.partition("Examples\n--------\n")[2]
    assert not arguments or "Parameters\n----------\n" in doc
    described = doc.partition("Parameters\n----------\n")[2].partition("Examples\n")[0]
    listed = {own.strip() for line in described.splitlines() if not line.startswith(" ") for own in line.split(",")}
    assert {*arguments} <= listed
    takes_arrays = any("ArrayLike" in str(own) or "NDArray" in str(own) for own in function.__annotations__.values())
    assert not takes_arrays or "shape" in doc or "array" in doc
    assert ("Raises\n------\n" in doc) == (name not in {*WITHOUT_ERRORS, *ERRORS_ELSEWHERE})
    assert ERRORS_ELSEWHERE.get(name, "") in doc
