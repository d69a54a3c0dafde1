"""Times writing stored blocks and reading them in `run`, `merge` and `status`, and campaigns against a bare loop.

    python3 benchmarks/blocks/run.py [--counts 10000 100000] [--print]

Builds the release of asperity. A block is one machine of a verdict, some 0.2 ms of work and 20 bytes. A contact problem takes more than ten
times as long. Writes RESULTS.md beside this file; `--print` prints it instead.
"""

import argparse
import datetime
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

# No compiled files beside the scripts.
sys.dont_write_bytecode = True

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path.insert(0, str(HERE.parent))
from harness import commit, duration, machine, table

BUILT = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")).resolve() / "release"
PROGRAM = BUILT / "asperity"
REPEATS = 3
STUDY = """seed = 1
[vibration]
mass = "1 kg"
natural_frequency = "316 rad/s"
damping_ratio = "0.2 ± 0.03"
normal_force = "2.5 kN ± 0.2 kN"
nominal_area = "833 mm^2"
dimensionless_belt_velocity = 0.003
stribeck = "4.2 ± 0.4"
static_friction = 0.1
friction_std = 0
[verdict]
half_width = 1e-6
evaluations = {count}
"""


# Each takes some 20 ms of one core.
MEMBER = """seed = 1
[vibration]
mass = "1 kg"
natural_frequency = "316 rad/s"
damping_ratio = 0.2
normal_force = "2.5 kN"
nominal_area = "833 mm^2"
dimensionless_belt_velocity = 0.003
stribeck = 4.2
static_friction = 0.1
friction_std = 0.002
friction_marginal = "normal"
friction_correlation_length = "20 um"
damping_sweep = [0.1, 0.3, 2]
trajectories = 8
duration = 12.0
"""
MEMBERS = [100, 1000]
PAIRS = 3


def measured(folder, *words, program=PROGRAM):
    """Returns seconds and peak memory in MB of a command."""
    began = time.perf_counter()
    quiet = ["--quiet"] if program == PROGRAM else []
    child = subprocess.Popen([program, *words, *quiet], cwd=folder, stdout=subprocess.DEVNULL)
    _, status, used = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode:
        raise SystemExit(f"asperity {' '.join(words)} ended with exit code {child.returncode}")
    return time.perf_counter() - began, used.ru_maxrss / 1024


def best(measure):
    """Returns the result of the fastest repeat."""
    return min(measure(number) for number in range(REPEATS))


def row(count):
    """Times the commands for a number of machines."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "study.toml").write_text(STUDY.format(count=count))
        alone = best(lambda _: measured(folder, "verdict", "study.toml"))
        stored = best(lambda n: measured(folder, "run", "study.toml", "--only", "verdict", "--out", f"stored-{n}/run"))
        again = best(lambda n: measured(folder, "run", "study.toml", "--only", "verdict", "--out", f"stored-0/again-{n}"))
        measured(folder, "run", "study.toml", "--only", "verdict", "--shard", "1/1", "--out", "part")
        merged = best(lambda n: measured(folder, "merge", "part", "--out", f"merged-{n}/run"))
        status = best(lambda _: measured(folder, "status", "stored-0/run"))
        size = sum(file.stat().st_size for file in Path(folder, "stored-0", ".asperity-blocks").rglob("*") if file.is_file())
        files = sum(1 for _ in Path(folder, "stored-0", ".asperity-blocks").rglob("*.blocks"))
    return {"alone": alone, "stored": stored, "again": again, "merged": merged, "status": status, "size": size / 1e6, "files": files}


def campaigns():
    """Times campaigns and the bare loop over the same members in turn. Returns seconds and memory of each, and the ratios of time."""
    found = {}
    for count in MEMBERS:
        with tempfile.TemporaryDirectory() as folder:
            Path(folder, "study.toml").write_text(MEMBER)
            pairs = []
            for number in range(PAIRS):
                bare = measured(folder, "study.toml", str(count), "sweep.toml", program=BUILT / "time_campaign")
                pairs.append((bare, measured(folder, "campaign", "sweep.toml", "--out", f"campaign-{number}")))
                shutil.rmtree(Path(folder, ".asperity-blocks"), ignore_errors=True)
        found[count] = pairs
    return found


def of_campaigns(found):
    body = []
    for count, pairs in found.items():
        ratios = sorted(campaign[0] / bare[0] for bare, campaign in pairs)
        cells = [f"{duration(min(p[side][0] for p in pairs))}, {max(p[side][1] for p in pairs):.0f} MB" for side in (0, 1)]
        body.append([f"{count:,}", *cells, f"{statistics.median(ratios):.3f} ({ratios[0]:.3f} to {ratios[-1]:.3f})"])
    return f"""
## Campaigns

A bare loop over the studies of the members, and `asperity campaign`, which also stores blocks and writes table and report, {PAIRS} times in turn.
The table states the least time, the largest memory, and the median of the ratios with its range.

{table(["members", "bare loop", "campaign", "ratio of time"], body)}"""


def report(rows):
    names = {"alone": "`verdict`, which stores nothing", "stored": "`run`, all blocks computed", "again": "`run`, all blocks read",
             "merged": "`merge` of a part with all blocks", "status": "`status`"}
    counts = sorted(rows)
    low, high = counts[0], counts[-1]
    head = ["", *[f"{count:,} machines" for count in counts], "1,000,000, extrapolated"]
    body = []
    for key, name in names.items():
        cells = [f"{duration(rows[count][key][0])}, {rows[count][key][1]:.0f} MB" for count in counts]
        slope = [(rows[high][key][part] - rows[low][key][part]) / (high - low) for part in (0, 1)]
        far = [rows[high][key][part] + slope[part] * (1e6 - high) for part in (0, 1)]
        body.append([name, *cells, f"{duration(far[0])}, {far[1]:.0f} MB"])
    disk = [f"{rows[count]['size']:.1f} MB in {rows[count]['files']} files" for count in counts]
    body.append(["blocks on the disk", *disk, f"{rows[high]['size'] * 1e6 / high:.0f} MB"])
    return f"""# Stored blocks

{datetime.date.today()}, commit {commit()}, {machine({}).removesuffix(', ')}. Time and largest memory of one command, the best of {REPEATS}. `run` also
writes the run folder.

{table(head, body)}"""


def main():
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--counts", type=int, nargs="+", default=[10_000, 100_000])
    options.add_argument("--print", action="store_true")
    chosen = options.parse_args()
    subprocess.run(["cargo", "build", "--release", "-p", "asperity-cli", "-p", "asperity-benchmarks", "--bins"], cwd=ROOT, check=True)
    text = report({count: row(count) for count in chosen.counts}) + of_campaigns(campaigns())
    if chosen.print:
        print(text)
    else:
        (HERE / "RESULTS.md").write_text(text)


if __name__ == "__main__":
    main()
