import math
import pickle

import numpy as np
import pytest

import asperity


def _text(name, *numbers):
    return f"{name}:{','.join(map(repr, numbers))}"


def _scipy(name, *numbers):
    stats = pytest.importorskip("scipy.stats")
    match name, numbers:
        case "uniform", (low, high):
            return stats.uniform(low, high - low)
        case "lognormal", (mu, sigma):
            return stats.lognorm(sigma, scale=math.exp(mu))
        case "triangular", (low, mode, high):
            return stats.triang((mode - low) / (high - low), low, high - low)
        case "beta", (a, b, low, high):
            return stats.beta(a, b, low, high - low)
    return {"normal": stats.norm}[name](*numbers)


def _openturns(name, *numbers):
    openturns = pytest.importorskip("openturns")
    names = {"lognormal": "LogNormal"}
    return getattr(openturns, names.get(name, name.capitalize()))(*numbers)


def _sobol(samples, marginals, seed=1):
    qmc = pytest.importorskip("scipy.stats").qmc
    unit = qmc.Sobol(len(marginals), seed=seed).random(samples)
    return np.column_stack([own.ppf(column) for own, column in zip(marginals, unit.T, strict=True)])


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


@pytest.mark.parametrize("stated", [_text, _scipy, _openturns])
def test_ishigami_has_the_indices_of_its_closed_form(stated):
    # Ishigami & Homma, ISUMA (1990) 398: with V = a²/8 + bπ⁴/5 + b²π⁸/18 + 1/2, the parts of x₀, x₁ and of x₀ with x₂.
    a, b = 7, 0.1
    first = 0.5 * (1 + b * math.pi**4 / 5) ** 2
    pair = b**2 * math.pi**8 * (1 / 18 - 1 / 50)
    variance = first + a**2 / 8 + pair
    x = _sobol(1024, [_scipy("uniform", -math.pi, math.pi)] * 3)
    values = np.sin(x[:, 0]) + a * np.sin(x[:, 1]) ** 2 + b * x[:, 2] ** 4 * np.sin(x[:, 0])
    uniform = stated("uniform", -math.pi, math.pi)
    expansion = asperity.Expansion.fit(x, values, degree=11, distributions=[uniform] * 3)
    assert expansion.mean == pytest.approx(a / 2, abs=0.005)
    assert expansion.variance == pytest.approx(variance, rel=0.005)
    found = expansion.sobol_indices()
    truth = {
        "first_order": np.array([first, a**2 / 8, 0]) / variance,
        "total": np.array([first + pair, a**2 / 8, pair]) / variance,
        "second_order": np.array([[np.nan, 0, pair], [0, np.nan, 0], [pair, 0, np.nan]]) / variance,
    }
    for name, expected in truth.items():
        assert getattr(found, name) == pytest.approx(expected, abs=0.005, nan_ok=True)
        low, high = np.moveaxis(getattr(found, f"{name}_interval"), -1, 0)
        known = ~np.isnan(expected)
        assert ((low <= expected) & (expected <= high))[known].all()
        assert (high - low)[known].max() < 0.005


@pytest.mark.parametrize("stated", [_text, _scipy, _openturns])
def test_the_borehole_has_its_indices(stated):
    # Harper & Gupta, ONWI-516 (1983). Indices by the estimators of Saltelli et al., Computer Physics Communications
    # 181 (2010) 259, at 8 scrambled Sobol' sets of 2^18 points in 16 dimensions; standard errors are at most 2.3e-5.
    marginals = [("normal", 0.10, 0.0161812), ("lognormal", 7.71, 1.0056)]
    bounds = [(63070, 115600), (990, 1110), (63.1, 116), (700, 820), (1120, 1680), (9855, 12045)]
    marginals += [("uniform", low, high) for low, high in bounds]
    first = [0.663728, 0.000002, 0, 0.094883, 0.000006, 0.094876, 0.090636, 0.021934]
    total = [0.694142, 0.000003, 0, 0.106121, 0.000009, 0.106120, 0.102783, 0.025129]
    x = _sobol(1024, [_scipy(*own) for own in marginals])
    rw, r, tu, hu, tl, hl, length, kw = x.T
    log = np.log(r / rw)
    flow = 2 * np.pi * tu * (hu - hl) / (log * (1 + 2 * length * tu / (log * rw**2 * kw) + tu / tl))
    expansion = asperity.Expansion.fit(x, flow, degree=4, distributions=[stated(*own) for own in marginals])
    found = expansion.sobol_indices()
    assert found.first_order == pytest.approx(first, abs=5e-4)
    assert found.total == pytest.approx(total, abs=5e-4)
    assert expansion.mean == pytest.approx(73.73894, rel=1e-4)
    assert expansion.variance == pytest.approx(817.716, rel=1e-3)


@pytest.mark.parametrize("stated", [_text, _scipy, _openturns])
def test_a_polynomial_of_bounded_variables_is_reproduced(stated):
    distributions = [stated("triangular", 1.0, 2.0, 5.0), stated("beta", 2.0, 3.0, -1.0, 1.0)]
    x = asperity.design("sobol", seed=3, samples=64, distributions=distributions)
    product = asperity.Expansion.of(
        lambda x: x[:, 0] * x[:, 1], degree=2, samples=64, seed=3, distributions=distributions, vectorized=True
    )
    assert product.evaluate(x) == pytest.approx(x[:, 0] * x[:, 1], abs=1e-12)
    # Means and variances of the triangular and of the Beta distribution.
    (m0, v0), (m1, v1) = (8 / 3, (1 + 4 + 25 - 2 - 5 - 10) / 18), (-1 / 5, 4 * 6 / (25 * 6))
    variance = v0 * v1 + v0 * m1**2 + v1 * m0**2
    assert product.mean == pytest.approx(m0 * m1, rel=1e-7)
    assert product.variance == pytest.approx(variance, rel=1e-7)
    found = product.sobol_indices()
    assert found.first_order == pytest.approx(np.array([v0 * m1**2, v1 * m0**2]) / variance, rel=1e-6)
    assert found.second_order[0, 1] == pytest.approx(v0 * v1 / variance, rel=1e-6)
    assert pickle.loads(pickle.dumps(product)) == product
    assert pickle.loads(pickle.dumps(product)).evaluate(x) == pytest.approx(product.evaluate(x), abs=0)


def test_the_kinds_of_distributions_give_equal_designs_and_expansions():
    marginals = [("lognormal", 0.5, 0.4), ("uniform", -2.0, 3.0), ("normal", 1.0, 2.0)]

    def product(stated):
        distributions = [stated(*own) for own in marginals]
        return asperity.Expansion.of(
            lambda x: x[0] * (x[1] + x[2]), degree=6, samples=200, seed=1, distributions=distributions
        )

    reference = product(_text)
    # E x₀ (E x₁ + E x₂), and E x₀² E(x₁ + x₂)² less its square.
    mean = math.exp(0.5 + 0.08) * 1.5
    assert reference.mean == pytest.approx(mean, rel=1e-5)
    assert reference.variance == pytest.approx(math.exp(1 + 0.32) * (25 / 12 + 4 + 2.25) - mean**2, rel=1e-4)
    for stated in (_scipy, _openturns):
        assert product(stated).coefficients == pytest.approx(reference.coefficients, rel=1e-9, abs=1e-9)
        assert product(stated) == product(stated)
    assert reference != product(lambda name, *numbers: _text(name, *[1.01 * number for number in numbers]))


def test_wrong_distributions_are_refused():
    xi = asperity.design("sobol", seed=1, samples=128, variables=2)
    unit = asperity.design("sobol", seed=1, samples=128, distributions=["uniform:0,1"] * 2)

    def fit(x, distributions):
        return asperity.Expansion.fit(x, x[:, 0], degree=1, distributions=distributions)

    # Points on the bounds are samples as well.
    edged = unit.copy()
    edged[0], edged[1, 1] = 0, 1
    assert fit(edged, ["uniform:0,1"] * 2).variance == pytest.approx(1 / 12)
    with pytest.raises(ValueError, match="variable 1 is not distributed as stated"):
        fit(unit, ["uniform:0,1", "beta:2,5"])
    with pytest.raises(ValueError, match=r"variable 0 is .*, outside its support from 0 to 1"):
        fit(xi, ["uniform:0,1", "normal"])
    with pytest.raises(ValueError, match="outside its support"):
        fit(unit, ["uniform:0,1"] * 2).evaluate([[0.5, 1.5]])
    with pytest.raises(ValueError, match="correlated"):
        fit(np.column_stack([unit[:, 0], unit[:, 0]]), ["uniform:0,1"] * 2)
    with pytest.raises(ValueError, match="1 distributions for 2 variables"):
        fit(unit, ["uniform:0,1"])
    with pytest.raises(ValueError, match="distribution 1: `gumbel:1,2` is not a marginal"):
        fit(unit, ["uniform:0,1", "gumbel:1,2"])
    with pytest.raises(ValueError, match="distribution 0: its distribution function is not continuous"):
        fit(unit, [pytest.importorskip("scipy.stats").poisson(3), "uniform:0,1"])
    with pytest.raises(TypeError, match="is neither a text nor a distribution"):
        fit(unit, [1.0, "uniform:0,1"])
    with pytest.raises(ValueError, match="state `variables` or `distributions`"):
        asperity.design("sobol", seed=1, samples=2)


def test_a_vectorized_function_is_called_once_with_all_samples():
    def of(function, vectorized):
        return asperity.Expansion.of(function, variables=2, degree=3, samples=60, seed=1, vectorized=vectorized)

    shapes = []

    def function(xi):
        shapes.append(xi.shape)
        return xi[..., 0] * xi[..., 1]

    assert of(function, True) == of(lambda xi: xi[0] * xi[1], False)
    assert shapes == [(60, 2)]
    with pytest.raises(ValueError, match=r"shape \(60, 2\), expected \(60,\)"):
        of(lambda xi: xi, True)


def test_intervals_contain_the_moments_and_are_undefined_without_an_error_estimate():
    # y = ξ₀ + ξ₀ξ₁ + e of mean 0 and variance 2, with noise e of variance 1/16 that belongs to no term.
    contained = np.zeros(3)
    for seed in range(40):
        xi = asperity.design("monte_carlo", seed=seed, samples=100, variables=3)
        expansion = asperity.Expansion.fit(xi, xi[:, 0] + xi[:, 0] * xi[:, 1] + xi[:, 2] / 2, degree=2)
        assert expansion.mean_interval == pytest.approx((0, 0), abs=1e-12)
        noise = np.random.default_rng(seed).normal(size=100) / 4
        expansion = asperity.Expansion.fit(xi[:, :2], xi[:, 0] + xi[:, 0] * xi[:, 1] + noise, degree=2)
        limits = [
            expansion.mean_interval,
            expansion.variance_interval,
            expansion.sobol_indices().first_order_interval[0],
        ]
        contained += [low <= truth <= high for (low, high), truth in zip(limits, (0, 2, 0.5), strict=True)]
    assert (contained >= 34).all()
    assert contained[0] < 40
    # One sample alone determines the slope.
    with pytest.warns(asperity.AsperityWarning, match="is undefined"):
        expansion = asperity.Expansion.fit([[0.0], [0.0], [0.0], [1.0]], [0.0, 0.0, 0.0, 1.0], degree=1)
    assert expansion.relative_error is None
    assert np.isnan(expansion.mean_interval).all()
    assert np.isnan(expansion.sobol_indices().total_interval).all()


def test_a_function_may_change_its_argument():
    def changing(x):
        x[..., 0] **= 2
        return x[..., 0] + x[..., 1]

    settings = {"distributions": ["uniform:0,1"] * 2, "degree": 4, "samples": 64, "seed": 1}
    for vectorized in (False, True):
        found = asperity.Expansion.of(changing, vectorized=vectorized, **settings)
        assert found.mean == pytest.approx(5 / 6, abs=1e-9)


def test_a_density_with_gaps_is_warned_about():
    stats = pytest.importorskip("scipy.stats")
    gap = stats.rv_histogram(([1, 0, 0, 1], [0, 1, 2, 3, 4]), density=True)
    with pytest.warns(asperity.AsperityWarning, match="the density has gaps or steps"):
        asperity.Expansion.of(lambda x: x[0], distributions=[gap], degree=2, samples=64, seed=1)


def test_values_beyond_all_probabilities_are_refused():
    points = asperity.design("sobol", samples=64, variables=1, seed=1, distributions=["normal:3,2"])
    found = asperity.Expansion.fit(points, points[:, 0], degree=1, distributions=["normal:3,2"])
    assert found.evaluate([[3.0 + 2.0 * 37]]) == pytest.approx(77.0)
    for far in (3.0 + 2.0 * 39, -1e9):
        with pytest.raises(ValueError, match=r"variable 0 is .*, too far in the tail"):
            found.evaluate([[far]])


def test_indices_of_pairs_are_in_the_data_set():
    pytest.importorskip("xarray")
    points = asperity.design("sobol", samples=256, variables=3, seed=1)
    values = points[:, 0] + 2 * points[:, 1] * points[:, 2]
    indices = asperity.Expansion.fit(points, values, degree=2).sobol_indices()
    found = indices.to_xarray()
    assert float(found.second_order.sel(variable=1, other=2)) == pytest.approx(0.8, abs=1e-9)
    assert found.total.dims == ("variable",)
    assert found.second_order_interval.shape == (3, 3, 2)
    assert float(found.first_order_interval.sel(variable=0, limit="low")) == indices.first_order_interval[0, 0]
