//! Rough cost of a study before it is run. Factors on the sizes of arrays are from runs of the program.

use crate::map::Grid;
use crate::study::{Stage, Study, friction_stage, pressure_stage, verdict, vibration_stage};
use crate::surface::model::SurfaceModel;

/// Iterations of a typical contact solution at the tolerance of a study.
const ITERATIONS: f64 = 30.0;
/// Seconds per cell and iteration on one core of a desktop computer.
const CELL_SECONDS: f64 = 20e-9;
/// Work of computing the stiffness of a contact, relative to solving it.
pub(super) const STIFFNESS_WORK: f64 = 0.5;
/// Bytes per point of a stability map, including cells and contours.
pub(super) const MAP_POINT_BYTES: f64 = 400.0;
/// Bytes of a value of a field in a run folder: a double in the NPY file, and in base64 in the VTK image.
const FIELD_BYTES: f64 = 8.0 + 32.0 / 3.0;
/// Bytes of the tables, the figures and the page of one stage in a run folder, and of its blocks beside it.
const STAGE_BYTES: f64 = 2e6;
/// Number of maps of a patch in a run folder: one sample with its pressures, and the distribution of the pressure.
const PATCH_FIELDS: f64 = 8.0;
/// Bytes of the program itself, its libraries and its threads: from 29 to 31 MB of unoptimised code, 20 MB of optimised code.
const PROGRAM_BYTES: f64 = 36e6;
/// Fraction of the memory of a member of a campaign that stays between members.
const KEPT_OF_A_MEMBER: f64 = 0.1;
/// Bytes per point of all scans in the surface stage, and those of their statistics per point of at most [`TRIAL_POINTS`].
const SCAN_BYTES: f64 = 110.0;
const TRIAL_BYTES: f64 = 400.0;
const TRIAL_POINTS: usize = 512 * 512;
/// Bytes per point of the scans in later stages.
const KEPT_SCAN_BYTES: f64 = 70.0;
/// Most points of a grid of which the modes are counted, in seconds. A larger one counts with all its modes.
const COUNTED_POINTS: usize = 1 << 23;

/// Rough cost of one stage. Times are accurate to a factor of a few.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StageEstimate {
    /// The stage.
    pub stage: Stage,
    /// Number of contact problems to solve.
    pub contact_solutions: usize,
    /// Upper bound of the work of contact problems on other grids, in problems on the stage's own grid: coarser ones of
    /// the pressure stage, shorter strips and finer ones of the friction stage.
    pub coarse_solutions: f64,
    /// Number of trajectories to simulate.
    pub trajectories: usize,
    /// Number of machines to evaluate without fluctuation of friction, for the verdict.
    pub machines: usize,
    /// Time on one core in second.
    pub core_seconds: f64,
    /// Memory of the program in byte while the stage runs, with the given number of threads.
    pub memory_bytes: f64,
}

impl StageEstimate {
    /// Returns the cost of a stage without solutions.
    pub(super) fn new(stage: Stage, memory_bytes: f64) -> Self {
        Self {
            stage,
            contact_solutions: 0,
            coarse_solutions: 0.0,
            trajectories: 0,
            machines: 0,
            core_seconds: 0.0,
            memory_bytes,
        }
    }

    /// Returns the memory of the program in byte while it runs the stage of several members of a campaign.
    pub(super) fn memory_together_bytes(&self, members: usize) -> f64 {
        let member_bytes = self.memory_bytes - PROGRAM_BYTES;
        PROGRAM_BYTES + (members as f64 + KEPT_OF_A_MEMBER) * member_bytes
    }
}

impl Study {
    /// Returns the rough cost of every stage of the study with `threads` threads; `scan_points` is the number of heights of its scans
    /// ([`Study::scan_points`]). Reads no file.
    pub fn estimate(&self, scan_points: usize, threads: usize) -> Vec<StageEstimate> {
        let verdict = || verdict::cost(self, threads);
        let stages = [
            pressure_stage::cost(self, threads),
            friction_stage::cost(self, scan_points, threads),
            vibration_stage::cost(self, threads),
            self.judges().then(verdict).flatten(),
        ];
        let mut stages: Vec<StageEstimate> = stages.into_iter().flatten().collect();
        if self.surface.is_some() {
            let bytes = SCAN_BYTES * scan_points as f64 + TRIAL_BYTES * scan_points.min(TRIAL_POINTS) as f64;
            let kept_bytes = KEPT_SCAN_BYTES * scan_points as f64;
            stages.iter_mut().for_each(|stage| {
                // Memory that the surface stage has freed serves the stages after it.
                stage.memory_bytes = (kept_bytes + stage.memory_bytes).max(bytes);
            });
            stages.insert(0, StageEstimate::new(Stage::Surface, bytes));
        }
        stages.iter_mut().for_each(|stage| stage.memory_bytes += PROGRAM_BYTES);
        stages
    }

    /// Returns the rough disk space of the run folder in byte, without the heights of scans. Reads and computes
    /// nothing.
    pub fn disk_bytes(&self) -> f64 {
        let bytes = |points: [usize; 2], fields: f64| fields * FIELD_BYTES * points[0] as f64 * points[1] as f64;
        let surface = self.file().surface.as_ref().map_or(0.0, |_| STAGE_BYTES);
        let pressure =
            self.pressure.as_ref().map_or(0.0, |p| STAGE_BYTES + bytes([p.grid.nx(), p.grid.ny()], PATCH_FIELDS));
        let friction = self.friction.as_ref().map_or(0.0, |f| STAGE_BYTES + bytes(f.points, 1.0));
        let vibration = self.vibration.as_ref().map_or(0.0, |v| {
            let map = v.map.as_ref().map_or(0.0, |map| (map.x.2 + 1) as f64 * (map.y.2 + 1) as f64);
            STAGE_BYTES + map * MAP_POINT_BYTES
        });
        surface + pressure + friction + vibration
    }
}

/// Returns the seconds of contact solutions on one core; `cells` counts those of all solutions.
pub(super) fn contact_seconds(cells: f64) -> f64 {
    cells * ITERATIONS * CELL_SECONDS
}

/// Returns the number of the Fourier modes of a patch or strip of a surface that scans measure.
pub(super) fn fourier_modes(grid: Grid, periodic: bool) -> usize {
    if periodic { grid.points() } else { 8 * grid.points() }
}

/// Returns the model of a surface that no scan measures, whose modes on a grid are counted.
pub(super) fn countable_surface(whole: &Study, grid: Grid) -> Option<SurfaceModel> {
    if grid.points() > COUNTED_POINTS {
        return None;
    }
    Some(SurfaceModel::new(whole.surface.as_ref()?.request.clone(), None).ok()?.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::vibration_stage::cost::{CROSSING_ENSEMBLES, FLUCTUATION_SECONDS};
    use asperity_testing::{METHODS, StudyText};

    #[test]
    fn the_estimate_counts_every_contact_problem_and_trajectory() {
        let text = StudyText::new(1, &["surface", "material", "pressure", "friction", "vibration"])
            .with("pressure", "size = [\"200 um\", \"200 um\"]\npoints = [64, 64]\nfine_solves = 100")
            .with("pressure", METHODS)
            .with("pressure", "reference_samples = 1000")
            .with("friction", "percentiles = [5.0, 50.0]\nrealisations = 20")
            .with("vibration", "belt_velocity = \"23.7 mm/s\"\ndamping_sweep = [0.05, 0.30, 11]\ntrajectories = 50")
            .without("material", &["hardness"])
            .without("friction", &["strip", "points", "window"])
            .without("vibration", &["dimensionless_belt_velocity"])
            .to_string();
        let text = text.as_str();
        let estimate = |text: &str| -> Vec<StageEstimate> {
            let stages = Study::parse(text, "study.toml").unwrap().estimate(0, 2);
            stages.into_iter().filter(|stage| stage.stage != Stage::Surface).collect()
        };
        let stages = estimate(text);
        // Two stated levels and the one at N/A_nom.
        assert_eq!(stages.iter().map(|s| s.contact_solutions).collect::<Vec<_>>(), [1300, 60, 0, 0]);
        assert_eq!(stages[2].trajectories, 2 * (11 + CROSSING_ENSEMBLES) * 50);
        // The hundred fine solves of the default may be followed by as much work again, four times over, on the same
        // maps.
        assert_eq!(stages.iter().map(|s| s.coarse_solutions).collect::<Vec<_>>(), [481.25, 18.0, 0.0, 0.0]);
        assert!(stages.iter().all(|s| s.core_seconds > 0.0 && s.memory_bytes > 0.0));
        // Maps of 64² points, a strip of doubles, and a few MB of tables, figures and page.
        let disk = |text: &str| Study::parse(text, "study.toml").unwrap().disk_bytes();
        let more = disk(&text.replace("points = [64, 64]", "points = [640, 640]")) - disk(text);
        assert!(
            (2e6..10e6).contains(&disk(text)) && (more / (8.0 * FIELD_BYTES * 99.0 * 4096.0) - 1.0).abs() < 1e-12,
            "{more}"
        );
        // Only the Monte Carlo and the coarse contacts include the stiffness.
        let stiff = estimate(&text.replace("percentile = 50.0", "percentile = 50.0\nstiffness = true"));
        let more = stiff[0].core_seconds / stages[0].core_seconds - 1.0;
        assert!((more - STIFFNESS_WORK * 581.25 / 1781.25).abs() < 1e-12, "{more}");
        assert_eq!(stiff[1..], stages[1..]);
        // Twelve surfaces with other parameters, each with half of the strips.
        let uncertain =
            text.replace("[vibration]", "[friction.uncertainty]\nrms_height = \"5 %\"\npoints = 12\n[vibration]");
        assert_eq!(estimate(&uncertain)[1].contact_solutions, 3 * (20 + 12 * 10));
        // Two rough bodies at seven more sliding distances.
        let rough = "[counterface]\ncovariance = \"exponential\"\nmarginal = \"normal\"\nrms_height = \"1 um\"\n\
                     correlation_length = \"20 um\"\n[vibration]";
        let both = text.replace("[vibration]", rough);
        assert_eq!(estimate(&both)[1].contact_solutions, 60 + 7 * 20);
        // An ensemble stores a bounded number of values, however long its trajectories are.
        let long = |duration: &str| {
            estimate(&text.replace("trajectories = 50", &format!("trajectories = 50\nduration = {duration}")))
        };
        assert!(long("1e12")[2].memory_bytes <= 1e9 && long("1e12")[2].memory_bytes > 2.0 * stages[2].memory_bytes);
        // Friction with a correlation length a thousandth as long has a thousand times as many values, which dominate
        // the time.
        let stated = |length: &str| {
            let text = text.split("[surface]").next().unwrap().to_owned()
                + "[vibration]"
                + text.split("[vibration]").nth(1).unwrap();
            let keys = "static_friction = 0.1\nfriction_std = 0.001\nfriction_marginal = \"normal\"";
            let text = format!("{text}{keys}\nfriction_correlation_length = \"{length}\"\n");
            estimate(&text)[0].core_seconds
        };
        let (short, shorter) = (stated("250 nm"), stated("250 pm"));
        assert!((shorter / short - 1000.0).abs() < 5.0, "{shorter} and {short}");
        // 20 values in 250 nm, over 640/316 s at 23.7 mm/s, in each of 3,100 trajectories.
        let values = 3100.0 * 20.0 * (640.0 / 316.0 * 23.7e-3) / 250e-9;
        assert!((short / (FLUCTUATION_SECONDS * values) - 1.0).abs() < 0.01, "{short}");
    }
}
