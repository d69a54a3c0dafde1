//! Contact of random surfaces beside that of the scan that they are like.

use crate::contact::{Boundary, Control, HalfSpace, Problem, Solver, rms_gradient};
use crate::map::{Grid, HeightMap};
use crate::random;
use crate::study::surface_model::SurfaceModel;
use crate::study::{StudyError, sentence};
use crate::surface::RandomSurface;
use crate::surface::level::{Level, remove_form};

/// Points a side of the part of the scan, and of the random maps, that are pressed at most.
const POINTS: usize = 192;
/// Fraction of the scan in contact at which they are compared, and the mean pressure over E*h' that a Gaussian surface takes for it.
const FRACTION: f64 = 0.05;
const FIRST_PRESSURE: f64 = 0.02;
/// Random maps pressed.
const MAPS: u64 = 2;
/// Ratio of the areas in contact from which, or below whose reciprocal, it is warned.
const WARNED: f64 = 1.25;

/// A warning where random maps, pressed elastically as hard as a part of the scan, touch on another area; none where the scan has
/// missing heights there.
///
/// A Gaussian field under a translation has the spectrum and the heights of a scan, but neither rounded summits over sharp valleys nor
/// rough plateaus. Such a scan and its random maps differ in contact although their slopes agree.
pub(super) fn contact_warning(scan: &HeightMap, model: &SurfaceModel) -> Result<Option<String>, StudyError> {
    let own = scan.grid();
    let (nx, ny) = (own.nx().min(POINTS), own.ny().min(POINTS));
    let Ok(grid) = Grid::new(nx, ny, own.dx_m(), own.dy_m()) else { return Ok(None) };
    let (left, top) = ((own.nx() - nx) / 2, (own.ny() - ny) / 2);
    let part = scan.heights_m().slice(ndarray::s![top..top + ny, left..left + nx]).to_owned();
    if part.iter().any(|z| z.is_nan()) {
        return Ok(None);
    }
    let levelled = |map: &HeightMap| remove_form(map, Level::Plane).ok().map(|levelled| levelled.map);
    let Some(part) = HeightMap::new(grid, part).ok().and_then(|map| levelled(&map)) else { return Ok(None) };
    // Everything is proportional to the contact modulus.
    let Ok(half_space) = HalfSpace::new(grid, 1.0, Boundary::Free) else { return Ok(None) };
    let fraction = |map: &HeightMap, pascal: f64| {
        let problem = Problem::new(&half_space, map.heights_m(), Control::MeanPressure { pascal }, None).ok()?;
        Some(Solver::default().solve(&problem).ok()?.contact_fraction()).filter(|fraction| *fraction > 0.0)
    };
    let first = FIRST_PRESSURE * rms_gradient(part.heights_m(), grid, Boundary::Free);
    let Some(pressure) = fraction(&part, first).map(|found| first * FRACTION / found) else { return Ok(None) };
    let Some(of_scan) = fraction(&part, pressure) else { return Ok(None) };
    let surface = model.strip(grid, true)?.surface;
    let mut sum = 0.0;
    for index in 0..MAPS {
        let mut stream = random::stream(1, "contact check", index);
        let map = surface.generate(&random::standard_normal(&mut stream, surface.germ_len()));
        let Some(found) = levelled(&map).and_then(|map| fraction(&map, pressure)) else { return Ok(None) };
        sum += found / MAPS as f64;
    }
    let ratio = sum / of_scan;
    let is_near = (1.0 / WARNED..=WARNED).contains(&ratio);
    Ok((!is_near).then(|| {
        format!(
            "pressed elastically as hard as a part of the scan of {nx} × {ny} points that touches on {} % of its area, random maps \
             touch on {} times that area: summits of the scan have other slopes and shapes than those of a Gaussian field with its \
             spectrum and heights, and mean contact pressures are off by about that factor",
            sentence::digits(100.0 * of_scan),
            sentence::digits(ratio),
        )
    }))
}
