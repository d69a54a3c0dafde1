import os
import signal
import threading
import time

import numpy as np
import pytest

import asperity
from support import ROOT

distributed = pytest.importorskip("distributed")

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


@pytest.mark.filterwarnings("default")
@pytest.mark.parametrize("workers", [1, 3])
def test_a_cluster_gives_the_bits_of_one_machine(workers, wanted):
    from asperity import dask

    with (
        distributed.LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        same(dask.run(STUDY, client), wanted)


@pytest.mark.filterwarnings("default")
def test_a_lost_worker_costs_only_time(wanted):
    from asperity import dask

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
            found = dask.run(STUDY, client)
        finally:
            ended.set()
            killer.join()
        assert lost
        same(found, wanted)


@pytest.mark.filterwarnings("default")
def test_errors_reach_the_client(tmp_path):
    from asperity import dask

    with (
        distributed.LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        with pytest.raises(FileNotFoundError, match=r"gone\.npy"):
            dask.run({"seed": 1, "surface": {"file": str(tmp_path / "gone.npy")}}, client)
        found = dask.run(ROOT / "studies" / "paper.toml", client, only="surface")
        assert found.surface is not None


def test_a_worker_with_another_build_is_refused():
    from asperity import dask, study

    asked = study.request(STUDY, None, None)
    with pytest.raises(RuntimeError, match="another build of asperity"):
        dask._part(asked, {"sha256": "0"}, (1, 1), None, None)


@pytest.mark.filterwarnings("default")
def test_a_campaign_runs_on_shared_storage_and_goes_on(tmp_path):
    from asperity import dask

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
        found = dask.run(campaign, client, storage=storage)
        assert found.to_dict() == wanted.to_dict()
        # Each member is the block of one part.
        assert len(list(storage.glob("part-*"))) == len(wanted.members)
        # What is stored is not computed again: no task is needed.
        client.close()
        assert dask.run(campaign, _NoTasks(), storage=storage).to_dict() == wanted.to_dict()


class _NoTasks:
    def scheduler_info(self, **_):
        return {"workers": {}}
