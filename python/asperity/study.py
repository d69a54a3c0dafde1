"""Runs of whole studies: surface, pressure, friction, vibration and verdict."""

from __future__ import annotations

import html
import os
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from asperity import _core, _plots, inputs
from asperity._progress import Progress, callback
from asperity._record import ByValue, Record, equal
from asperity._section import Section, stated_study, with_folder
from asperity.errors import warn
from asperity.friction import FrictionProcess
from asperity.inputs import Friction, Material, Pressure, Sections, Surface, Vibration
from asperity.results import CampaignResults, FrictionResult, PressureResult, Results, VerdictResult
from asperity.surface import HeightMap, field_to_xarray

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.axes import Axes


class Table(dict[str, NDArray[np.float64] | list[str]]):
    """Columns of equal length by name; rows may have names in the column ``name``."""

    def __eq__(self, other: object) -> bool:
        return equal(self, other)

    def __ne__(self, other: object) -> bool:
        return not self == other

    __hash__ = None

    def to_dataframe(self) -> pandas.DataFrame:
        """Return the table as a data frame."""
        import pandas

        return pandas.DataFrame(self)


@dataclass(frozen=True, eq=False)
class Field(ByValue):
    """Values on a grid, shape (ny, nx), NaN where undefined."""

    name: str
    values: NDArray[np.float64]
    dx_m: float
    dy_m: float
    unit: str

    def to_xarray(self) -> xarray.DataArray:
        """Return the field with the coordinates of the cell centres."""
        return field_to_xarray(self.values, self.dx_m, self.dy_m, name=self.name, unit=self.unit)

    def plot(self, *, ax: Axes | None = None) -> Axes:
        """Draw the field."""
        name = self.name.replace("_", " ")
        return _plots.field(self.values, self.dx_m, self.dy_m, name=name, unit=self.unit, ax=ax)


@dataclass(frozen=True, kw_only=True, eq=False)
class StudyResults(Results):
    """Results of a run: the content of ``results.json``, with the tables and fields of the run folder."""

    tables: Mapping[str, Table] = field(default_factory=dict, repr=False)
    """Tables by name, as in ``tables/``."""
    fields: Mapping[str, Field] = field(default_factory=dict, repr=False)
    """Fields by name, as in ``fields/``."""
    friction_process: FrictionProcess | None = field(default=None, repr=False)
    """Friction process at the operating point, as in ``friction_process.json``."""
    summary: list[str] = field(default_factory=list, repr=False)
    """The answer in sentences, as ``asperity run`` prints it; empty without a machine."""

    def _repr_html_(self) -> str:
        sentences = "".join(f"<p>{html.escape(sentence)}</p>" for sentence in self.summary)
        rows = "".join(
            f"<tr><th>{html.escape(name)}</th><td>{value:.4g}</td></tr>" for name, value in self._main().items()
        )
        rest = super()._repr_html_().replace("<details open>", "<details>", 1)
        return f"{sentences}<table>{rows}</table>{_plots.first_figure(self)}{rest}"

    def _main(self) -> dict[str, float]:
        """Return up to six numbers of the answer."""
        covariance = self.surface.covariance if self.surface else None
        point = self.friction.operating_point if self.friction else None
        found = {
            "rms height (m)": covariance.std_m if covariance else None,
            "probability of contact": self.pressure.contact_probability if self.pressure else None,
            "friction coefficient": point.mean if point else None,
            "its standard deviation over windows": point.std if point else None,
            "damping ratio at which vibration ends": self.verdict.nominal.limit_damping_ratio if self.verdict else None,
            "probability of vibration": self.verdict.probability if self.verdict else None,
        }
        return {name: value for name, value in found.items() if value is not None}

    def to_xarray(self) -> xarray.Dataset:
        """Return the fields; each has its own coordinates, as their grids may differ."""
        import xarray

        renamed = (own.to_xarray().rename(x=f"x_{name}", y=f"y_{name}") for name, own in sorted(self.fields.items()))
        return xarray.Dataset({str(array.name): array for array in renamed})

    def plot(self, figure: _plots.StudyFigure, *, ax: Axes | None = None) -> Axes:
        """Draw a figure of the run; the report has them all.

        Raises
        ------
        ValueError
            The run has no results for this figure. The message lists the figures that can be drawn.
        """
        return _plots.study_figure(self, figure, ax)


_SECTIONS: dict[str, type[Section]] = {name.lower(): getattr(inputs, name) for name in inputs.__all__}
# Attributes of sections whose names are those of methods.
_FIELDS = {"verdict": "verdict_plan"}


@dataclass(frozen=True, kw_only=True, eq=False)
class Study(Sections):
    """A study: inputs, uncertainty and plan as sections, named as in a study file; `verdict_plan` is ``[verdict]``.

    It is checked when it is created. It does not change: `with_values` returns another one.

    Raises
    ------
    ValueError
        A key or value is wrong, or a section lacks one that it needs.

    Examples
    --------
    >>> import asperity
    >>> from asperity.inputs import Surface
    >>> surface = Surface(covariance="exponential", rms_height=1e-6, correlation_length=20e-6, marginal="normal")
    >>> study = asperity.Study(seed=7, surface=surface)
    >>> study.with_values(rms_height=2e-6).run(progress=False).surface.covariance.std_m
    2e-06
    """

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, kind in _SECTIONS.items():
            own = getattr(self, _FIELDS.get(name, name))
            if own is not None and not isinstance(own, kind):
                found = type(own).__name__
                raise TypeError(f"{name}: found {found}, expected asperity.inputs.{kind.__name__}; see Study.from_dict")
        _core.check_inputs(self.to_dict())

    @classmethod
    def from_dict(cls, sections: Mapping[str, Any]) -> Study:
        """Create a study from dictionaries, one for each section.

        Parameters
        ----------
        sections
            Sections of a study file; quantities are texts with units.

        Raises
        ------
        ValueError
            A key or value is wrong.

        Examples
        --------
        >>> import asperity
        >>> surface = {"covariance": "exponential", "rms_height": "1 um", "correlation_length": "20 um"}
        >>> asperity.Study.from_dict({"seed": 7, "surface": {**surface, "marginal": "normal"}}).seed
        7
        """
        _core.check_inputs(stated_study(sections))
        own: dict[str, Any] = {
            key: _SECTIONS[key](**value) if key in _SECTIONS else value for key, value in sections.items()
        }
        return cls(**{_FIELDS.get(key, key): value for key, value in own.items()})

    def to_dict(self) -> dict[str, Any]:
        """Return the study as dictionaries, one for each section.

        Examples
        --------
        >>> import asperity
        >>> surface = {"covariance": "exponential", "rms_height": "1 um", "correlation_length": "20 um"}
        >>> asperity.Study.from_dict({"seed": 7, "surface": {**surface, "marginal": "normal"}}).to_dict()["seed"]
        7
        """
        names = {field: key for key, field in _FIELDS.items()}
        return {names.get(key, key): value for key, value in super().to_dict().items()}

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> Study:
        """Read a study file. Its relative paths become absolute.

        Parameters
        ----------
        path
            Study file.

        Raises
        ------
        OSError
            The file cannot be read.
        ValueError
            The file is no study, or a key or value is wrong; the message states the line.

        Examples
        --------
        >>> import asperity
        >>> asperity.Study.read("studies/quickstart.toml").vibration.mass  # doctest: +SKIP
        '15 kg'
        """
        file = os.path.abspath(path)
        return cls.from_dict(with_folder(_core.read_study(file), os.path.dirname(file)))

    def to_toml(self) -> str:
        """Return the text of a study file; a `HeightMap` is a file that the end of the process removes.

        Examples
        --------
        >>> import asperity
        >>> surface = {"covariance": "exponential", "rms_height": "1 um", "correlation_length": "20 um"}
        >>> study = asperity.Study.from_dict({"seed": 7, "surface": {**surface, "marginal": "normal"}})
        >>> study.to_toml().splitlines()[0]
        'seed = 7'
        """
        return _core.toml_of(self.to_dict())

    def with_values(self, **values: Any) -> Study:
        """Return the study with another seed or name, or with other values of keys of its sections.

        Parameters
        ----------
        values
            Values by key; None removes one. A key of several sections, such as ``boundary``, is stated as
            ``friction__boundary``.

        Raises
        ------
        ValueError
            No section of the study has the key, several have, or a value is wrong.

        Examples
        --------
        >>> import asperity
        >>> surface = {"covariance": "exponential", "rms_height": "1 um", "correlation_length": "20 um"}
        >>> study = asperity.Study.from_dict({"seed": 7, "surface": {**surface, "marginal": "normal"}})
        >>> study.with_values(rms_height="2 um").surface.rms_height
        '2 um'
        """
        own = {key: getattr(self, _FIELDS.get(key, key)) for key in _SECTIONS}
        changed = {key: section for key, section in own.items() if section is not None}
        above: dict[str, Any] = {name: values[name] for name in ("seed", "name") if name in values}
        unstated = set(self.unstated or ())
        for name, value in values.items():
            if name in above:
                continue
            section, _, key = name.rpartition("__")
            having = [own for own in changed if section in ("", own) and key in changed[own]._names()]
            if len(having) != 1:
                found = f"the sections {', '.join(having)} have" if having else "no section of the study has"
                raise ValueError(f"{found} the key {key}; state SECTION__{key} of a section that the study has")
            changed[having[0]] = replace(changed[having[0]], **{key: value})
            unstated.discard(f"{having[0]}.{key}")
        if self.unstated is not None:
            above["unstated"] = [name for name in self.unstated if name in unstated]
        return replace(self, **above, **{_FIELDS.get(key, key): section for key, section in changed.items()})

    def check(self) -> StudyCheck:
        """Return what the study computes, what it costs, and what is wrong with it, without computing results.

        Examples
        --------
        >>> import asperity
        >>> surface = {"covariance": "exponential", "rms_height": "1 um", "correlation_length": "20 um"}
        >>> study = asperity.Study.from_dict({"seed": 7, "surface": {**surface, "marginal": "normal"}})
        >>> study.check().problems
        []
        """
        return StudyCheck(**_core.check_study(request(self, None, None)))

    def run(self, **options: Any) -> StudyResults:
        """Run the study.

        Parameters
        ----------
        options
            Those of `run_study`, which also lists the errors.

        Examples
        --------
        >>> import asperity
        >>> surface = {"covariance": "exponential", "rms_height": "1 um", "correlation_length": "20 um"}
        >>> study = asperity.Study.from_dict({"seed": 7, "surface": {**surface, "marginal": "normal"}})
        >>> study.run(progress=False).surface.covariance.std_m
        1e-06
        """
        return run_study(self, **options)

    def verdict(self, **options: Any) -> VerdictResult:
        """Return the probability of vibration.

        Parameters
        ----------
        options
            Those of `verdict`, which also lists the errors.

        Examples
        --------
        >>> import asperity
        >>> machine = {"mass": "1 kg", "natural_frequency": "50 Hz", "normal_force": "100 N", "nominal_area": "1 cm^2"}
        >>> friction = {"static_friction": 0.4, "stribeck": "0.5 s/m", "friction_std": 0}
        >>> vibration = {**machine, **friction, "belt_velocity": "20 mm/s", "damping_ratio": "0.01 ± 0.002"}
        >>> study = asperity.Study.from_dict({"seed": 1, "vibration": vibration})
        >>> study.verdict(progress=False).probability
        1.0
        """
        return verdict(self, **options)


@dataclass(frozen=True, eq=False)
class StudyCheck(Record):
    """What a study computes and costs, as `asperity check` shows it."""

    stages: list[dict[str, Any]]
    """Stages with their ``contact_solutions``, ``core_s`` and ``memory_bytes``."""
    warnings: list[str]
    """Warnings."""
    problems: list[str]
    """Reasons why the study cannot run; empty if it can."""


def run_study(
    study: Study | str | os.PathLike[str] | Mapping[str, Any],
    *,
    only: Literal["surface", "pressure", "friction", "vibration", "verdict"] | None = None,
    seed: int | None = None,
    progress: Progress = True,
    out: str | os.PathLike[str] | None = None,
) -> StudyResults:
    """Run a study. The results are those of ``asperity run``, to the last bit.

    Parameters
    ----------
    study
        A `Study`, a study file, or its content as a dictionary, in which quantities are texts with units, such as
        ``"210 GPa"``. Paths in a file are relative to it, those in a dictionary or a `Study` to the working folder
        when it runs. In a dictionary a scan may be a `HeightMap` and a file a `pathlib.Path`; an uncertain number may
        be a distribution of SciPy or OpenTURNS, an uncertain quantity the result of `asperity.uncertain`.
    only
        Compute this stage and the stages that it needs.
    seed
        Seed to use instead of the study's.
    progress
        True shows progress on a terminal or in a notebook. A function is called with the task, the number of blocks
        done and the number of all blocks.
    out
        Folder to write, with tables, figures and a report; it must not exist. An interrupted run goes on from its
        finished blocks when it is run again with the same folder.

    Raises
    ------
    ValueError
        A key or value of the study is wrong.
    NotConvergedError
        Too few samples are valid.
    ResourceError
        The study needs more memory than is free.

    Warns
    -----
    AsperityWarning
        For each of the `warnings` of the results.

    Examples
    --------
    >>> import asperity
    >>> surface = {"covariance": "exponential", "rms_height": "1 um", "correlation_length": "20 um"}
    >>> found = asperity.run_study({"seed": 7, "surface": {**surface, "marginal": "normal"}})
    >>> found.surface.covariance.std_m
    1e-06
    """
    sections = (study.surface, study.counterface) if isinstance(study, Study) and out is not None else ()
    if any(isinstance(own, HeightMap) for section in sections if section for own in section._maps()):
        warn(
            "the folder names a file of the map that the end of this process removes; write the map and state its file"
        )
    found = _core.compute(
        request(study, only, seed), False, callback(progress), None if out is None else os.fspath(out)
    )
    results = collect(found)
    assert isinstance(results, StudyResults)
    return results


def run_campaign(
    campaign: str | os.PathLike[str],
    *,
    seed: int | None = None,
    progress: Progress = True,
    out: str | os.PathLike[str] | None = None,
) -> CampaignResults:
    """Run a campaign: one study over lists, grids and samples of its values, and over scans.

    Parameters
    ----------
    campaign
        Campaign file.
    seed, progress, out
        See `run_study`.

    Raises
    ------
    ValueError
        A key or value of the campaign or of its study is wrong.
    ResourceError
        A member needs more memory than is free.

    Examples
    --------
    >>> import asperity
    >>> found = asperity.run_campaign("campaign.toml", out="runs/campaign")  # doctest: +SKIP
    >>> found.to_dataframe()  # doctest: +SKIP
    """
    found = _core.compute(
        request(campaign, None, seed), True, callback(progress), None if out is None else os.fspath(out)
    )
    results = collect(found)
    assert isinstance(results, CampaignResults)
    return results


def request(
    source: Study | str | os.PathLike[str] | Mapping[str, Any], only: str | None, seed: int | None
) -> dict[str, Any]:
    """Return what the compiled module is asked for."""
    if isinstance(source, Study):
        source = source.to_dict()
    given: Any = stated_study(source) if isinstance(source, Mapping) else os.fspath(source)
    return {"source": given, "only": only, "seed": seed, "library": _core.__file__}


def collect(found: Mapping[str, Any]) -> StudyResults | CampaignResults:
    """Return the results from the parts that the compiled module returns, and issue their warnings."""
    if "campaign" in found:
        campaign = CampaignResults.from_dict(found["campaign"])
        for message in campaign.warnings:
            warn(message)
        for own in campaign.member_warnings:
            warn(f"{own.warning} ({len(own.members)} of {len(campaign.members)} members)")
        return campaign
    results = StudyResults.from_dict(found["results"])
    for message in results.warnings:
        warn(message)
    tables = {name: Table(columns) for name, columns in found["tables"].items()}
    fields = {name: Field(name, *parts) for name, parts in found["fields"].items()}
    process = found["friction_process"] and FrictionProcess.from_dict(found["friction_process"])
    for name, value in (
        ("tables", tables),
        ("fields", fields),
        ("friction_process", process),
        ("summary", found["summary"]),
    ):
        object.__setattr__(results, name, value)
    return results


def cite(run: str | os.PathLike[str], *, bibtex: bool = False) -> list[str]:
    """Return the papers behind the methods that a run used, as ``asperity cite`` prints them.

    Parameters
    ----------
    run
        Folder of a finished run.
    bibtex
        Entries of BibTeX instead of sentences.

    Raises
    ------
    OSError
        The folder cannot be read.
    ValueError
        The folder has no finished run.

    Examples
    --------
    >>> import asperity, pathlib, tempfile
    >>> surface = {"covariance": "exponential", "rms_height": "1 um", "correlation_length": "20 um"}
    >>> study = asperity.Study.from_dict({"seed": 7, "surface": {**surface, "marginal": "normal"}})
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = study.run(out=pathlib.Path(folder, "run"), progress=False)
    ...     asperity.cite(pathlib.Path(folder, "run"))[0].partition(":")[0]
    'N. Gaus, C. Proppe, C. Zaccardi'
    """
    return _core.cite(run, bibtex)


def _study(surface: Any, seed: int | None, **sections: Section | None) -> Any:
    """Return the study of a surface and other sections, or what is one already."""
    if isinstance(surface, HeightMap):
        surface = Surface(file=surface)
    if not isinstance(surface, Surface):
        if any(sections.values()):
            raise TypeError(f"found {type(surface).__name__} with sections, expected a Surface or a HeightMap")
        return surface
    return Study(seed=1 if seed is None else seed, surface=surface, **sections)  # type: ignore[arg-type]


def pressure_distribution(
    surface: Surface | HeightMap | Study | str | os.PathLike[str] | Mapping[str, Any],
    material: Material | None = None,
    pressure: Pressure | None = None,
    *,
    seed: int | None = None,
    progress: Progress = True,
) -> PressureResult:
    """Return the distribution of the contact pressure of a random surface: the pressure stage of a study.

    Parameters
    ----------
    surface, material, pressure
        Sections of a study; instead of a `Surface` a map, of which the surface has the statistics. Or a whole study in
        place of the surface.
    seed, progress
        See `run_study`; the seed of sections is 1 if it is left out.

    Raises
    ------
    ValueError
        A key or value is wrong.
    NotConvergedError
        Too few samples are valid.

    Examples
    --------
    >>> import asperity
    >>> from asperity.inputs import Material, Pressure, Surface
    >>> surface = Surface(covariance="exponential", rms_height=1e-6, correlation_length=20e-6, marginal="normal")
    >>> plan = Pressure(size=(128e-6, 128e-6), points=(16, 16), mean_pressure=2e6, boundary="periodic", fine_solves=20)
    >>> found = asperity.pressure_distribution(surface, Material(youngs_modulus=10e9), plan, progress=False)
    >>> 0 < found.contact_probability < 1
    True
    """
    study = _study(surface, seed, material=material, pressure=pressure)
    found = run_study(study, only="pressure", seed=seed, progress=progress).pressure
    assert found is not None
    return found


def friction_distribution(
    surface: Surface | HeightMap | Study | str | os.PathLike[str] | Mapping[str, Any],
    material: Material | None = None,
    friction: Friction | None = None,
    *,
    pressure: Pressure | None = None,
    vibration: Vibration | None = None,
    seed: int | None = None,
    progress: Progress = True,
) -> FrictionResult:
    """Return the friction coefficient of windows that slide over a random surface: the friction stage of a study.

    Parameters
    ----------
    surface, material, friction, pressure, vibration
        Sections of a study; instead of a `Surface` a map, of which the surface has the statistics. Or a whole study in
        place of the surface. `pressure` has the boundary and the operating point, `vibration` the nominal pressure.
    seed, progress
        See `run_study`; the seed of sections is 1 if it is left out.

    Raises
    ------
    ValueError
        A key or value is wrong.
    NotConvergedError
        Too few samples are valid.

    Examples
    --------
    >>> import asperity
    >>> found = asperity.friction_distribution("studies/quickstart.toml")  # doctest: +SKIP
    >>> found.operating_point.mean, found.operating_point.std  # doctest: +SKIP
    """
    study = _study(surface, seed, material=material, friction=friction, pressure=pressure, vibration=vibration)
    found = run_study(study, only="friction", seed=seed, progress=progress).friction
    assert found is not None
    return found


def verdict(
    study: Study | str | os.PathLike[str] | Mapping[str, Any], *, seed: int | None = None, progress: Progress = True
) -> VerdictResult:
    """Return the probability that a machine vibrates, over the uncertain values of a study.

    Parameters
    ----------
    study, seed, progress
        See `run_study`.

    Raises
    ------
    ValueError
        A key or value of the study is wrong, or it has no machine.

    Examples
    --------
    >>> import asperity
    >>> machine = {"mass": "1 kg", "natural_frequency": "50 Hz", "normal_force": "100 N", "nominal_area": "1 cm^2"}
    >>> friction = {"static_friction": 0.4, "stribeck": "0.5 s/m", "friction_std": 0}
    >>> vibration = {**machine, **friction, "belt_velocity": "20 mm/s", "damping_ratio": "0.01 ± 0.002"}
    >>> asperity.verdict({"seed": 1, "vibration": vibration}, progress=False).probability
    1.0
    """
    found = run_study(study, only="verdict", seed=seed, progress=progress).verdict
    assert found is not None
    return found
