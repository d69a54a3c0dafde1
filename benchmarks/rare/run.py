"""Counts the evaluations that small probabilities take in asperity and OpenTURNS at a true relative error of 0.1.

    python3 benchmarks/rare/run.py [--probabilities 1e-3 1e-6] [--replicates 50] [--rows LOG] [--print]

`--rows` takes available rows of all methods except `small_probability` from the output of an earlier run.

Installs OpenTURNS into a virtual environment below the build folder, which is kept. Writes RESULTS.md beside this file; `--print`
prints it instead.
"""

import argparse
import datetime
import json
import math
import os
import platform
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

# No compiled files beside the scripts.
sys.dont_write_bytecode = True

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path.insert(0, str(HERE.parent))
from environment import enter

enter(HERE / "requirements.txt")

import openturns

import peers
from limit_states import LIMIT_STATES, parameter

# The program counts evaluations, so the profile for development suffices.
OURS = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")).resolve() / "debug" / "time_rare"
WANTED = 0.1
STEPS, MOST_EVALUATIONS = 8, 200_000
# Replicates while the effort is searched.
PILOT = 12
CASES = [("linear", 2), ("linear", 10), ("machine", 2), ("parabola", 2), ("parabola", 10), ("branches", 2), ("branches", 10)]
# Title, method, first effort, largest effort. The time of NAIS grows with the square of the effort.
PEERS = [
    ("FORM and importance sampling", peers.form_importance, 200, 100_000),
    ("FORM and controlled importance sampling", peers.form_controlled, 2, 100_000),
    ("cross-entropy, quantile 0.3", peers.cross_entropy(0.3), 250, 20_000),
    ("NAIS, quantile 0.1", peers.nais(0.1), 250, 1000),
    ("subset simulation, fraction 0.1", peers.subset(0.1), 6000, 100_000),
]
ABOUT = """P = P[g < 0] for n standard normal variables z; u and v are orthogonal directions that involve all of them.

- **True error**: root mean square of P/P_exact − 1 over {replicates} replicates, with its standard error.
- **Evaluations** of g, differences for derivatives included: the mean at the least effort (samples of a level, draws) that has a true error
  of {wanted}, interpolated between two efforts, or scaled
  by (true error/{wanted})² if the first one sufficed. `small_probability` runs with its default settings. Its evaluations are multiplied by
  (true error/{wanted})² if the true error is larger, and are not reduced if it is smaller.
- **Coverage** of the 95 % intervals.
- *Not reached*: the error stays above {wanted}, because a method misses failures or takes more than {most} evaluations. NAIS has at most 1,000
  samples per step.

FORM with controlled importance sampling is exact for a linear g once the design point is known. Design points of FORM are found with one-sided
differences, from a start at 0.1 in each variable.
"""


@dataclass
class Found:
    """Replicates of a method at one effort."""

    error: float
    error_std: float
    bias: float
    evaluations: float
    coverage: float | None = None
    failure: str | None = None

    @classmethod
    def of(cls, answers, truth, coverage=None):
        count = len(answers)
        squares = [(probability / truth - 1) ** 2 for probability, _ in answers]
        mean = sum(squares) / count
        spread = math.sqrt(sum((square - mean) ** 2 for square in squares) / max(count - 1, 1) / count)
        bias = sum(probability for probability, _ in answers) / count / truth - 1
        error = math.sqrt(mean)
        return cls(error, spread / (2 * max(error, 1e-12)), bias, sum(evaluations for _, evaluations in answers) / count, coverage)


def ours(name, variables, b, truth, replicates, samples=None):
    command = [OURS, name, variables, b, replicates, *([samples] if samples else [])]
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, check=True)
    answers = json.loads(done.stdout)
    coverage = sum(answer["low"] <= truth <= answer["high"] for answer in answers) / len(answers)
    return Found.of([(answer["probability"], answer["evaluations"]) for answer in answers], truth, coverage)


def least(run, effort, most, replicates):
    """Returns the result at the least effort that reaches the required error, with its evaluations.

    A few replicates determine the effort, all replicates the result. The effort grows with the square of the error until the error
    is reached. If this takes more than one effort, the evaluations are interpolated between the last two.
    """
    before = None
    pilot = True
    for _ in range(STEPS):
        try:
            found = run(round(effort), min(PILOT, replicates) if pilot else replicates)
        except Exception as error:  # OpenTURNS raises TypeError and RuntimeError.
            stopped = "stopped" in str(error)
            reason = "stopped after a million evaluations" if stopped else str(error).strip().splitlines()[0][:80]
            return Found(math.nan, math.nan, math.nan, math.nan, failure=reason)
        if found.error <= WANTED and not pilot:
            if before and before.error > WANTED:
                part = math.log(before.error / WANTED) / math.log(before.error / found.error)
                found.evaluations = before.evaluations * (found.evaluations / before.evaluations) ** part
            elif found.error > WANTED / 2:
                # The variance is inversely proportional to the effort.
                found.evaluations *= (found.error / WANTED) ** 2
            return found
        if found.error <= 1.5 * WANTED and pilot:
            pilot = False
            continue
        ratio = min(max((found.error / WANTED) ** 2, 1.3), 6)
        if found.evaluations * ratio > MOST_EVALUATIONS or effort * ratio > most:
            break
        before, effort = None if pilot else found, effort * ratio
    found.failure = "not reached"
    return found


def printed(path):
    """Returns the rows of an earlier run from its output."""
    rows = {}
    for line in path.read_text(encoding="utf-8").splitlines() if path else []:
        cells = [cell.strip() for cell in line.split("|")]
        if len(cells) == 8:
            name, variables, probability, title, evaluations, error, coverage, _ = cells
            reached = evaluations.isdigit()
            error, error_std = map(float, error.split("±")) if error else (math.nan, math.nan)
            rows[name, int(variables), float(probability), title] = Found(
                error, error_std, math.nan, float(evaluations) if reached else math.nan,
                float(coverage.split()[0]) / 100 if coverage else None, None if reached else evaluations)
    return rows


def evaluated(method, name, variables, b, truth):
    def run(effort, replicates):
        return Found.of([method(name, variables, b, effort, seed) for seed in range(replicates)], truth)

    return run


def row(title, found, own=None):
    error = "" if math.isnan(found.error) else f"{found.error:.3f} ± {found.error_std:.3f}"
    if found.failure:
        bias = "" if math.isnan(found.bias) else f", bias {100 * found.bias:+.0f} % after {found.evaluations:.0f}"
        return [title, f"{found.failure}{bias}", error, "", ""]
    coverage = "" if found.coverage is None else f"{100 * found.coverage:.0f} %"
    return [title, f"{found.evaluations:.0f}", error, coverage, "" if own is None else f"{own.evaluations / found.evaluations:.2f}"]


def table(head, rows):
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(str(cell) for cell in line) + " |" for line in lines) + "\n"


def compare(name, variables, probability, replicates, earlier):
    """Returns the rows of all methods, and the row of the summary."""

    def found_earlier(title, run):
        return earlier.get((name, variables, probability, title)) or run()

    b = parameter(name, variables, probability)
    own = ours(name, variables, b, probability, replicates)
    own.evaluations *= max(1.0, (own.error / WANTED) ** 2)
    rows = [row("asperity", own)]
    levels = found_earlier("asperity, subset simulation", lambda: least(
        lambda samples, replicates: ours(name, variables, b, probability, replicates, samples), 500, 100_000, replicates))
    rows.append(row("asperity, subset simulation", levels, own))
    reached, subset = [], None
    for title, method, effort, most in PEERS:
        found = found_earlier(f"OpenTURNS, {title}", lambda: least(
            evaluated(method, name, variables, b, probability), effort, most, replicates))
        rows.append(row(f"OpenTURNS, {title}", found, own))
        if not found.failure:
            reached.append((found.evaluations, title))
            subset = found.evaluations if method is PEERS[-1][1] else None
    for line in rows:
        print(name, variables, probability, *line, sep=" | ", flush=True)

    def ratio(numerator, denominator):
        return f"{numerator / denominator:.2f}" if denominator else ""

    best = min(reached, default=(None, "none"))
    line = [name, variables, f"{probability:.0e}", f"{own.evaluations:.0f}", f"{best[0]:.0f}, {best[1]}" if best[0] else "none",
            ratio(own.evaluations, best[0]), ratio(own.evaluations, subset), "" if levels.failure else ratio(levels.evaluations, subset)]
    return rows, line


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--probabilities", type=float, nargs="+", default=[1e-3, 1e-4, 1e-5, 1e-6])
    parser.add_argument("--replicates", type=int, default=50)
    parser.add_argument("--rows", type=Path)
    parser.add_argument("--print", action="store_true")
    arguments = parser.parse_args()
    subprocess.run(["cargo", "build", "--quiet", "-p", "asperity-benchmarks", "--bin", "time_rare"], check=True, cwd=ROOT)
    summary, parts, earlier = [], [], printed(arguments.rows)
    for name, variables in CASES:
        for probability in arguments.probabilities:
            rows, line = compare(name, variables, probability, arguments.replicates, earlier)
            summary.append(line)
            parts.append(f"## {name}: {LIMIT_STATES[name][3]}; n = {variables}, P = {probability:.0e}\n\n" + table(
                ["method", "evaluations", "true error", "coverage", "asperity / this"], rows))
    rustc = subprocess.run(["rustc", "--version"], capture_output=True, text=True, cwd=ROOT, check=True).stdout.split()[:2]
    commit = subprocess.run(["git", "describe", "--always", "--dirty=, with changes"], capture_output=True, text=True, cwd=ROOT).stdout.strip()
    text = "\n".join([
        "# Small probabilities compared with OpenTURNS\n",
        f"Made by `python3 benchmarks/rare/run.py` on {datetime.date.today()}, asperity at {commit}; {platform.system()}, "
        f"{' '.join(rustc)}, Python {platform.python_version()}, OpenTURNS {openturns.__version__}."
        + (" Methods other than `small_probability` are from an earlier run." if earlier else "") + "\n",
        ABOUT.format(replicates=arguments.replicates, wanted=WANTED, most=f"{MOST_EVALUATIONS:,}"),
        table(["limit state", "n", "P", "asperity", "best method of OpenTURNS", "asperity / best", "asperity / subset simulation",
               "subset simulations, asperity / OpenTURNS"], summary), *parts])
    if arguments.print:
        print(text)
    else:
        (HERE / "RESULTS.md").write_text(text, encoding="utf-8")


main()
