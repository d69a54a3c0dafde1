"""The virtual environment that holds the packages of a benchmark."""

import hashlib
import os
import subprocess
import sys
from pathlib import Path


def enter(requirements):
    """Runs the calling program again inside an environment with these requirements, which is made under the build folder and kept."""
    text = requirements.read_bytes()
    target = Path(os.environ.get("CARGO_TARGET_DIR", requirements.parents[2] / "target")).resolve()
    environment = target / f"{requirements.parent.name}-peers"
    python = environment / "bin" / "python"
    stamp = environment / f"installed-{hashlib.sha256(text).hexdigest()[:12]}"
    if not stamp.exists():
        if not python.exists():
            subprocess.run([sys.executable, "-m", "venv", environment], check=True)
        print(f"installing {', '.join(text.decode().split())}", flush=True)
        subprocess.run([python, "-m", "pip", "install", "--quiet", "--requirement", requirements], check=True)
        stamp.touch()
    if Path(sys.prefix).resolve() != environment:
        os.execv(python, [str(python), *sys.argv])
