//! Friction of solved strips against closed forms and naive counts.

use std::f64::consts::PI;
use std::sync::Arc;

use asperity_base::blocks::Task;
use asperity_base::correlation::{CorrelationModel, Covariance, LengthSettings, RecordCorrelation};
use asperity_base::distribution::Marginal;
use asperity_base::distribution::fit::Family;
use asperity_base::map::{Grid, HeightMap};
use asperity_base::monitor::Silent;
use asperity_base::random;
use asperity_base::stats::Moments;
use asperity_contact::{Boundary, ContactProblem, Control, HalfSpace, Solution, Solver};
use asperity_friction::law::{BowdenTabor, WindowLaw};
use asperity_friction::statistics::FrictionStatistics;
use asperity_friction::strip::{Record, SolvedStrips, StripProblem, Strips};
use asperity_friction::window::{Window, WindowError};
use asperity_friction::window_study::WindowStudy;
use asperity_friction::{FrictionError, PressedScan, WINDOWS, WindowContact, window_contacts};
use asperity_surface::{RandomSurface, SpectralField};
use asperity_testing::autoregressive;
use ndarray::Array2;

const MODULUS_PA: f64 = 230e9;

fn grid(nx: usize, ny: usize) -> Grid {
    Grid::new(nx, ny, 2e-6, 2e-6).unwrap()
}

fn half_space(grid: Grid, periodic: bool) -> HalfSpace {
    let mean_compliance_m_per_pa = HalfSpace::default_mean_compliance_m_per_pa(grid, MODULUS_PA);
    let boundary = if periodic { Boundary::Periodic { mean_compliance_m_per_pa } } else { Boundary::Free };
    HalfSpace::new(grid, MODULUS_PA, boundary).unwrap()
}

fn solve(map: &HeightMap, half_space: &HalfSpace, control: Control, hardness_pa: Option<f64>) -> Solution {
    let problem = ContactProblem::new(half_space, map.complete_heights_m().unwrap(), control, hardness_pa).unwrap();
    let solver = Solver { tolerance: 1e-7, ..Solver::default() };
    let solution = solver.solve(&problem).unwrap();
    assert!(solution.converged(), "{:?}", solution.residual());
    solution
}

fn field(grid: Grid, length_m: f64) -> SpectralField {
    let covariance = Covariance::isotropic(CorrelationModel::SquaredExponential, 0.5e-6, length_m).unwrap();
    SpectralField::periodic(&covariance, grid)
}

fn rough(grid: Grid, sample: u64) -> HeightMap {
    let field = field(grid, 12e-6);
    field.generate(&random::standard_normal(&mut random::stream(4, "friction test", sample), field.xi_len()))
}

/// Computes the contacts of a window as wide as the strip.
fn slide(window: &Window, solution: &Solution) -> Vec<WindowContact> {
    let mut tracks = window_contacts(solution, &[window], None).remove(0);
    assert_eq!(tracks.len(), 1);
    tracks.remove(0)
}

/// Counts contact cells, area and load of the columns `start..start + cells`, cell by cell.
fn counted(solution: &Solution, start: usize, cells: usize) -> (f64, f64, f64) {
    let (p, areas) = (solution.pressure_pa(), solution.cell_contact_areas());
    let (ny, nx) = p.dim();
    let (mut contact, mut area, mut load_pa) = (0.0, 0.0, 0.0);
    for column in start..start + cells {
        for row in 0..ny {
            let cell = [row, column % nx];
            contact += f64::from(p[cell] > 0.0);
            area += areas[cell];
            load_pa += p[cell];
        }
    }
    let cell_m2 = solution.grid().cell_area_m2();
    (contact, area * cell_m2, load_pa * cell_m2)
}

#[test]
fn sliding_sums_equal_direct_counts_of_every_window() {
    for (periodic, hardness_pa) in [(true, None), (true, Some(3e9)), (false, Some(3e9))] {
        // Sizes that are neither even nor powers of two.
        let grid = grid(331, 15);
        let solution =
            solve(&rough(grid, 0), &half_space(grid, periodic), Control::Percentile { percent: 20.0 }, hardness_pa);
        let plastic = solution.plastic_fraction();
        assert!(hardness_pa.is_none() || plastic > 0.0 && plastic < solution.contact_fraction());
        let window = Window::new(33.0 * grid.dx_m(), grid).unwrap();
        let step = (window.step_m() / grid.dx_m()).round() as usize;
        assert_eq!((window.cells(), step), (33, 2));
        let seen = slide(&window, &solution);
        let first = if periodic { 0 } else { 15 };
        for (index, found) in seen.iter().enumerate() {
            let start = first + index * step;
            let (contact, area_m2, load_n) = counted(&solution, start, 33);
            assert_eq!(found.contact_cells, contact);
            assert!((found.area_m2 - area_m2).abs() < 1e-12 * grid.area_m2(), "window {index}");
            assert!((found.load_n - load_n).abs() <= 1e-13 * solution.load_n(), "window {index}");
            assert!((found.position_m - (start as f64 + 16.5) * grid.dx_m()).abs() < 1e-15);
        }
    }
}

#[test]
fn adjoining_windows_add_up_to_the_strip() {
    let grid = grid(320, 16);
    let solution = solve(&rough(grid, 1), &half_space(grid, true), Control::Percentile { percent: 10.0 }, Some(3e9));
    let window = Window::new(32.0 * grid.dx_m(), grid).unwrap();
    let seen = slide(&window, &solution);
    let steps = (window.length_m() / window.step_m()).round() as usize;
    let adjoining = || seen.iter().step_by(steps);
    assert_eq!(adjoining().count(), 10);
    let area_m2: f64 = adjoining().map(|w| w.area_m2).sum();
    let load_n: f64 = adjoining().map(|w| w.load_n).sum();
    assert!((area_m2 / (solution.corrected_contact_fraction() * grid.area_m2()) - 1.0).abs() < 1e-12);
    assert!((load_n / solution.load_n() - 1.0).abs() < 1e-12);
}

#[test]
fn a_free_strip_has_no_window_nearer_to_an_end_than_it_is_wide() {
    for width in [16, 25] {
        let grid = grid(400, width);
        let solution = solve(&rough(grid, 2), &half_space(grid, false), Control::Percentile { percent: 30.0 }, None);
        let window = Window::new(40.0 * grid.dx_m(), grid).unwrap();
        let seen = slide(&window, &solution);
        let half_m = 0.5 * window.length_m();
        let (first, last) = (seen[0].position_m - half_m, seen[seen.len() - 1].position_m + half_m);
        assert!((first - grid.height_m()).abs() < 1e-12, "the first allowed window begins at {first:e}");
        let rest_m = grid.width_m() - grid.height_m() - last;
        assert!(rest_m > -1e-12 && rest_m < window.step_m(), "the last window ends {rest_m:e} m before the limit");
    }
}

#[test]
fn windows_that_do_not_fit_their_strip_are_refused() {
    let grid = grid(200, 10);
    assert!(matches!(Window::new(3e-6 * 0.9, grid), Err(WindowError::TooShort { .. })));
    assert!(matches!(Window::new(f64::NAN, grid), Err(WindowError::TooShort { .. })));
    assert!(matches!(Window::new(41e-6, grid), Err(WindowError::TooLong { .. })));
    let window = Window::new(40e-6, grid).unwrap();
    assert!(window.step_m() <= window.length_m() / 8.0);
    let narrower: Vec<usize> = window.narrower().iter().map(Window::cells).collect();
    assert_eq!(narrower, [10, 5], "an eighth of 20 cells is too few");
}

fn problem(half_space: HalfSpace, law: &BowdenTabor, hardness_pa: f64, window: &Window) -> StripProblem {
    StripProblem {
        valid_share: 0.95,
        half_space,
        window: window.clone(),
        law: Arc::new(*law),
        hardness_pa: Some(hardness_pa),
        solver: Solver { tolerance: 1e-6, ..Solver::default() },
    }
}

#[test]
fn friction_is_never_below_shear_strength_over_hardness() {
    let grid = grid(512, 16);
    let (surface, half_space) = (field(grid, 12e-6), half_space(grid, true));
    let (law, window) = (BowdenTabor { shear_strength_pa: 385e6 }, Window::new(60e-6, grid).unwrap());
    let levels = [0.5, 5.0, 50.0].map(|percent| Control::Percentile { percent });
    let solved = problem(half_space, &law, 2e9, &window).strips(&surface, 3, 9).solve(&levels, &Silent).unwrap();
    let mut empty = 0;
    for level in solved {
        let level = level.unwrap();
        assert!(level.plastic_fraction() > 0.0 && level.plastic_fraction() < 1.0);
        for record in level.records.iter().chain(level.narrower.iter().flatten()) {
            for (mu, load_n) in record.friction.iter().zip(&record.load_n) {
                assert_eq!(mu.is_nan(), *load_n == 0.0, "μ is undefined exactly where no load is carried");
                assert!(mu.is_nan() || *mu >= 385.0 / 2000.0 * (1.0 - 1e-12), "{mu}");
            }
        }
        let statistics = FrictionStatistics::new(&level.records, 6e-6, true, 1).unwrap();
        let nan = level.records.iter().flat_map(|record| &record.friction).filter(|mu| mu.is_nan()).count();
        assert_eq!(statistics.empty_windows, nan);
        empty += nan;
    }
    assert!(empty > 0, "half a percent of the heights leaves windows empty");
}

#[test]
fn fully_plastic_friction_is_constant_at_shear_strength_over_hardness() {
    let grid = grid(512, 16);
    let (surface, half_space) = (field(grid, 12e-6), half_space(grid, true));
    let (law, window) = (BowdenTabor { shear_strength_pa: 0.2 }, Window::new(60e-6, grid).unwrap());
    let problem = problem(half_space, &law, 1.0, &window);
    let strips = problem.strips(&surface, 3, 9);
    let level = strips.solve(&[Control::Percentile { percent: 30.0 }], &Silent).unwrap().remove(0).unwrap();
    assert_eq!(level.plastic_fraction(), 1.0);
    let statistics = FrictionStatistics::new(&level.records, window.step_m(), true, 1).unwrap();
    assert!((statistics.moments.mean - 0.2).abs() < 1e-15 && statistics.moments.std == 0.0);
    assert!(statistics.correlation.is_err(), "what does not vary has no correlation");
    let (mean, records) = Record::at_mean_load(&level.records);
    assert!((mean - 0.2).abs() < 1e-13);
    // Sums over hundreds of windows have rounding errors, which do not count as a process.
    let process = FrictionStatistics::new(&records, window.step_m(), true, 1).unwrap();
    assert!((process.moments.mean - 0.2).abs() < 1e-13 && process.moments.std == 0.0);
    assert!(process.correlation.is_err() && process.marginal().is_none() && process.moments.skewness.is_nan());
}

#[test]
fn extrapolation_multiplies_area_and_friction_beyond_their_least_values() {
    let grid = grid(512, 16);
    let (surface, half_space) = (field(grid, 12e-6), half_space(grid, true));
    let (law, window) = (BowdenTabor { shear_strength_pa: 385e6 }, Window::new(60e-6, grid).unwrap());
    let problem = problem(half_space, &law, 2e9, &window);
    let strips = problem.strips(&surface, 2, 9);
    let level = |pitch_factor: f64| {
        let strips = Strips { pitch_factor, ..strips };
        strips.solve(&[Control::Percentile { percent: 5.0 }], &Silent).unwrap().remove(0).unwrap()
    };
    let (own, half) = (level(1.0), level(0.5));
    let excess = |level: &SolvedStrips| level.contact_fraction - level.mean_pressure_pa / 2e9;
    assert!(excess(&own) > 0.0 && (excess(&half) / excess(&own) - 0.5).abs() < 1e-9);
    for (own, half) in own.records.iter().zip(&half.records) {
        for (index, load_n) in own.load_n.iter().enumerate() {
            let least_m2 = load_n / 2e9;
            let wanted_m2 = 0.5 * (own.area_m2[index] + least_m2);
            assert!((half.area_m2[index] - wanted_m2).abs() <= 1e-12 * wanted_m2);
            // F = τ A stays the law of the extrapolated window, and F/N its quotient.
            let force_n = half.friction_force_n[index];
            assert!((force_n - 385e6 * half.area_m2[index]).abs() <= 1e-9 * force_n.abs());
            assert!(*load_n == 0.0 || (half.friction[index] * load_n - force_n).abs() <= 1e-9 * force_n);
        }
    }
}

#[test]
fn in_full_elastic_contact_friction_is_shear_strength_over_mean_pressure() {
    let grid = grid(320, 16);
    let (amplitude_m, wavelength_m) = (10e-9, 32.0 * grid.dx_m());
    let wave = HeightMap::from_function(grid, |x, _| amplitude_m * (2.0 * PI * x / wavelength_m).cos()).unwrap();
    // Westergaard: contact is complete from p* = πE*h/λ on.
    let pressure_pa = 1.5 * PI * MODULUS_PA * amplitude_m / wavelength_m;
    let solution = solve(&wave, &half_space(grid, true), Control::MeanPressure { pascal: pressure_pa }, None);
    assert_eq!(solution.contact_fraction(), 1.0);
    let window = Window::new(wavelength_m, grid).unwrap();
    let friction = BowdenTabor { shear_strength_pa: 1e8 };
    for seen in slide(&window, &solution) {
        let mu = friction.coefficient(&seen).unwrap();
        assert!((mu / (1e8 / pressure_pa) - 1.0).abs() < 1e-6, "a window of one wave has {mu}");
    }
}

fn record(friction_force_n: Vec<f64>, load_n: Vec<f64>) -> Record {
    let quotient = |(force_n, load_n): (&f64, &f64)| if *load_n > 0.0 { force_n / load_n } else { f64::NAN };
    Record {
        position_m: (0..load_n.len()).map(|index| index as f64).collect(),
        friction: friction_force_n.iter().zip(&load_n).map(quotient).collect(),
        contact_cells: vec![1.0; load_n.len()],
        area_m2: friction_force_n.clone(),
        friction_force_n,
        load_n,
    }
}

#[test]
fn at_the_mean_load_windows_count_by_their_load() {
    // Equal loads change nothing.
    let even = record(vec![0.2, 0.3, 0.1], vec![2.0; 3]);
    let (mean, same) = Record::at_mean_load(std::slice::from_ref(&even));
    assert!((mean - 0.1).abs() < 1e-15);
    assert!(same[0].friction.iter().zip(&even.friction).all(|(a, b)| (a - b).abs() < 1e-15));
    // Uneven loads over two strips: ΣF/ΣN, which equals the mean of the records. An empty window has the mean.
    let uneven = [record(vec![1.0, 0.0], vec![4.0, 0.0]), record(vec![0.5, 0.03, 2.0], vec![1.0, 0.01, 8.0])];
    let (mean, linear) = Record::at_mean_load(&uneven);
    assert!((mean - 3.53 / 13.01).abs() < 1e-15);
    assert!((linear[0].friction[1] - mean).abs() < 1e-15);
    let all: Vec<f64> = linear.iter().flat_map(|record| record.friction.clone()).collect();
    assert!((all.iter().sum::<f64>() / 5.0 - mean).abs() < 1e-15);
    // A window with little load has a quotient of 3 and little weight.
    assert!((uneven[1].friction[1] - 3.0).abs() < 1e-12 && (linear[1].friction[1] - mean).abs() < 0.02);
}

#[test]
fn the_windows_of_a_pressed_wave_fluctuate_as_those_of_westergaard() {
    // Two waves along x under s = p̄/p*. With sin²(πa/λ) = s the pressure over u = sin(πx/λ) is (2p̄/s)√(s − u²)√(1 − u²), and a window from
    // the crest to u has the load (p̄λ/π)(u√(s − u²)/s + asin(u/√s)) and the friction force τ per contact width.
    let (s, waves, amplitude_m): (f64, f64, f64) = (0.3, 2.0, 0.1e-6);
    let grids = [1024, 2048].map(|nx| Grid::new(nx, 8, 256e-6 / nx as f64, 32e-6).unwrap());
    let wavelength_m = grids[0].width_m() / waves;
    let pascal = s * PI * MODULUS_PA * amplitude_m / wavelength_m;
    let law = BowdenTabor { shear_strength_pa: 1e8 };
    let wave = |x: f64, _| amplitude_m * (2.0 * PI * x / wavelength_m).cos();
    let maps = grids.map(|grid| HeightMap::from_function(grid, wave).unwrap());
    let [along, across] = WINDOWS;
    let window_m = grids[0].width_m() / along as f64;
    let problems = grids.map(|grid| {
        let window = Window::rectangle(window_m, grid.height_m() / across as f64, grid).unwrap();
        problem(half_space(grid, true), &law, 1e20, &window)
    });
    let task = Task::new(&Silent, "wave", 2);
    let found = PressedScan::new(&maps, &problems, Control::MeanPressure { pascal }, &task).unwrap().unwrap();

    let edge = s.sqrt();
    let halves = |x: f64| {
        // Signed contact width and load between the crest and x, at most half a wave away.
        let x = x / wavelength_m;
        let (turns, part) = (x.round(), x - x.round());
        let u = (PI * part).sin().clamp(-edge, edge);
        let load = (u * (s - u * u).max(0.0).sqrt() / s + (u / edge).clamp(-1.0, 1.0).asin()) / PI;
        [2.0 * turns * edge.asin() / PI + u.asin() / PI, turns + load]
    };
    let mean = 1e8 * 2.0 * edge.asin() / PI / pascal;
    let positions = 4096;
    let friction: Vec<f64> = (0..positions)
        .map(|index| {
            let start_m = wavelength_m * f64::from(index) / f64::from(positions);
            let ([a0, n0], [a1, n1]) = (halves(start_m), halves(start_m + window_m));
            let [area, load] = [a1 - a0, n1 - n0].map(|part| part * wavelength_m / window_m);
            mean + 1e8 * area / pascal - mean * load
        })
        .collect();
    let exact = Moments::from_values(friction.iter().copied());
    assert!((exact.mean / mean - 1.0).abs() < 1e-9, "{exact:?} {mean}");
    assert!((found.mean.value / mean - 1.0).abs() < 0.01, "{found:?} {mean}");
    assert!((found.std / exact.std - 1.0).abs() < 0.02, "{found:?} {exact:?}");
}

/// Averages a periodic record of one value per cell over windows.
fn averaged(process: &[f64], window: &Window, grid: Grid) -> Record {
    let step = (window.step_m() / grid.dx_m()).round() as usize;
    let cells = window.cells();
    let mean = |start: usize| (start..start + cells).map(|i| process[i % process.len()]).sum::<f64>() / cells as f64;
    let friction: Vec<f64> = (0..process.len()).step_by(step).map(mean).collect();
    let ones = vec![1.0; friction.len()];
    Record {
        position_m: (0..friction.len()).map(|index| index as f64 * window.step_m()).collect(),
        contact_cells: ones.clone(),
        area_m2: friction.clone(),
        friction_force_n: friction.clone(),
        load_n: ones,
        friction,
    }
}

/// Returns the window study of a process with the correlation φ^lag from cell to cell, under a window of 64 cells and
/// its parts.
fn study_of(phi: f64, seed: u64) -> (WindowStudy, Grid) {
    let grid = Grid::new(4096, 4, 1e-6, 1e-6).unwrap();
    let process = |strip: u64| -> Vec<f64> {
        let noise = random::standard_normal(&mut random::stream(seed, "process", strip), 4096);
        let mut last = noise[0];
        let next = |e: &f64| {
            last = phi * last + (1.0 - phi * phi).sqrt() * e;
            0.2 + 0.01 * last
        };
        noise.iter().map(next).collect()
    };
    let strips: Vec<Vec<f64>> = (0..12).map(process).collect();
    let window = Window::new(64e-6, grid).unwrap();
    let windows = std::iter::once(window.clone()).chain(window.narrower());
    let seen = |window: &Window| strips.iter().map(|strip| averaged(strip, window, grid)).collect();
    let records: Vec<(Window, Vec<Record>)> = windows.map(|window| (window.clone(), seen(&window))).collect();
    assert_eq!(records.len(), 4);
    (WindowStudy::new(&records, 1, LengthSettings::default()).unwrap(), grid)
}

#[test]
fn the_correlation_of_white_friction_is_due_to_the_window_alone() {
    let (study, grid) = study_of(0.0, 1);
    assert!(study.window_only(), "{study:?}");
    // The remaining length is below the cells of the shortest window.
    assert!(study.length_m < 2.0 * grid.dx_m(), "{:e}", study.length_m);
    for seen in &study.windows {
        // An exponential fitted to the triangle of W alone returns 322–368 µm at 600 µm; 5 % allow for the sample.
        let ratio = seen.length_m / seen.window_m;
        assert!(ratio > 0.95 * 322.0 / 600.0 && ratio < 1.05 * 368.0 / 600.0, "{ratio}");
    }
    // For independent cells the variance falls with the window.
    let stds: Vec<f64> = study.windows.iter().map(|seen| seen.std * seen.window_m.sqrt()).collect();
    assert!(stds.iter().all(|std| (std / stds[3] - 1.0).abs() < 0.1), "{stds:?}");
}

#[test]
fn white_friction_under_a_window_has_the_triangular_correlation() {
    let grid = Grid::new(4096, 4, 1e-6, 1e-6).unwrap();
    let window = Window::new(64e-6, grid).unwrap();
    let noise = |strip| random::standard_normal(&mut random::stream(3, "white", strip), 4096);
    let records: Vec<Record> = (0..60).map(|strip| averaged(&noise(strip), &window, grid)).collect();
    let series: Vec<&[f64]> = records.iter().map(|record| record.friction.as_slice()).collect();
    let found = RecordCorrelation::estimate(&series, window.step_m(), 32).unwrap();
    // The triangle 1 − s/W. Its estimate from 60 · 64 windows has the error √(2/3 · 1/3840) ≈ .013; 1/e at (1 − 1/e) W
    // = .632 W.
    for (lag, rho) in found.correlation.iter().enumerate() {
        let triangle = (1.0 - lag as f64 / 16.0).max(0.0);
        assert!((rho - triangle).abs() < 4.0 * 0.013, "{rho} for {triangle} at {lag} steps");
    }
    let length = found.correlation_length_m().unwrap() / window.length_m();
    assert!((length - 0.632).abs() < 4.0 * 0.013, "{length}");
}

#[test]
#[ignore = "slow"]
fn the_length_of_a_simulated_process_is_recovered_under_the_windows() {
    // φ = e^{−Δ/ℓ} with ℓ = 25 cells.
    let truth_m = 25e-6;
    let found: Vec<WindowStudy> = (2..10).map(|seed| study_of((-1.0_f64 / 25.0).exp(), seed).0).collect();
    assert!(found.iter().all(|study| !study.window_only()));
    let mean = found.iter().map(|study| study.length_m).sum::<f64>() / 8.0;
    let se = (found.iter().map(|study| (study.length_m - mean).powi(2)).sum::<f64>() / (7.0 * 8.0)).sqrt();
    println!("{mean:e} ± {se:e}");
    // The bias of the fit of a finite record is about one part in the number of lengths, 12·4096/25.
    assert!((mean - truth_m).abs() < 4.0 * se + 0.01 * truth_m, "{mean:e} ± {se:e}");
    // Of eight 95 % intervals, all miss with a probability of 4·10⁻¹¹, three or more with 6·10⁻³.
    let covering = found.iter().filter(|study| study.interval.contains(truth_m)).count();
    assert!(covering >= 6, "{covering} of 8 intervals hold the truth");
}

/// Returns strips of a Beta(2.1, 5) process on [.1, .4]. The normal variables have the correlation e^{−s/ℓ}, ℓ ten
/// steps.
fn beta_strips(strips: usize, steps: usize, seed: u64) -> Vec<Record> {
    let marginal = Marginal::beta(2.1, 5.0, 0.1, 0.4).unwrap();
    let phi = (-0.1_f64).exp();
    let strip = |strip: usize| {
        let g = autoregressive(phi, steps, &mut random::stream(seed, "beta strips", strip as u64));
        let friction: Vec<f64> = g.iter().map(|g| marginal.translate(*g)).collect();
        record(friction, vec![1.0; steps])
    };
    (0..strips).map(strip).collect()
}

#[test]
fn statistics_of_a_simulated_process_are_recovered() {
    let marginal = Marginal::beta(2.1, 5.0, 0.1, 0.4).unwrap();
    let mut records = beta_strips(20, 500, 3);
    // Windows without load leave gaps.
    for window in 40..45 {
        records[7].friction[window] = f64::NAN;
    }
    let found = FrictionStatistics::new(&records, 1e-5, false, 1).unwrap();
    assert_eq!((found.empty_windows, found.moments.n), (5, 9995));
    // The records contain 1,000 ℓ: the mean has an effective sample size of about 500, a little more after translation.
    assert!(found.effective_windows > 350.0 && found.effective_windows < 800.0, "{}", found.effective_windows);
    let estimates = found.estimates;
    for (estimate, truth) in [
        (estimates.mean, marginal.mean()),
        (estimates.std, marginal.std()),
        (estimates.coefficient_of_variation, marginal.std() / marginal.mean()),
        (estimates.skewness, marginal.skewness()),
        (estimates.excess_kurtosis, marginal.excess_kurtosis()),
    ] {
        let estimate = estimate.unwrap();
        assert!((estimate.value - truth).abs() < 4.0 * estimate.standard_error, "{estimate:?} for {truth}");
        assert!(estimate.interval.contains(estimate.value));
    }
    let (place, beta) = (found.marginals.place().unwrap(), found.beta.as_ref().unwrap());
    println!("{} {:?}", found.marginal().unwrap().marginal, found.marginals.goodness[place]);
    assert!(
        (beta.marginal.mean() / marginal.mean() - 1.0).abs() < 0.01
            && (beta.marginal.std() / marginal.std() - 1.0).abs() < 0.05
    );
    assert_eq!(found.parameters.len(), found.marginals.fits.len());
    let normal = found.marginals.fits.iter().position(|fit| fit.family == Family::Normal).unwrap();
    let p = |place: usize| found.marginals.goodness[place].anderson_darling.unwrap().p_value;
    assert!(p(place) > 0.01 && p(normal) < 0.05, "{} {}", p(place), p(normal));
    // The upper tail of a Beta distribution of shape b ends with ξ = −1/b.
    let tail = found.tail.as_ref().unwrap();
    assert!(tail.shape_interval.contains(-0.2) && tail.largest < 0.4, "{tail:?}");
    assert_eq!(tail.distributions.len(), found.marginals.fits.len());
    for mu in [0.2, 0.25, 0.3] {
        let (fraction, estimate) = found.fraction_above(mu);
        let estimate = estimate.unwrap();
        assert!((fraction - marginal.survival(mu)).abs() < 4.0 * estimate.standard_error, "{mu}: {estimate:?}");
    }
    let length_m = found.correlation.unwrap().exponential.length_m;
    assert!((length_m / 1e-4 - 1.0).abs() < 0.2, "{length_m:e}");
}

#[test]
fn the_standard_error_at_the_mean_load_agrees_with_a_jackknife_over_strips() {
    // Loads of Beta(2.1, 5), and forces that depend on them by half, in strips of 20 ℓ.
    let (loads, own) = (beta_strips(40, 200, 11), beta_strips(40, 200, 12));
    let strip = |(load, own): (&Record, &Record)| {
        let force = load.friction.iter().zip(&own.friction).map(|(n, f)| 0.1 * n + 0.1 * f).collect();
        record(force, load.friction.clone())
    };
    let records: Vec<Record> = loads.iter().zip(&own).map(strip).collect();
    let (mean, linear) = Record::at_mean_load(&records);
    let found = FrictionStatistics::new(&linear, 1e-5, false, 1).unwrap().estimates.mean.unwrap();
    assert!((found.value - mean).abs() < 1e-14);
    let without = |left_out: usize| {
        let kept: Vec<Record> =
            records.iter().enumerate().filter(|(i, _)| *i != left_out).map(|(_, r)| r.clone()).collect();
        Record::at_mean_load(&kept).0
    };
    let left: Vec<f64> = (0..40).map(without).collect();
    let jackknife = Moments::new(&left).std * 39.0_f64.sqrt();
    // Each standard error is accurate to 1/√(2·40), the quotient to √2 times that.
    assert!((found.standard_error / jackknife).ln().abs() < 4.0 * 0.11 * 2.0_f64.sqrt(), "{found:?} {jackknife}");
    // For ΣF/ΣN, loads determine half of the force. The quotients themselves vary far more.
    assert!(found.interval.contains(0.2), "{found:?}");
}

#[test]
fn few_long_strips_have_the_intervals_of_many_short_ones() {
    let width = |records: &[Record]| {
        let interval = FrictionStatistics::new(records, 1e-5, false, 1).unwrap().estimates.mean.unwrap().interval;
        interval.high - interval.low
    };
    let (one, many) = (width(&beta_strips(1, 4000, 5)), width(&beta_strips(20, 200, 6)));
    // Each width is accurate to about √(2/40)/2 on forty blocks.
    assert!((one / many).ln().abs() < 4.0 * 0.11 * 2.0_f64.sqrt(), "{one} {many}");
    // Strips of about one correlation length do not show their own correlation; their variability gives the interval.
    let short = FrictionStatistics::new(&beta_strips(40, 12, 7), 1e-5, false, 1).unwrap();
    assert!(short.estimates.mean.unwrap().degrees_of_freedom < 40.0);
}

#[test]
fn too_few_loaded_windows_have_no_statistics() {
    let nothing = record(vec![0.0; 30], vec![0.0; 30]);
    let error = FrictionStatistics::new(&[nothing], 1e-6, false, 1).unwrap_err();
    assert_eq!(error, FrictionError::NoContact { windows: 30, with_contact: 0 });
    let friction = BowdenTabor { shear_strength_pa: 1.0 };
    let empty = WindowContact {
        position_m: 0.0,
        contact_cells: 0.0,
        area_m2: 0.0,
        least_area_m2: 0.0,
        load_n: 0.0,
        ploughing_n: 0.0,
    };
    assert_eq!(friction.coefficient(&empty), None);
}

#[test]
fn a_level_that_cannot_be_solved_has_its_own_error() {
    let grid = grid(256, 16);
    let (surface, half_space) = (field(grid, 12e-6), half_space(grid, true));
    let (law, window) = (BowdenTabor { shear_strength_pa: 1e8 }, Window::new(40e-6, grid).unwrap());
    let levels = [Control::MeanPressure { pascal: 2e9 }, Control::Percentile { percent: 20.0 }];
    let solved = problem(half_space, &law, 1e9, &window).strips(&surface, 3, 9).solve(&levels, &Silent).unwrap();
    assert!(
        matches!(&solved[0], Err(FrictionError::TooFewValid { valid: 0, total: 3, first, .. }) if first.contains("hardness"))
    );
    let level = solved[1].as_ref().unwrap();
    let shown: &Array2<f64> = level.sample_pressure_pa.as_ref().unwrap();
    assert_eq!(shown.dim(), grid.shape());
}
