import math

import numpy as np
import pytest

import asperity


@pytest.mark.parametrize("sparse", [False, True])
def test_the_indices_of_a_lognormal_product_are_those_of_the_closed_form(sparse):
    # y = e^{a ξ₀ + b ξ₁} has V = e^{s}(e^{s} − 1) with s = a² + b², and S₀ = (e^{a²} − 1)/(e^{s} − 1).
    a, b = 0.5, 0.3
    product = asperity.Expansion.of(
        lambda xi: math.exp(a * xi[0] + b * xi[1]), variables=2, degree=8, samples=400, seed=1, sparse=sparse
    )
    s = math.exp(a * a + b * b)
    assert product.mean == pytest.approx(s**0.5, rel=1e-4)
    assert product.variance == pytest.approx(s * (s - 1), rel=1e-3)
    found = product.sobol_indices()
    expected = [(math.exp(c * c) - 1) / (s - 1) for c in (a, b)]
    assert found.first_order == pytest.approx(expected, abs=1e-3)
    assert found.total == pytest.approx([1 - expected[1], 1 - expected[0]], abs=1e-3)


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
    assert expansion.sobol_indices().to_dataframe().shape == (3, 3)
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
    with pytest.raises(ValueError, match="not a valid sampler"):
        asperity.design("halton", seed=1, samples=2, variables=1)
    with pytest.raises(ValueError, match="2 samples have 3 values"):
        asperity.Expansion.fit(np.zeros((2, 1)), np.zeros(3), degree=1)
    with pytest.raises(ValueError, match="not finite"):
        asperity.Expansion.fit(np.ones((5, 1)), [1, 2, 3, 4, np.nan], degree=1)
    with pytest.raises(ValueError, match="samples"):
        asperity.Expansion.fit(np.ones((2, 1)), np.ones(2), degree=3)
    expansion = asperity.Expansion.fit([[-1.0], [0.0], [1.0]], [0.0, 1.0, 2.0], degree=1)
    with pytest.raises(ValueError, match="0 variables"):
        expansion.evaluate(np.zeros((3, 0)))
    with pytest.raises(TypeError):
        expansion.evaluate([1.0, 2.0])


def test_a_sparse_expansion_has_its_constant_at_any_number_of_samples():
    xi = asperity.design("latin_hypercube", seed=1, samples=1500, variables=2)
    expansion = asperity.Expansion.fit(xi, xi[:, 0], degree=1, sparse=True)
    assert expansion.variance == pytest.approx(1)
    with pytest.raises(ValueError, match="5 variables"):
        expansion.evaluate(np.ones((1, 5)))


@pytest.mark.parametrize("sparse", [False, True])
@pytest.mark.parametrize("values", [np.full(200, 0.1), 5 + 1e-15 * np.sin(np.arange(200))])
def test_a_function_that_does_not_vary_has_no_variance(sparse, values):
    xi = asperity.design("sobol", seed=1, samples=200, variables=3)
    expansion = asperity.Expansion.fit(xi, values, degree=3, sparse=sparse)
    assert expansion.variance == 0
    assert expansion.mean == pytest.approx(values[0], rel=1e-12)
    with pytest.warns(asperity.AsperityWarning, match="no variance"):
        assert np.isnan(expansion.sobol_indices().total).all()


def test_an_expansion_that_does_not_predict_says_so():
    xi = asperity.design("monte_carlo", seed=1, samples=300, variables=2)
    with pytest.warns(asperity.AsperityWarning, match="of the variance"):
        asperity.Expansion.fit(xi, np.sign(np.sin(20 * xi[:, 0])), degree=12)


def test_samples_that_are_not_standard_normal_are_refused():
    stream = np.random.default_rng(1)
    uniform, normal = stream.uniform(-(3**0.5), 3**0.5, (1000, 2)), stream.standard_normal((1000, 2))
    for xi, reason in [
        (uniform, "variable 0 is not standard normal"),
        (normal + np.array([0, 1]), "variable 1 is not standard normal"),
        (2 * normal, "variance"),
        (normal @ [[1, 0.6], [0, 0.8]], "correlated"),
    ]:
        with pytest.raises(ValueError, match=reason):
            asperity.Expansion.fit(xi, xi[:, 0], degree=2)


def test_few_undefined_values_are_left_out():
    xi = asperity.design("latin_hypercube", seed=1, samples=100, variables=2)
    values = xi[:, 0].copy()
    values[[3, 70]] = np.nan
    with pytest.warns(asperity.AsperityWarning, match="2 of 100 values are undefined and left out: samples 3, 70"):
        assert asperity.Expansion.fit(xi, values, degree=1).variance == pytest.approx(1)
    values[:50] = np.nan
    with pytest.raises(ValueError, match="not finite"):
        asperity.Expansion.fit(xi, values, degree=1)
