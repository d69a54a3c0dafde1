//! Random contact problems, each determined by its number, and a rough surface for tables.

use std::error::Error;

use asperity::contact::{
    Boundary, ContactError, ContactProblem, Control, HalfSpace, rms_gradient, spectral_rms_gradient,
};
use asperity::map::Grid;
use asperity::random;
use asperity_testing::{Choices, filtered_noise};
use ndarray::{Array2, s};

const SEED: u64 = 2016;
/// Columns and rows: even, odd, prime, and eight times as long as wide.
const SIZES: [(usize, usize); 20] = [
    (16, 16),
    (17, 17),
    (24, 24),
    (23, 19),
    (31, 31),
    (16, 128),
    (32, 32),
    (45, 45),
    (61, 67),
    (64, 64),
    (128, 16),
    (97, 97),
    (100, 100),
    (128, 128),
    (32, 256),
    (127, 131),
    (23, 184),
    (192, 192),
    (251, 241),
    (256, 256),
];
/// Pitch along y over that along x.
const ASPECTS: [f64; 8] = [1.0, 1.0, 1.0, 1.0, 2.0, 0.5, 5.0, 0.125];
const KINDS: [SurfaceKind; 9] = [
    SurfaceKind::SelfAffine,
    SurfaceKind::Smooth,
    SurfaceKind::Lay,
    SurfaceKind::Bump,
    SurfaceKind::RoughBump,
    SurfaceKind::Wave,
    SurfaceKind::WhiteNoise,
    SurfaceKind::Step,
    SurfaceKind::Plateaus,
];

/// Kind of surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SurfaceKind {
    /// Self-affine spectrum.
    SelfAffine,
    /// Gaussian spectrum.
    Smooth,
    /// Lay along y.
    Lay,
    /// Paraboloid.
    Bump,
    /// Rough paraboloid.
    RoughBump,
    /// One wave.
    Wave,
    /// White noise.
    WhiteNoise,
    /// Rough step.
    Step,
    /// Plateaus of equal height.
    Plateaus,
}

impl SurfaceKind {
    /// Returns the name of the kind in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::SelfAffine => "self-affine",
            Self::Smooth => "Gaussian spectrum",
            Self::Lay => "lay along y",
            Self::Bump => "paraboloid",
            Self::RoughBump => "rough paraboloid",
            Self::Wave => "one wave",
            Self::WhiteNoise => "white noise",
            Self::Step => "rough step",
            Self::Plateaus => "plateaus",
        }
    }
}

/// Random contact problem with its half-space and heights.
pub struct RandomProblem {
    /// Kind of surface.
    pub kind: SurfaceKind,
    /// Half-space.
    pub half_space: HalfSpace,
    heights_m: Array2<f64>,
    control: Control,
    hardness_pa: Option<f64>,
}

impl RandomProblem {
    /// Returns the problem for the solver.
    ///
    /// # Errors
    /// The problem is invalid.
    pub fn problem(&self) -> Result<ContactProblem<'_>, ContactError> {
        ContactProblem::new(&self.half_space, &self.heights_m, self.control, self.hardness_pa)
    }
}

/// Draws problem `number`. Kinds of surface, boundaries and controls alternate; everything else is random.
///
/// # Errors
/// A drawn value is invalid, which does not happen.
pub fn random_problem(number: u64) -> Result<RandomProblem, Box<dyn Error>> {
    let mut choices = Choices::new(SEED, "contact validation", number);
    let kind = KINDS[number as usize % KINDS.len()];
    let (nx, ny) = choices.one_of(&SIZES);
    let (pitch_m, modulus_pa, rms_m) =
        (choices.decades(-8.0, -4.0), choices.decades(6.0, 12.0), choices.decades(-9.0, -5.0));
    let grid = Grid::new(nx, ny, pitch_m, pitch_m * choices.one_of(&ASPECTS))?;
    let heights_m = standardised(heights(&mut choices, kind, grid)).mapv(|z| rms_m * z);
    let heights_m = Array2::from_shape_vec((ny, nx), heights_m.into_raw_vec_and_offset().0)?;
    let unit_pa = modulus_pa * rms_gradient(&heights_m, grid, Boundary::Free);
    let mean_pa = unit_pa * choices.decades(-3.3, 0.2);
    let control = match number % 5 {
        0 => Control::MeanPressure { pascal: mean_pa },
        1 => Control::Load { newton: mean_pa * grid.area_m2() },
        2 => Control::Penetration { metre: rms_m * choices.decades(-1.0, 0.7) },
        3 => Control::Percentile { percent: 100.0 * choices.decades(-2.5, -0.05) },
        _ => Control::MeanGap { metre: rms_m * choices.decades(-1.5, 0.3) },
    };
    let boundary = if (number / 5).is_multiple_of(2) {
        Boundary::Free
    } else {
        let usual = HalfSpace::default_mean_compliance_m_per_pa(grid, modulus_pa);
        let ratio = choices.one_of(if control.prescribes_plane() { &[0.3, 1.0, 3.0] } else { &[0.0, 0.0, 1.0] });
        Boundary::Periodic { mean_compliance_m_per_pa: ratio * usual }
    };
    let hardness_pa = match (choices.one_of(&[false, true]), control) {
        (false, _) => None,
        (true, Control::MeanPressure { .. } | Control::Load { .. }) => {
            Some(mean_pa * (1.0 + choices.decades(-2.0, 2.5)))
        }
        (true, _) => Some(unit_pa * choices.decades(-1.5, 0.7)),
    };
    Ok(RandomProblem { kind, half_space: HalfSpace::new(grid, modulus_pa, boundary)?, heights_m, control, hardness_pa })
}

fn heights(choices: &mut Choices, kind: SurfaceKind, grid: Grid) -> Vec<f64> {
    let (nx, ny) = (grid.nx(), grid.ny());
    let (x0, y0, waves) = (choices.between(0.3, 0.7), choices.between(0.3, 0.7), choices.one_of(&[1.0, 2.0, 5.0]));
    let hurst = choices.between(0.3, 0.9);
    let at = |i: usize| ((i % nx) as f64 / nx as f64, (i / nx) as f64 / ny as f64);
    let bump = |i: usize| -((at(i).0 - x0).powi(2) + (at(i).1 - y0).powi(2));
    let noise = random::standard_normal(&mut choices.stream, grid.points());
    let of = |height: &dyn Fn(usize) -> f64| (0..grid.points()).map(height).collect();
    match kind {
        SurfaceKind::SelfAffine => {
            filtered_noise(grid, &mut choices.stream, |qx, qy| qx.hypot(qy).max(2.0).powf(-1.0 - hurst))
        }
        SurfaceKind::Smooth => filtered_noise(grid, &mut choices.stream, |qx, qy| (-(qx * qx + qy * qy) / 144.0).exp()),
        SurfaceKind::Lay => {
            filtered_noise(grid, &mut choices.stream, |qx, qy| (qx / 16.0).hypot(qy / 2.0).max(0.5).powf(-1.0 - hurst))
        }
        SurfaceKind::Bump => of(&bump),
        SurfaceKind::RoughBump => of(&|i| bump(i) + 0.02 * noise[i]),
        SurfaceKind::Wave => of(&|i| (std::f64::consts::TAU * (waves * at(i).0 + at(i).1)).cos()),
        SurfaceKind::WhiteNoise => noise,
        SurfaceKind::Step => of(&|i| f64::from(at(i).0 < x0) + 0.01 * noise[i]),
        SurfaceKind::Plateaus => noise.iter().map(|z| z.round()).collect(),
    }
}

/// Scales heights to mean zero and unit standard deviation.
fn standardised(heights: Vec<f64>) -> ndarray::Array1<f64> {
    let heights = ndarray::Array1::from_vec(heights);
    let mean = heights.sum() / heights.len() as f64;
    let centred = heights.mapv(|z| z - mean);
    let rms = (centred.mapv(|z| z * z).sum() / centred.len() as f64).sqrt();
    centred.mapv(|z| z / rms)
}

/// Returns periodic heights over the unit square, self-affine with H = 0.8 between four cycles and `cutoff` cycles per side and flat
/// below, with an rms gradient of 1, on every `stride`-th of `points` × `points` points.
///
/// # Errors
/// The grid is invalid.
pub fn rough(points: usize, cutoff: f64, stride: usize) -> Result<Array2<f64>, Box<dyn Error>> {
    let grid = Grid::with_size(points, points, 1.0, 1.0)?;
    let filter = |qx: f64, qy: f64| match qx.hypot(qy) {
        q if q > cutoff => 0.0,
        q => q.max(4.0).powf(-1.8),
    };
    let heights = filtered_noise(grid, &mut random::stream(SEED, "rough", cutoff as u64), filter);
    let heights = Array2::from_shape_vec((points, points), heights)?;
    let gradient = spectral_rms_gradient(&heights, grid);
    Ok(heights.slice(s![..;stride, ..;stride]).mapv(|z| z / gradient))
}
