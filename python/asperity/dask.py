"""Studies on a Dask cluster."""

from __future__ import annotations

import io
import os
import pathlib
import tempfile
import zipfile
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Literal

from asperity import _core
from asperity.interop import with_stated_distributions
from asperity.study import StudyResults, collect

if TYPE_CHECKING:
    from distributed import Client

_BLOCKS = ".asperity-blocks"
# Fewer new blocks per part are not worth another pass over the study.
_FEWEST = 4


def _packed(folder: pathlib.Path) -> bytes:
    """Return the block files below a folder as an archive."""
    target = io.BytesIO()
    root = folder / _BLOCKS
    with zipfile.ZipFile(target, "w") as archive:
        for file in sorted(root.glob("*/*.blocks")):
            archive.write(file, file.relative_to(root))
    return target.getvalue()


def _unpack(archive: bytes, folder: pathlib.Path) -> None:
    with zipfile.ZipFile(io.BytesIO(archive)) as files:
        files.extractall(folder / _BLOCKS)


def _part(source: Any, only: str | None, seed: int | None, part: tuple[int, int], known: bytes) -> bytes:
    """Compute a part on a worker and return its blocks; `known` holds those of earlier passes."""
    with tempfile.TemporaryDirectory() as folder:
        own = pathlib.Path(folder, "part")
        _unpack(known, pathlib.Path(folder))
        _core.study_part(source, only, seed, part, os.fspath(own), _core.__file__)
        return _packed(own)


def run(
    study: str | os.PathLike[str] | Mapping[str, Any],
    client: Client,
    *,
    only: Literal["surface", "pressure", "friction", "vibration", "verdict"] | None = None,
    seed: int | None = None,
    parts: int | None = None,
) -> StudyResults:
    """Run a study on the workers of a Dask cluster. The results are those of one machine, to the last bit.

    Each task computes a part of the blocks that can be computed: contact solutions, strips, batches of trajectories.
    The client joins them, and the next tasks compute the loops that need them, until too little is left to share; the
    rest is computed by the client. A task whose worker is lost runs again on another one. Dask's dashboard shows the
    tasks. The blocks travel as bytes; scans are read by every worker, from paths that it must see.

    Parameters
    ----------
    study, only, seed
        See `asperity.run_study`.
    client
        Client of the cluster. Workers have the same version of asperity and processors with the same instruction sets.
    parts
        Number of tasks of a pass; four per worker by default.

    Raises
    ------
    RuntimeError
        A worker has another version of asperity, or a processor with other instruction sets.
    """
    source: Any = with_stated_distributions(study) if isinstance(study, Mapping) else os.path.abspath(study)
    count = parts or 4 * max(1, len(client.scheduler_info(n_workers=-1)["workers"]))
    with tempfile.TemporaryDirectory() as folder:
        target, before = pathlib.Path(folder, "run"), -1
        blocks: list[bytes] = []
        while True:
            names = [pathlib.Path(folder, f"part-{number}") for number in range(len(blocks))]
            for name, archive in zip(names, blocks, strict=True):
                _unpack(archive, name)
            paths = [os.fspath(name) for name in names]
            found, done = _core.merge_parts(source, only, seed, paths, os.fspath(target), False, _core.__file__)
            if found is None and blocks and done - before < _FEWEST * count:
                if done == before:
                    raise RuntimeError("the workers have another build of asperity or other processors than the client")
                found, _ = _core.merge_parts(source, only, seed, [], os.fspath(target), True, _core.__file__)
            if found is not None:
                return collect(found)
            before = done
            known = client.scatter(_packed(pathlib.Path(folder)), broadcast=True)
            tasks = [
                client.submit(_part, source, only, seed, (number, count), known, pure=False)
                for number in range(1, count + 1)
            ]
            blocks = client.gather(tasks)
