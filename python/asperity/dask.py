"""Studies and campaigns on a Dask cluster."""

from __future__ import annotations

import io
import math
import os
import pathlib
import tempfile
import time
import zipfile
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Literal

from asperity import _core
from asperity.results import CampaignResults
from asperity.study import StudyResults, collect, request

if TYPE_CHECKING:
    from distributed import Client

_BLOCKS = ".asperity-blocks"
# After a pass that took less, the rest is not worth another one.
_SHORT_S = 2.0


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


def _part(
    asked: dict[str, Any], program: dict[str, Any], part: tuple[int, int], known: bytes | None, storage: str | None
) -> bytes | None:
    """Compute a part on a worker; return its blocks or leave them in `storage`. `known` are those of earlier passes."""
    if _core.module_program(_core.__file__) != program:
        raise RuntimeError("a worker has another build of asperity, or another processor, than the client")
    asked = asked | {"library": _core.__file__}
    name = f"part-{part[0]}"
    if storage is not None:
        _core.study_part(asked, part, os.path.join(storage, name))
        return None
    with tempfile.TemporaryDirectory() as folder:
        if known is not None:
            _unpack(known, pathlib.Path(folder))
        _core.study_part(asked, part, os.path.join(folder, name))
        return _packed(pathlib.Path(folder, name))


def run(
    study: str | os.PathLike[str] | Mapping[str, Any],
    client: Client,
    *,
    only: Literal["surface", "pressure", "friction", "vibration", "verdict"] | None = None,
    seed: int | None = None,
    parts: int | None = None,
    storage: str | os.PathLike[str] | None = None,
) -> StudyResults | CampaignResults:
    """Run a study or a campaign on the workers of a Dask cluster. The results are those of one machine, bit by bit.

    Each task computes a part of the blocks that can be computed: members of a campaign, contact solutions, strips,
    batches of trajectories. The client joins them, and the next tasks compute the loops that need them, until too
    little is left to share; the rest is computed by the client. A task whose worker is lost runs again on another one.
    Dask's dashboard shows the tasks. Every worker reads the file and its scans, from paths that it must see.

    Parameters
    ----------
    study
        Study or campaign file, or a study as a dictionary.
    client
        Client of the cluster. Workers have the same build of asperity and processors with the same instruction sets.
    only, seed
        See `asperity.run_study`.
    parts
        Number of tasks of a pass; four per worker by default.
    storage
        Folder that client and workers see, for finished blocks: a run that was interrupted goes on from them. Without
        it blocks travel as bytes.

    Raises
    ------
    RuntimeError
        A worker has another build of asperity, or a processor with other instruction sets.
    """
    asked = request(study if isinstance(study, Mapping) else os.path.abspath(study), only, seed)
    program = _core.module_program(_core.__file__)
    count = parts or 4 * max(1, len(client.scheduler_info(n_workers=-1)["workers"]))
    shared = None if storage is None else os.path.abspath(storage)
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary if shared is None else shared)
        folder.mkdir(parents=True, exist_ok=True)
        target, before, took_s = os.fspath(folder / "run"), -1, math.inf
        while True:
            paths = [os.fspath(path) for path in sorted(folder.glob("part-*")) if (path / _BLOCKS).exists()]
            found, done = _core.merge_parts(asked, paths, target, False)
            if found is None and (done == before or took_s < _SHORT_S):
                found, _ = _core.merge_parts(asked, [], target, True)
            if found is not None:
                return collect(found)
            before, start = done, time.monotonic()
            known = None if shared else client.scatter(_packed(folder), broadcast=True)
            tasks = [
                client.submit(_part, asked, program, (number, count), known, shared, pure=False)
                for number in range(1, count + 1)
            ]
            for number, blocks in enumerate(client.gather(tasks), start=1):
                if blocks is not None:
                    _unpack(blocks, folder / f"part-{number}")
            took_s = time.monotonic() - start
