//! The scan itself, pressed like the random strips: the check of the whole route from scan to friction.

use asperity_base::blocks::Task;
use ndarray::s;

use crate::contact::Control;
use crate::friction::strip::StripProblem;
use crate::friction::{PressedScan, WINDOWS};
use crate::map::{BoundaryKind, Grid, HeightMap};
use crate::monitor::Monitor;
use crate::random::{standard_normal, stream};
use crate::study::check::FrictionStudy;
use crate::study::file::WindowShape;
use crate::study::friction_strips::strip_problem;
use crate::study::output::StageOutput;
use crate::study::result::{ScanCutoff, ScanFriction};
use crate::study::surface_scans::filled;
use crate::study::surface_stage::SurfaceStage;
use crate::study::{StudyError, sentence};
use crate::surface::RandomSurface;
use crate::surface::filter::{Edges, Respaced};
use crate::surface::model::BandSlopes;

/// Stream of the random heights in voids.
const FILL_STAGE: &str = "friction/scan";
/// Largest number of points of a scan; a larger one is pressed in its middle.
const MOST_POINTS: usize = 1 << 20;
/// Largest number of cells at a quarter of the pixel; half of it is always solved.
const MOST_AT_QUARTER: usize = 1 << 20;
/// Cut-offs at which a scan is pressed, at most.
const MOST_CUT_OFFS: usize = 3;
/// Strips whose slopes are compared with those of the scan.
const STRIPS: usize = 4;
/// Ratio of the shortest wave of the strips to that of the pixels below which there is no cut-off between them.
const BETWEEN: f64 = 1.5;
/// Pixels of the shortest wave that a difference over a pixel resolves.
const SLOPE_PIXELS: f64 = 4.0;

/// Presses the scan at the mean pressure of the operating level, without waves beyond the cut-off of the strips and with all waves; `None`
/// without a scan, with a rough counterface, and for Coulomb's law.
pub(super) fn run(
    friction: &FrictionStudy,
    surface: &SurfaceStage,
    (strips, pascal): (&dyn RandomSurface, f64),
    seed: u64,
    monitor: &dyn Monitor,
) -> Result<(Option<ScanFriction>, StageOutput), StudyError> {
    let mut output = StageOutput::default();
    let Some(scan) = surface.measured.as_ref().filter(|_| surface.model.counterface.is_none()) else {
        return Ok((None, output));
    };
    if !friction.depends_on_contact() {
        return Ok((None, output));
    }
    let cropped = middle(&scan.map)?;
    let grid = cropped.grid();
    if [grid.nx(), grid.ny()].iter().zip(WINDOWS).any(|(points, windows)| *points < 2 * windows) {
        output.warnings.push("the scan itself was not pressed: it has too few points".into());
        return Ok((None, output));
    }
    let missing = cropped.missing_points();
    let map = match filled(&cropped, seed, FILL_STAGE, monitor) {
        Ok(map) => map,
        Err(reason) => {
            output.warnings.push(format!("the scan itself was not pressed: its voids could not be filled ({reason})"));
            return Ok((None, output));
        }
    };
    let nyquist_m = 2.0 * grid.dx_m().max(grid.dy_m());
    let shortest_m = surface.model.surface.shortest_wave_m.filter(|m| *m > nyquist_m * (1.0 + 1e-9));
    let cut_offs: Vec<Option<f64>> = match shortest_m {
        Some(m) if surface.states_cut_off => vec![Some(m)],
        Some(m) if m > BETWEEN * nyquist_m => vec![Some(m), Some((m * nyquist_m).sqrt()), None],
        Some(m) => vec![Some(m), None],
        None => vec![None],
    };
    let problems = problems(friction, grid)?;
    let task = Task::new(monitor, "friction: the scan itself", cut_offs.len() * problems.len());
    let mut found = Vec::with_capacity(cut_offs.len());
    for cut_off in cut_offs {
        let first = cut_off.map_or_else(|| map.clone(), |m| Respaced::cut(&map, Edges::Mirrored, m).generate(&[]));
        let mut maps = vec![first];
        while maps.len() < problems.len() {
            let finer = Respaced::with_half_the_pitch(&maps[maps.len() - 1], Edges::Mirrored);
            let finer = finer.map_err(|error| StudyError::Grid { section: "friction", error })?.generate(&[]);
            maps.push(finer);
        }
        match PressedScan::new(&maps, &problems, Control::MeanPressure { pascal }, &task)? {
            Ok(pressed) => found.push((cut_off.unwrap_or(nyquist_m), pressed)),
            Err(reason) => {
                output.warnings.push(format!("the scan itself has no friction coefficient: {reason}"));
                return Ok((None, output));
            }
        }
    }
    let slope_ratio = slope_ratio(&scan.map, strips, shortest_m.unwrap_or(nyquist_m), seed)?;
    let sides = if grid.points() < scan.map.grid().points() { "its middle, " } else { "" };
    output.assumptions.push(format!(
        "The scan itself ({sides}{}, closed periodically{}) was pressed at {} too.",
        sentence::size(grid.width_m(), grid.height_m()),
        if missing > 0 { ", voids filled by a random surface of its statistics" } else { "" },
        sentence::si(pascal, "Pa"),
    ));
    let cut_offs = found.into_iter().map(|(cutoff_m, pressed)| ScanCutoff {
        cutoff_m,
        mean: pressed.mean.value,
        mean_interval: [-1.0, 1.0].map(|sign| pressed.mean.value + sign * pressed.sampling_error),
        grid_error: pressed.mean.error,
        order: pressed.mean.order,
        std: pressed.std,
        rms_slope: pressed.rms_slope,
        plastic_fraction: pressed.plastic_fraction,
    });
    let result = ScanFriction {
        size_m: [grid.width_m(), grid.height_m()],
        pitches_m: (0..problems.len()).map(|k| 0.5 * nyquist_m / f64::from(1_u32 << k)).collect(),
        slope_ratio,
        cut_offs: cut_offs.collect(),
    };
    Ok((Some(result), output))
}

/// Returns the middle of a map, at most `MOST_POINTS` points of its proportions.
fn middle(map: &HeightMap) -> Result<HeightMap, StudyError> {
    let grid = map.grid();
    let fraction = (MOST_POINTS as f64 / grid.points() as f64).sqrt();
    if fraction >= 1.0 {
        return Ok(map.clone());
    }
    let side = |n: usize| ((n as f64 * fraction) as usize).max(1);
    let (nx, ny) = (side(grid.nx()), side(grid.ny()));
    let (left, top) = ((grid.nx() - nx) / 2, (grid.ny() - ny) / 2);
    let heights_m = map.heights_m().slice(s![top..top + ny, left..left + nx]).to_owned();
    let part = Grid::new(nx, ny, grid.dx_m(), grid.dy_m()).and_then(|grid| HeightMap::measured(grid, heights_m));
    part.map_err(|error| StudyError::Grid { section: "surface", error })
}

/// Returns the halvings of the pixel at which a scan of a number of points is solved.
fn halvings(points: usize) -> std::ops::RangeInclusive<u32> {
    0..=if points << 4 <= MOST_AT_QUARTER { 2 } else { 1 }
}

/// Returns the number of cells of the finest solution of a scan of a number of points, and of all solutions.
pub(super) fn cells(points: usize) -> [usize; 2] {
    let cells = |k: u32| points.min(MOST_POINTS) << (2 * k);
    let halvings = halvings(points.min(MOST_POINTS));
    [cells(*halvings.end()), MOST_CUT_OFFS * halvings.map(cells).sum::<usize>()]
}

/// Returns the contact problems of a scan of this grid, from its own pitch to smaller ones.
fn problems(friction: &FrictionStudy, grid: Grid) -> Result<Vec<StripProblem>, StudyError> {
    let [along_x, along_y] = WINDOWS;
    let problem = |k: u32| {
        let study = FrictionStudy {
            points: [grid.nx() << k, grid.ny() << k],
            size_m: [grid.width_m(), grid.height_m()],
            boundary: BoundaryKind::Periodic,
            mean_compliance: None,
            // Whole pixels, so that no window is missing.
            window_m: [(grid.nx() / along_x) as f64 * grid.dx_m(), (grid.ny() / along_y) as f64 * grid.dy_m()],
            window_shape: WindowShape::Rectangle,
            ..friction.clone()
        };
        strip_problem(&study).map(|(problem, _)| problem)
    };
    halvings(grid.points()).map(problem).collect()
}

/// Returns Sdq of a few strips over Sdq of the scan, both without waves below `shortest_m` or those that a pitch does not resolve; `None` if
/// these waves are too long for the maps.
fn slope_ratio(
    scan: &HeightMap,
    strips: &dyn RandomSurface,
    shortest_m: f64,
    seed: u64,
) -> Result<Option<f64>, StudyError> {
    let grid = strips.grid();
    let cutoff_m = shortest_m.max(SLOPE_PIXELS * grid.dx_m().max(grid.dy_m()));
    let Some(slopes) = BandSlopes::new(&[scan], std::f64::consts::TAU / cutoff_m)? else { return Ok(None) };
    let mut squares = 0.0;
    for index in 0..STRIPS {
        let xi = standard_normal(&mut stream(seed, "friction/strip", index as u64), strips.xi_len());
        let Some(ratio) = slopes.ratio_of(&strips.generate(&xi))? else { return Ok(None) };
        squares += ratio * ratio;
    }
    Ok(Some((squares / STRIPS as f64).sqrt()))
}
