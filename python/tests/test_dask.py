import concurrent.futures
import math
import os
import signal
import subprocess
import sys
import threading
import time
import zipfile

import numpy as np
import pytest

import asperity
from support import ROOT

distributed = pytest.importorskip("distributed")
dask = pytest.importorskip("asperity.dask")

STUDY = {
    "seed": 5,
    "surface": {
        "covariance": "exponential",
        "marginal": "normal",
        "rms_height": "1 um",
        "correlation_length": "20 um",
    },
    "material": {"youngs_modulus": "210 GPa", "hardness": "2 GPa"},
    "pressure": {
        "size": ["100 um", "100 um"],
        "points": [48, 48],
        "percentile": 50.0,
        "fine_solves": 100,
        "methods": ["monte_carlo", "default"],
        "reference_samples": 400,
        "variables": 4,
        "degree": 2,
    },
}


MACHINE = """
seed = 1
[vibration]
natural_frequency = "316 rad/s"
mass = "1 kg"
normal_force = "2.5 kN"
nominal_area = "833 mm^2"
dimensionless_belt_velocity = 0.1
damping_ratio = 0.1
stribeck = 4.2
static_friction = 0.2
friction_std = 0
[verdict]
"""


def same(found, wanted):
    assert found.to_dict() == wanted.to_dict()
    for name, table in wanted.tables.items():
        for column, values in table.items():
            np.testing.assert_array_equal(found.tables[name][column], values)
    for name, field in wanted.fields.items():
        np.testing.assert_array_equal(found.fields[name].values, field.values)


@pytest.fixture(scope="module")
def wanted():
    return asperity.run_study(STUDY, progress=False)


@pytest.fixture
def shares(monkeypatch):
    """Share every loop, as if it were much faster elsewhere; return the number of tasks of each."""
    found, share = [], dask._Run.share

    def counted(run, left, *folders):
        found.append(left["parts"])
        return share(run, left, *folders)

    for name, value in {"_START_S": -math.inf, "_PATIENCE_S": 120.0, "_threads": lambda _: 16}.items():
        monkeypatch.setattr(dask, name, value)
    monkeypatch.setattr(dask._Run, "share", counted)
    return found


def cluster(workers, threads=1):
    return distributed.LocalCluster(n_workers=workers, threads_per_worker=threads, dashboard_address=None)


def same_folders(one, other):
    """Compare the files of two runs but those that state times."""
    files = [sorted(path.relative_to(own) for path in own.rglob("*")) for own in (one, other)]
    assert files[0] == files[1]
    assert (one / "results.json").read_bytes() == (other / "results.json").read_bytes()


@pytest.mark.parametrize("parts", [None, 32])
def test_the_client_computes_what_workers_do_not_speed_up(parts, tmp_path, wanted):
    reports = []
    with cluster(2) as own, distributed.Client(own) as client:
        same(dask.run(STUDY, client, parts=parts, progress=lambda *report: reports.append(report)), wanted)
    assert reports
    assert not any(what.endswith(": tasks") for what, _, _ in reports)


@pytest.mark.filterwarnings("default")
@pytest.mark.parametrize("workers", [1, 3])
def test_a_cluster_gives_the_bits_of_one_machine(workers, tmp_path, wanted, shares):
    reports = []
    out = {"out": tmp_path / "run", "progress": lambda *report: reports.append(report)}
    with cluster(workers, 2) as own, distributed.Client(own) as client:
        future = dask.run(STUDY, client, parts=6, wait=False, **out)
        assert isinstance(future, concurrent.futures.Future)
        same(future.result(), wanted)
        threads = client.run(lambda: os.environ.get("RAYON_NUM_THREADS"))
        assert set(threads.values()) == {"2"}
    # Each loop is shared once.
    names = [what for what, done, total in reports if what.endswith(": tasks") and done == total]
    assert len(shares) == len(names) >= 2
    assert all(0 < done <= total for _, done, total in reports)
    asperity.run_study(STUDY, progress=False, out=tmp_path / "own")
    same_folders(tmp_path / "run", tmp_path / "own")


@pytest.mark.filterwarnings("default")
def test_an_interrupted_run_cancels_its_tasks(shares):
    def interrupt(what, done, total):
        if what.endswith(": tasks"):
            raise KeyboardInterrupt

    with cluster(1) as own, distributed.Client(own) as client:
        with pytest.raises(KeyboardInterrupt):
            dask.run(STUDY, client, parts=8, progress=interrupt)
        assert shares == [8]
        ends = time.monotonic() + 30.0
        while any(client.processing().values()) and time.monotonic() < ends:
            time.sleep(0.05)
        # The task that was computed has ended, and no other was begun.
        assert not any(client.processing().values())
        states = client.run_on_scheduler(lambda dask_scheduler: [t.state for t in dask_scheduler.tasks.values()])
        assert not {"queued", "processing"} & {*states}


INTERRUPTED = """
import math
import distributed
from asperity import dask
if __name__ == "__main__":
    dask._threads, dask._START_S = lambda _: 16, -math.inf
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        try:
            dask.run({study!r}, client, parts=8, progress=lambda *report: print(*report, flush=True))
        except KeyboardInterrupt:
            print("interrupted", flush=True)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="process groups of POSIX")
def test_ctrl_c_in_a_terminal_leaves_no_stack_traces(tmp_path):
    script = tmp_path / "script.py"
    longer = {**STUDY, "pressure": {**STUDY["pressure"], "fine_solves": 2000, "reference_samples": 4000}}
    script.write_text(INTERRUPTED.format(study=longer))
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen([sys.executable, script], text=True, start_new_session=True, **pipes) as process:
        assert process.stdout is not None
        assert any(": tasks" in line for line in process.stdout)
        # A terminal sends the signal to the workers too.
        os.killpg(process.pid, signal.SIGINT)
        out, err = process.communicate(timeout=60)
    assert "interrupted" in out
    assert "Traceback" not in err


@pytest.mark.filterwarnings("default")
def test_a_lost_worker_costs_only_time(wanted, shares):
    with (
        distributed.LocalCluster(n_workers=3, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        lost, ended = [], threading.Event()
        pids = client.run(os.getpid)

        def kill():
            while not lost and not ended.is_set():
                busy = [address for address, tasks in client.processing().items() if tasks]
                if busy:
                    lost.append(busy[0])
                    os.kill(pids[busy[0]], signal.SIGKILL)
                time.sleep(0.01)

        killer = threading.Thread(target=kill)
        killer.start()
        try:
            found = dask.run(STUDY, client, parts=12)
        finally:
            ended.set()
            killer.join()
        assert lost
        same(found, wanted)


@pytest.mark.filterwarnings("default")
def test_errors_reach_the_client(tmp_path):
    with (
        distributed.LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        with pytest.raises(FileNotFoundError, match=r"gone\.npy"):
            dask.run({"seed": 1, "surface": {"file": str(tmp_path / "gone.npy")}}, client)
        found = dask.run(ROOT / "studies" / "paper.toml", client, only="surface")
        assert found.surface is not None


@pytest.mark.filterwarnings("default")
def test_errors_of_workers_reach_the_client(monkeypatch, shares):
    program = {**asperity._core.module_program(asperity._core.__file__), "sha256": "0123456789abcdef"}
    with cluster(1) as own, distributed.Client(own) as client:
        worker = next(iter(client.scheduler_info()["workers"]))
        with monkeypatch.context() as patched:
            patched.setattr(dask._core, "module_program", lambda _: program)
            build = rf"worker {worker} has another build of asperity.*: [0-9a-f]{{12}} .* instead of 0123456789ab "
            with pytest.raises(RuntimeError, match=build):
                dask.run(STUDY, client)
        monkeypatch.setattr(dask, "_packed", lambda *_: b"no archive")
        with pytest.raises(zipfile.BadZipFile):
            dask.run(STUDY, client)
    assert len(shares) == 2


@pytest.mark.filterwarnings("default")
def test_a_cluster_that_finishes_nothing_is_left(monkeypatch, wanted, shares):
    monkeypatch.setattr(dask, "_PATIENCE_S", 0.5)
    with cluster(1) as own, distributed.Client(own) as client:
        other = client.submit(time.sleep, 30)
        same(dask.run(STUDY, client), wanted)
        other.release()
    assert len(shares) == 1


@pytest.mark.filterwarnings("default")
def test_a_campaign_runs_on_shared_storage_and_goes_on(tmp_path, shares):
    (tmp_path / "study.toml").write_text(MACHINE)
    campaign = tmp_path / "campaign.toml"
    campaign.write_text('study = "study.toml"\n[values]\nvibration.damping_ratio = [0.05, 0.1, 0.2, 0.3, 0.4]\n')
    wanted = asperity.run_campaign(campaign, progress=False)
    assert [member.vibrates for member in wanted.members] == [True, True, True, False, False]
    storage = tmp_path / "blocks"
    with (
        distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        assert dask.run(campaign, client, parts=2).to_dict() == wanted.to_dict()
        assert dask.run(campaign, client, parts=2, storage=storage).to_dict() == wanted.to_dict()
        # Members are the blocks of one loop.
        assert shares == [2, 2]
        assert sorted(path.name for path in storage.glob("part-*")) == ["part-1", "part-2"]
        # What is stored is not computed again: no task is needed.
        client.close()
        found = dask.run(campaign, client, storage=storage, out=tmp_path / "run")
        assert found.to_dict() == wanted.to_dict()
        asperity.run_campaign(campaign, progress=False, out=tmp_path / "own")
        same_folders(tmp_path / "run", tmp_path / "own")


def program_of_the_documentation(word):
    """Return the Python program of docs/clusters.md that contains a word, without its guard against a second start."""
    text = (ROOT / "docs" / "clusters.md").read_text(encoding="utf-8")
    (found,) = (own.split("```")[0] for own in text.split("```python\n") if word in own.split("```")[0])
    return found


def run_program(program, changes):
    for old, new in changes.items():
        assert old in program
        program = program.replace(old, new)
    names = {"__name__": "__main__"}
    exec(program, names)
    return names["results"]


@pytest.mark.filterwarnings("default")
def test_the_program_for_slurm_asks_for_its_jobs_and_gives_the_bits_of_one_machine(
    monkeypatch, tmp_path, wanted, shares
):
    jobqueue = pytest.importorskip("dask_jobqueue")
    started = []

    slurm = jobqueue.SLURMCluster

    def here(**settings):
        with slurm(**{**settings, "n_workers": 0}) as own:
            script = own.job_script()
        assert {"#SBATCH --cpus-per-task=4", "#SBATCH --mem=8G", "#SBATCH -t 02:00:00"} <= set(script.splitlines())
        assert "--nthreads 4" in script
        started.append(settings["n_workers"])
        return cluster(2)

    monkeypatch.setattr(jobqueue, "SLURMCluster", here)
    changes = {'"brake.toml"': repr(STUDY), "workers(8)": "workers(2)", '"runs/brake"': repr(str(tmp_path / "run"))}
    found = run_program(program_of_the_documentation("SLURMCluster"), changes)
    same(found, wanted)
    assert started == [8]
    assert shares


@pytest.mark.filterwarnings("default")
def test_the_program_for_kubernetes_has_pods_of_its_schema_and_gives_the_bits_of_one_machine(
    monkeypatch, tmp_path, wanted, shares
):
    operator = pytest.importorskip("dask_kubernetes.operator")
    kubernetes = pytest.importorskip("kubernetes.client")
    pods = []

    def here(custom_cluster_spec):
        pods.append(custom_cluster_spec["spec"]["worker"])
        return cluster(2)

    monkeypatch.setattr(operator, "KubeCluster", here)
    changes = {
        '"/project/brake.toml"': repr(STUDY),
        "workers(8)": "workers(2)",
        '"/project/runs/brake"': repr(str(tmp_path / "run")),
    }
    found = run_program(program_of_the_documentation("KubeCluster"), changes)
    same(found, wanted)
    assert shares
    (worker,) = pods
    assert worker["replicas"] == 8
    assert worker["spec"]["containers"][0]["args"][-2:] == ["--nthreads", "4"]
    # The schema keeps what it knows.
    client = kubernetes.ApiClient()
    known = client._ApiClient__deserialize(worker["spec"], "V1PodSpec")
    del worker["spec"]["containers"][0]["env"]
    assert client.sanitize_for_serialization(known) == worker["spec"]


def machines(ratios, velocities):
    law = asperity.Stribeck(kinetic=0.1, decay=4.2)
    return asperity.Oscillator(static_friction=0.1, law=law, damping_ratio=ratios, belt_velocity=velocities)


@pytest.mark.filterwarnings("default")
def test_chunks_of_machines_have_the_bits_of_one_call():
    array = pytest.importorskip("dask.array")
    ratios, velocities = np.linspace(0.05, 0.3, 30)[:, None], np.geomspace(0.003, 0.3, 7)
    chunks = machines(array.from_array(ratios, chunks=(8, 1)), array.from_array(velocities, chunks=3))
    assert chunks == machines(chunks.damping_ratio, chunks.belt_velocity)
    assert chunks != machines(chunks.damping_ratio + 0.01, chunks.belt_velocity)
    whole = machines(ratios, velocities)
    with cluster(2) as own, distributed.Client(own):
        for find in (asperity.limit_cycle, asperity.critical_damping):
            found, wanted = find(chunks), find(whole)
            assert {type(value) for value in found._values().values()} == {array.Array}
            for name, value in wanted._values().items():
                computed = getattr(found, name).compute()
                assert computed.dtype == value.dtype
                np.testing.assert_array_equal(computed, value)
            assert found.to_xarray().compute().equals(wanted.to_xarray())
            assert found.to_dataframe().equals(wanted.to_dataframe())
        wrong = machines(array.from_array(np.array([0.1, 0.1, 0.2, -1.0]), chunks=2), 0.003)
        with pytest.raises(ValueError, match=r"chunk from \[2\]: machine \[1\]: damping_ratio is -1"):
            asperity.limit_cycle(wrong).period.compute()
    with pytest.raises(TypeError, match="only limit_cycle and critical_damping take arrays of Dask"):
        asperity.trajectory(chunks, [0, 1])


@pytest.mark.filterwarnings("default")
def test_a_verdict_of_a_cluster_is_that_of_one_machine(tmp_path, shares):
    study = tmp_path / "study.toml"
    study.write_text(MACHINE.replace("damping_ratio = 0.1", 'damping_ratio = "0.21 ± 0.02"'))
    with cluster(2) as own, distributed.Client(own) as client:
        found = dask.verdict(study, client, progress=False)
    assert found == asperity.verdict(study, progress=False)
    assert 0 < found.probability < 1
