"""Runs of whole studies: surface, pressure, friction, vibration and verdict."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from asperity import _core, _plots
from asperity._progress import Progress, callback
from asperity._record import ByValue, equal
from asperity.errors import warn
from asperity.friction import FrictionProcess
from asperity.interop import with_stated_distributions
from asperity.results import CampaignResults, PressureResult, Results, VerdictResult
from asperity.surface import field_to_xarray

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


def run_study(
    study: str | os.PathLike[str] | Mapping[str, Any],
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
        Study file, or its content as a dictionary. Quantities are texts with units, such as ``"210 GPa"``. Paths in a
        file are relative to it, those in a dictionary to the working directory. An uncertain number may be a
        distribution of OpenTURNS, an uncertain quantity the result of `asperity.uncertain`.
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
    """
    found = _core.compute(
        request(campaign, None, seed), True, callback(progress), None if out is None else os.fspath(out)
    )
    results = collect(found)
    assert isinstance(results, CampaignResults)
    return results


def request(source: str | os.PathLike[str] | Mapping[str, Any], only: str | None, seed: int | None) -> dict[str, Any]:
    """Return what the compiled module is asked for."""
    given: Any = with_stated_distributions(source) if isinstance(source, Mapping) else os.fspath(source)
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
    for name, value in (("tables", tables), ("fields", fields), ("friction_process", process)):
        object.__setattr__(results, name, value)
    return results


def pressure_distribution(
    study: str | os.PathLike[str] | Mapping[str, Any], *, seed: int | None = None, progress: Progress = True
) -> PressureResult:
    """Return the distribution of the contact pressure of a random surface: the pressure stage of a study.

    The study has the sections ``surface``, ``material`` and ``pressure``; see `run_study` for the parameters, and for
    tables and fields.
    """
    found = run_study(study, only="pressure", seed=seed, progress=progress).pressure
    assert found is not None
    return found


def verdict(
    study: str | os.PathLike[str] | Mapping[str, Any], *, seed: int | None = None, progress: Progress = True
) -> VerdictResult:
    """Return the probability that a machine vibrates, over the uncertain values of a study; see `run_study`."""
    found = run_study(study, only="verdict", seed=seed, progress=progress).verdict
    assert found is not None
    return found
