//! Synthetic scan of the quickstart study.

use asperity::correlation::{CorrelationModel, Covariance};
use asperity::distribution::Marginal;
use asperity::map::Grid;
use asperity::random::{self, Stream};
use asperity::surface::{RandomSurface, SpectralField};
use asperity_formats::Scan;
use ndarray::Array2;
use rand::RngExt;

const SEED: u64 = 1950;
const STREAM: &str = "brake disc";
const POINTS: usize = 512;
const PITCH_M: f64 = 2e-6;
const RMS_M: f64 = 0.8e-6;
/// Scales of the Matérn covariance along x (sliding) and y; the 1/e lengths are about the same.
const SCALES_M: [f64; 2] = [18e-6, 12e-6];
/// Smoothness of the covariance: a Hurst exponent of 0.8 at short waves.
const SMOOTHNESS: f64 = 0.8;
const GROOVES: u64 = 14;
const SPIKES: usize = 90;
const HOLES: usize = 26;

/// Returns the scan; it is the same every time.
///
/// # Errors
/// The grid or the covariance is invalid, which does not happen.
pub fn brake_disc() -> Result<Scan, Box<dyn std::error::Error>> {
    let grid = Grid::new(POINTS, POINTS, PITCH_M, PITCH_M)?;
    let covariance = Covariance::new(CorrelationModel::Matern { nu: SMOOTHNESS }, 1.0, SCALES_M[0], SCALES_M[1])?;
    let field = SpectralField::free(&covariance, grid)?;
    let xi = random::standard_normal(&mut random::stream(SEED, STREAM, 0), field.xi_len());
    // Wear leaves plateaus and valleys: a Beta distribution with its long tail below.
    let marginal = Marginal::beta(5.0, 2.1, 0.0, 1.0)?;
    let (mean, std) = (marginal.mean(), marginal.std());
    let mut heights = field.generate(&xi).heights_m().mapv(|g| (marginal.translate(g) - mean) / std * RMS_M);
    for index in 0..GROOVES {
        groove(&mut heights, &mut random::stream(SEED, "brake disc/groove", index));
    }
    heights.indexed_iter_mut().for_each(|((row, column), z)| {
        let (x, y) = (column as f64 * PITCH_M, row as f64 * PITCH_M);
        *z += 4e-3 * x - 2.5e-3 * y;
    });
    let mut stream = random::stream(SEED, "brake disc/faults", 0);
    for _ in 0..SPIKES {
        let (row, column) = (stream.random_range(0..POINTS), stream.random_range(0..POINTS));
        let sign = if stream.random_bool(0.7) { 1.0 } else { -1.0 };
        heights[[row, column]] += sign * stream.random_range(7.0..14.0) * RMS_M;
    }
    for _ in 0..HOLES {
        hole(&mut heights, &mut stream);
    }
    let mut scan = Scan::new(heights, Some((PITCH_M, PITCH_M)));
    for (key, value) in [
        ("Record2/Instrument/Manufacturer", "none: synthetic scan made by asperity's example brake_disc"),
        ("Record2/Comment", "SYNTHETIC, not measured: brake disc with tilt, grooves, spikes and missing points"),
    ] {
        scan.metadata.insert(key.into(), value.into());
    }
    Ok(scan)
}

/// Adds a groove with raised edges, nearly along the sliding direction.
fn groove(heights: &mut Array2<f64>, stream: &mut Stream) {
    let start = stream.random_range(0.0..POINTS as f64);
    let slope: f64 = stream.random_range(-0.05..0.05);
    let width = stream.random_range(1.5..4.0);
    let depth = stream.random_range(0.3..0.9) * RMS_M;
    let first = stream.random_range(0..POINTS / 2);
    let last = stream.random_range(POINTS / 2..POINTS);
    for column in first..last {
        let centre = start + slope * column as f64;
        for row in 0..POINTS {
            let t = (row as f64 - centre) / width;
            if t.abs() < 4.0 {
                // Mexican hat: the material displaced from the groove lies beside it.
                heights[[row, column]] -= depth * (1.0 - t * t) * (-0.5 * t * t).exp();
            }
        }
    }
}

/// Removes the readings of an elliptic patch.
fn hole(heights: &mut Array2<f64>, stream: &mut Stream) {
    let (row, column) = (stream.random_range(0.0..POINTS as f64), stream.random_range(0.0..POINTS as f64));
    let (half_height, half_width) = (stream.random_range(1.0..6.0), stream.random_range(1.0..9.0));
    for ((i, j), z) in heights.indexed_iter_mut() {
        let (v, u): (f64, f64) = ((i as f64 - row) / half_height, (j as f64 - column) / half_width);
        if u * u + v * v < 1.0 {
            *z = f64::NAN;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[ignore = "slow"]
    fn the_stored_scan_equals_the_generated_one() {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../studies/brake_disc.x3p");
        let stored = asperity_formats::read(&path).unwrap();
        let made = brake_disc().unwrap();
        assert_eq!(stored.pitch_m, made.pitch_m);
        assert_eq!(stored.heights_m.dim(), made.heights_m.dim());
        assert!(stored.metadata.values().any(|text| text.contains("SYNTHETIC, not measured")), "{:?}", stored.metadata);
        let present = || made.heights_m.iter().filter(|z| z.is_finite());
        let (low, high) =
            present().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), z| (low.min(*z), high.max(*z)));
        // Heights are stored in 16 bits, of which one or two values may stand for missing points.
        let step_m = (high - low) / 65_530.0;
        for ((row, column), wanted) in made.heights_m.indexed_iter() {
            let found = stored.heights_m[[row, column]];
            assert_eq!(found.is_finite(), wanted.is_finite(), "point [{row}, {column}]");
            assert!(
                !wanted.is_finite() || (found - wanted).abs() <= step_m,
                "[{row}, {column}]: {found:e} for {wanted:e}"
            );
        }
    }
}
