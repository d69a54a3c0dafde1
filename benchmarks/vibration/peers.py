"""Runs one peer: `peers.py NAME` reads a job as JSON from standard input and prints the answer as JSON.

Slip is integrated in X and X' until the relative velocity falls through zero; stick is a straight line and computed in closed form. The
answer to a job has one entry for each relative tolerance of the job.
"""

import json
import os
import sys
import time

# Longest slip that is integrated.
LONGEST_SLIP = 100.0


def timed(run, job):
    """Returns the seconds of the timed runs and the result of the last."""
    seconds = []
    for number in range(job["warm_up"] + job["repeats"]):
        start = time.perf_counter()
        result = run()
        if number >= job["warm_up"]:
            seconds.append(time.perf_counter() - start)
    return seconds, result


class SciPy:
    def __init__(self):
        import numpy
        import scipy.integrate

        self.np, self.scipy, self.solve = numpy, scipy, scipy.integrate.solve_ivp

    def version(self):
        return self.scipy.__version__

    def cycle(self, job, rtol):
        friction, decay, damping, velocity = (job[key] for key in ("friction", "decay", "damping", "velocity"))
        release = friction - 2 * damping * velocity

        def slope(_, y):
            x, v = y
            return v, friction / (1 + decay * (velocity - v)) - 2 * damping * v - x

        def arrival(_, y):
            return velocity - y[1]

        arrival.terminal, arrival.direction = True, -1

        def run():
            total = 0.0
            for _ in range(job["cycles"]):
                found = self.solve(slope, (0, LONGEST_SLIP), (release, velocity), method=job["method"], events=arrival,
                                   rtol=rtol, atol=rtol * job["atol_share"])
                total += found.t[-1] + (release - found.y[0, -1]) / velocity
            return total / job["cycles"]

        seconds, period = timed(run, job)
        return {"seconds": seconds, "period": period}

    def path(self, job, rtol):
        friction, decay, damping, velocity = (job[key] for key in ("friction", "decay", "damping", "velocity"))
        step, duration = job["step"], job["duration"]
        drag = 2 * damping * velocity

        def follow(knots):
            last = len(knots) - 2

            def fluctuation(s):
                place = max(s, 0.0) / step
                cell = min(int(place), last)
                return knots[cell] + (knots[cell + 1] - knots[cell]) * (place - cell)

            def slope(_, y):
                x, v, s = y
                return v, friction / (1 + decay * (velocity - v)) + fluctuation(s) - 2 * damping * v - x, velocity - v

            def arrival(_, y):
                return velocity - y[1]

            arrival.terminal, arrival.direction = True, -1
            tau, x, s, ends = 0.0, 0.97 * friction - drag, 0.0, []
            while True:
                release = max(friction + fluctuation(s) - drag, x)
                tau += (release - x) / velocity
                if tau >= duration:
                    return ends
                found = self.solve(slope, (0, LONGEST_SLIP), (release, velocity, s), method=job["method"], events=arrival,
                                   rtol=rtol, atol=rtol * job["atol_share"])
                x, s, tau = found.y[0, -1], found.y[2, -1], tau + found.t[-1]
                if tau > duration:
                    return ends
                if found.y[1].min() < 0:
                    ends.append(float(tau))

        paths = self.np.fromfile(job["knots"], "<f8").reshape(job["written"], -1)[: job["paths"]].tolist()
        seconds, ends = timed(lambda: [follow(knots) for knots in paths], job)
        return {"seconds": seconds, "ends": ends}


class Diffrax:
    def __init__(self):
        # One thread.
        if hasattr(os, "sched_setaffinity"):
            os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
        import jax

        jax.config.update("jax_enable_x64", True)
        import diffrax
        import optimistix

        self.jax, self.diffrax, self.optimistix = jax, diffrax, optimistix
        self.compiled = {}

    def version(self):
        return f"{self.diffrax.__version__} (jax {self.jax.__version__})"

    def period(self, job):
        """Returns the mean period as a function of damping ratio and tolerance."""
        jax, diffrax = self.jax, self.diffrax
        friction, decay, velocity = (job[key] for key in ("friction", "decay", "velocity"))

        def slope(_, y, damping):
            x, v = y
            return v, friction / (1 + decay * (velocity - v)) - 2 * damping * v - x

        newton = self.optimistix.Newton(rtol=1e-12, atol=1e-12)
        arrival = diffrax.Event(lambda t, y, args, **_: velocity - y[1], newton, direction=False)
        solver = getattr(diffrax, job["method"])()

        def period(damping, rtol):
            release = friction - 2 * damping * velocity
            control = diffrax.PIDController(rtol=rtol, atol=rtol * job["atol_share"])

            def turn(total, _):
                # The start depends on the sum, so that the compiler does not merge cycles.
                start = release + 0 * total, jax.numpy.asarray(velocity)
                found = diffrax.diffeqsolve(diffrax.ODETerm(slope), solver, 0.0, LONGEST_SLIP, None, start, args=damping,
                                            event=arrival, stepsize_controller=control, max_steps=100_000)
                return total + found.ts[-1] + (release - found.ys[0][-1]) / velocity, None

            total, _ = jax.lax.scan(turn, 0.0 * damping, None, length=job["cycles"])
            return total / job["cycles"]

        return period

    def cycle(self, job, rtol):
        run = self.compiled.setdefault("cycle", self.jax.jit(self.period(job)))
        seconds, period = timed(lambda: float(run(job["damping"], rtol)), job)
        return {"seconds": seconds, "period": period}

    def lockstep(self, job, rtol):
        run = self.compiled.setdefault("lockstep", self.jax.jit(self.jax.vmap(self.period(job), in_axes=(0, None))))
        dampings = job["damping"] * self.jax.numpy.linspace(0.9, 1.1, job["machines"])
        seconds, _ = timed(lambda: run(dampings, rtol).block_until_ready(), job)
        return {"seconds": seconds, "cycles": job["cycles"] * job["machines"]}


PEERS = {"SciPy": SciPy, "diffrax": Diffrax}


def main():
    peer = PEERS[sys.argv[1]]()
    job = json.loads(sys.stdin.read())
    if job["case"] == "version":
        print(json.dumps({"version": peer.version()}))
        return
    print(json.dumps({"answers": [getattr(peer, job["case"])(job, rtol) for rtol in job["rtols"]]}))


main()
