import asperity
import numpy as np
import pytest


def ishigami(xi):
    """Ishigami's function of three variables, uniform on [−π, π] as functions of normal ones."""
    from math import erf, pi, sin  # noqa: PLC0415

    x = [pi * erf(value / 2**0.5) for value in xi]
    return sin(x[0]) + 7 * sin(x[1]) ** 2 + 0.1 * x[2] ** 4 * sin(x[0])


def test_the_indices_of_ishigami_s_function_are_those_of_the_closed_form():
    expansion = asperity.Expansion.of(ishigami, variables=3, degree=14, samples=2000, seed=1, sparse=True)
    found = expansion.sobol_indices()
    assert expansion.mean == pytest.approx(3.5, abs=0.05)
    assert found.first_order == pytest.approx([0.3139, 0.4424, 0], abs=0.05)
    assert found.total == pytest.approx([0.5576, 0.4424, 0.2437], abs=0.05)


def test_a_polynomial_is_reproduced():
    xi = asperity.design("sobol", seed=2, samples=64, variables=3)
    values = 1 + 2 * xi[:, 0] - xi[:, 1] * xi[:, 2] + xi[:, 2] ** 2
    expansion = asperity.Expansion.fit(xi, values, degree=2)
    fresh = np.random.default_rng(1).normal(size=(10, 3))
    expected = 1 + 2 * fresh[:, 0] - fresh[:, 1] * fresh[:, 2] + fresh[:, 2] ** 2
    assert expansion.evaluate(fresh) == pytest.approx(expected, abs=1e-10)
    # Variances: 4 of ξ₀, 1 of ξ₁ξ₂, 2 of ξ₂².
    assert expansion.variance == pytest.approx(7)
    assert expansion.sobol_indices().total == pytest.approx([4 / 7, 1 / 7, 3 / 7])
    assert expansion.relative_error == pytest.approx(0, abs=1e-20)
    assert expansion.powers.shape == (10, 3)
    assert expansion.coefficients[expansion.powers.tolist().index([0, 1, 1])] == pytest.approx(-1)


def test_designs_are_stratified_and_depend_on_the_seed():
    for method in ("latin_hypercube", "maximin_latin_hypercube", "sobol", "monte_carlo"):
        xi = asperity.design(method, seed=1, samples=32, variables=4)
        assert xi.shape == (32, 4)
        assert np.array_equal(xi, asperity.design(method, seed=1, samples=32, variables=4))
        assert not np.array_equal(xi, asperity.design(method, seed=2, samples=32, variables=4))


def test_wrong_samples_are_refused():
    with pytest.raises(ValueError, match="no sampler"):
        asperity.design("halton", seed=1, samples=2, variables=1)
    with pytest.raises(ValueError, match="2 samples have 3 values"):
        asperity.Expansion.fit(np.zeros((2, 1)), np.zeros(3), degree=1)
    with pytest.raises(ValueError, match="not finite"):
        asperity.Expansion.fit(np.ones((5, 1)), [1, 2, 3, 4, np.nan], degree=1)
    with pytest.raises(ValueError, match="2 samples|too few|samples"):
        asperity.Expansion.fit(np.ones((2, 1)), np.ones(2), degree=3)
    expansion = asperity.Expansion.fit([[-1.0], [0.0], [1.0]], [0.0, 1.0, 2.0], degree=1)
    with pytest.raises(ValueError, match="0 variables"):
        expansion.evaluate(np.zeros((3, 0)))
    with pytest.raises(TypeError):
        expansion.evaluate([1.0, 2.0])
