//! Rough cost of a study before it is run.

mod memory;
mod verdict;

use crate::friction::DISTANCES;
use crate::map::BoundaryKind;
use crate::study::check::{FrictionSource, FrictionStudy, VibrationStudy};
use crate::study::friction_stage::scan;
use crate::study::{Stage, Study};
use crate::vibration::EnsembleSettings;

/// Iterations of a typical contact solution at the tolerance of a study.
const ITERATIONS: f64 = 30.0;
/// Seconds per cell and iteration on one core of a desktop computer; the free boundary pads its transforms.
const PERIODIC_SECONDS: f64 = 20e-9;
const FREE_SECONDS: f64 = 20e-9;
/// Upper bound of the work of the pressure stage on coarser models, relative to the fine solves of one method: the same
/// maps at a loose tolerance, with half and a quarter of the points along either side, and further samples if they pay.
const COARSE_WORK: f64 = 4.0 + 0.5 + 0.25 + 0.0625;
/// Work of computing the stiffness of a contact, relative to solving it.
const STIFFNESS_WORK: f64 = 0.5;
/// Seconds per unit of dimensionless time of a trajectory, and per value of its fluctuation.
const TRAJECTORY_SECONDS: f64 = 0.2e-6;
const FLUCTUATION_SECONDS: f64 = 60e-9;
/// Additional ensembles, beside those of the sweep, that locate the crossings of one upscaling.
const CROSSING_ENSEMBLES: usize = 20;
/// Number of values of a fluctuation per correlation length.
const FLUCTUATION_VALUES: f64 = 20.0;
/// Bytes per point of a stability map, including cells and contours.
const MAP_POINT_BYTES: f64 = 400.0;
/// Bytes of a value of a field in a run folder: a double in the NPY file, and in base64 in the VTK image.
const FIELD_BYTES: f64 = 8.0 + 32.0 / 3.0;
/// Bytes of the tables, the figures and the page of one stage in a run folder, and of its blocks beside it.
const STAGE_BYTES: f64 = 2e6;
/// Number of maps of a patch in a run folder: one sample with its pressures, and the distribution of the pressure.
const PATCH_FIELDS: f64 = 8.0;

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
    fn new(stage: Stage, memory_bytes: f64) -> Self {
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
        let member_bytes = self.memory_bytes - memory::PROGRAM_BYTES;
        memory::PROGRAM_BYTES + (members as f64 + memory::KEPT_OF_A_MEMBER) * member_bytes
    }
}

impl Study {
    /// Returns the rough cost of every stage of the study with `threads` threads; `scan_points` is the number of heights of its scans
    /// ([`Study::scan_points`]). Reads no file.
    pub fn estimate(&self, scan_points: usize, threads: usize) -> Vec<StageEstimate> {
        let mut stages = self.stage_estimates(threads);
        if self.presses_scan(scan_points)
            && let Some(stage) = stages.iter_mut().find(|stage| stage.stage == Stage::Friction)
        {
            let [finest, all] = scan::cells(scan_points);
            stage.core_seconds += all as f64 * ITERATIONS * PERIODIC_SECONDS;
            stage.memory_bytes = stage.memory_bytes.max(memory::pressed_bytes(finest));
        }
        if self.surface.is_some() {
            let bytes = memory::surface_bytes(scan_points);
            stages.iter_mut().for_each(|stage| {
                // Memory that the surface stage has freed serves the stages after it.
                stage.memory_bytes = (memory::kept_bytes(scan_points) + stage.memory_bytes).max(bytes);
            });
            stages.insert(0, StageEstimate::new(Stage::Surface, bytes));
        }
        stages.iter_mut().for_each(|stage| stage.memory_bytes += memory::PROGRAM_BYTES);
        stages
    }

    /// Returns whether the friction stage presses the scan itself.
    fn presses_scan(&self, scan_points: usize) -> bool {
        let depends = self.friction.as_ref().is_some_and(FrictionStudy::depends_on_contact);
        scan_points > 0 && depends && self.counterface.is_none()
    }

    /// Returns the rough cost of every stage after the surface, with its own memory.
    fn stage_estimates(&self, threads: usize) -> Vec<StageEstimate> {
        let contact = |stage, (solutions, coarse): (usize, f64), points: [usize; 2], boundary, memory_bytes: f64| {
            let cells = points[0] as f64 * points[1] as f64;
            let per_cell = if boundary == BoundaryKind::Free { FREE_SECONDS } else { PERIODIC_SECONDS };
            StageEstimate {
                contact_solutions: solutions,
                coarse_solutions: coarse,
                core_seconds: (solutions as f64 + coarse) * cells * ITERATIONS * per_cell,
                ..StageEstimate::new(stage, memory_bytes)
            }
        };
        let mut stages = Vec::new();
        if let Some(p) = &self.pressure {
            // The reference, and three samplers that the other methods share.
            let solutions = p.reference_samples + 3 * p.fine_solves;
            let coarse = COARSE_WORK * p.fine_solves as f64;
            let points = [p.grid.nx(), p.grid.ny()];
            let bytes = self.pressure_bytes(p, threads);
            let mut stage = contact(Stage::Pressure, (solutions, coarse), points, p.boundary, bytes);
            if p.stiffness {
                // The stiffness of the Monte Carlo samples and of those on coarser grids.
                let more = STIFFNESS_WORK * (p.fine_solves as f64 + coarse);
                stage.core_seconds *= 1.0 + more / (solutions as f64 + coarse);
            }
            stages.push(stage);
        }
        if let Some(f) = &self.friction {
            let nominal = self.vibration.as_ref().is_some_and(|v| v.friction == FrictionSource::Computed(None));
            let uncertain = f.uncertainty.as_ref().map_or(0, |u| u.points * u.realisations);
            let levels = f.levels.len() + usize::from(nominal);
            // Two rough bodies are solved again after several sliding distances, at one level.
            let slides = self.counterface.is_some() && f.boundary == BoundaryKind::Periodic;
            let slid = if slides { DISTANCES * f.realisations } else { 0 };
            let solutions = levels * (f.realisations + uncertain) + slid;
            let plan = f.cutoff_plan(levels, 0.0);
            let others = plan.map_or(0.0, |plan| plan.work(f.points[0]));
            let bytes = self.friction_bytes(f, levels, plan, threads);
            let mut stage = contact(Stage::Friction, (solutions, others), f.points, f.boundary, bytes);
            // The strips of the operating level have a stiffness.
            stage.core_seconds *= 1.0 + STIFFNESS_WORK * f.realisations as f64 / (solutions as f64 + others);
            stages.push(stage);
        }
        if let Some(v) = self.vibration.as_ref().filter(|v| v.coupled.is_none()) {
            // Both upscalings, and a map whose front is refined: a line of cells at each depth.
            let points = v.map.as_ref().map_or(0, |map| {
                let (nx, ny) = (map.x.2, map.y.2);
                (nx + 1) * (ny + 1) + 4 * nx.max(ny) * ((1 << (map.depth + 1)) - 2)
            });
            let map = v.map.as_ref().map_or(0, |map| points.saturating_mul(map.trajectories));
            let ensembles = v.damping_sweep.2 + CROSSING_ENSEMBLES;
            let trajectories = (2 * ensembles * v.trajectories).saturating_add(map);
            let bytes = EnsembleSettings::new(v.trajectories, v.duration, self.seed()).memory_bytes(threads)
                + points as f64 * MAP_POINT_BYTES;
            stages.push(StageEstimate {
                trajectories,
                core_seconds: trajectories as f64 * self.trajectory_seconds(v),
                ..StageEstimate::new(Stage::Vibration, bytes)
            });
        }
        if self.states_verdict() {
            stages.extend(self.verdict_estimate(threads));
        }
        stages
    }

    /// Returns the seconds of one trajectory of the vibration stage.
    fn trajectory_seconds(&self, v: &VibrationStudy) -> f64 {
        // Friction that a study computes is correlated over at least one window.
        let length_m = match &v.friction {
            FrictionSource::Stated(friction) => Some(friction.length_m),
            FrictionSource::Computed(_) | FrictionSource::File(_) => self.friction.as_ref().map(|f| f.window_m[0]),
        };
        let values = length_m.map_or(0.0, |length_m| FLUCTUATION_VALUES * v.sliding_distance_m() / length_m);
        TRAJECTORY_SECONDS * v.duration + FLUCTUATION_SECONDS * values
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

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_testing::StudyText;

    #[test]
    fn the_estimate_counts_every_contact_problem_and_trajectory() {
        let text = StudyText::new(1, &["surface", "material", "pressure", "friction", "vibration"])
            .with("pressure", "size = [\"200 um\", \"200 um\"]\npoints = [64, 64]\nfine_solves = 100")
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
        assert_eq!(stages.iter().map(|s| s.contact_solutions).collect::<Vec<_>>(), [1300, 60, 0]);
        assert_eq!(stages[2].trajectories, 2 * (11 + CROSSING_ENSEMBLES) * 50);
        // The hundred fine solves of the default may be followed by as much work again, four times over, on the same
        // maps.
        assert_eq!(stages.iter().map(|s| s.coarse_solutions).collect::<Vec<_>>(), [481.25, 18.0, 0.0]);
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
