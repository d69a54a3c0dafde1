"""Times the surface analyses and Karhunen–Loève modes of asperity against surfalize, SurfaceTopography and OpenTURNS.

    python3 benchmarks/surfaces/run.py [--points 2048]

Every comparison runs both programs in turn on the same map and first compares their results. Writes RESULTS.md beside this
file. The peers are installed into a virtual environment below the build folder, which is kept.
"""

import argparse
import csv
import json
import os
import subprocess
import sys
import tempfile
import time
import warnings
from importlib.metadata import version
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from environment import enter
from harness import ROOT, machine

enter(HERE / "requirements.txt")

import numpy as np

warnings.filterwarnings("ignore")

PITCH_M = 1e-6
PACKAGES = ("numpy", "surfalize", "SurfaceTopography", "openturns")
REPEATS = 3
# Limits: smallest ratios of a peer's time to asperity's.
PARAMETERS_BAR, SPECTRA_BAR, MODES_BAR = 10.0, 10.0, 50.0
MODES = 101
OURS_SIDE, THEIR_SIDE = 64, 48
LENGTH = 0.2

# Name in surfalize, name in asperity, factor to the unit of asperity.
SAME = [
    ("Sa", "Sa_m", 1e-6), ("Sq", "Sq_m", 1e-6), ("Sp", "Sp_m", 1e-6), ("Sv", "Sv_m", 1e-6), ("Sz", "Sz_m", 1e-6),
    ("Ssk", "Ssk", 1), ("Sku", "Sku", 1), ("Sdq", "Sdq", 1), ("Sdr", "Sdr", 0.01), ("Sal", "Sal_m", 1e-6), ("Str", "Str", 1),
    ("Sk", "Sk_m", 1e-6), ("Spk", "Spk_m", 1e-6), ("Svk", "Svk_m", 1e-6), ("Smr1", "Smrk1", 0.01),
    ("Smr2", "Smrk2", 0.01), ("Vmp", "Vmp_m", 1e-6), ("Vmc", "Vmc_m", 1e-6), ("Vvc", "Vvc_m", 1e-6), ("Vvv", "Vvv_m", 1e-6),
]


RMS_M, HURST, ROLL_OFF = 1e-6, 0.8, 8


def amplitude(waves_per_side):
    """Returns amplitudes that are flat up to the roll-off and then fall like q^(-1 - H)."""
    return np.maximum(waves_per_side, ROLL_OFF) ** (-1 - HURST)


def self_affine(points, seed=2016):
    """Returns Gaussian heights with a self-affine spectrum, and the spectrum in m⁴ as a function of the wavenumber in rad/m."""
    noise = np.fft.rfft2(np.random.default_rng(seed).standard_normal((points, points)))
    frequency = np.fft.fftfreq(points) * points
    heights = np.fft.irfft2(noise * amplitude(np.hypot(frequency[:, None], frequency[None, : points // 2 + 1])), s=(points, points))
    heights -= heights.mean()
    power = (amplitude(np.hypot(frequency[:, None], frequency[None, :])) ** 2).sum() - amplitude(0) ** 2
    side_m = points * PITCH_M
    spectrum = lambda q: (RMS_M * side_m * amplitude(q * side_m / (2 * np.pi))) ** 2 / power
    return heights * (RMS_M / heights.std()), spectrum


def timed(function):
    """Returns the best time in second and the last result."""
    times = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        result = function()
        times.append(time.perf_counter() - start)
        if times[0] > 60:
            break
    return min(times), result


def ours(arguments, program, *words):
    done = subprocess.run([arguments.target / program, *map(str, words)], capture_output=True, text=True, check=True)
    return done.stdout.splitlines()


def best(lines, name):
    """Returns the best time that `time_surface` prints for an analysis."""
    line = next(line for line in lines if line.startswith(name))
    return float(line.split("best")[1].split()[0])


def parameters(arguments, heights, source):
    """Times and compares all parameters of ISO 25178-2."""
    from surfalize import Surface

    done = subprocess.run(
        [arguments.target / "asperity", "--quiet", "surface", "stats", source, "--level", "none", "--pixel-size", "1 um", "--json"],
        capture_output=True, text=True, check=True)
    found = json.loads(done.stdout)
    # Height, spatial, hybrid, functional and volume parameters; only surfalize has the features of ISO 25178-2 (Spd, S10z, …).
    names = [name for name, _, _ in SAME] + ["Std", "Ssw", "Spkx", "Svkx", "Sxp"]

    def all_of_them():
        # A new surface for every call, because a surface stores its results.
        surface = Surface(heights * 1e6, 1.0, 1.0)
        return {name: getattr(surface, name)() for name in names}

    theirs_s, theirs = timed(all_of_them)
    ours_s = best(ours(arguments, "time_surface", source, 5, "texture parameters"), "texture parameters")
    apart = {name: abs(found[own] / (theirs[name] * factor) - 1) for name, own, factor in SAME if abs(theirs[name]) > 1e-3}
    worst = max(apart, key=apart.get)
    note = f"{len(apart)} parameters differ by at most {100 * apart[worst]:.2g} % ({worst}); {len(theirs)} are timed"
    return theirs_s, ours_s, note


def spectra(arguments, heights, source, folder, truth):
    """Times and compares the autocorrelation and the radial power spectrum."""
    from SurfaceTopography import Topography

    size = tuple(n * PITCH_M for n in heights.T.shape)

    def theirs():
        topography = Topography(heights.T, size, unit="m")
        return topography.autocorrelation_from_area(), topography.power_spectrum_from_area()

    theirs_s, ((their_lag, their_acf), (their_q, their_psd)) = timed(theirs)
    lines = ours(arguments, "time_surface", source, 5, "autocorrelation") + ours(arguments, "time_surface", source, 5, "radial power")
    ours_s = best(lines, "autocorrelation") + best(lines, "radial power")
    ours(arguments, "time_surface", source, 1, "radial power", folder)
    with open(folder / "radial_spectrum.csv") as file:
        rows = [(float(row["wavenumber_rad_per_m"]), float(row["psd_m4"])) for row in csv.DictReader(file)]
    q, psd = np.array([row for row in rows if row[1] > 0]).T
    # In eight bands, the mean of the ratio to the spectrum of the generator is compared with that of the plain periodogram in
    # rings, which is exact because the map is periodic. The ratio removes the slope within a bin.
    edges = np.geomspace(20 * q[q > 0].min(), 0.5 * np.pi / PITCH_M, 9)

    def bands(x, y):
        known = (x > 0) & (y > 0)
        ratio, band = y[known] / truth(x[known]), np.digitize(x[known], edges)
        return np.array([ratio[band == place].mean() for place in range(1, len(edges))])

    points = len(heights)
    power = np.abs(np.fft.fft2(heights)) ** 2 * PITCH_M**2 / points**2
    frequency = np.fft.fftfreq(points) * points
    waves = np.hypot(frequency[:, None], frequency[None, :]).ravel()
    ring = np.rint(waves).astype(int)
    count = np.bincount(ring)
    exact = bands(np.bincount(ring, waves) / count * 2 * np.pi / (points * PITCH_M), np.bincount(ring, power.ravel()) / count)
    error = lambda x, y: np.abs(bands(x, y) / exact - 1).max()
    note = (f"largest difference from the exact periodogram over eight bands: SurfaceTopography {100 * error(their_q, their_psd):.2g} %, "
            f"asperity {100 * error(q, psd):.2g} %")
    return theirs_s, ours_s, note


def eigenvalues(arguments, side):
    done = subprocess.run(
        [arguments.target / "asperity", "--quiet", "surface", "modes", "--covariance", "exponential", "--correlation-length", f"{LENGTH} m",
         "--size", "1 m,1 m", "--points", f"{side},{side}", "--modes", str(MODES), "--route", "general", "--json"],
        capture_output=True, text=True, check=True)
    found = json.loads(done.stdout)
    return np.array(found["eigenvalues"])


def karhunen_loeve(arguments):
    """Times and compares 101 modes of an isotropic exponential covariance, which is not separable, on the unit square."""
    import openturns

    covariance = openturns.MaternModel([LENGTH] * 2, [1.0], 0.5)

    def theirs():
        mesh = openturns.IntervalMesher([THEIR_SIDE - 1] * 2).build(openturns.Interval([0.0, 0.0], [1.0, 1.0]))
        algorithm = openturns.KarhunenLoeveP1Algorithm(mesh, covariance, 0.0)
        algorithm.setNbModes(MODES)
        algorithm.run()
        return np.array(algorithm.getResult().getEigenvalues())

    theirs_s, their_values = timed(theirs)
    line = next(line for line in ours(arguments, "time_modes", OURS_SIDE, "exponential") if line.startswith("exponential"))
    ours_s = float(line.split("wall")[1].split()[0])
    # The reference: eigenvalues of asperity at three sides, extrapolated by the observed order.
    coarse, middle, fine = (eigenvalues(arguments, side) for side in (64, 128, 256))
    ratio = (coarse - middle) / (middle - fine)
    truth = fine - (middle - fine) / (ratio - 1)
    error = lambda values: np.abs(values[:12] / truth[:12] - 1).max()
    note = (f"largest error of the first 12 eigenvalues: OpenTURNS at {THEIR_SIDE}² {error(their_values):.1e}, asperity at {OURS_SIDE}² "
            f"{error(coarse):.1e} (against asperity at 64², 128², 256², extrapolated)")
    return theirs_s, ours_s, note


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--points", type=int, default=2048, help="points along each side of the map")
    parser.add_argument("--skip-modes", action="store_true", help="leave out OpenTURNS, which takes minutes")
    arguments = parser.parse_args()
    arguments.target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release"
    build = ["cargo", "build", "--release", "--quiet"]
    subprocess.run(build + ["-p", "asperity-cli"], cwd=ROOT, check=True)
    subprocess.run(build + ["-p", "asperity-benchmarks", "--bin", "time_surface", "--bin", "time_modes"], cwd=ROOT, check=True)
    points = arguments.points
    rows = []

    def compare(work, peer, bar, function, *words):
        theirs_s, ours_s, note = function(arguments, *words)
        rows.append((work, peer, theirs_s, ours_s, bar, note))
        print(f"{work}: {peer} {theirs_s:.3f} s, asperity {ours_s:.4f} s, ratio {theirs_s / ours_s:.1f}; {note}", flush=True)

    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        heights, truth = self_affine(points)
        source = folder / "map.npy"
        np.save(source, heights)
        compare(f"all parameters of ISO 25178-2, {points}²", "surfalize", PARAMETERS_BAR, parameters, heights, source)
        compare(f"autocorrelation and radial spectrum, {points}²", "SurfaceTopography", SPECTRA_BAR, spectra, heights, source, folder, truth)
        if not arguments.skip_modes:
            compare(f"{MODES} Karhunen–Loève modes, ours {OURS_SIDE}², theirs {THEIR_SIDE}²", "OpenTURNS", MODES_BAR, karhunen_loeve)
        # Sizes that OpenTURNS cannot reach.
        large = [ours(arguments, "time_modes", side, "exponential")[-1] for side in (256, 1024)]
        large += [ours(arguments, "time_modes", 256, kind)[-1] for kind in ("matern", "oblique", "measured")]
    text = (
        "# Surfaces\n\nMade by `benchmarks/surfaces/run.py`: both programs on the same work in one run, best times in second.\n\n"
        f"Machine: {machine({name: version(name) for name in PACKAGES})}.\n\n"
        "| work | peer | its time | asperity | ratio | bar | results |\n|---|---|---|---|---|---|---|\n"
    )
    for work, peer, theirs_s, ours_s, bar, note in rows:
        ratio = theirs_s / ours_s
        met = "met" if ratio >= bar else "**missed**"
        text += f"| {work} | {peer} | {theirs_s:.3f} | {ours_s:.4f} | {ratio:.0f} | ≥ {bar:g} {met} | {note} |\n"
    text += "\nLarger Karhunen–Loève expansions, on a unit square with correlation lengths of a fifth of it:\n\n"
    text += "".join(f"- {line}\n" for line in large)
    (HERE / "RESULTS.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
