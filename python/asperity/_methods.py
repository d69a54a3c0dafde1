"""Methods of results whose attributes are generated."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

import numpy as np

from asperity import _plots
from asperity._record import Record, frame, row

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.axes import Axes

    from asperity.results import CampaignResults
    from asperity.vibration_results import Ensemble, StabilityMap


class CampaignMethods(Record):
    """Methods of a campaign."""

    def to_dataframe(self) -> pandas.DataFrame:
        """Return the members as a data frame, a row each; the columns of their values have the names of the keys."""
        own = cast("CampaignResults", self)
        keys = [key.key for key in own.keys]
        return frame(dict(zip(keys, member.values, strict=True)) | row(member) for member in own.members).drop(
            columns="values"
        )


class MachineMethods(Record):
    """Methods of an answer about a machine, or of the answers about an array of machines.

    The attributes of the latter are arrays of its shape: numbers with NaN where they are undefined, flags and names.
    They are arrays of Dask if the machines are.
    """

    def to_dataframe(self) -> pandas.DataFrame:
        """Return a row per machine, in C order."""
        import pandas

        if np.ndim(next(iter(self._values().values()))) == 0:
            return super().to_dataframe()
        return pandas.DataFrame({name: np.ravel(np.asarray(values)) for name, values in self._values().items()})

    def to_xarray(self) -> xarray.Dataset:
        """Return the attributes as variables over the axes of the array, ``dim_0``, ``dim_1`` and so on."""
        import xarray

        units = {"units": "1"}
        values = {name: xarray.DataArray(value) for name, value in (self._values() | row(self)).items()}
        return xarray.Dataset(
            {name: value.assign_attrs(units if value.dtype.kind == "f" else {}) for name, value in values.items()}
        )


class EnsembleMethods(Record):
    """Methods of an ensemble."""

    def to_xarray(self) -> xarray.Dataset:
        """Return the samples of displacements and periods, each with its own dimension."""
        import xarray

        samples = {name: getattr(self, name).sample for name in ("reattachments", "releases", "periods")}
        return xarray.Dataset({name: (f"{name}_sample", own, {"units": "1"}) for name, own in samples.items()})

    def plot(self, *, ax: Axes | None = None) -> Axes:
        """Draw the distribution of the displacements at which the mass sticks again."""
        return _plots.ensemble(cast("Ensemble", self), ax)


class StabilityMapMethods(Record):
    """Methods of a stability map."""

    def to_dataframe(self) -> pandas.DataFrame:
        """Return the points as a data frame, a row each."""
        return frame(map(row, cast("StabilityMap", self).points))

    def plot(self, *, ax: Axes | None = None) -> Axes:
        """Draw the probability with its contours and the limit without fluctuation."""
        return _plots.stability_map(cast("StabilityMap", self), ax)
