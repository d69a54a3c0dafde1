"""The virtual environment that holds the packages of a benchmark."""

import hashlib
import os
import subprocess
import sys
from pathlib import Path


def located(requirements):
    """The folder of the environment, under the build folder, its interpreter, and the stamp that says that it is complete."""
    target = Path(os.environ.get("CARGO_TARGET_DIR", requirements.parents[2] / "target")).resolve()
    folder = target / f"{requirements.parent.name}-peers"
    digest = hashlib.sha256(requirements.read_bytes()).hexdigest()[:12]
    return folder, folder / "bin" / "python", folder / f"installed-{digest}"


def install(python, words, **options):
    """Installs packages with pip, into an environment that is made if there is none."""
    if not python.exists():
        subprocess.run([sys.executable, "-m", "venv", python.parents[1]], check=True)
    return subprocess.run([python, "-m", "pip", "install", "--quiet", *words], **options)


def enter(requirements):
    """Runs the calling program again inside an environment with these requirements, which is made under the build folder and kept."""
    folder, python, stamp = located(requirements)
    if not stamp.exists():
        print(f"installing {', '.join(requirements.read_text().split())}", flush=True)
        install(python, ["--requirement", requirements], check=True)
        stamp.touch()
    if Path(sys.prefix).resolve() != folder:
        os.execv(python, [str(python), *sys.argv])


def prepare(requirements, build=None):
    """Installs every paragraph of the requirements on its own and returns, by title, why a paragraph could not be installed.

    `build` returns the words for pip and the environment variables that a paragraph needs besides, given its title.
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
    # What failed is tried again by the next run.
    if not failed:
        stamp.touch()
    return failed
