"""Common parts of the benchmarks: processes that print JSON, and the text of a report."""

import json
import os
import platform
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]


class Failed(Exception):
    """A program that returns no result."""


def process(command, text=None, patience_s=1800.0, variables=()):
    """Returns the JSON that a process prints for the input `text`; `variables` are further names of variables that limit its threads."""
    names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", *variables)
    environment = os.environ | {name: "1" for name in names} | {"PYTHONDONTWRITEBYTECODE": "1", "JAX_PLATFORMS": "cpu", "RUST_BACKTRACE": "0"}
    try:
        done = subprocess.run(list(map(str, command)), input=text, capture_output=True, text=True, env=environment, timeout=patience_s)
    except subprocess.TimeoutExpired:
        raise Failed(f"slower than {patience_s:g} s") from None
    except OSError as error:
        raise Failed(str(error)) from None
    if done.returncode:
        lines = [line for line in done.stderr.strip().splitlines() if line and not line.startswith("note: ")]
        raise Failed((lines or [f"exit code {done.returncode}"])[-1][:200])
    return json.loads(done.stdout.strip().splitlines()[-1])


def duration(seconds):
    """Returns a time with its unit, to three digits."""
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6)):
        if seconds >= 0.9995 * size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds / 1e-9:.3g} ns"


def table(head, rows):
    """Returns a table in Markdown."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(str(cell) for cell in line) + " |" for line in lines) + "\n"


def machine(versions):
    """Returns a description of the machine and the software; `versions` are the versions of the peers, by name."""
    lines = Path("/proc/cpuinfo").read_text().splitlines() if Path("/proc/cpuinfo").exists() else []
    model = next((line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")), platform.machine())
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30
    rustc = subprocess.run(["rustc", "--version"], capture_output=True, text=True, cwd=ROOT).stdout.split()[:2]
    peers = ", ".join(f"{name} {version}" for name, version in versions.items())
    return f"{os.cpu_count()} cores of {model}, {memory:.0f} GiB, {platform.system()}; {' '.join(rustc)}; Python {platform.python_version()}, {peers}"


def commit():
    """Returns the commit of the sources, with a note if they have changes."""
    words = ["git", "describe", "--always", "--dirty=, with changes"]
    return subprocess.run(words, capture_output=True, text=True, cwd=ROOT).stdout.strip()
