"""Methods of OpenTURNS: (limit state, variables, parameter, effort, seed) → (probability, evaluations of the limit state).

The effort is the number of samples of a level or step, or of draws. Differences for derivatives count as evaluations. A method that takes
more than a million evaluations is stopped, because cross-entropy may not end if it misses failures.
"""

import numpy as np
import openturns as ot

from limit_states import LIMIT_STATES

ot.Log.Show(ot.Log.NONE)
MOST_EVALUATIONS = 1_000_000


class Problem:
    def __init__(self, name, variables, parameter, seed):
        ot.RandomGenerator.SetSeed(seed)
        state = LIMIT_STATES[name][0]
        self.variables, evaluations = variables, 0

        def limited(z):
            nonlocal evaluations
            evaluations += len(z)
            if evaluations > MOST_EVALUATIONS:
                raise RuntimeError("stopped after a million evaluations")
            return state(np.asarray(z), parameter)[:, None]

        self.function = ot.PythonFunction(variables, 1, func_sample=limited)
        # One-sided differences take n + 1 evaluations instead of 2 n.
        self.function.setGradient(ot.NonCenteredFiniteDifferenceGradient([1e-6] * variables, self.function.getEvaluation()))
        vector = ot.RandomVector(ot.Normal(variables))
        self.event = ot.ThresholdEvent(ot.CompositeRandomVector(self.function, vector), ot.Less(), 0.0)

    def run(self, algorithm, outer, block):
        algorithm.setMaximumOuterSampling(outer)
        algorithm.setBlockSize(block)
        algorithm.setMaximumCoefficientOfVariation(-1.0)
        algorithm.run()
        return algorithm.getResult().getProbabilityEstimate(), self.function.getEvaluationCallsNumber()

    def solver(self):
        solver = ot.AbdoRackwitz()
        solver.setStartingPoint([0.1] * self.variables)
        solver.setCheckStatus(False)
        return solver

    def form(self):
        form = ot.FORM(self.solver(), self.event)
        form.run()
        return form.getResult()


def subset(fraction):
    def method(name, variables, parameter, effort, seed):
        problem = Problem(name, variables, parameter, seed)
        algorithm = ot.SubsetSampling(problem.event, 2.0, fraction)
        # A block of at most one sample per chain gives the samples of a block of one, in less time.
        block = max(1, int(fraction * effort / 2))
        algorithm.setMinimumProbability(1e-12)
        return problem.run(algorithm, max(1, round(effort / block)), block)

    return method


def form_importance(name, variables, parameter, effort, seed):
    problem = Problem(name, variables, parameter, seed)
    return problem.run(ot.PostAnalyticalImportanceSampling(problem.form()), 1, effort)


def form_controlled(name, variables, parameter, effort, seed):
    problem = Problem(name, variables, parameter, seed)
    return problem.run(ot.PostAnalyticalControlledImportanceSampling(problem.form()), 1, effort)


def cross_entropy(quantile):
    def method(name, variables, parameter, effort, seed):
        problem = Problem(name, variables, parameter, seed)
        return problem.run(ot.StandardSpaceCrossEntropyImportanceSampling(problem.event, quantile), effort, 1)

    return method


def nais(quantile):
    def method(name, variables, parameter, effort, seed):
        problem = Problem(name, variables, parameter, seed)
        return problem.run(ot.NAIS(problem.event, quantile), effort, 1)

    return method
