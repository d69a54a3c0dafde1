"""Fixtures: the program of the command line, and a rough map."""

import json
import subprocess
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from support import PROGRAM


@pytest.fixture(scope="session")
def program() -> Callable[..., dict[str, Any]]:
    """Return a function that runs a command and returns its JSON answer."""
    if not PROGRAM.exists():
        pytest.skip(f"{PROGRAM} is not built")

    def run(*arguments: object) -> dict[str, Any]:
        command = [PROGRAM, *map(str, arguments), "--json"]
        answer = subprocess.run(command, capture_output=True, check=True, text=True)
        found: dict[str, Any] = json.loads(answer.stdout)
        return found

    return run


@pytest.fixture
def rough() -> "np.ndarray[Any, np.dtype[np.float64]]":
    """Return a periodic rough map of 64 × 64 points."""
    generator = np.random.default_rng(1)
    q = np.hypot(*np.meshgrid(np.fft.fftfreq(64), np.fft.fftfreq(64)))
    amplitude = np.where(q > 0, np.maximum(q, 1 / 16) ** -1.8, 0)
    waves = np.fft.fft2(generator.standard_normal((64, 64))) * amplitude
    heights = np.fft.ifft2(waves).real
    return 1e-6 * heights / heights.std()
