//! Contact of random surfaces beside that of the scan that they are like.

use crate::contact::{Boundary, ContactProblem, Control, HalfSpace, Solver, rms_gradient};
use crate::map::{Grid, HeightMap};
use crate::study::sentence;
use crate::surface::level::{Level, remove_form};

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
/// Ratio of the areas in contact from which, or below whose reciprocal, it is warned.
const WARNED: f64 = 1.2;

/// Returns a warning if random maps have another contact area than the scan under the same elastic mean pressure. Both are pressed on a
/// part of the grid of the scan; there is no warning if heights are missing in this part.
///
/// A Gaussian field under a translation has the spectrum and the heights of a scan, but neither rounded summits over sharp valleys nor
/// rough plateaus. Such a scan and its random maps differ in contact although their slopes agree.
pub(super) fn contact_warning(scan: &HeightMap, maps: &[HeightMap]) -> Option<String> {
    let own = scan.grid();
    let (nx, ny) = (own.nx().min(POINTS), own.ny().min(POINTS));
    let grid = Grid::new(nx, ny, own.dx_m(), own.dy_m()).ok()?;
    let levelled_part = |map: &HeightMap| {
        let (left, top) = ((map.grid().nx() - nx) / 2, (map.grid().ny() - ny) / 2);
        let part = map.heights_m().slice(ndarray::s![top..top + ny, left..left + nx]).to_owned();
        let is_complete = part.iter().all(|z| !z.is_nan());
        let part = HeightMap::new(grid, part).ok().filter(|_| is_complete)?;
        Some(remove_form(&part, Level::Plane).ok()?.map)
    };
    let part = levelled_part(scan)?;
    // Everything is proportional to the contact modulus.
    let half_space = HalfSpace::new(grid, 1.0, Boundary::Free).ok()?;
    let fraction = |map: &HeightMap, pascal: f64| {
        let problem = ContactProblem::new(&half_space, map.heights_m(), Control::MeanPressure { pascal }, None).ok()?;
        Some(Solver::default().solve(&problem).ok()?.contact_fraction()).filter(|fraction| *fraction > 0.0)
    };
    let mut pressure = FIRST_PRESSURE * rms_gradient(part.heights_m(), grid, Boundary::Free);
    let mut of_scan = fraction(&part, pressure)?;
    for _ in 1..SOLUTIONS {
        if (of_scan / FRACTION - 1.0).abs() < TOLERANCE {
            break;
        }
        pressure *= FRACTION / of_scan;
        of_scan = fraction(&part, pressure)?;
    }
    let pressed = &maps[..maps.len().min(MAPS)];
    let fractions: Vec<f64> =
        pressed.iter().map(|map| fraction(&levelled_part(map)?, pressure)).collect::<Option<_>>()?;
    let ratio = fractions.iter().sum::<f64>() / fractions.len() as f64 / of_scan;
    let is_near = (1.0 / WARNED..=WARNED).contains(&ratio);
    let of_part =
        if own.shape() == grid.shape() { String::new() } else { format!("a part of {nx} × {ny} points of ") };
    (!is_near).then(|| {
        format!(
            "pressed elastically as hard as {of_part}the scan, which touches on {} % of its area, random maps touch on {} times that \
             area, and mean contact pressures are off by about that factor: random maps have the scan's spectrum and heights, but not \
             the shape of its summits; a form of higher degree to remove (`level`), or the rejection of outliers, may help",
            sentence::digits(100.0 * of_scan),
            sentence::digits(ratio),
        )
    })
}
