"""Times asperity's readers against NumPy, SurfaceTopography and surfalize on one map in several formats.

    python3 benchmarks/formats/run.py [--points 2048] [--asperity PROGRAM] [--keep FOLDER]

Every time is the best of up to five, with the file in the page cache. Writes RESULTS.md beside this file. The peers are installed
into a virtual environment below the build folder, which is kept.
"""

import argparse
import gc
import os
import struct
import subprocess
import sys
import tempfile
import time
import warnings
import zipfile
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Callable

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))
from environment import enter
from harness import ROOT, machine

enter(HERE / "requirements.txt")

import numpy as np

warnings.filterwarnings("ignore")

PACKAGES = ("numpy", "SurfaceTopography", "surfalize")
REPEATS = 5
# Total time after which a reader is not repeated.
BUDGET_S = 60.0
# Limits: for text, the smallest speed-up over numpy.loadtxt; for binary files, the largest time over that of numpy.fromfile
# and astype(float).
TEXT_BAR, BINARY_BAR = 5.0, 2.0
PITCH_M = 1e-6


def self_affine(points, hurst=0.8, rms_m=1e-6, seed=2016):
    """Returns Gaussian heights in metre whose spectrum falls like q^(-2 - 2H)."""
    noise = np.fft.rfft2(np.random.default_rng(seed).standard_normal((points, points)))
    q = np.hypot(np.fft.fftfreq(points)[:, None], np.fft.rfftfreq(points)[None, :])
    q[0, 0] = np.inf
    heights = np.fft.irfft2(noise * q ** (-1 - hurst), s=(points, points))
    return heights * (rms_m / heights.std())


@dataclass
class Case:
    """A format: the writer of its file, the simplest reader in NumPy, and the packages that read it."""

    name: str
    extension: str
    # Name and function of the writer, if asperity does not write the file.
    writer: str
    write: Callable | None
    baseline_name: str
    baseline: Callable
    is_text: bool = False
    # Relative to the range of heights; integers and single-precision factors limit the precision.
    tolerance: float = 1e-12
    peers: tuple = ("SurfaceTopography", "surfalize")
    # Whether `asperity surface convert` is tried first.
    ask: bool = True


class Refused(Exception):
    """A program does not write or read a format."""


def convert(arguments, source, target):
    """Writes `target` with `asperity surface convert`."""
    command = [arguments.asperity, "--quiet", "surface", "convert", source, target, "--pixel-size", f"{PITCH_M * 1e6} um"]
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if done.returncode:
        lines = done.stderr.strip().splitlines()
        raise Refused(lines[0].replace(f"{target}: ", "") if lines else f"exit code {done.returncode}")


def surfalize_surface(heights):
    from surfalize import Surface

    return Surface(heights * 1e6, PITCH_M * 1e6, PITCH_M * 1e6)


def topography(heights):
    from SurfaceTopography import Topography

    # Their first index is x.
    size = tuple(n * PITCH_M for n in heights.T.shape)
    return Topography(heights.T, size, unit="m")


def sur_int16(path, heights):
    """Writes a Digital Surf file of 16-bit heights, with the published layout of the header."""
    scale = np.float32(np.ptp(heights) * 1e9 / 65000)
    middle = (heights.min() + heights.max()) / 2
    stored = np.round((heights - middle) * 1e9 / scale).astype("<i2")
    header = bytearray(512)
    header[:12] = b"DIGITAL SURF"
    # Format, objects, version, type (a surface); bits per point.
    struct.pack_into("<4h", header, 12, 0, 1, 1, 2)
    struct.pack_into("<h", header, 98, 16)
    rows, columns = stored.shape
    struct.pack_into("<5i3f", header, 100, stored.min(), stored.max(), columns, rows, stored.size, 1.0, 1.0, scale)
    for place, unit in zip((180, 196, 212, 228, 244, 260), (b"um", b"um", b"nm") * 2):
        header[place : place + 16] = unit.ljust(16)
    struct.pack_into("<3f", header, 276, 1.0, 1.0, 1.0)
    path.write_bytes(bytes(header) + stored.tobytes())


def tmd(path, heights):
    """Writes a TrueMap file with lengths and heights in millimetre, as the routines of the vendor do. surfalize writes micrometre."""
    rows, columns = heights.shape
    header = b"Binary TrueMap Data File v2.0\r\n\0" + b"map".ljust(24, b"\0")
    header += struct.pack("<2I4f", columns, rows, columns * PITCH_M * 1e3, rows * PITCH_M * 1e3, 0.0, 0.0)
    path.write_bytes(header + (heights * 1e3).astype("<f4").tobytes())


def numbers(path, count):
    """Reads the last bytes of a file as `count` numbers in the fastest way of NumPy."""
    size = path.stat().st_size
    kind = {2: "<i2", 4: "<i4", 8: "<f8"}[min(8, size // count)]
    offset = size - count * np.dtype(kind).itemsize
    return np.fromfile(path, kind, count, offset=offset).astype(float)


def zipped_numbers(path, count):
    """Reads the largest file of an archive as `count` numbers."""
    with zipfile.ZipFile(path) as archive:
        largest = max(archive.infolist(), key=lambda entry: entry.file_size)
        content = archive.read(largest)
    kind = {2: "<i2", 4: "<f4", 8: "<f8"}[len(content) // count]
    return np.frombuffer(content, kind, count).astype(float)


def cases():
    fromfile = "numpy.fromfile + astype"
    unzip = "zipfile + numpy.frombuffer + astype"
    loose = 1e-6
    surfalize = ("surfalize", lambda path, z: surfalize_surface(z).save(path))
    both = ("SurfaceTopography", "surfalize")
    return [
        Case("text", "txt", "numpy", lambda path, z: np.savetxt(path, z), "numpy.loadtxt",
             lambda path, n: np.loadtxt(path), is_text=True, peers=both[:1], ask=False),
        Case("CSV", "csv", "numpy", lambda path, z: np.savetxt(path, z, delimiter=","), "numpy.loadtxt",
             lambda path, n: np.loadtxt(path, delimiter=","), is_text=True, peers=(), ask=False),
        Case("NPY", "npy", "numpy", lambda path, z: np.save(path, z), fromfile, numbers, peers=both[:1], ask=False),
        Case("NPZ", "npz", "numpy", lambda path, z: np.savez(path, heights=z), "numpy.load",
             lambda path, n: np.load(path)["heights"], peers=(), ask=False),
        Case("X3P", "x3p", "", None, unzip, zipped_numbers),
        Case("SUR, int16", "sur", "this script", sur_int16, fromfile, numbers, tolerance=2**-15, ask=False),
        Case("SUR", "sur", *surfalize, fromfile, numbers, tolerance=loose),
        Case("SDF, binary", "sdf", *surfalize, fromfile, numbers, tolerance=loose),
        Case("AL3D", "al3d", *surfalize, fromfile, numbers, tolerance=loose),
        Case("TMD", "tmd", "this script", tmd, fromfile, numbers, tolerance=loose, ask=False),
        Case("NetCDF, classic", "nc", both[0], lambda path, z: topography(z).to_netcdf(str(path)), fromfile, numbers,
             peers=both[:1]),
        Case("GWY", "gwy", both[0], lambda path, z: topography(z).to_gwy(str(path)), fromfile, numbers),
    ]


def read_surface_topography(path):
    from SurfaceTopography import read_topography

    # Text and NPY have no size, which the reader needs.
    size = {"physical_sizes": (1.0, 1.0)} if path.suffix in (".txt", ".npy") else {}
    read = read_topography(str(path), **size)
    unit = {"m": 1.0, "mm": 1e-3, "µm": 1e-6, "um": 1e-6, "nm": 1e-9, "pm": 1e-12, None: 1.0}[read.unit]
    return np.ma.filled(read.heights(), np.nan).T * unit


def read_surfalize(path):
    from surfalize import Surface

    return Surface.load(path).data * 1e-6


PEERS = {"SurfaceTopography": read_surface_topography, "surfalize": read_surfalize}


def best_of(function):
    """Returns the last result and the best time in second; the first call, which warms up, counts only if it is very slow."""
    times = []
    begin = time.perf_counter()
    for repeat in range(REPEATS + 1):
        gc.collect()
        start = time.perf_counter()
        result = function()
        took = time.perf_counter() - start
        if repeat or took > BUDGET_S / 2:
            times.append(took)
        if times and time.perf_counter() - begin > BUDGET_S:
            break
    return result, min(times)


def difference(found, wanted):
    """Returns the largest difference over the range of heights, and a description of other differences."""
    if found.shape != wanted.shape:
        return np.inf, f"shape {found.shape}"
    range_m = np.ptp(wanted)

    def largest(array):
        # Writers of integers move the datum; that is no difference in shape.
        apart = array - wanted
        return np.max(np.abs(apart - np.median(apart))) / range_m, np.abs(np.median(apart)) / range_m

    results = {"": found, "upside down": found[::-1], "transposed": found.T, "turned": found.T[::-1]}
    best = min(results, key=lambda name: largest(results[name])[0])
    apart, shift = largest(results[best])
    words = [best] if best else []
    if shift > max(apart, 1e-12):
        words.append("datum moved")
    return apart, ", ".join(words)


def ours(arguments, path, folder):
    """Returns heights, best and median time of asperity."""
    heights = folder / "ours.npy"
    done = subprocess.run([arguments.time_read, path, str(REPEATS), heights], capture_output=True, text=True)
    if done.returncode:
        raise Refused(done.stderr.strip().splitlines()[0].removeprefix(f"{path}: "))
    _, _, best, median = done.stdout.split()
    return np.load(heights), float(best), float(median)


def run(arguments, folder):
    """Returns one row for every case, notes, and whether any heights of asperity are wrong."""
    z = self_affine(arguments.points)
    source = folder / "source.npy"
    np.save(source, z)
    rows, notes, failed = [], [], False
    for place, case in enumerate(cases()):
        path = folder / f"{place}.{case.extension}"
        writer = "asperity"
        try:
            if not case.ask:
                raise Refused
            convert(arguments, source, path)
        except Refused as reason:
            if case.write is None:
                notes.append(f"{case.name}: left out, `asperity surface convert` does not write it: {reason}")
                continue
            writer = case.writer
            try:
                case.write(path, z)
            except Exception as error:
                notes.append(f"{case.name}: left out, no writer: {type(error).__name__}: {error}")
                continue
        try:
            heights, best, median = ours(arguments, path, folder)
        except Refused as reason:
            notes.append(f"{case.name}: left out, asperity does not read it: {reason}")
            continue
        apart, words = difference(heights, z)
        if apart > case.tolerance or "turned" in words or "transposed" in words or "upside" in words:
            failed = True
            notes.append(f"{case.name}: **asperity's heights differ by {apart:.1e} of the range** {words}")
        _, baseline = best_of(lambda: case.baseline(path, z.size))
        ratio = baseline / best if case.is_text else best / baseline
        met = ratio >= TEXT_BAR if case.is_text else ratio <= BINARY_BAR
        peers = {}
        for name in case.peers:
            try:
                found, peers[name] = best_of(lambda: PEERS[name](path))
                apart, words = difference(found, z)
                if apart > max(case.tolerance, 1e-9) or words:
                    notes.append(f"{case.name}: {name} differs by {apart:.1e} of the range {words}".rstrip())
            except Exception as error:
                notes.append(f"{case.name}: {name} does not read it: {type(error).__name__}: {first_line(error)}")
        megabytes = path.stat().st_size / 1e6
        rows.append((case, writer, megabytes, baseline, best, median, ratio, met, peers))
        print(f"{case.name}: {best:.4f} s, {case.baseline_name} {baseline:.4f} s, ratio {ratio:.2f}", flush=True)
        if not arguments.keep:
            path.unlink()
    return rows, notes, failed


def first_line(error):
    """Returns the first line of the message of an error, shortened for a list."""
    return (str(error).strip().splitlines() or [""])[0][:100].strip()


def table(rows, notes, points):
    head = (
        "# Reading files\n\n"
        "Made by `benchmarks/formats/run.py`.\n\n"
        f"One self-affine map of {points} × {points} heights. Times in second, the best of {REPEATS} with the file in the page\n"
        "cache; for asperity the median as well. Each time is compared with the simplest way to read the same numbers in NumPy:\n"
        f"text must be read at least {TEXT_BAR:g} times as fast, binary numbers in at most {BINARY_BAR:g} times the time.\n\n"
        f"Machine: {machine({name: version(name) for name in PACKAGES})}.\n\n"
    )
    lines = [
        "| format | MB | written by | compared with | its time | asperity, best | median | ratio | bar | SurfaceTopography | surfalize |",
        "|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for case, writer, megabytes, baseline, best, median, ratio, met, peers in rows:
        bar = f"≥ {TEXT_BAR:g}" if case.is_text else f"≤ {BINARY_BAR:g}"
        peer = [f"{peers[name]:.3f}" if name in peers else "" for name in PEERS]
        lines.append(
            f"| {case.name} | {megabytes:.1f} | {writer} | {case.baseline_name} | {baseline:.4f} | {best:.4f} | {median:.4f} "
            f"| {ratio:.2f} | {bar} {'met' if met else '**missed**'} | {peer[0]} | {peer[1]} |"
        )
    listed = "".join(f"- {note}\n" for note in notes)
    return head + "\n".join(lines) + "\n" + (f"\n## Notes\n\n{listed}" if notes else "")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--points", type=int, default=2048, help="points along each side")
    parser.add_argument("--asperity", type=Path, help="the program; built when left out")
    parser.add_argument("--keep", type=Path, help="folder that keeps the files")
    arguments = parser.parse_args()
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release"
    build = ["cargo", "build", "--release", "--quiet"]
    subprocess.run(build + ["-p", "asperity-benchmarks", "--bin", "time_read"], cwd=ROOT, check=True)
    arguments.time_read = target / "time_read"
    if arguments.asperity is None:
        subprocess.run(build + ["-p", "asperity-cli"], cwd=ROOT, check=True)
        arguments.asperity = target / "asperity"
    with tempfile.TemporaryDirectory() as temporary:
        folder = arguments.keep or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        rows, notes, failed = run(arguments, folder)
    (HERE / "RESULTS.md").write_text(table(rows, notes, arguments.points), encoding="utf-8")
    raise SystemExit(1 if failed else 0)


if __name__ == "__main__":
    main()
