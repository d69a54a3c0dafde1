"""Times asperity's polynomial-chaos regression against NumPy, OpenTURNS, chaospy and scikit-learn, one thread each.

    python3 benchmarks/chaos/run.py [--quick]

The peers are installed into a virtual environment below the build folder, which is kept. Writes RESULTS.md beside this file;
`--quick` takes one round of smaller cases and only prints.
"""

import argparse
import datetime
import json
import os
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
OURS = PEERS.parent / "release" / "time_regression"
ROUNDS = 5
# Time after which a process is stopped, and total time after which a code is not repeated.
PATIENCE_S, BUDGET_S = 1800.0, 60.0
THREADS = ("RAYON_NUM_THREADS", "OPENTURNS_NUM_THREADS")


def ours(job):
    hidden = ("case", "q", "some", "decomposition", "fresh", "fresh_matrix")
    return process([OURS, job["case"], *(f"{key}={value}" for key, value in job.items() if key not in hidden)], None, PATIENCE_S, THREADS)


def peer(name):
    return lambda job: process([PYTHON, HERE / "peers.py", name], json.dumps(job), PATIENCE_S, THREADS)


@dataclass
class Timing:
    """Times, peak memory and last answer of a code in a case."""

    seconds: list = field(default_factory=list)
    memory_bytes: int = 0
    answer: dict = field(default_factory=dict)
    failure: str | None = None

    @property
    def median(self):
        return statistics.median(self.seconds)

    def text(self, count=1.0):
        if self.failure:
            return f"none: {self.failure}"
        low, high = min(self.seconds), max(self.seconds)
        return f"{duration(self.median / count)} ({duration(low / count)} – {duration(high / count)})"


def race(codes, rounds):
    """Returns the timings of codes (name, run, job) by name; the rounds are interleaved."""
    timings = {name: Timing() for name, _, _ in codes}
    for turn in range(rounds):
        for name, run, job in codes:
            timing = timings[name]
            if timing.failure or (turn and sum(timing.seconds) * (turn + 1) / turn > BUDGET_S):
                continue
            try:
                answer = run(job)
            except Failed as failure:
                timing.failure = str(failure)
                continue
            timing.seconds += answer["seconds"]
            timing.memory_bytes = max(timing.memory_bytes, answer["memory_bytes"])
            timing.answer = answer
    for name, timing in timings.items():
        print(name, timing.text(), f"{timing.memory_bytes / 2**20:.0f} MiB", {k: v for k, v in timing.answer.items() if k != "seconds"}, flush=True)
    return timings


def ratio(timing, own, count=1.0, own_count=1.0):
    if timing.failure or own.failure:
        return ""
    return f", **×{timing.median / count / (own.median / own_count):.3g}**"


class Bench:
    def __init__(self, folder, quick):
        import numpy
        import problems

        self.np, self.problems, self.folder, self.quick = numpy, problems, folder, quick
        self.rounds = 1 if quick else ROUNDS
        self.runs = {"warm_up": 1, "repeats": 1 if quick else 3}

    def write(self, name, values):
        path = self.folder / name
        self.np.ascontiguousarray(values, "<f8").tofile(path)
        return str(path)

    def read(self, name, shape):
        return self.np.fromfile(self.folder / name, "<f8").reshape(shape)

    def output(self, name):
        return {"output": str(self.folder / name)}

    def solve(self):
        """Times regressions with 165 terms, 2,000 samples, and thousands of responses at once."""
        samples, variables, degree, count = 2000, 8, 3, 256 if self.quick else 4096
        x = self.problems.points("latin_hypercube", 1, samples, variables, variables)
        random = self.np.random.default_rng(2)
        y = self.np.exp(0.2 * x @ random.standard_normal((variables, count))) + 0.1 * random.standard_normal((samples, count))
        job = {"samples": samples, "variables": variables, "degree": degree, "hermite": variables, "count": count,
               "points": self.write("points.f64", x), "responses": self.write("responses.f64", y), **self.runs}
        few = {"warm_up": 0, "repeats": 1}
        timings = race([
            ("asperity", ours, job | {"case": "solve"} | self.output("ours.f64")),
            ("asperity, with leave-one-out", ours, job | {"case": "fit"}),
            ("NumPy", peer("NumPy"), job | {"case": "solve"} | self.output("numpy.f64")),
            ("OpenTURNS", peer("OpenTURNS"), job | few | {"case": "solve", "some": 16}),
            ("chaospy", peer("chaospy"), job | few | {"case": "solve", "some": 64}),
        ], self.rounds)
        own, shape = timings["asperity"], (-1, count)
        difference = self.np.abs(self.read("ours.f64", shape) - self.read("numpy.f64", shape)).max()
        rows = []
        for name, timing in timings.items():
            responses = timing.answer.get("responses", count)
            rows.append([name, responses, timing.text(), timing.text(responses) + ratio(timing, own, responses, count)])
        parts = ", ".join(f"{key[:-2]} {duration(own.answer[key])}" for key in ("design_s", "factor_s", "solve_s"))
        return (f"## Many responses\n\n165 terms (8 variables, degree 3), {samples} samples: design matrix, QR, all responses. Largest "
                f"difference of a coefficient between asperity and NumPy {difference:.1e}. The parts of asperity: {parts}. OpenTURNS and chaospy "
                f"solve for fewer responses at once.\n\n" + table(["code", "responses", "time", "per response, ratio to asperity"], rows))

    def evaluate(self):
        """Times the evaluation of the same expansion at a million points."""
        variables, degree, count = 8, 3, 100_000 if self.quick else 1_000_000
        x = self.np.random.default_rng(3).standard_normal((count, variables))
        coefficients = self.np.random.default_rng(4).standard_normal(165)
        job = {"case": "evaluate", "samples": count, "variables": variables, "degree": degree, "hermite": variables,
               "points": self.write("points.f64", x), "coefficients": self.write("coefficients.f64", coefficients), **self.runs}
        some = 20_000
        timings = race([
            ("asperity", ours, job | self.output("ours.f64")),
            ("NumPy", peer("NumPy"), job | self.output("numpy.f64")),
            ("OpenTURNS", peer("OpenTURNS"), job | {"some": some} | self.output("openturns.f64")),
        ], self.rounds)
        own = timings["asperity"]
        values = self.read("ours.f64", -1)
        difference = self.np.abs(values - self.read("numpy.f64", -1)).max()
        rows = []
        for name, timing in timings.items():
            points = timing.answer.get("points", count)
            speed = "" if timing.failure else f"{points / timing.median / 1e6:.3g}"
            rows.append([name, points, timing.text(), speed + ratio(timing, own, points, count)])
        note = ""
        if not timings["OpenTURNS"].failure:
            note = f", OpenTURNS {self.np.abs(values[:some] - self.read('openturns.f64', -1)).max():.1e}"
        return (f"## Evaluation\n\n165 terms. Largest difference from NumPy {difference:.1e}{note}.\n\n"
                + table(["code", "points", "time", "million points per second, ratio"], rows))

    def select(self):
        """Times the selection of terms among 5,253 candidates."""
        samples, variables = (200, 40) if self.quick else (500, 101)
        x = self.problems.points("latin_hypercube", 5, samples, variables, variables)
        indices = self.problems.total_degree(variables, 2)
        y = self.problems.field_at_a_point(x, 0.05, 6)
        job = {"case": "select", "samples": samples, "variables": variables, "degree": 2, "hermite": variables,
               "points": self.write("points.f64", x), "response": self.write("response.f64", y), **self.runs}
        matrix = self.write("matrix.f64", self.problems.design(x, indices, variables))
        few = {"warm_up": 0, "repeats": 1}
        timings = race([
            ("asperity", ours, job),
            ("scikit-learn, OMP by 10-fold cross-validation", peer("scikit-learn"), job | few | {"matrix": matrix}),
            ("OpenTURNS, LARS by leave-one-out", peer("OpenTURNS"), job | few | {"decomposition": "QR"}),
        ], self.rounds)
        own = timings["asperity"]
        rows = []
        for name, timing in timings.items():
            memory = f"{timing.memory_bytes / 2**20:.0f} MiB, **×{timing.memory_bytes / own.memory_bytes:.3g}**"
            steps, terms = timing.answer.get("tried", ""), timing.answer.get("terms", "")
            rows.append([name, timing.text() + ratio(timing, own), "" if timing.failure else memory, steps, terms])
        return (f"## Sparse selection\n\n{len(indices)} terms ({variables} variables, degree 2), {samples} "
                f"samples, 5 % noise; times include the design matrix. Memory is the peak of the process, Python and its packages included.\n\n"
                + table(["code", "time, ratio to asperity", "memory", "models tried", "terms"], rows))

    def accuracy(self):
        """Computes errors at fresh points, as geometric means over five designs."""
        np, rows = self.np, []
        for name, (function, variance, make, hermite, variables, samples) in self.problems.ACCURACY.items():
            indices = make()
            # OpenTURNS enumerates a set of the same size.
            q, degree = (0.75, 5) if name == "borehole" else (1, 14)
            fresh = self.problems.points("independent", 7, 20_000 if self.quick else 100_000, variables, hermite)
            truth = function(fresh)
            matrix = self.problems.design(fresh, indices, hermite)
            fresh_files = {"fresh": self.write("fresh.f64", fresh), "fresh_matrix": self.write("fresh_matrix.f64", matrix)}
            errors, failures = {}, {}
            for seed in range(5):
                x = self.problems.points("latin_hypercube", seed, samples, variables, hermite)
                own = {"case": "select", "samples": samples, "columns": len(indices), "warm_up": 0, "repeats": 1,
                       "matrix": self.write("matrix.f64", self.problems.design(x, indices, hermite)),
                       "response": self.write("response.f64", function(x)), **self.output("found.f64")}
                other = own | {"points": self.write("points.f64", x), "variables": variables, "hermite": hermite,
                               "degree": degree, "q": q, "decomposition": "QR", **fresh_files}
                codes = [("asperity", ours, own), ("OpenTURNS, LARS", peer("OpenTURNS"), other),
                         ("scikit-learn, OMP by cross-validation", peer("scikit-learn"), other)]
                for code, run, job in codes:
                    try:
                        run(job)
                    except Failed as failure:
                        failures[code] = str(failure)
                        continue
                    found = np.fromfile(self.folder / "found.f64", "<f8")
                    predicted = matrix @ found if run is ours else found
                    errors.setdefault(code, []).append(np.mean((predicted - truth) ** 2) / variance)
            for code in [code for code, _, _ in codes]:
                if code in errors:
                    found = errors[code]
                    rows.append([name, code, f"{np.exp(np.mean(np.log(found))):.1e}", f"{min(found):.1e} – {max(found):.1e}", len(found)])
                else:
                    rows.append([name, code, f"none: {failures[code]}", "", 0])
                print(rows[-1], flush=True)
        return ("## Accuracy\n\nMean square error over the variance at fresh points: Ishigami's function with 680 terms (degree 14) from 100 samples, the "
                "borehole with 237 (hyperbolic, q = 0.75, p = 5) from 150; Latin hypercubes of five seeds.\n\n"
                + table(["function", "code", "geometric mean", "range", "designs"], rows))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true")
    quick = parser.parse_args().quick
    failed = prepare(HERE / "requirements.txt")
    if Path(sys.prefix).resolve() != PEERS:
        os.execv(PYTHON, [str(PYTHON), __file__, *sys.argv[1:]])
    subprocess.run(["cargo", "build", "--quiet", "--release", "-p", "asperity-benchmarks", "--bin", "time_regression"], check=True, cwd=ROOT)
    versions = {}
    for name in ("NumPy", "OpenTURNS", "chaospy", "scikit-learn"):
        try:
            versions[name] = peer(name)({"case": "version"})["version"]
        except Failed as failure:
            versions[name] = f"not installed ({failed.get(name, failure)})"
    before = os.getloadavg()[0]
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(Path(folder), quick)
        parts = [bench.solve(), bench.evaluate(), bench.select(), bench.accuracy()]
    text = "\n".join([
        "# Polynomial-chaos regression compared with its peers\n",
        f"Made by `benchmarks/chaos/run.py` on {datetime.date.today()}, asperity at {commit()}. One thread each; medians, with the range, over "
        f"interleaved rounds of fresh processes. Load average {before:.2f} before and {os.getloadavg()[0]:.2f} after the run.\n",
        machine(versions) + ".\n", *parts])
    if quick:
        print(text)
    else:
        (HERE / "RESULTS.md").write_text(text)


main()
