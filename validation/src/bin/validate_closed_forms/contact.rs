//! Contact of parabolas, waves and rough maps.

use std::f64::consts::PI;

use asperity::contact::exact::{Hertz, Westergaard};
use asperity::contact::{Boundary, ContactProblem, Control, HalfSpace, Solution, Solver};
use asperity::map::{Grid, HeightMap};
use asperity::random;
use asperity_testing::{CAPPED_HERTZ, CappedHertz, paraboloid, self_affine};
use ndarray::Array2;

use crate::{Result, error, table};

/// Approach of the parabolas of radius 1, and their contact radius.
const APPROACH: f64 = 0.01;
const CONTACT_RADIUS: f64 = 0.1;

fn solve(heights: &Array2<f64>, half_space: &HalfSpace, control: Control, hardness: Option<f64>) -> Result<Solution> {
    let solution = Solver::default().solve(&ContactProblem::new(half_space, heights, control, hardness)?)?;
    if !solution.converged() {
        return Err(format!("not converged: {:?}", solution.residual()).into());
    }
    Ok(solution)
}

fn order(coarse: f64, fine: f64) -> String {
    format!("{:.2}", (coarse.abs() / fine.abs()).log2())
}

pub(crate) fn hertz() -> Result<String> {
    let load = Hertz::load_n(1.0, 1.0, APPROACH);
    let exact = Hertz::new(1.0, 1.0, load);
    let (mut rows, mut before) = (Vec::new(), None);
    for n in [64, 128, 256, 512, 1024] {
        let (grid, heights) = paraboloid(n, 2.5 * CONTACT_RADIUS, 0.0);
        let half_space = HalfSpace::new(grid, 1.0, Boundary::Free)?;
        let solution = solve(&heights, &half_space, Control::Load { newton: load }, None)?;
        let pressure = solution.max_pressure_pa() / exact.max_pressure_pa - 1.0;
        let approach = solution.penetration_m() / exact.approach_m - 1.0;
        let area = solution.corrected_contact_fraction() * grid.area_m2();
        let radius = (area / PI).sqrt() / exact.contact_radius_m - 1.0;
        let orders = before.map_or([String::new(), String::new()], |(p, d)| [order(p, pressure), order(d, approach)]);
        let [of_pressure, of_approach] = orders;
        rows.push(vec![
            format!("{n} × {n}"),
            error(pressure),
            of_pressure,
            error(approach),
            of_approach,
            error(radius),
        ]);
        before = Some((pressure, approach));
    }
    let headers = ["grid", "error of p₀", "order", "error of the approach", "order", "error of the radius"];
    Ok(format!(
        "## Hertz\n\nA parabola of revolution pressed into a free half-space at a given load: highest pressure p₀ = 3F/2πa², approach a²/R and contact \
         radius a = (3FR/4E*)^(1/3) (Johnson, *Contact Mechanics*, 1985, §4.2, <https://doi.org/10.1017/CBO9781139171731>). The map is 2.5 a \
         wide. The radius follows from the contact area with the perimeter correction; since the area counts cells, its error has no smooth order. The test requires \
         errors of p₀ below 2.2e-4·(128/n)² and an order of 2 ± 0.1.\n\n{}",
        table(&headers, rows)
    ))
}

pub(crate) fn capped_hertz() -> Result<String> {
    let elastic_load = Hertz::load_n(1.0, 1.0, APPROACH);
    let p0 = Hertz::new(1.0, 1.0, elastic_load).max_pressure_pa;
    let rows = CAPPED_HERTZ.map(|CappedHertz { hardness, load, area, load_tolerance }| {
        let mut row = vec![format!("{hardness}"), format!("{load}")];
        for n in [128, 256, 512] {
            let (grid, heights) = paraboloid(n, 0.4, 0.5);
            let half_space = HalfSpace::new(grid, 1.0, Boundary::Free)?;
            let control = Control::Penetration { metre: APPROACH };
            let solution = solve(&heights, &half_space, control, Some(hardness * p0))?;
            row.push(error(solution.load_n() / elastic_load - load));
            if n == 512 {
                row.extend([error(load_tolerance), format!("{area}")]);
                row.push(error(solution.corrected_contact_fraction() * grid.area_m2() / (PI * APPROACH) - area));
            }
        }
        Ok(row)
    });
    let rows: Result<Vec<Vec<String>>> = rows.into_iter().collect();
    let headers =
        ["H/p₀", "N/N_Hertz", "error, 128²", "256²", "512²", "bar of the test, 256²", "A/A_Hertz", "error, 512²"];
    Ok(format!(
        "## Hertz with a hardness\n\nThe same parabola at a given approach, with pressures of at most H: load and area over the elastic ones, against an \
         independent fine solution with four to five digits. Errors are absolute.\n\n{}",
        table(&headers, rows?)
    ))
}

pub(crate) fn westergaard() -> Result<String> {
    let (h, wavelength) = (0.01, 1.0);
    let mut rows = Vec::new();
    for n in [64, 256, 1024, 4096] {
        let pitch = wavelength / f64::from(n);
        let grid = Grid::new(n as usize, 2, pitch, pitch)?;
        // The crest is a quarter of a cell off a point. At a point of symmetry, widths change only by two cells at a time.
        let map = HeightMap::from_function(grid, |x, _| h * (2.0 * PI * (x - 0.25 * pitch)).cos())?;
        let half_space = HalfSpace::new(grid, 1.0, Boundary::Periodic { mean_compliance_m_per_pa: 0.0 })?;
        let mut row = vec![n.to_string()];
        for ratio in [0.1, 0.25, 0.5, 0.75] {
            let full = Westergaard::new(1.0, h, wavelength, 0.0).full_contact_pressure_pa;
            let exact = Westergaard::new(1.0, h, wavelength, ratio * full);
            let solution = solve(map.heights_m(), &half_space, Control::MeanPressure { pascal: ratio * full }, None)?;
            row.push(error(solution.contact_fraction() - exact.contact_fraction));
            row.push(error(solution.max_pressure_pa() / exact.max_pressure_pa - 1.0));
        }
        rows.push(row);
    }
    let headers =
        ["points", "width, p̄/p* = 0.1", "p_max", "width, 0.25", "p_max", "width, 0.5", "p_max", "width, 0.75", "p_max"];
    Ok(format!(
        "## Westergaard\n\nOne wave pressed flat: p̄/p* = sin²(πa/λ) and p_max = 2√(p̄p*) (Westergaard, *J. Appl. Mech.* 6 (1939) A49). The error of the \
         width 2a/λ is absolute; a width changes by whole cells, and the test allows an error of one cell, 1/points.\n\n{}",
        table(&headers, rows)
    ))
}

/// Returns the root-mean-square slope of a periodic map of side 1 by forward differences.
fn rms_slope(heights: &Array2<f64>) -> f64 {
    let n = heights.nrows();
    let square = |((i, j), z): ((usize, usize), &f64)| {
        (heights[[i, (j + 1) % n]] - z).powi(2) + (heights[[(i + 1) % n, j]] - z).powi(2)
    };
    // The mean of squares is over n² cells and differences are over 1/n, so the factors cancel.
    heights.indexed_iter().map(square).sum::<f64>().sqrt()
}

pub(crate) fn light_load() -> Result<String> {
    let maps = 8;
    let mut rows = Vec::new();
    for load in [0.003, 0.01, 0.03, 0.1] {
        let mut row = vec![format!("{load}")];
        for n in [128, 256, 512] {
            let grid = Grid::with_size(n, n, 1.0, 1.0)?;
            let half_space = HalfSpace::new(grid, 1.0, Boundary::Periodic { mean_compliance_m_per_pa: 0.0 })?;
            let mut sum = 0.0;
            for sample in 0..maps {
                let heights = self_affine(n, 3.0, &mut random::stream(5, "rough", sample));
                let control = Control::MeanPressure { pascal: load * rms_slope(&heights) };
                sum += solve(&heights, &half_space, control, None)?.corrected_contact_fraction() / load;
            }
            row.push(format!("{:.3}", sum / maps as f64));
        }
        rows.push(row);
    }
    let headers = ["p̄/(E*h′)", "κ, 128²", "256²", "512²"];
    Ok(format!(
        "## Slope of the contact area at light load\n\nκ = A/A₀ · E*h′/p̄ on self-affine maps (Hurst exponent 0.8, roll-off at a third of the side, slopes up to the \
         pitch; mean of {maps} maps). Persson's theory gives √(8/π) = 1.596 (<https://doi.org/10.1063/1.1388626>), Bush, Gibson and Thomas \
         √(2π) = 2.507 (<https://doi.org/10.1016/0043-1648(75)90145-3>); both are limits, and the test requires values between them. Waves as short as the pitch are not \
         resolved, which is why κ still depends on the grid.\n\n{}",
        table(&headers, rows)
    ))
}
