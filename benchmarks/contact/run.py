"""Times asperity's contact solver against Tamaas, ContactMechanics and ASPHER at equal true error.

    python3 benchmarks/contact/run.py [--quick | --fastest | --large]

The peers are installed into a virtual environment below the build folder, which is kept. Writes RESULTS.md beside this file;
`--quick` is a smoke run of some small cases, `--fastest` races only the fastest peer of every case, and `--large` solves one map of
8192² cells with asperity alone. These three only print.
"""

import argparse
import datetime
import json
import os
import selectors
import statistics
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

# No compiled files beside the scripts.
sys.dont_write_bytecode = True
sys.path.insert(1, str(Path(__file__).resolve().parents[1]))

from environment import located, prepare
from harness import ROOT, Failed, commit, machine

HERE = Path(__file__).resolve().parent
PEERS, PYTHON, _ = located(HERE / "requirements.txt")

# Largest true residual of every code.
WANTED = 1e-6
# Factor between the tolerances that are tried.
STEP = 10**0.5
ROUNDS = 5
# Total time in one case after which a code is not repeated, and time of one answer after which it is stopped.
BUDGET_S, PATIENCE_S = 60.0, 900.0
# A shorter solve is repeated within a round, after one that is not timed.
SHORT_S = 0.5

PERIODIC, FREE = "periodic", "free"
# Mean pressures over E* for contact of about 1, 11 and 57 %.
LOADS = (0.0005, 0.005, 0.033)
# Hardnesses over E*, by cells along a side, for which 20 and 60 % of the contact at the middle load is plastic.
HARDNESSES = {128: (0.0700, 0.0396), 256: (0.0730, 0.0414)}
BATCH_POINTS, BATCH_MAPS = 64, 64
LARGE_POINTS, LARGE_LOAD = 8192, 0.0022

# Every way to run a peer; the fastest that meets the wanted residual counts.
ASPHER = ("ASPHER", "ASPHER, mixed precision")
WAYS = {"Tamaas": ("Tamaas",), "ContactMechanics": ("ContactMechanics",), "ASPHER": ASPHER}


def build(title):
    """Returns the arguments of pip and the environment variables for building a peer."""
    # By default, ASPHER downloads Eigen and is built without the vector instructions of the machine.
    prefixes = ":".join(str(path) for path in PEERS.glob("lib/python*/site-packages/cmeel.prefix"))
    return ["--no-binary", "aspher"] if title == "ASPHER" else [], {"CMAKE_ARGS": "-DASPHER_NATIVE=ON", "CMAKE_PREFIX_PATH": prefixes}


def environment(threads):
    names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "RAYON_NUM_THREADS")
    return os.environ | {name: str(threads) for name in names}


class Peer:
    """A peer in a process of its own, which keeps plans and kernels between answers."""

    def __init__(self, name, threads=1):
        self.name, self.threads, self.process = name, threads, None

    def command(self):
        return [PYTHON, HERE / "peers.py", self.name]

    def ask(self, job):
        if self.process is None:
            self.process = subprocess.Popen(
                self.command(), stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL, text=True, env=environment(self.threads))
        line, reason = "", "crashed"
        try:
            self.process.stdin.write(json.dumps(job) + "\n")
            self.process.stdin.flush()
            with selectors.DefaultSelector() as selector:
                selector.register(self.process.stdout, selectors.EVENT_READ)
                if selector.select(PATIENCE_S):
                    line = self.process.stdout.readline()
                else:
                    reason = f"slower than {PATIENCE_S:g} s"
        except BrokenPipeError:
            pass
        if not line:
            self.stop()
            raise Failed(reason)
        answer = json.loads(line)
        if "error" in answer:
            raise Failed(answer["error"])
        return answer

    def stop(self):
        if self.process is not None:
            self.process.kill()
            self.process.wait()
            self.process = None


class Asperity:
    """The solver of asperity, run by the program `time_contact`."""

    name = "asperity"

    def __init__(self, threads=1, **words):
        self.threads, self.words, self.answers = threads, words, []

    def ask(self, job):
        words = self.words | {key: job[key] for key in ("points", "boundary", "mean_pressure", "tolerance", "repeats", "warm_up", "pressure")}
        words |= {"maps": job["maps"], "threads": self.threads, "transforms": job.get("transforms", "true")}
        if job["hardness"] is not None:
            words["hardness"] = job["hardness"]
        command = [PEERS.parent / "release" / "time_contact", job["heights"], *(f"{key}={value}" for key, value in words.items())]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment(self.threads)) as process:
            output = process.stdout.read()
            _, status, usage = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode:
            raise Failed(f"exit code {process.returncode}")
        answer = json.loads(output) | {"memory_bytes": usage.ru_maxrss * 1024}
        self.answers.append(answer)
        return answer

    def stop(self):
        pass


@dataclass
class Case:
    """A problem for all codes."""

    points: int
    boundary: str
    mean_pressure: float
    hardness: float | None = None
    maps: int = 1
    threads: int = 1


@dataclass
class Timing:
    """Result of a code in a case."""

    way: str
    tolerance: float
    residual: float
    seconds: list
    # One solve before the rounds.
    first: float = 0.0

    @property
    def median(self):
        return statistics.median(self.seconds)


class Bench:
    """Runs cases, and stores the last sufficient tolerance of each code."""

    def __init__(self, folder, rounds):
        self.folder, self.rounds, self.served = folder, rounds, {}
        self.versions, self.failed = {}, {}

    def heights(self, case):
        import numpy as np

        import truth

        maps = np.stack([truth.self_affine(case.points, case.points + 10_000 * place) for place in range(case.maps)])
        path = self.folder / "heights.f64"
        maps.astype("<f8").tofile(path)
        return maps, path

    def job(self, case, path, tolerance, repeats, warm_up):
        return {
            "points": case.points, "maps": case.maps, "boundary": case.boundary, "mean_pressure": case.mean_pressure,
            "hardness": case.hardness, "tolerance": tolerance, "repeats": repeats, "warm_up": warm_up,
            "heights": str(path), "pressure": str(self.folder / "pressure.f64"),
        }

    def residual(self, case, maps):
        import numpy as np

        import truth

        pressures = np.fromfile(self.folder / "pressure.f64", "<f8").reshape(maps.shape)
        return max(truth.residual(p, z, case.mean_pressure, case.boundary, case.hardness) for p, z in zip(pressures, maps))

    def search(self, code, case, maps, path):
        """Returns the result at the loosest tolerance with which `code` meets the required residual."""
        def attempt(tolerance):
            answer = code.ask(self.job(case, path, tolerance, 1, 0))
            return Timing(code.name, tolerance, self.residual(case, maps), answer["seconds"])

        found = attempt(self.served.get(code.name, WANTED))
        looser = found.residual <= WANTED
        while found.tolerance > 1e-15:
            try:
                tried = attempt(found.tolerance * STEP if looser else found.tolerance / STEP)
            except Failed:
                if looser:
                    break
                raise
            if looser and (tried.residual > WANTED or tried.tolerance > 1):
                break
            found = tried
            if not looser and found.residual <= WANTED:
                break
        if found.residual > WANTED:
            raise Failed(f"residual {found.residual:.0e} at best")
        self.served[code.name] = found.tolerance
        return found

    def run(self, case, codes):
        """Returns, by name, the timing or the reason why there is none, for codes of (name, ways)."""
        maps, path = self.heights(case)
        results, racing = {}, []
        for name, ways in codes:
            found, reason = [], None
            for code in ways:
                try:
                    found.append((self.search(code, case, maps, path), code))
                except Failed as failure:
                    reason = str(failure)
            # Warm solves decide between the ways of a peer.
            for timing, code in found:
                if timing.seconds[0] < SHORT_S:
                    timing.seconds = code.ask(self.job(case, path, timing.tolerance, 1, 1))["seconds"]
            if found:
                timing, code = min(found, key=lambda pair: pair[0].median)
                racing.append((timing, code))
            results[name] = timing if found else reason
        for timing, code in racing:
            timing.first = timing.seconds[0]
            if timing.first < BUDGET_S / 2:
                timing.seconds = []
            if isinstance(code, Asperity):
                code.answers.clear()
        for turn in range(self.rounds):
            for timing, code in racing:
                if timing.seconds and (turn + 1) * timing.first > BUDGET_S:
                    continue
                short = timing.first < SHORT_S
                warm_up = 1 if short or isinstance(code, Asperity) else 0
                timing.seconds += code.ask(self.job(case, path, timing.tolerance, 3 if short else 1, warm_up))["seconds"]
        return results


def formatted(seconds):
    return f"{seconds:.3g} s" if seconds >= 0.9995 else f"{1e3 * seconds:.3g} ms"


def spread(timing):
    return f"{formatted(timing.median)} ({formatted(min(timing.seconds))} – {formatted(max(timing.seconds))}), {timing.residual:.1e}"


def row(first, results, more):
    """Returns a line of a table: its first cells, asperity, and every peer with its ratio to asperity."""
    own = results["asperity"]
    cells = [*first, spread(own) if isinstance(own, Timing) else f"**{own}**", *more]
    for name in WAYS:
        if name not in results:
            cells.append("")
            continue
        timing = results[name]
        if isinstance(timing, Timing) and isinstance(own, Timing):
            way = timing.way.removeprefix(name).lstrip(", ")
            cells.append(f"{spread(timing)}{f' [{way}]' if way else ''}, **×{timing.median / own.median:.3g}**")
        else:
            cells.append(f"none: {timing}")
    return "| " + " | ".join(cells) + " |"


def table(head, rows):
    return "\n".join(["| " + " | ".join(head) + " |", "|" + "---|" * len(head), *rows]) + "\n"


def peers_of(bench, failed):
    """Returns the peers that answer, and stores the reasons of the others."""
    codes = {}
    for name, ways in WAYS.items():
        peers = [Peer(way) for way in ways]
        try:
            bench.versions[name] = peers[0].ask({"ask": "version"})["version"]
            codes[name] = peers
        except Failed as failure:
            bench.failed[name] = f"not installed: {failed.get(name, failure)}"
            codes[name] = []
    return codes


def elastic(bench, codes, cases):
    rows, pairs = [], {}
    transforms = Peer("transforms")
    for case in cases:
        own = Asperity(case.threads)
        if case.threads == 1:
            raced = [("asperity", [own]), *codes.items()]
        else:
            raced = [("asperity", [own]), ("ASPHER", [Peer(way, case.threads) for way in ASPHER] if codes["ASPHER"] else [])]
        results = bench.run(case, raced)
        for name, ways in raced[1:]:
            if results[name] is None:
                results[name] = bench.failed[name]
            if case.threads > 1:
                [peer.stop() for peer in ways]
        answer = own.answers[-1]
        # The solver evaluates the residual again at the end, and on the free boundary the displacement at the start.
        applications = answer["iterations"][0] + (2 if case.boundary == FREE else 1)
        pair = statistics.median(answer["transform_pair_s"] for answer in own.answers)
        ratios = [statistics.median(turn["seconds"]) / turn["transform_pair_s"] for turn in own.answers]
        each = statistics.median(ratios) / applications
        contact = f"{100 * answer['contact_fraction']:.1f} %"
        if case.hardness is not None:
            contact += f", {100 * answer['plastic_fraction'] / answer['contact_fraction']:.0f} % of it plastic"
        threads = f", {case.threads} threads" if case.threads > 1 else ""
        rows.append(row([f"{case.points}² {case.boundary}{threads}", contact], results, [str(answer["iterations"][0]), f"{each:.1f}"]))
        print(rows[-1], flush=True)
        if case.threads == 1 and case.hardness is None and (case.points, case.boundary) not in pairs:
            pairs[case.points, case.boundary] = pair, transforms.ask({"points": case.points, "boundary": case.boundary})
    transforms.stop()
    return rows, pairs


def batch(bench, codes, maps):
    case = Case(BATCH_POINTS, PERIODIC, LOADS[1], maps=maps)
    if codes["ASPHER"]:
        codes = codes | {"ASPHER": [*codes["ASPHER"], Peer("ASPHER, one grid")]}
    results = bench.run(case, [("asperity", [Asperity()]), *codes.items()])
    cells = []
    for name, timing in results.items():
        if not isinstance(timing, Timing):
            cells.append(f"none: {timing or bench.failed[name]}")
            continue
        ratio = timing.median / results["asperity"].median
        way = timing.way.removeprefix(name).lstrip(", ")
        text = f"{maps / timing.median:.4g}/s, {timing.residual:.1e}{f' [{way}]' if way else ''}"
        cells.append(text if name == "asperity" else f"{text}, **×{ratio:.3g}**")
    line = "| " + " | ".join([f"{maps} maps of {BATCH_POINTS}²", *cells]) + " |"
    print(line, flush=True)
    return line


def alone(bench, points, load):
    """Returns time, iterations and memory of one cold solve by asperity, as text."""
    case = Case(points, PERIODIC, load)
    maps, path = bench.heights(case)
    own = Asperity()
    answer = own.ask(bench.job(case, path, WANTED, 1, 0) | {"transforms": "false"})
    residual = bench.residual(case, maps)
    line = (f"asperity, {points}² periodic, {100 * answer['contact_fraction']:.1f} % contact, one thread: {formatted(answer['seconds'][0])}, "
            f"{answer['iterations'][0]} iterations, residual {residual:.0e}, peak memory {answer['memory_bytes'] / 1e6:.0f} MB "
            f"({answer['memory_bytes'] / points**2:.0f} bytes per cell, file and heights included).")
    print(line, flush=True)
    return line


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true", help="some small cases, in under a minute; writes nothing")
    parser.add_argument("--fastest", action="store_true", help="only the fastest peer of every case, in five minutes; writes nothing")
    parser.add_argument("--large", action="store_true", help=f"asperity alone on {LARGE_POINTS}² cells at 5 %% contact; writes nothing")
    arguments = parser.parse_args()
    failed = prepare(HERE / "requirements.txt", build)
    if Path(sys.prefix).resolve() != PEERS.resolve():
        os.execve(PYTHON, [str(PYTHON), str(HERE / "run.py"), *sys.argv[1:]], environment(1))
    subprocess.run(["cargo", "build", "--release", "--quiet", "-p", "asperity-benchmarks", "--bin", "time_contact"], cwd=ROOT, check=True)
    with tempfile.TemporaryDirectory() as temporary:
        bench = Bench(Path(temporary), 2 if arguments.quick else ROUNDS)
        if arguments.large:
            alone(bench, LARGE_POINTS, LARGE_LOAD)
            return
        before = os.getloadavg()
        codes = peers_of(bench, failed)
        if arguments.quick:
            cases = [Case(128, PERIODIC, LOADS[1]), Case(128, FREE, LOADS[1]), Case(256, PERIODIC, LOADS[1], threads=2)]
            plastic = [Case(128, PERIODIC, LOADS[1], HARDNESSES[128][0])]
        else:
            cases = [Case(n, PERIODIC, load) for n in (256, 512, 1024) for load in LOADS]
            cases += [Case(1024, PERIODIC, LOADS[1], threads=2)]
            cases += [Case(n, FREE, load) for n in (256, 512) for load in LOADS]
            plastic = [Case(n, PERIODIC, LOADS[1], hardness) for n, hard in HARDNESSES.items() for hardness in hard]
        # ASPHER has no hardness.
        capped = {name: ways for name, ways in codes.items() if name != "ASPHER"}
        elastic_codes = codes
        if arguments.fastest:
            elastic_codes, capped = {"ASPHER": codes["ASPHER"]}, {"ContactMechanics": codes["ContactMechanics"]}
        elastic_rows, pairs = elastic(bench, elastic_codes, cases)
        plastic_rows, _ = elastic(bench, capped, plastic)
        batch_row = batch(bench, elastic_codes, 8 if arguments.quick else BATCH_MAPS)
        memory = alone(bench, 512 if arguments.quick else 2048, LOADS[1])
        after = os.getloadavg()
        for ways in codes.values():
            [peer.stop() for peer in ways]
    pair_rows = []
    for (points, boundary), (own, others) in pairs.items():
        size = f"{points}²" if boundary == PERIODIC else f"{points}², padded"
        others = [f"{formatted(others[name])}, ×{others[name] / own:.2f}" for name in ("FFTW", "pocketfft")]
        pair_rows.append("| " + " | ".join([size, formatted(own), *others]) + " |")
    head = ["cells", "contact", "asperity", "iterations", "pairs per application", *WAYS]
    text = f"""# Contact

Made by `benchmarks/contact/run.py` on {datetime.date.today()}, asperity at {commit()}.

Machine: {machine({"numpy": version("numpy")} | bench.versions)}. Load average {before[0]:.2f} before and {after[0]:.2f} after the run.

Self-affine maps (Hurst exponent {0.8}, roll-off at 8 waves per side, cut at n/8, rms slope 0.1), the same for all. Every code's
own tolerance is the loosest, on a ladder of factor √10, with which the *true* residual is at most {WANTED:.0e}: recomputed by this
benchmark from the pressure alone, by `truth.py`. Cells state the median time (least – largest), the true residual, **and the ratio
to the time of asperity**. One thread each unless stated otherwise; codes take turns within a case, {bench.rounds} rounds. The planning of
transforms and the computation of kernels are excluded for all codes. *Pairs per application*: time over the time of
(iterations + 1, on the free boundary + 2) pairs of a forward and an inverse transform of a map by asperity, measured in the same
processes.

ContactMechanics stops by the overlap alone; its other criteria are off. ASPHER is built with the machine's vector instructions
and its own FFT; the faster of its double and mixed precision counts.

## Elastic

{table(head, elastic_rows)}
## With a hardness

Tamaas uses Kato's saturated solver.

{table(head, plastic_rows)}
## Many small maps

One thread, periodic, about 11 % contact; solves per second.

{table(["maps", "asperity", *elastic_codes], [batch_row])}
## Transforms

A forward and an inverse transform of a real map on one thread. FFTW and pocketfft do not skip the zeros of padded maps.

{table(["cells", "asperity", "FFTW, measured plan", "pocketfft (SciPy)"], pair_rows)}
## Memory

{memory}
"""
    if bench.failed:
        text += "\n## Not installed\n\n" + "".join(f"- {name}: {reason}\n" for name, reason in bench.failed.items())
    if arguments.quick or arguments.fastest:
        print(text)
    else:
        (HERE / "RESULTS.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
