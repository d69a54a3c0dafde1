"""Runs the quickstart with the program that the tests built, and checks what a newcomer relies on."""

import json
import pathlib
import subprocess
import sys
import tomllib

PROGRAM = "target/debug/asperity"
STUDY = pathlib.Path("studies/quickstart.toml")
OUT = pathlib.Path("target/quickstart")

subprocess.run([PROGRAM, "run", STUDY, "--out", OUT, "--force", "--quiet"], check=True)
study = tomllib.loads(STUDY.read_text())
results = json.loads((OUT / "results.json").read_text())
surface, point = results["surface"], results["friction"]["operating_point"]
scan = json.loads(
    subprocess.run(
        [PROGRAM, "surface", "stats", STUDY.parent / study["surface"]["file"], "--level", "plane", "--json", "--quiet"],
        check=True,
        capture_output=True,
    ).stdout
)

# Contact cells of a window: its share of the cells of a strip, times the contact fraction.
length_mm, _ = study["friction"]["strip"][0].split()
nx, ny = study["friction"]["points"]
window_cells = nx * ny * results["friction"]["window_m"] / (float(length_mm) * 1e-3)
checks = {
    "the scan spans 25 correlation lengths along x": scan["nx"] * scan["dx_m"] >= 25 * scan["correlation_length_x_m"],
    "the scan spans 25 correlation lengths along y": scan["ny"] * scan["dy_m"] >= 25 * scan["correlation_length_y_m"],
    "lengths, heights and slopes have intervals": all(
        surface[f"{key}_interval"] for key in ["Sq_m", "Ssk", "Sku", "Sdq", "correlation_length_x_m", "correlation_length_y_m"]
    ),
    "the friction coefficient has intervals": bool(point["mean_interval"] and point["std_interval"]),
    "windows contain hundreds of contact cells": window_cells * point["contact_fraction"] > 200,
    "random surfaces have the slopes of the scan": abs(surface["covariance"]["slope_ratio"] - 1) < 0.15,
    "the brake vibrates": results["vibration"]["kind"] == "stick_slip",
    # The warning is about the pitch of the strips; more points would remove it.
    "at most one warning": len(results["warnings"]) <= 1,
}
for name, holds in checks.items():
    print("ok    " if holds else "FAILED", name)
sys.exit(not all(checks.values()))
