"""Runs other contact solvers behind one interface: `peers.py NAME` answers jobs, one JSON line each.

A job names a file of heights and the problem. The answer has the seconds of every solve, without the planning of transforms and the
computation of kernels; the pressures are written to a file. The name `transforms` times Fourier transforms.
"""

import json
import os
import sys
import time
from importlib.metadata import version

import numpy as np

MOST_ITERATIONS = 10_000


class Tamaas:
    """Polonsky and Keer's conjugate gradients as given by Rey; Kato's projected gradients with a largest pressure."""

    package = "tamaas"

    def __init__(self, job):
        import tamaas

        tamaas.set_log_level(tamaas.LogLevel.error)
        self.tamaas, self.job = tamaas, job
        n = job["points"]
        self.model = tamaas.ModelFactory.createModel(tamaas.model_type.basic_2d, [1.0, 1.0], [n, n])
        self.model.E, self.model.nu = 1.0, 0.0
        if job["boundary"] == "free":
            tamaas.ModelFactory.registerNonPeriodic(self.model, "dcfft")
            self.model.operators["dcfft"](self.model.traction, self.model.displacement)
        else:
            self.model.solveNeumann()

    def prepare(self, heights):
        tolerance, hardness = self.job["tolerance"], self.job["hardness"]
        # Solvers start from the fields of the model.
        self.model.traction[...] = 0
        self.model.displacement[...] = 0
        heights = np.ascontiguousarray(heights)
        if hardness is None:
            solver = self.tamaas.PolonskyKeerRey(self.model, heights, tolerance)
        else:
            solver = self.tamaas.KatoSaturated(self.model, heights, tolerance, hardness)
        solver.max_iter = MOST_ITERATIONS
        if self.job["boundary"] == "free":
            solver.setIntegralOperator("dcfft")
        self.kept = solver, heights
        return lambda: solver.solve(self.job["mean_pressure"])

    def pressure(self, _):
        return np.array(self.model.traction)


class ContactMechanics:
    """Polonsky and Keer's conjugate gradients; the hardness cuts the force in every iteration."""

    package = "ContactMechanics"

    def __init__(self, job):
        from ContactMechanics import FreeFFTElasticHalfSpace, PeriodicFFTElasticHalfSpace
        from ContactMechanics.Optimization import constrained_conjugate_gradients
        from SurfaceTopography import Topography

        self.job, self.topography, self.solve = job, Topography, constrained_conjugate_gradients
        substrate = FreeFFTElasticHalfSpace if job["boundary"] == "free" else PeriodicFFTElasticHalfSpace
        n = job["points"]
        self.substrate = substrate((n, n), 1.0, (1.0, 1.0))
        self.substrate.evaluate_disp(np.zeros(self.substrate.nb_domain_grid_pts))

    def prepare(self, heights):
        job = self.job
        map = self.topography(heights, (1.0, 1.0), periodic=job["boundary"] == "periodic")
        hardness = None if job["hardness"] is None else job["hardness"] * self.substrate.area_per_pt
        # The overlap is the only criterion, because others can only take longer.
        return lambda: self.solve(
            self.substrate, map, hardness=hardness, external_force=job["mean_pressure"], forcetol=np.inf, thermotol=np.inf,
            pentol=job["tolerance"] * heights.std(), maxiter=MOST_ITERATIONS)

    def pressure(self, result):
        if not result.success:
            raise RuntimeError(f"not converged after {result.nit} iterations")
        n = self.job["points"]
        force = np.abs(np.asarray(result.jac)[:n, :n])
        pressure = force / self.substrate.area_per_pt
        # Rounding in force units.
        hardness = self.job["hardness"]
        return pressure if hardness is None else np.where(pressure > hardness * (1 - 1e-12), hardness, pressure)


class Aspher:
    """Preconditioned conjugate gradients on nested grids; the free boundary by an exact convolution."""

    package = "aspher"
    precision = "double"

    def __init__(self, job):
        import aspher

        self.aspher, self.job = aspher, job

    def prepare(self, heights):
        job, n = self.job, self.job["points"]
        backend = "fft" if job["boundary"] == "free" else "periodic"
        gap = np.ascontiguousarray(-heights.ravel())
        # Every call builds the operators, and reports the time for it.
        return lambda: self.aspher.solve_nested(
            grid_size=n, gap=gap, p_nominal=job["mean_pressure"], coarsest=min(64, n // 2), tol=job["tolerance"],
            backend=backend, precision=self.precision)

    def untimed(self, result):
        return result.timings["build"]

    def pressure(self, result):
        return np.array(result.pressure)


class AspherMixed(Aspher):
    """ASPHER, first in single precision."""

    precision = "float_then_double"


class AspherSingleGrid(Aspher):
    """ASPHER, on the finest grid alone."""

    def __init__(self, job):
        super().__init__(job)
        backend = "fft" if job["boundary"] == "free" else "periodic"
        self.solver = self.aspher.ContactSolver(grid_size=job["points"], backend=backend)

    def prepare(self, heights):
        job, gap = self.job, np.ascontiguousarray(-heights.ravel())
        return lambda: self.solver.solve(gap, p_nominal=job["mean_pressure"], tol=job["tolerance"], precond="fourier")

    def untimed(self, _):
        return 0.0


SOLVERS = {
    "Tamaas": Tamaas, "ContactMechanics": ContactMechanics, "ASPHER": Aspher, "ASPHER, mixed precision": AspherMixed,
    "ASPHER, one grid": AspherSingleGrid,
}


def transforms(points, boundary):
    """Returns the median seconds of a forward and an inverse real transform by pocketfft (of SciPy) and FFTW (measured plans)."""
    import pyfftw
    import scipy.fft

    length = points if boundary == "periodic" else 2 * points
    map = np.random.default_rng(1).standard_normal((length, length))
    aligned = pyfftw.empty_aligned(map.shape)
    spectrum = pyfftw.empty_aligned((length, length // 2 + 1), dtype=complex)
    there = pyfftw.FFTW(aligned, spectrum, axes=(0, 1), flags=["FFTW_MEASURE"])
    back = pyfftw.FFTW(spectrum, aligned, axes=(0, 1), direction="FFTW_BACKWARD", flags=["FFTW_MEASURE", "FFTW_DESTROY_INPUT"])
    aligned[...] = map

    def fftw():
        there.execute()
        back.execute()
        np.multiply(aligned, 1 / length**2, out=aligned)

    def pocketfft():
        scipy.fft.irfft2(scipy.fft.rfft2(map), s=map.shape, overwrite_x=True)

    answer = {}
    for name, pair in (("FFTW", fftw), ("pocketfft", pocketfft)):
        pair()
        seconds, begin = [], time.perf_counter()
        while len(seconds) < 3 or time.perf_counter() - begin < 0.3:
            start = time.perf_counter()
            pair()
            seconds.append(time.perf_counter() - start)
        answer[name] = float(np.median(seconds))
    return answer


def solve(solver, job):
    """Solves every map of a job `repeats` times, after `warm_up` times that are not timed."""
    n = job["points"]
    maps = np.fromfile(job["heights"], "<f8").reshape(-1, n, n)
    seconds, pressures, iterations = [], np.empty_like(maps), []
    for turn in range(job["warm_up"] + job["repeats"]):
        total, iterations = 0.0, []
        for heights, pressure in zip(maps, pressures):
            work = solver.prepare(heights)
            start = time.perf_counter()
            result = work()
            total += time.perf_counter() - start
            if hasattr(solver, "untimed"):
                total -= solver.untimed(result)
            pressure[...] = solver.pressure(result)
            iterations.append(getattr(result, "iterations", getattr(result, "nit", None)))
        if turn >= job["warm_up"]:
            seconds.append(total)
    pressures.tofile(job["pressure"])
    return {"seconds": seconds, "iterations": iterations}


def answer(name, job, kept):
    if name == "transforms":
        return transforms(job["points"], job["boundary"])
    kind = SOLVERS[name]
    if job.get("ask") == "version":
        __import__(kind.package)
        return {"version": version(kind.package)}
    problem = [job[key] for key in ("points", "boundary", "hardness")]
    if kept.get("problem") != problem:
        kept.clear()
        kept.update(solver=kind(job), problem=problem)
    kept["solver"].job = job
    return solve(kept["solver"], job)


def main():
    # The output of packages must not mix with the answers.
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    kept = {}
    for line in sys.stdin:
        try:
            reply = answer(sys.argv[1], json.loads(line), kept)
        except Exception as error:
            reply = {"error": f"{type(error).__name__}: {(str(error).strip().splitlines() or [''])[0][:200]}"}
        print(json.dumps(reply), file=answers, flush=True)


if __name__ == "__main__":
    main()
