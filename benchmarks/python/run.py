"""Times the Python package against the Rust library and Tamaas (a contact, the import, single calls), and counts copies of maps.

    python3 benchmarks/python/run.py [--rounds 10] [--installed] [--print]

Builds the release of asperity (three minutes on two idle cores) and installs it with Tamaas into a virtual environment below the build
folder, which is kept. `--installed` uses the package that is installed there or on PYTHONPATH. Writes RESULTS.md beside this file; `--print`
prints it instead.
"""

import argparse
import datetime
import os
import statistics
import subprocess
import sys
import tempfile
import time
from importlib.metadata import version
from pathlib import Path

# No compiled files beside the scripts.
sys.dont_write_bytecode = True

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent), str(HERE.parent / "contact")]
from environment import enter, install, located
from harness import ROOT, commit, duration, machine, process, table

enter(HERE / "requirements.txt")

import numpy as np

from contact import run as contact

POINTS = 512
# Limits: time of a contact in Python over that in Rust, time that a call of the package adds, copies of a map.
CONTACT_BAR, CALL_BAR_S, COPIES_BAR = 1.02, 20e-6, 1.0
IMPORTS = 20
# glibc keeps freed memory, so that the next call finds memory with pages.
KEPT = "GLIBC_TUNABLES=glibc.malloc.mmap_threshold=1073741824:glibc.malloc.trim_threshold=4294967296"
SCRIPTS, SCRIPT_CALLS = 5, 20
CALL_ROUNDS, CALL_S = 31, 0.02
MAP_POINTS = 2048

# A script that solves the contact again and again.
SCRIPT = """
import json, resource, statistics, time
import numpy as np
import asperity

def faults():
    return resource.getrusage(resource.RUSAGE_SELF).ru_minflt

map = asperity.HeightMap.from_array(np.fromfile({path!r}).reshape({points}, {points}), dx_m=1 / {points})
seconds = []
for turn in range({calls} + 2):
    if turn == 2:
        before = faults()
    start = time.perf_counter()
    asperity.solve_contact(map, modulus_pa=1.0, mean_pressure_pa={pressure}, tolerance={tolerance})
    seconds.append(time.perf_counter() - start)
print(json.dumps([statistics.median(seconds[2:]), (faults() - before) / {calls}]))
"""
IMPORT = """
import json, time
start = time.perf_counter()
import numpy
between = time.perf_counter()
import asperity
print(json.dumps([between - start, time.perf_counter() - between]))
"""
# The peak before the work is the memory of the map, because nothing else was as large.
MEMORY = """
import json, resource
import numpy as np
import asperity

def peak_bytes():
    return 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss

z = np.empty(({points}, {points}))
np.random.default_rng(1).standard_normal(out=z)
{before}
start = peak_bytes()
kept = {work}
print(json.dumps((peak_bytes() - start) / z.nbytes))
"""
MAP = "map = asperity.HeightMap.from_array(z, dx_m=1e-6)"
WORKS = {
    "`HeightMap.from_array(z)`": ("", "asperity.HeightMap.from_array(z, dx_m=1e-6)"),
    "`.heights`": (MAP, "map.heights"),
    '`.level("none")`': (MAP, 'map.level("none")'),
}


class Solver(contact.Peer):
    """A solver in a process of this environment."""

    def command(self):
        return [sys.executable, HERE / "solvers.py", self.name]


def of_contact(rounds):
    rust, whole, python, tamaas = contact.Asperity(), contact.Asperity(fresh="true"), Solver("asperity"), Solver("Tamaas")
    case = contact.Case(POINTS, contact.PERIODIC, contact.LOADS[1])
    with tempfile.TemporaryDirectory() as folder:
        bench = contact.Bench(Path(folder), rounds)
        found = bench.run(case, [("Rust", [rust]), ("whole", [whole]), ("Python", [python]), ("Tamaas", [tamaas])])
        if reasons := [f"{name}: {timing}" for name, timing in found.items() if isinstance(timing, str)]:
            raise SystemExit("; ".join(reasons))
        _, path = bench.heights(case)
        script = SCRIPT.format(
            path=str(path), points=POINTS, pressure=case.mean_pressure, tolerance=found["Python"].tolerance, calls=SCRIPT_CALLS)
        scripts = {}
        for variables in ((), (KEPT,)):
            command = ["env", *variables, sys.executable, "-c", script]
            answers = [process(command, variables=("RAYON_NUM_THREADS",)) for _ in range(SCRIPTS)]
            scripts[variables] = [statistics.median(column) for column in zip(*answers)]
    for peer in (python, tamaas):
        peer.stop()
    whole_s = found["whole"].median
    over = lambda seconds: f"{seconds / whole_s:.4g}"
    of_script = lambda seconds, faults: [f"{duration(seconds)}, {faults:,.0f} page faults", over(seconds)]
    rows = [
        ["Rust, the solution alone", contact.spread(found["Rust"]), over(found["Rust"].median)],
        ["Rust, a whole call", contact.spread(found["whole"]), "1"],
        ["`asperity.solve_contact`", contact.spread(found["Python"]), over(found["Python"].median)],
        ["`asperity.solve_contact` in a script", *of_script(*scripts[()])],
        ["`asperity.solve_contact` in a script, memory kept", *of_script(*scripts[(KEPT,)])],
        ["Tamaas, the solution alone", contact.spread(found["Tamaas"]), over(found["Tamaas"].median)],
    ]
    met = "met" if found["Python"].median <= CONTACT_BAR * whole_s else "**missed**"
    fraction = 100 * rust.answers[-1]["contact_fraction"]
    return f"""## A contact

{POINTS}² cells, periodic, {fraction:.1f} % contact, one thread: the map, the search for the loosest tolerance with a true residual of at most
{contact.WANTED:.0e}, and the cells (median time, least – largest, true residual) are as in `benchmarks/contact`. The codes take turns, {rounds} rounds.
`solve_contact` makes the half-space and its memory in every call and returns the gap and the plastic displacement, as the second line does; it
also copies the heights. Bar: at most {CONTACT_BAR:g} times as long as the second line, {met}.

A script calls `solve_contact` {SCRIPT_CALLS} times; median of {SCRIPTS} scripts. Its calls take fresh memory from the system, page by page, unless
`{KEPT}` makes glibc keep freed memory.

{table(["", "time", "over Rust"], rows)}"""


def of_import():
    pairs = [process([sys.executable, "-c", IMPORT]) for _ in range(1 + IMPORTS)][1:]
    numpy_s, own_s = (statistics.median(column) for column in zip(*pairs))
    rows = [["`import numpy`", duration(numpy_s)], ["`import asperity`, after it", duration(own_s)]]
    return f"""## Import

Median of {IMPORTS} processes with the files in the page cache.

{table(["", "time"], rows)}"""


def per_call_s(work, number):
    start = time.perf_counter()
    for _ in range(number):
        work()
    return (time.perf_counter() - start) / number


def of_calls():
    import asperity
    from asperity import _core

    tiny = 1e-6 * np.random.default_rng(1).standard_normal((8, 8))
    law = asperity.Stribeck(kinetic=0.1, decay=4.2)
    oscillator = asperity.Oscillator(static_friction=0.1, law=law, damping_ratio=0.17, belt_velocity=0.003)
    problem = {"modulus_pa": 1e11, "mean_pressure_pa": 1e8}
    settings = dict.fromkeys(
        ["youngs_modulus_pa", "poisson_ratio", "penetration_m", "percentile", "load_n", "mean_gap_m", "hardness_pa",
         "mean_compliance_m_per_pa", "tolerance"]) | {"boundary": "periodic"} | problem
    works = {
        "`HeightMap.from_array`, 8²": (
            lambda: asperity.HeightMap.from_array(tiny, dx_m=1e-6), lambda: _core.height_map(tiny, 1e-6, 1e-6)),
        "`limit_cycle`": (lambda: asperity.limit_cycle(oscillator), lambda: _core.limit_cycle(oscillator._checked)),
        "`solve_contact`, 8²": (
            lambda: asperity.solve_contact(tiny, dx_m=1e-6, **problem), lambda: _core.solve_contact(tiny, 1e-6, 1e-6, settings)),
    }
    rows = []
    for name, (whole, core) in works.items():
        number = max(1, int(CALL_S / per_call_s(whole, 20)))
        pairs = [(per_call_s(whole, number), per_call_s(core, number)) for _ in range(CALL_ROUNDS)]
        whole_s, core_s = (statistics.median(column) for column in zip(*pairs))
        added_s = statistics.median(whole_s - core_s for whole_s, core_s in pairs)
        rows.append([name, duration(whole_s), duration(core_s), duration(added_s), "met" if added_s <= CALL_BAR_S else "**missed**"])
    return f"""## Calls

A call of the package, and of the compiled module with the same arguments, in turn; medians of {CALL_ROUNDS} rounds. Bar: the package adds at most
{duration(CALL_BAR_S)}.

{table(["", "package", "compiled module", "difference", "bar"], rows)}"""


def of_memory():
    rows = []
    for name, (before, work) in WORKS.items():
        copies = process([sys.executable, "-c", MEMORY.format(points=MAP_POINTS, before=before, work=work)])
        # The tolerance is for pages of the program, which are read during the work.
        rows.append([name, f"{copies:.2f}", "met" if copies <= COPIES_BAR + 0.05 else "**missed**"])
    return f"""## Memory

Peak memory of the process beyond its input, in copies of a map of {MAP_POINTS}² heights (34 MB). Bar: at most one copy, which is the result.

{table(["", "copies", "bar"], rows)}"""


def main():
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--rounds", type=int, default=10)
    options.add_argument("--installed", action="store_true", help="take the package that is installed")
    options.add_argument("--print", action="store_true")
    chosen = options.parse_args()
    subprocess.run(["cargo", "build", "--release", "--quiet", "-p", "asperity-benchmarks", "--bin", "time_contact"], cwd=ROOT, check=True)
    if not chosen.installed:
        _, python, _ = located(HERE / "requirements.txt")
        install(python, ["--force-reinstall", "--no-deps", ROOT], check=True)
    before = os.getloadavg()[0]
    parts = [of_contact(chosen.rounds), of_import(), of_calls(), of_memory()]
    text = f"""# Python

Made by `benchmarks/python/run.py` on {datetime.date.today()}, asperity at {commit()}.

Machine: {machine({"numpy": version("numpy"), "Tamaas": version("tamaas")})}. Load average {before:.2f} before and {os.getloadavg()[0]:.2f} after the run.

""" + "\n".join(parts)
    if chosen.print:
        print(text)
    else:
        (HERE / "RESULTS.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
