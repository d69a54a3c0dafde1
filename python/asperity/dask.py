"""Studies and campaigns on a Dask cluster."""

from __future__ import annotations

import io
import os
import pathlib
import queue
import signal
import tempfile
import threading
import time
import zipfile
from collections.abc import Callable, Iterable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, overload

from asperity import _core
from asperity._progress import Progress, callback
from asperity.results import CampaignResults, VerdictResult
from asperity.study import Study, StudyResults, collect, request

if TYPE_CHECKING:
    from distributed import Client

_BLOCKS = ".asperity-blocks"
# Seconds until the workers begin a loop.
_START_S = 1.0
# Seconds without a finished task, beyond the time of the client alone, after which the client goes on alone.
_PATIENCE_S = 10.0


def _packed(folder: pathlib.Path, stages: Iterable[str] = ("*",)) -> bytes:
    """Return the block files beside a run, of some stages or of all, as an archive."""
    target = io.BytesIO()
    root = folder / _BLOCKS
    with zipfile.ZipFile(target, "w") as archive:
        for stage in stages:
            for file in sorted(root.glob(f"{stage}/*.blocks")):
                archive.write(file, file.relative_to(root))
    return target.getvalue()


def _unpack(archive: bytes, folder: pathlib.Path) -> None:
    with zipfile.ZipFile(io.BytesIO(archive)) as files:
        files.extractall(folder / _BLOCKS)


def _build(program: Mapping[str, Any]) -> str:
    return f"{program['sha256'][:12]} ({', '.join([*program['instruction_sets'], program['functions'][:12]])})"


def _part(
    asked: dict[str, Any], program: dict[str, Any], part: tuple[int, int], known: bytes | None, storage: str | None
) -> bytes | None:
    """Compute a part on a worker; return its blocks or leave them in `storage`. `known` are those of earlier loops."""
    from distributed import get_worker

    worker = get_worker()
    own = _core.module_program(_core.__file__)
    if own != program:
        raise RuntimeError(
            f"worker {worker.address} has another build of asperity, or another processor, than the client: "
            f"{_build(own)} instead of {_build(program)}"
        )
    # The threads of a process start with its first computation, and stay.
    os.environ.setdefault("RAYON_NUM_THREADS", str(worker.state.nthreads))
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


def _ignore_interrupts(client: int) -> None:
    """Ignore Ctrl-C in a worker process of a process, which cancels the tasks itself."""
    if os.getppid() == client and threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGINT, signal.SIG_IGN)


def _threads(client: Client) -> int:
    """Return the number of threads of all workers; on this machine, not more than its processors."""
    from distributed.utils import get_ip

    here = {"127.0.0.1", "::1", "localhost", get_ip()}  # type: ignore[no-untyped-call]
    own, others = 0, 0
    for worker in client.scheduler_info(n_workers=-1)["workers"].values():
        if worker["host"] in here:
            own += int(worker["nthreads"])
        else:
            others += int(worker["nthreads"])
    return min(own, os.cpu_count() or own) + others


@dataclass(frozen=True)
class _Run:
    client: Client
    asked: dict[str, Any]
    parts: int | None
    storage: str | None
    report: Callable[[str, int, int], object] | None
    out: str | None

    def compute(self) -> StudyResults | CampaignResults:
        """Compute on the client, and share the loops that it leaves."""
        alone = False
        with tempfile.TemporaryDirectory(prefix="asperity-", ignore_cleanup_errors=True) as temporary:
            folder = pathlib.Path(self.storage or temporary)
            folder.mkdir(parents=True, exist_ok=True)
            # Without storage an interrupted run goes on from the blocks beside its folder, as on one machine.
            target = pathlib.Path(folder / "run" if self.storage or self.out is None else self.out)
            while True:
                threads = 0 if alone else _threads(self.client)
                parts = sorted(folder.glob("part-*"))
                found, left = _core.compute_or_leave(
                    self.asked, self.report, target, self.out, parts, threads, self.parts, _START_S
                )
                if left is None:
                    assert found is not None
                    return collect(found)
                alone = not self.share(left, target.parent, folder)

    def share(self, left: Mapping[str, Any], blocks: pathlib.Path, folder: pathlib.Path) -> bool:
        """Compute a loop on the workers into parts in `folder`. Return False if they do not finish a task in time."""
        # Only needed for workers that the client's terminal interrupts too.
        self.client.run(_ignore_interrupts, os.getpid(), on_error="ignore")
        known = None
        if self.storage is None:
            known = self.client.scatter(_packed(blocks, left["folders"]), broadcast=True, hash=False)
        # The other stages are not needed.
        asked, count = self.asked | {"only": left["only"]}, left["parts"]
        program = _core.module_program(_core.__file__)
        tasks = {
            self.client.submit(_part, asked, program, (number, count), known, self.storage, pure=False): number
            for number in range(1, count + 1)
        }
        finished: queue.SimpleQueue[Any] = queue.SimpleQueue()
        for task in tasks:
            task.add_done_callback(finished.put)
        last = time.monotonic()
        try:
            while tasks and time.monotonic() - last < left["left_s"] + _PATIENCE_S:
                try:
                    # Short waits, so that Ctrl-C ends them on all systems.
                    task = finished.get(timeout=0.2)
                except queue.Empty:
                    continue
                archive, number, last = task.result(), tasks.pop(task), time.monotonic()
                if archive is not None:
                    _unpack(archive, folder / f"part-{number}")
                if self.report is not None:
                    self.report(f"{left['name']}: tasks", count - len(tasks), count)
            return not tasks
        finally:
            self.client.cancel([*tasks])


@overload
def run(
    study: Study | str | os.PathLike[str] | Mapping[str, Any],
    client: Client,
    *,
    only: Literal["surface", "pressure", "friction", "vibration", "verdict"] | None = None,
    seed: int | None = None,
    parts: int | None = None,
    storage: str | os.PathLike[str] | None = None,
    progress: Progress = True,
    out: str | os.PathLike[str] | None = None,
    wait: Literal[False],
) -> Future[StudyResults | CampaignResults]: ...


@overload
def run(
    study: Study | str | os.PathLike[str] | Mapping[str, Any],
    client: Client,
    *,
    only: Literal["surface", "pressure", "friction", "vibration", "verdict"] | None = None,
    seed: int | None = None,
    parts: int | None = None,
    storage: str | os.PathLike[str] | None = None,
    progress: Progress = True,
    out: str | os.PathLike[str] | None = None,
    wait: Literal[True] = True,
) -> StudyResults | CampaignResults: ...


def run(
    study: Study | str | os.PathLike[str] | Mapping[str, Any],
    client: Client,
    *,
    only: Literal["surface", "pressure", "friction", "vibration", "verdict"] | None = None,
    seed: int | None = None,
    parts: int | None = None,
    storage: str | os.PathLike[str] | None = None,
    progress: Progress = True,
    out: str | os.PathLike[str] | None = None,
    wait: bool = True,
) -> StudyResults | CampaignResults | Future[StudyResults | CampaignResults]:
    """Run a study or a campaign on the workers of a Dask cluster. The results are those of one machine, bit by bit.

    The client computes, and measures each loop for half a second: contact solutions, strips, batches of trajectories,
    members of a campaign. It leaves the rest of a loop to the workers if they need less than 80 % of its own time,
    including what each task repeats. A cluster on the client's machine with as many threads therefore computes nothing,
    and the run takes as long as `asperity.run_study`. A task has at least a second of work and eight times the work
    that it repeats. A task whose worker is lost runs again on another one. If no task finishes for 10 s longer than the
    client needs for the loop, the client goes on alone.

    Dask's dashboard shows the tasks. Every worker reads the file and its scans, from paths that it must see. A worker
    process computes with as many threads as Dask assigns to it (``nthreads``), unless ``RAYON_NUM_THREADS`` is set in
    its environment. That variable also sets the threads of the client.

    Parameters
    ----------
    study
        A `Study`, a study or campaign file, or a study as a dictionary.
    client
        Client of the cluster. Workers have the same build of asperity and processors with the same instruction sets.
        Those that are not there yet are not counted; see `Client.wait_for_workers`.
    only, seed, out
        See `asperity.run_study`.
    parts
        Number of tasks of a loop that is left to the workers; by default it follows from the work.
    storage
        Folder that client and workers see, for finished blocks: a run that was interrupted goes on from them. Without
        it blocks travel as bytes.
    progress
        See `asperity.run_study`. The tasks of a loop are reported as ``"NAME: tasks"``.
    wait
        False returns a future of the results at once; a thread of the client runs the study.

    Raises
    ------
    RuntimeError
        A worker has another build of asperity, or a processor with other instruction sets; the message names it.
    KeyboardInterrupt
        After Ctrl-C. Tasks that have not begun are cancelled; others end in the background.

    Examples
    --------
    >>> from distributed import Client  # doctest: +SKIP
    >>> with Client("scheduler:8786") as client:  # doctest: +SKIP
    ...     results = asperity.dask.run("study.toml", client, out="runs/study")
    """
    asked = request(os.path.abspath(study) if isinstance(study, (str, os.PathLike)) else study, only, seed)
    written = None if out is None else os.path.abspath(out)
    shared = None if storage is None else os.path.abspath(storage)
    own = _Run(client, asked, parts, shared, callback(progress), written)
    if wait:
        return own.compute()
    thread = ThreadPoolExecutor(1)
    future = thread.submit(own.compute)
    thread.shutdown(wait=False)
    return future


def verdict(
    study: Study | str | os.PathLike[str] | Mapping[str, Any],
    client: Client,
    *,
    seed: int | None = None,
    parts: int | None = None,
    storage: str | os.PathLike[str] | None = None,
    progress: Progress = True,
) -> VerdictResult:
    """Return the probability that a machine vibrates: `asperity.verdict` on the workers of a cluster.

    Parameters
    ----------
    study, client, seed, parts, storage, progress
        See `run`, which also lists the errors.

    Examples
    --------
    >>> from distributed import Client  # doctest: +SKIP
    >>> with Client("scheduler:8786") as client:  # doctest: +SKIP
    ...     print(asperity.dask.verdict("study.toml", client).probability)
    """
    found = run(study, client, only="verdict", seed=seed, parts=parts, storage=storage, progress=progress)
    assert isinstance(found, StudyResults)
    assert found.verdict is not None
    return found.verdict
