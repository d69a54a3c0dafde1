"""Runs one peer: `peers.py NAME` reads a job as JSON from standard input and prints the answer as JSON."""

import json
import sys
import time

import numpy as np

import problems


def load(job, name, shape):
    return np.fromfile(job[name], "<f8").reshape(shape)


def timed(run, job):
    """Returns the seconds of the timed runs and the result of the last."""
    seconds = []
    for number in range(job["warm_up"] + job["repeats"]):
        start = time.perf_counter()
        result = run()
        if number >= job["warm_up"]:
            seconds.append(time.perf_counter() - start)
    return seconds, result


class NumPy:
    def version(self):
        return np.__version__

    def solve(self, job):
        x = load(job, "points", (job["samples"], job["variables"]))
        y = load(job, "responses", (job["samples"], job["count"]))
        indices = problems.total_degree(job["variables"], job["degree"])

        def run():
            q, r = np.linalg.qr(problems.design(x, indices, job["hermite"]))
            return np.linalg.solve(r, q.T @ y)

        seconds, coefficients = timed(run, job)
        return seconds, coefficients, {}

    def evaluate(self, job):
        x = load(job, "points", (job["samples"], job["variables"]))
        indices = problems.total_degree(job["variables"], job["degree"])
        coefficients = load(job, "coefficients", len(indices))

        def run():
            return np.concatenate([problems.design(part, indices, job["hermite"]) @ coefficients
                                   for part in np.array_split(x, max(1, len(x) // 2000))])

        seconds, values = timed(run, job)
        return seconds, values, {}


class OpenTURNS:
    def __init__(self):
        import openturns

        self.ot = openturns
        openturns.TBB.Disable()
        openturns.Log.Show(openturns.Log.NONE)

    def version(self):
        return self.ot.__version__

    def basis(self, job):
        ot, variables = self.ot, job["variables"]
        marginals = [ot.Normal() if i < job["hermite"] else ot.Uniform(-1, 1) for i in range(variables)]
        factories = [ot.HermiteFactory() if i < job["hermite"] else ot.LegendreFactory() for i in range(variables)]
        if job.get("q", 1) == 1:
            order = ot.LinearEnumerateFunction(variables)
            terms = order.getStrataCumulatedCardinal(job["degree"])
        else:
            order = ot.HyperbolicAnisotropicEnumerateFunction(variables, job["q"])
            terms = order.getMaximumDegreeCardinal(job["degree"])
        return ot.JointDistribution(marginals), ot.OrthogonalProductPolynomialFactory(factories, order), terms

    def solve(self, job):
        ot = self.ot
        x = ot.Sample(load(job, "points", (job["samples"], job["variables"])))
        y = ot.Sample(load(job, "responses", (job["samples"], job["count"]))[:, : job["some"]])
        distribution, basis, terms = self.basis(job)

        def run():
            algorithm = ot.FunctionalChaosAlgorithm(
                x, y, distribution, ot.FixedStrategy(basis, terms), ot.LeastSquaresStrategy(ot.PenalizedLeastSquaresAlgorithmFactory()))
            algorithm.run()
            return algorithm.getResult()

        seconds, result = timed(run, job)
        return seconds, np.array(result.getCoefficients()), {"responses": job["some"]}

    def evaluate(self, job):
        ot = self.ot
        x = load(job, "points", (job["samples"], job["variables"]))[: job["some"]]
        distribution, basis, terms = self.basis(job)
        coefficients = np.fromfile(job["coefficients"], "<f8")
        places = {tuple(int(i) for i in alpha): j
                  for j, alpha in enumerate(problems.total_degree(job["variables"], job["degree"]))}
        order = basis.getEnumerateFunction()
        functions = [basis.build(i) for i in range(terms)]
        weights = [coefficients[places[tuple(int(a) for a in order(i))]] for i in range(terms)]
        metamodel = ot.LinearCombinationFunction(functions, weights)
        sample = ot.Sample(x)
        seconds, values = timed(lambda: metamodel(sample), job)
        return seconds, np.array(values).ravel(), {"points": len(x)}

    def select(self, job):
        ot = self.ot
        x = ot.Sample(load(job, "points", (job["samples"], job["variables"])))
        y = ot.Sample(load(job, "response", (job["samples"], 1)))
        distribution, basis, terms = self.basis(job)
        ot.ResourceMap.SetAsString("LeastSquaresMetaModelSelection-DecompositionMethod", job["decomposition"])

        def run():
            factory = ot.LeastSquaresMetaModelSelectionFactory(ot.LARS(), ot.CorrectedLeaveOneOut())
            algorithm = ot.FunctionalChaosAlgorithm(x, y, distribution, ot.FixedStrategy(basis, terms), ot.LeastSquaresStrategy(factory))
            algorithm.run()
            return algorithm.getResult()

        seconds, result = timed(run, job)
        values = np.empty(0)
        if "fresh" in job:
            fresh = load(job, "fresh", (-1, job["variables"]))
            values = np.array(result.getMetaModel()(ot.Sample(fresh))).ravel()
        history = result.getErrorHistory() if hasattr(result, "getErrorHistory") else []
        return seconds, values, {"terms": len(result.getIndices()), "tried": len(history)}


class Chaospy:
    def __init__(self):
        import chaospy

        self.chaospy = chaospy

    def version(self):
        return self.chaospy.__version__

    def solve(self, job):
        chaospy = self.chaospy
        x = load(job, "points", (job["samples"], job["variables"]))
        y = load(job, "responses", (job["samples"], job["count"]))[:, : job["some"]]
        distribution = chaospy.Iid(chaospy.Normal(), job["variables"])
        expansion = chaospy.generate_expansion(job["degree"], distribution, normed=True)
        seconds, _ = timed(lambda: chaospy.fit_regression(expansion, x.T, y), job)
        return seconds, np.empty(0), {"responses": job["some"]}


class ScikitLearn:
    def version(self):
        import sklearn

        return sklearn.__version__

    def select(self, job):
        import warnings

        from sklearn import linear_model

        warnings.filterwarnings("ignore")
        y = load(job, "response", job["samples"])
        matrix = load(job, "matrix", (job["samples"], -1))[:, 1:]
        run = lambda: linear_model.OrthogonalMatchingPursuitCV(cv=10, max_iter=job["samples"] * 9 // 10 - 1).fit(matrix, y)
        seconds, model = timed(run, job)
        values = np.empty(0)
        if "fresh_matrix" in job:
            values = model.predict(load(job, "fresh_matrix", (-1, matrix.shape[1] + 1))[:, 1:])
        return seconds, values, {"terms": int((model.coef_ != 0).sum()) + 1}


PEERS = {"NumPy": NumPy, "OpenTURNS": OpenTURNS, "chaospy": Chaospy, "scikit-learn": ScikitLearn}


def peak_memory_bytes():
    """Returns the peak resident memory of the process."""
    with open("/proc/self/status") as lines:
        return next(1024 * int(line.split()[1]) for line in lines if line.startswith("VmHWM"))


def main():
    peer = PEERS[sys.argv[1]]()
    job = json.loads(sys.stdin.read())
    if job["case"] == "version":
        print(json.dumps({"version": peer.version()}))
        return
    seconds, values, more = getattr(peer, job["case"])(job)
    if "output" in job:
        np.ascontiguousarray(values, "<f8").tofile(job["output"])
    print(json.dumps({"seconds": seconds, "memory_bytes": peak_memory_bytes()} | more))


main()
