//! Contact of random surfaces beside that of the scan that they are like.

use ndarray::s;

use asperity_base::map::{Grid, HeightMap};
use asperity_contact::{Boundary, ContactProblem, Control, HalfSpace, Solver, rms_gradient};
use asperity_surface::level::{Level, remove_form};

/// Points a side of the part of the scan, and of the random maps, that are pressed at most.
const POINTS: usize = 512;
/// Fraction of the scan in contact at which they are compared, and the mean pressure over E*h' that a Gaussian surface takes for it.
const FRACTION: f64 = 0.05;
const FIRST_PRESSURE: f64 = 0.02;
/// The fraction is met to this fraction of it, in this many solutions at most.
const TOLERANCE: f64 = 0.1;
const SOLUTIONS: usize = 8;
/// Random maps pressed at most.
const MAPS: usize = 2;
/// Ratio of the areas in contact from which, or below whose reciprocal, contact differs.
const DIFFERENT: f64 = 1.2;

/// Contact areas of a scan and of random maps that are like it, under the same elastic mean pressure.
///
/// A Gaussian field under a translation has the spectrum and the heights of a scan, but neither rounded summits over sharp valleys
/// nor rough plateaus. Such a scan and its random maps differ in contact although their slopes agree.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactLikeness {
    /// Points of the pressed part along x and y.
    pub points: [usize; 2],
    /// Fraction of the scan in contact, some 5 %.
    pub fraction_of_scan: f64,
    /// Mean fraction of the random maps in contact over that of the scan.
    pub ratio: f64,
}

impl ContactLikeness {
    /// Presses the middle of the scan, 512 × 512 points at most, and of two maps at most. Maps have the pitch of the scan. `None`
    /// without maps, if a map has fewer points or heights are missing in this part, or if a solution fails.
    pub fn new(scan: &HeightMap, maps: &[HeightMap]) -> Option<Self> {
        let own = scan.grid();
        let (nx, ny) = (own.nx().min(POINTS), own.ny().min(POINTS));
        let grid = Grid::new(nx, ny, own.dx_m(), own.dy_m()).ok()?;
        let levelled_part = |map: &HeightMap| {
            let (left, top) = (map.grid().nx().checked_sub(nx)? / 2, map.grid().ny().checked_sub(ny)? / 2);
            let part = map.heights_m().slice(s![top..top + ny, left..left + nx]).to_owned();
            let is_complete = part.iter().all(|z| !z.is_nan());
            let part = HeightMap::new(grid, part).ok().filter(|_| is_complete)?;
            Some(remove_form(&part, Level::Plane).ok()?.map)
        };
        let part = levelled_part(scan).filter(|_| !maps.is_empty())?;
        // Everything is proportional to the contact modulus.
        let half_space = HalfSpace::new(grid, 1.0, Boundary::Free).ok()?;
        let fraction = |map: &HeightMap, pascal: f64| {
            let problem =
                ContactProblem::new(&half_space, map.heights_m(), Control::MeanPressure { pascal }, None).ok()?;
            Some(Solver::default().solve(&problem).ok()?.contact_fraction()).filter(|fraction| *fraction > 0.0)
        };
        let mut pressure = FIRST_PRESSURE * rms_gradient(part.heights_m(), grid, Boundary::Free);
        let mut fraction_of_scan = fraction(&part, pressure)?;
        for _ in 1..SOLUTIONS {
            if (fraction_of_scan / FRACTION - 1.0).abs() < TOLERANCE {
                break;
            }
            pressure *= FRACTION / fraction_of_scan;
            fraction_of_scan = fraction(&part, pressure)?;
        }
        let pressed = &maps[..maps.len().min(MAPS)];
        let fractions: Vec<f64> =
            pressed.iter().map(|map| fraction(&levelled_part(map)?, pressure)).collect::<Option<_>>()?;
        let ratio = fractions.iter().sum::<f64>() / fractions.len() as f64 / fraction_of_scan;
        Some(Self { points: [nx, ny], fraction_of_scan, ratio })
    }

    /// Returns whether the areas differ by less than a fifth.
    pub fn is_near(&self) -> bool {
        (1.0 / DIFFERENT..=DIFFERENT).contains(&self.ratio)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_base::random::stream;
    use asperity_testing::self_affine;

    fn map(heights_m: ndarray::Array2<f64>) -> HeightMap {
        let (ny, nx) = heights_m.dim();
        HeightMap::new(Grid::new(nx, ny, 1.0, 1.0).unwrap(), heights_m).unwrap()
    }

    #[test]
    fn a_map_is_like_itself_and_unlike_steeper_and_reversed_ones() {
        let gaussian = self_affine(96, 12.0, &mut stream(1, "likeness", 0));
        // Rounded summits over deep valleys.
        let std = gaussian.std(0.0);
        let heights = gaussian.mapv(|z| -(-z / std).exp());
        let scan = map(heights.clone());
        let like = |other: ndarray::Array2<f64>| ContactLikeness::new(&scan, &[map(other)]).unwrap();
        let same = like(heights.clone());
        assert!((same.fraction_of_scan - 0.05).abs() < 0.005 && (same.ratio - 1.0).abs() < 1e-12 && same.is_near());
        // A tilt and an offset are no difference.
        let tilted = ndarray::Array2::from_shape_fn((96, 96), |(row, column)| {
            heights[[row, column]] + 0.01 * row as f64 - 0.02 * column as f64 + 3.0
        });
        assert!((like(tilted).ratio - 1.0).abs() < 1e-6);
        // Small areas of Gaussian heights are proportional to the pressure over the slope.
        let steep = ContactLikeness::new(&map(gaussian.clone()), &[map(2.0 * gaussian)]).unwrap();
        assert!((steep.ratio - 0.5).abs() < 0.05 && !steep.is_near(), "{steep:?}");
        // Sharp summits have the same slopes and a smaller contact area.
        let reversed = like(-&heights);
        assert!(reversed.ratio < 0.7 && !reversed.is_near(), "{reversed:?}");
    }

    #[test]
    fn missing_heights_and_flat_maps_are_not_compared() {
        let heights = self_affine(32, 8.0, &mut stream(1, "likeness", 1));
        let scan = map(heights.clone());
        let mut missing = heights.clone();
        missing[[3, 4]] = f64::NAN;
        assert_eq!(ContactLikeness::new(&map(missing), std::slice::from_ref(&scan)), None);
        let smaller = map(self_affine(16, 8.0, &mut stream(1, "likeness", 2)));
        assert_eq!([ContactLikeness::new(&scan, &[smaller]), ContactLikeness::new(&scan, &[])], [None; 2]);
        assert_eq!(ContactLikeness::new(&map(0.0 * heights), &[scan]), None);
    }
}
