"""Times asperity's stick-slip solver against SciPy, diffrax and the crate differential-equations at equal true error.

    python3 benchmarks/vibration/run.py [--quick | --full]

The peers are installed and built below the build folder and kept there. Writes RESULTS.md beside this file; `--full` adds a sweep over
damping on all threads, and `--quick` takes one round of smaller cases and only prints.
"""

import argparse
import datetime
import json
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

# No compiled files beside the scripts.
sys.dont_write_bytecode = True
sys.path.insert(1, str(Path(__file__).resolve().parents[1]))

from environment import located, prepare
from harness import ROOT, Failed, commit, duration, machine, process, table

HERE = Path(__file__).resolve().parent
PEERS, PYTHON, _ = located(HERE / "requirements.txt")
CRATE = PEERS / "differential-equations"
CRATE_VERSION = "0.6.1"
OURS = PEERS.parent / "release" / "time_vibration"
ROUNDS = 3

MACHINE = {"friction": 0.1, "decay": 4.2, "damping": 0.17, "velocity": 0.003}
# Period of this cycle from arithmetic with 40 digits.
PERIOD = 6.372163483739709201
# Required errors of the period, and the one at which batches are compared.
WANTED, WANTED_AT_ONCE = (1e-6, 1e-9, 1e-12), 1e-9
# Required differences of the ends of the cycles of a stochastic trajectory.
WANTED_ENDS = (1e-2, 1e-5)
# Tried relative tolerances; the absolute tolerances are a thousandth of them.
LADDER, ATOL_SHARE = [10.0**-k for k in range(5, 14)], 1e-3
DURATION = 637.2

CARGO = f"""[package]
name = "differential-equations-peer"
version = "0.0.0"
edition = "2024"

[[bin]]
name = "peer"
path = "peer.rs"

[dependencies]
differential-equations = "={CRATE_VERSION}"

[profile.release]
lto = "fat"
codegen-units = 1

[workspace]
"""


def build_crate():
    """Builds the program of the crate with the vector instructions of the machine; returns the error if this fails."""
    CRATE.mkdir(parents=True, exist_ok=True)
    (CRATE / "Cargo.toml").write_text(CARGO)
    shutil.copyfile(HERE / "differential_equations.rs", CRATE / "peer.rs")
    environment = os.environ | {"CARGO_TARGET_DIR": str(CRATE / "target"), "RUSTFLAGS": "-C target-cpu=native"}
    done = subprocess.run(["cargo", "build", "--quiet", "--release"], cwd=CRATE, env=environment, capture_output=True, text=True)
    if done.returncode:
        lines = [line for line in done.stderr.splitlines() if "error" in line.lower()]
        return (lines or ["cargo failed"])[0][:200]
    return None


def words(job):
    return [f"{key}={str(value).lower() if isinstance(value, bool) else value}" for key, value in job.items()]


def ours(case, job):
    return process([OURS, case, *words(MACHINE | job)])


def crate(case, job, rtols):
    program = CRATE / "target" / "release" / "peer"
    return [process([program, case, *words(MACHINE | job | {"rtol": rtol, "atol": rtol * ATOL_SHARE})]) for rtol in rtols]


def python(name, method):
    def ask(case, job, rtols):
        request = MACHINE | job | {"case": case, "method": method, "rtols": rtols, "atol_share": ATOL_SHARE}
        return process([PYTHON, HERE / "peers.py", name], json.dumps(request))["answers"]

    return ask


@dataclass
class Timing:
    """Seconds of one piece of work by a code, the true error of its answer and its tolerance."""

    error: float = 0.0
    rtol: float | None = None
    seconds: list = field(default_factory=list)

    @property
    def median(self):
        return statistics.median(self.seconds)

    def text(self, own=None):
        text = f"{duration(self.median)} ({duration(min(self.seconds))} – {duration(max(self.seconds))})"
        return text if own is None else f"{text}, **×{self.median / own.median:.3g}**"


class Bench:
    def __init__(self, folder, quick):
        self.folder, self.quick = folder, quick
        self.rounds = 1 if quick else ROUNDS

    def cycle(self):
        """Times one deterministic cycle at several true errors."""
        scale = 10 if self.quick else 1
        few, many = {"cycles": 20 // scale}, {"cycles": 2000 // scale}
        codes = {
            "differential-equations, DOP853, its events": (crate, many | {"refine": "none"}),
            "differential-equations, DOP853, events refined": (crate, many | {"refine": "ends"}),
            "diffrax, Tsit5": (python("diffrax", "Tsit5"), {"cycles": 200 // scale}),
            "diffrax, Dopri8": (python("diffrax", "Dopri8"), {"cycles": 200 // scale}),
            "SciPy, RK45": (python("SciPy", "RK45"), few),
            "SciPy, DOP853": (python("SciPy", "DOP853"), few),
        }
        runs = {"warm_up": 1, "repeats": 3}
        every, failures = [], {}
        for name, (ask, job) in codes.items():
            try:
                answers = ask("cycle", job | {"warm_up": 1, "repeats": 1}, LADDER)
            except Failed as failure:
                failures[name] = str(failure)
                continue
            rungs = [Timing(abs(answer["period"] - PERIOD), rtol, [answer["seconds"][0] / job["cycles"]])
                     for rtol, answer in zip(LADDER, answers)]
            every.append((name, rungs))
            print(name, [(f"{rung.error:.0e}", duration(rung.median)) for rung in rungs], flush=True)
        own, batch = Timing(), Timing()
        # By code and required error: the loosest sufficient tolerance.
        chosen = {}
        for name, rungs in every:
            for wanted in WANTED:
                sufficient = next((rung for rung in rungs if rung.error <= wanted), None)
                if sufficient:
                    chosen[name, wanted] = Timing(sufficient.error, sufficient.rtol)
        alone = {"cycles": 2000 // scale, "threads": 1, **runs}
        at_once = {"cycles": 400 // scale, "machines": 256, "threads": 1, **runs}
        for _ in range(self.rounds):
            answer = ours("cycle", alone)
            own.error = abs(answer["period"] - PERIOD)
            own.seconds += [seconds / answer["cycles"] for seconds in answer["seconds"]]
            answer = ours("lockstep", at_once)
            batch.error = abs(answer["period"] - PERIOD)
            batch.seconds += [seconds / answer["cycles"] for seconds in answer["seconds"]]
            for name, _ in every:
                ask, job = codes[name]
                rtols = sorted({chosen[name, wanted].rtol for wanted in WANTED if (name, wanted) in chosen}, reverse=True)
                for rtol, answer in zip(rtols, ask("cycle", job | runs, rtols)):
                    for wanted in WANTED:
                        if (name, wanted) in chosen and chosen[name, wanted].rtol == rtol:
                            chosen[name, wanted].seconds += [seconds / job["cycles"] for seconds in answer["seconds"]]
        rows = [["asperity", f"{own.text()}, {own.error:.0e}", *[""] * (len(WANTED) - 1)]]
        for name, rungs in every:
            cells = []
            for wanted in WANTED:
                timing = chosen.get((name, wanted))
                cells.append(f"{timing.text(own)}, {timing.error:.0e} at {timing.rtol:.0e}" if timing
                             else f"none: {min(rung.error for rung in rungs):.0e} at best")
            rows.append([name, *cells])
        rows += [[name, f"none: {why}", *[""] * (len(WANTED) - 1)] for name, why in failures.items()]
        text = ("## One cycle\n\nThe deterministic stick-slip cycle, μ_st = 0.1, a = 4.2, ζ = 0.17, V = 0.003; its period is "
                f"{PERIOD:.15f}. A cell states the time of a cycle, the true error of the period, and the relative tolerance. For every "
                "required error, a peer has the loosest tolerance (powers of ten) that reaches it, even if by chance. asperity has one accuracy. All peers "
                "integrate slip from the detachment to their event; stick, a straight line, is computed in closed form. *Events refined*: the crate finds "
                "events on its interpolation, whose error no tolerance controls, so the last step is repeated up to the event.\n\n"
                + table(["code", *[f"error at most {wanted:.0e}" for wanted in WANTED]], rows))
        rows = [[name, *[f"{duration(rung.median)}, {rung.error:.0e}" for rung in rungs]] for name, rungs in every]
        text += "\nSingle runs at every tolerance:\n\n" + table(["code", *[f"{rtol:.0e}" for rtol in LADDER]], rows)
        return text, own, batch, chosen

    def at_once(self, own, batch, chosen):
        """Times many deterministic machines in one batch."""
        machines, cycles = 256, 5 if self.quick else 50
        rows = [["asperity, in lockstep", f"{batch.text(batch)}, {batch.error:.0e}"], ["asperity, one by one", f"{own.text(batch)}, {own.error:.0e}"]]
        for method in ("Tsit5", "Dopri8"):
            name = f"diffrax, {method}"
            if (name, WANTED_AT_ONCE) not in chosen:
                continue
            rtol, timing = chosen[name, WANTED_AT_ONCE].rtol, Timing()
            job = {"machines": machines, "cycles": cycles, "warm_up": 1, "repeats": 3}
            try:
                for _ in range(self.rounds):
                    [answer] = python("diffrax", method)("lockstep", job, [rtol])
                    timing.seconds += [seconds / answer["cycles"] for seconds in answer["seconds"]]
            except Failed as failure:
                rows.append([f"{name}, mapped", f"none: {failure}"])
                continue
            rows.append([f"{name}, mapped", f"{timing.text(batch)}, at {rtol:.0e}"])
        for (name, wanted), timing in chosen.items():
            if wanted == WANTED_AT_ONCE:
                rows.append([f"{name}, one by one", f"{timing.text(batch)}, {timing.error:.0e}"])
        return ("## Many machines at once\n\nDeterministic cycles of 256 machines, damping ratios evenly from 0.153 to 0.187, on one thread; time "
                f"per cycle, and true error of the period at ζ = 0.17. Peers run at a required error of {WANTED_AT_ONCE:.0e}; *one by one* are the times "
                "of the first table. diffrax maps the compiled cycle over machines (vmap).\n\n" + table(["code", "per cycle, ratio, error"], rows))

    def path(self):
        """Times trajectories under stochastic friction."""
        paths, written = (40, 4) if self.quick else (400, 20)
        knots = self.folder / "knots.f64"
        truth = ours("path", {"paths": written, "repeats": 1, "warm_up": 0, "duration": DURATION, "knots": knots})
        shared = {"knots": str(knots), "step": truth["step"], "duration": DURATION}
        few = {"paths": 1, "written": written}
        ladder = [10.0**-k for k in range(6, 9 if self.quick else 12)]
        knot_to_knot, over = {"paths": written, "pieces": True}, {"paths": written, "pieces": False, "refine": "ends"}
        codes = {
            "differential-equations, DOP853, from knot to knot": (crate, knot_to_knot | {"refine": "ends"}, written, LADDER),
            "differential-equations, DOP853, from knot to knot, knots refined": (crate, knot_to_knot | {"refine": "all"}, written, LADDER),
            "differential-equations, DOP853, over the knots": (crate, over, written, ladder),
            "SciPy, RK45, over the knots": (python("SciPy", "RK45"), few, 1, ladder),
            "SciPy, DOP853, over the knots": (python("SciPy", "DOP853"), few, 1, ladder),
        }

        def off(answer):
            """Returns the largest difference of the ends of cycles; infinite if the number of cycles differs."""
            worst = 0.0
            for found, true, count in zip(answer["ends"], truth["ends"], truth["cycles_by_path"]):
                worst = max(worst, max(min(abs(a - b) for b in true) for a in found)) if len(found) == count else float("inf")
            return worst

        chosen, reasons = {}, {}
        for name, (ask, job, count, rungs) in codes.items():
            best = float("inf")
            try:
                for rtol in rungs:
                    [answer] = ask("path", job | shared | {"warm_up": 0, "repeats": 1}, [rtol])
                    error, seconds = off(answer), answer["seconds"][0] / count
                    best = min(best, error)
                    print(name, f"{rtol:.0e}", duration(seconds), f"{error:.0e}", flush=True)
                    for wanted in WANTED_ENDS:
                        if error <= wanted:
                            chosen.setdefault((name, wanted), Timing(error, rtol))
                    if best <= min(WANTED_ENDS):
                        break
                least = "another number of cycles" if best == float("inf") else f"{best:.0e} at best"
                reasons[name] = f"none: {least}, {duration(seconds)} at {rungs[-1]:.0e}"
            except Failed as failure:
                reasons[name] = f"none: {failure}"
        own, batch = Timing(), Timing()
        runs = {"paths": paths, "duration": DURATION, "threads": 1, "repeats": 3, "warm_up": 1}
        for turn in range(self.rounds):
            own.seconds += [seconds / paths for seconds in ours("path", runs)["seconds"]]
            found = ours("ensemble", runs)
            batch.seconds += [seconds / paths for seconds in found["seconds"]]
            for (name, _), timing in chosen.items():
                ask, job, count, _ = codes[name]
                # A path takes seconds with the slow codes.
                if turn < 3 or ask is crate:
                    repeats = 3 if ask is crate else 1
                    [answer] = ask("path", job | shared | {"warm_up": repeats // 2, "repeats": repeats}, [timing.rtol])
                    timing.seconds += [seconds / count for seconds in answer["seconds"]]
        rows = [["asperity, one by one", own.text(own), ""], ["asperity, in lockstep", batch.text(own), ""]]
        for name in codes:
            timings = [chosen.get((name, wanted)) for wanted in WANTED_ENDS]
            rows.append([name, *[f"{t.text(own)}, {t.error:.0e} at {t.rtol:.0e}" if t else reasons[name] for t in timings]])
        return (f"## One stochastic trajectory\n\nτ = {DURATION}, friction of standard deviation 0.001 with a Beta(2.1, 5) distribution and correlation "
                "length λ = 0.01, linear between knots λ/20 apart; one thread. asperity generates the noise during the run and, in lockstep, also computes "
                f"the distributions of all events; peers read the knots of the first {written} paths (SciPy of the first) from a file. Peers have the "
                "loosest tolerance with which every path has as many cycles as asperity's and every cycle ends within the required difference; cells state "
                f"the largest difference and the tolerance. asperity: {found['cycles'] / paths:.2f} cycles a path, standard error {found['se']:.2f}. From knot to knot the "
                "program of the crate searches for the earlier of two events, knot and end of slip, on the interpolation of the crate, and its first steps "
                "aim at the knot. Ends of slips are refined as above; *knots refined* refines the knots in the same way.\n\n"
                + table(["code", *[f"ends within {wanted:.0e}" for wanted in WANTED_ENDS]], rows))

    def sweep(self):
        """Times many trajectories at many damping ratios."""
        paths = 10_000
        answer = ours("sweep", {"paths": paths, "dampings": 12, "duration": DURATION, "threads": 0, "repeats": 1, "warm_up": 0})
        rows = [[f"{damping:.4f}", f"{mean:.2f}"] for damping, mean in zip(answer["dampings"], answer["mean_cycles"])]
        interval = " – ".join(f"{bound:.4f}" for bound in answer["half_interval"])
        return (f"## A sweep\n\nasperity on all threads: 12 damping ratios of {paths:,} trajectories each in {duration(answer['seconds'][0])}. The "
                f"mean number of cycles falls to half at ζ = {answer['half']:.4f} ({interval}).\n\n" + table(["damping ratio", "mean cycles"], rows))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    which = parser.add_mutually_exclusive_group()
    which.add_argument("--quick", action="store_true")
    which.add_argument("--full", action="store_true")
    arguments = parser.parse_args()
    failed = prepare(HERE / "requirements.txt")
    subprocess.run(["cargo", "build", "--quiet", "--release", "-p", "asperity-benchmarks", "--bin", "time_vibration"], check=True, cwd=ROOT)
    unbuilt = build_crate()
    versions = {"differential-equations": f"not built ({unbuilt})" if unbuilt else f"{CRATE_VERSION} (target-cpu=native)"}
    for name in ("diffrax", "SciPy"):
        try:
            versions[name] = process([PYTHON, HERE / "peers.py", name], json.dumps({"case": "version"}))["version"]
        except Failed as failure:
            versions[name] = f"not installed ({failed.get(name, failure)})"
    before = os.getloadavg()[0]
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(Path(folder), arguments.quick)
        cycle, *found = bench.cycle()
        parts = [cycle, bench.at_once(*found), bench.path()]
        if arguments.full:
            parts.append(bench.sweep())
    text = "\n".join([
        "# Stick-slip compared with its peers\n",
        f"Made by `benchmarks/vibration/run.py{' --full' if arguments.full else ''}` on {datetime.date.today()}, asperity at {commit()}. One thread "
        f"each; medians, with the range, over interleaved rounds of fresh processes. Load average {before:.2f} before and {os.getloadavg()[0]:.2f} "
        "after the run.\n",
        machine(versions) + ".\n", *parts])
    if arguments.quick:
        print(text)
    else:
        (HERE / "RESULTS.md").write_text(text, encoding="utf-8")


main()
