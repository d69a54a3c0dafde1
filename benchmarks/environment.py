"""Virtual environments with the packages of the benchmarks."""

import hashlib
import os
import subprocess
import sys
from pathlib import Path


def located(requirements):
    """Returns the folder of the environment below the build folder, its interpreter, and the stamp file of a complete environment."""
    target = Path(os.environ.get("CARGO_TARGET_DIR", requirements.parents[2] / "target")).resolve()
    folder = target / f"{requirements.parent.name}-peers"
    digest = hashlib.sha256(requirements.read_bytes()).hexdigest()[:12]
    return folder, folder / "bin" / "python", folder / f"installed-{digest}"


def install(python, words, **options):
    """Installs packages with pip; creates the environment if there is none."""
    if not python.exists():
        subprocess.run([sys.executable, "-m", "venv", python.parents[1]], check=True)
    return subprocess.run([python, "-m", "pip", "install", "--quiet", *words], **options)


def enter(requirements):
    """Runs the calling program again inside an environment with these requirements, which is created below the build folder and kept."""
    folder, python, stamp = located(requirements)
    if not stamp.exists():
        print(f"installing {', '.join(requirements.read_text().split())}", flush=True)
        install(python, ["--requirement", requirements], check=True)
        stamp.touch()
    if Path(sys.prefix).resolve() != folder:
        os.execv(python, [str(python), *sys.argv])


def prepare(requirements, build=None):
    """Installs each paragraph of the requirements separately and returns the reasons of failures, by title.

    `build` returns additional arguments of pip and environment variables for the title of a paragraph.
    """
    _, python, stamp = located(requirements)
    if stamp.exists():
        return {}
    failed = {}
    for paragraph in requirements.read_text().split("\n\n")[1:]:
        title, *packages = paragraph.strip().splitlines()
        title = title[2:]
        print(f"installing {', '.join(packages)}", flush=True)
        words, variables = build(title) if build else ([], {})
        done = install(python, [*words, *packages], capture_output=True, text=True, env=os.environ | variables)
        if done.returncode:
            lines = [line for line in done.stderr.splitlines() if "error" in line.lower()]
            failed[title] = (lines or ["pip failed"])[-1][:200]
    if "base" in failed:
        raise SystemExit(f"the virtual environment cannot be made: {failed['base']}")
    # The next run tries the failed paragraphs again.
    if not failed:
        stamp.touch()
    return failed
