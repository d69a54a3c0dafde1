"""Numbers of docs/limits.md."""

import re

import pytest

import asperity
from support import ROOT

PAGE = (ROOT / "docs" / "limits.md").read_text(encoding="utf-8")
ROWS = [
    [float(cell) for cell in row]
    for row in re.findall(r"^\| ([0-9.]+) \| ([0-9.]+) \| ([0-9.]+) \|$", PAGE, re.MULTILINE)
]


@pytest.fixture(scope="module")
def scan():
    return asperity.artificial_surface(
        rms_height_m=1e-6, hurst=0.8, size_m=256e-6, points=512, correlation_length_m=40e-6, seed=1
    )


@pytest.mark.parametrize(("index", "share", "ratio"), ROWS)
def test_friction_falls_to_shear_strength_over_hardness_as_the_contact_becomes_plastic(scan, index, share, ratio):
    modulus_pa = 1e11
    hardness_pa = modulus_pa * scan.statistics().Sdq / index
    found = asperity.solve_contact(
        scan, modulus_pa=modulus_pa, mean_pressure_pa=0.02 * hardness_pa, hardness_pa=hardness_pa
    )
    assert found.plastic_fraction * hardness_pa / found.mean_pressure_pa == pytest.approx(share, abs=0.005)
    assert found.contact_fraction_corrected * hardness_pa / found.mean_pressure_pa == pytest.approx(ratio, abs=0.005)


def test_the_page_has_a_row_of_each_kind_and_its_examples_are_right():
    assert ROWS[0][2] > 3
    assert ROWS[-1][2] == 1
    modulus_gpa, hardness_gpa, gradient, index = re.search(
        r"E\* = (\d+) GPa, H = (\d+) GPa\) with h′ = ([0-9.]+) has ([0-9.]+)\.", PAGE
    ).groups()
    assert float(modulus_gpa) * float(gradient) / float(hardness_gpa) == pytest.approx(float(index), abs=0.06)
    window_mm, variation, left, area_cm2 = re.search(
        r"A window of (\d+) mm with a coefficient of variation of (\d+) % leaves ([0-9.]+) % on a pad of (\d+) cm²",
        PAGE,
    ).groups()
    averaged = float(variation) * float(window_mm) / (float(area_cm2) * 100) ** 0.5
    assert averaged == pytest.approx(float(left), abs=0.005)
