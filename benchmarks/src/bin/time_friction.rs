//! Times the parts of the friction stage on strips of a rough steel surface at eight percentiles, and prints JSON.
//!
//! `cargo run --release -p asperity-benchmarks --bin time_friction -- key=value …` with
//!
//! | key | default | meaning |
//! |---|---|---|
//! | `strips` | 200 | strips |
//! | `nx`, `ny` | 2048, 256 | cells of a strip of 6 mm × 0.75 mm |
//! | `tolerance` | 1e-4 | of the solver |
//! | `threads` | 2 | of the pool |
//! | `parts` | 2 | strips on which generation, cold and warm solves, and windows are timed separately, on one thread |
//!
//! Heights are normal of Sq = 1 µm with squared exponential covariance, ℓ = 20 µm; E = 210 GPa, ν = 0.3, H = 2 GPa; the boundary
//! is periodic. `/usr/bin/time -f %M` prints the memory.
#![expect(clippy::print_stdout, reason = "prints times")]

use std::sync::Arc;
use std::time::Instant;

use asperity::contact::{Boundary, ContactProblem, Control, HalfSpace, Solver, contact_modulus_pa};
use asperity::correlation::{CorrelationModel, Covariance};
use asperity::distribution::Marginal;
use asperity::friction::law::BowdenTabor;
use asperity::friction::strip::{StripProblem, Strips};
use asperity::friction::window::Window;
use asperity::friction::window_contacts;
use asperity::map::Grid;
use asperity::monitor::Silent;
use asperity::random;
use asperity::surface::SpectralField;
use ndarray::Array2;
use serde_json::{Value, json};

type Result<T> = std::result::Result<T, Box<dyn std::error::Error + Send + Sync>>;

const PERCENTILES: [f64; 8] = [5.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 75.0];

/// Settings from the command line.
struct Settings {
    strips: usize,
    nx: usize,
    ny: usize,
    threads: usize,
    parts: usize,
    tolerance: f64,
}

impl Settings {
    fn parse(words: impl Iterator<Item = String>) -> Result<Self> {
        let mut settings = Self { strips: 200, nx: 2048, ny: 256, threads: 2, parts: 2, tolerance: 1e-4 };
        for word in words {
            let (key, value) = word.split_once('=').ok_or_else(|| format!("{word} is not key=value"))?;
            match key {
                "strips" => settings.strips = value.parse()?,
                "nx" => settings.nx = value.parse()?,
                "ny" => settings.ny = value.parse()?,
                "threads" => settings.threads = value.parse()?,
                "parts" => settings.parts = value.parse()?,
                "tolerance" => settings.tolerance = value.parse()?,
                _ => return Err(format!("unknown: {key}").into()),
            }
        }
        Ok(settings)
    }
}

fn main() -> Result<()> {
    let settings = Settings::parse(std::env::args().skip(1))?;
    let grid = Grid::with_size(settings.nx, settings.ny, 6e-3, 0.75e-3)?;
    let covariance = Covariance::isotropic(CorrelationModel::SquaredExponential, 1e-6, 20e-6)?;
    let surface = SpectralField::periodic(&covariance, grid);
    let modulus_pa = contact_modulus_pa(210e9, 0.3);
    let mean_compliance_m_per_pa = HalfSpace::default_mean_compliance_m_per_pa(grid, modulus_pa);
    let half_space = HalfSpace::new(grid, modulus_pa, Boundary::Periodic { mean_compliance_m_per_pa })?;
    let marginal = Marginal::normal(0.0, 1e-6)?;
    let problem = StripProblem {
        valid_share: 0.95,
        half_space,
        window: Window::new(600e-6, grid)?,
        law: Arc::new(BowdenTabor { shear_strength_pa: 385e6 }),
        hardness_pa: Some(2e9),
        solver: Solver { tolerance: settings.tolerance, ..Solver::default() },
    };
    let strips = problem.strips(&surface, settings.strips, 2016);
    let controls = PERCENTILES.map(|percent| Control::Plane { height_m: marginal.quantile(1.0 - percent / 100.0) });
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let apart = alone.install(|| parts(&strips, &controls, settings.parts))?;
    let start = Instant::now();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(settings.threads).build()?;
    let levels = if settings.strips > 0 { pool.install(|| strips.solve(&controls, &Silent))? } else { Vec::new() };
    let seconds = start.elapsed().as_secs_f64();
    let mut solved = Vec::new();
    for (percentile, level) in PERCENTILES.iter().zip(levels) {
        let level = level?;
        solved.push(json!({
            "percentile": percentile, "mean_pressure_pa": level.mean_pressure_pa, "failures": level.failures.len(),
            "contact_fraction": level.contact_fraction, "plastic_share": level.plastic_fraction(),
        }));
    }
    let solves = settings.strips * PERCENTILES.len();
    println!(
        "{}",
        json!({
            "seconds": seconds, "solves": solves, "solves_per_second": solves as f64 / seconds, "parts": apart, "levels": solved,
        })
    );
    Ok(())
}

/// Returns the seconds of each part of the work on `count` strips.
fn parts(strips: &Strips<'_>, controls: &[Control], count: usize) -> Result<Value> {
    let (mut xi_s, mut maps_s, mut windows_s) = (0.0, 0.0, 0.0);
    let mut by_level = vec![[0.0; 4]; controls.len()];
    let setup = strips.problem;
    let mut workspace = setup.half_space.workspace();
    for index in 0..count {
        let start = Instant::now();
        let xi = random::standard_normal(&mut random::stream(1, "parts", index as u64), strips.surface.xi_len());
        xi_s += start.elapsed().as_secs_f64();
        let start = Instant::now();
        let map = strips.surface.generate(&xi);
        maps_s += start.elapsed().as_secs_f64();
        let mut last: Option<Array2<f64>> = None;
        for (level, control) in by_level.iter_mut().zip(controls) {
            let problem =
                ContactProblem::new(&setup.half_space, map.complete_heights_m()?, *control, setup.hardness_pa)?;
            for (warm, start_from) in [(0, None), (2, last.as_ref())] {
                let start = Instant::now();
                let solution = setup.solver.solve_from(&problem, start_from, &mut workspace, &Silent)?;
                level[warm] += start.elapsed().as_secs_f64();
                level[warm + 1] += solution.iterations() as f64;
            }
            let solution = setup.solver.solve_with(&problem, &mut workspace)?;
            let start = Instant::now();
            let narrower = setup.window.narrower();
            let windows: Vec<&Window> = std::iter::once(&setup.window).chain(&narrower).collect();
            let seen: usize = window_contacts(&solution, &windows, None).iter().map(|tracks| tracks[0].len()).sum();
            windows_s += start.elapsed().as_secs_f64();
            assert!(seen > 0, "a strip has windows");
            last = Some(solution.pressure_pa().clone());
        }
    }
    let per = |seconds: f64| seconds / count.max(1) as f64;
    Ok(json!({
        "normal_variables_s": per(xi_s), "map_s": per(maps_s), "windows_s": per(windows_s) / controls.len() as f64,
        "levels": by_level.iter().map(|[cold_s, cold, warm_s, warm]| json!({
            "cold_s": per(*cold_s), "cold_iterations": per(*cold), "warm_s": per(*warm_s), "warm_iterations": per(*warm),
        })).collect::<Vec<_>>(),
    }))
}
