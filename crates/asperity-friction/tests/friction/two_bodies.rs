//! Friction of two rough bodies on solved strips.

use std::sync::Arc;

use asperity_base::correlation::{CorrelationModel, Covariance};
use asperity_base::distribution::Marginal;
use asperity_base::map::Grid;
use asperity_base::monitor::Silent;
use asperity_base::translation::TranslationKind;
use asperity_contact::{Boundary, Control, HalfSpace, Solver};
use asperity_friction::law::BowdenTabor;
use asperity_friction::strip::StripProblem;
use asperity_friction::window::Window;
use asperity_friction::{LevelControl, NominalContact, RoughBody, SolvedLevel, TwoBodyFriction, WindowFriction};
use asperity_surface::model::{CompositeModel, SurfaceCovariance, SurfaceModel, Texture, XiOrder};

const MODULUS_PA: f64 = 230e9;
const LENGTH_M: f64 = 12e-6;
const STRIPS: usize = 8;

fn body(std_m: f64) -> SurfaceModel {
    let covariance = Covariance::isotropic(CorrelationModel::SquaredExponential, std_m, LENGTH_M).unwrap();
    SurfaceModel {
        marginal: Marginal::normal(0.0, std_m).unwrap(),
        texture: Texture::Translated {
            covariance: SurfaceCovariance::Model(covariance),
            translation: TranslationKind::Plain,
            expansion: None,
        },
        shortest_wave_m: None,
    }
}

/// Friction of a track and a slider with these standard deviations of their heights, under a mean pressure. The half-space is
/// periodic or free.
fn slide(std_m: [f64; 2], pressure_pa: f64, periodic: bool) -> (SolvedLevel, Option<TwoBodyFriction>) {
    let grid = Grid::new(512, 8, 2e-6, 2e-6).unwrap();
    let mean_compliance_m_per_pa = HalfSpace::default_mean_compliance_m_per_pa(grid, MODULUS_PA);
    let boundary = if periodic { Boundary::Periodic { mean_compliance_m_per_pa } } else { Boundary::Free };
    let problem = StripProblem {
        valid_share: 0.95,
        half_space: HalfSpace::new(grid, MODULUS_PA, boundary).unwrap(),
        window: Window::new(48e-6, grid).unwrap(),
        law: Arc::new(BowdenTabor { shear_strength_pa: 385e6 }),
        hardness_pa: None,
        solver: Solver { tolerance: 1e-6, ..Solver::default() },
    };
    let [surface, counterface] = std_m.map(body);
    let model = CompositeModel { surface, counterface: Some(counterface) };
    let generated = model.strip(grid, periodic, XiOrder::Variance).unwrap();
    let strips = problem.strips(generated.surface.as_ref(), if periodic { STRIPS } else { 2 }, 9);
    let control = Control::MeanPressure { pascal: pressure_pa };
    let solved = strips.solve(&[control], &Silent).unwrap().remove(0).unwrap();
    let level = SolvedLevel::new(LevelControl::MeanPressure(pressure_pa), solved, &problem, 9).unwrap();
    let found = TwoBodyFriction::solve(&strips, &level, control, &Silent).unwrap();
    (level, found)
}

/// Asserts that an estimate with a 95 % interval differs from the truth by at most 1.5 half-widths.
fn close(value: f64, interval: asperity_base::stats::Interval, wanted: f64) {
    let half = 0.5 * (interval.high - interval.low);
    assert!((value - wanted).abs() < 1.5 * half && half < 0.5 * wanted, "{value} ± {half}, not {wanted}");
}

#[test]
fn a_smooth_slider_leaves_the_process_of_the_track() {
    let (level, found) = slide([0.5e-6, 0.5e-9], 1e9, true);
    let found = found.unwrap();
    assert_eq!(found.between_parts_interval.unwrap().low, 0.0);
    assert!(found.path_std > 0.9 * level.process.moments.std, "{found:?}");
    let along = level.process.correlation.as_ref().unwrap().exponential.length_m;
    close(found.path_length_m, found.path_length_interval_m.unwrap(), along);
}

#[test]
fn a_smooth_track_leaves_differences_between_parts() {
    let (mut level, found) = slide([0.5e-9, 0.5e-6], 1e9, true);
    let (found, std) = (found.unwrap(), level.process.moments.std);
    assert!((found.between_parts_std / std - 1.0).abs() < 0.01 && found.path_std < 0.05 * std, "{found:?}");
    level.two_bodies = Some(found);
    let nominal = NominalContact { area_m2: 1e-6, pressure_pa: 1e9 };
    let [track, slider, both] = [RoughBody::Track, RoughBody::Slider, RoughBody::Both]
        .map(|body| WindowFriction::from_level(&level, body, nominal, None))
        .map(|friction| [friction.std, friction.between_parts_std]);
    assert_eq!([track, slider, both], [[std, 0.0], [0.0, std], [found.path_std, found.between_parts_std]]);
}

#[test]
fn in_full_contact_variances_are_those_of_the_bodies() {
    // In full contact the load of a window is linear in the heights, and friction at the mean load is μ̄(2 − N/N̄). Both bodies have
    // the same correlation, so the slider has b²/(a² + b²) of the variance. Pressures have a standard deviation of E*σ/ℓ.
    let std_m: [f64; 2] = [1e-9, 0.8e-9];
    let total_m = std_m[0].hypot(std_m[1]);
    let pressure_pa = 8.0 * MODULUS_PA * total_m / LENGTH_M;
    let (level, found) = slide(std_m, pressure_pa, true);
    assert_eq!(level.strips.sample_pressure_pa.as_ref().unwrap().iter().filter(|p| **p <= 0.0).count(), 0);
    let (found, std) = (found.unwrap(), level.process.moments.std);
    close(found.between_parts_std, found.between_parts_interval.unwrap(), std * std_m[1] / total_m);
    assert!((found.between_parts_std.hypot(found.path_std) / std - 1.0).abs() < 1e-12);
    // The fluctuation has the correlation of windows along the strip.
    let along = level.process.correlation.as_ref().unwrap().exponential.length_m;
    close(found.path_length_m, found.path_length_interval_m.unwrap(), along);
}

#[test]
fn the_track_of_a_free_strip_cannot_move() {
    assert_eq!(slide([0.5e-6, 0.5e-6], 1e9, false).1, None);
}
