import numpy as np
import pytest

import asperity
from asperity import HeightMap

HEIGHTS = 1e-6 * np.arange(16.0).reshape(4, 4)


def test_fields_of_packed_records_are_copied():
    # The distance between values is 12 bytes, which is no multiple of a double.
    records = np.zeros((4, 4), dtype=[("a", "f4"), ("z", "f8")])
    records["z"] = HEIGHTS
    assert np.array_equal(HeightMap.from_array(records["z"], dx_m=1e-6).heights, HEIGHTS)
    assert np.array_equal(HeightMap(records["z"], 1e-6, 1e-6).level("none").heights, HEIGHTS)
    shifted = np.frombuffer(b"x" + HEIGHTS.tobytes(), dtype=np.float64, offset=1).reshape(4, 4)
    assert np.array_equal(HeightMap.from_array(shifted, dx_m=1e-6).heights, HEIGHTS)


def test_masked_values_are_missing():
    masked = np.ma.array([[1e-6, 2e-6], [3e-6, 9e-3]], mask=[[0, 0], [0, 1]])
    assert np.isnan(HeightMap.from_array(masked, dx_m=1e-6).heights[1, 1])


def spectral(points: int) -> asperity.Spectral:
    covariance = asperity.Covariance(model="exponential", correlation_length_m=20e-6)
    return asperity.Spectral(covariance=covariance, rms_height_m=1e-6, size_m=1e-4, points=points)


@pytest.mark.parametrize(
    "call",
    [
        lambda: asperity.design("monte_carlo", seed=1, samples=10**6, variables=10**7),
        lambda: asperity.design("maximin_latin_hypercube", seed=1, samples=10, variables=2**61),
        lambda: asperity.Expansion.fit(
            asperity.design("monte_carlo", seed=1, samples=500, variables=100), np.zeros(500), degree=12
        ),
        lambda: HeightMap.from_array(np.broadcast_to(np.float64(1.0), (10**6, 10**6)), dx_m=1e-6),
        lambda: spectral(10**6),
        lambda: spectral(64).sample(1, 2**62),
    ],
)
def test_what_needs_more_memory_than_is_free_is_refused(call):
    with pytest.raises(asperity.ResourceError, match="GB of memory are free"):
        call()


def test_standard_normal_variables_are_bounded():
    surface = spectral(16)
    with pytest.raises(ValueError, match="numbers from -1000000 to 1000000"):
        surface.generate(np.full(surface.xi_len, 1e308))
