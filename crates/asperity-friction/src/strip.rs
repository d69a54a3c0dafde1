//! Strips of a random surface, solved at several levels of contact and evaluated by a sliding window.

use std::sync::Arc;

use ndarray::Array2;
use serde::{Deserialize, Serialize};

use crate::FrictionError;
use crate::law::WindowLaw;
use crate::window::Window;
use crate::{WindowContact, window_contacts};
use asperity_base::blocks::{Loop, Task};
use asperity_base::map::{Grid, HeightMap};
use asperity_base::monitor::{Cancelled, Monitor, Silent};
use asperity_base::random;
use asperity_base::stats::Moments;
use asperity_contact::{
    Boundary, ContactProblem, ContactWorkspace, Control, HalfSpace, Motion, Solution, Solver, StiffnessSolver,
};
use asperity_surface::RandomSurface;

/// Tolerance of the contact stiffness. The relative error of the stiffness is of the order of its square, 1e-4: far below the standard error
/// over the strips.
const STIFFNESS_TOLERANCE: f64 = 1e-2;

/// Contact problem, window and friction law of strips, without their random surface.
#[derive(Debug)]
pub struct StripProblem {
    /// Half-space on the strips' grid.
    pub half_space: HalfSpace,
    /// Sliding window. The windows of [`Window::narrower`] also slide along the strips, for the window study.
    pub window: Window,
    /// Friction law of the contacts.
    pub law: Arc<dyn WindowLaw>,
    /// Hardness in pascal, the upper bound of the pressure; `None` is elastic.
    pub hardness_pa: Option<f64>,
    /// Contact solver.
    pub solver: Solver,
    /// Least fraction of strips that must converge at a level.
    pub valid_share: f64,
}

impl StripProblem {
    /// Returns the grid of the strips.
    pub fn grid(&self) -> Grid {
        self.half_space.grid()
    }

    /// Returns whether the strips are periodic.
    pub fn is_periodic(&self) -> bool {
        self.half_space.boundary() != Boundary::Free
    }

    /// Returns the least friction coefficient, that of windows in which all contact is at the hardness; `None` if friction does not depend
    /// on the contact.
    pub fn least_coefficient(&self) -> Option<f64> {
        self.law.plastic_floor(self.hardness_pa.unwrap_or(f64::INFINITY))
    }

    /// Returns a number of strips of a random surface on the grid of the problem.
    pub fn strips<'a>(&'a self, surface: &'a dyn RandomSurface, realisations: usize, seed: u64) -> Strips<'a> {
        Strips { problem: self, surface, realisations, seed, stiff_level: None, pitch_factor: 1.0 }
    }
}

/// Strips of a random surface with their contact problem.
#[derive(Clone, Copy)]
pub struct Strips<'a> {
    /// Contact problem of the strips.
    pub problem: &'a StripProblem,
    /// Random surface on the grid of the problem.
    pub surface: &'a dyn RandomSurface,
    /// Number of strips.
    pub realisations: usize,
    /// Seed of the strips.
    pub seed: u64,
    /// Index of the level at which the contact stiffness is computed; each strip then costs up to half as much again.
    pub stiff_level: Option<usize>,
    /// Factor of the contact area beyond N/H, the least area under a load N, from this pitch to vanishing pitch; 1 does not extrapolate.
    pub pitch_factor: f64,
}

/// μ(s) of one strip, or of one track on it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Positions of the window in metre.
    pub position_m: Vec<f64>,
    /// Friction coefficient; NaN if the window carries no load.
    pub friction: Vec<f64>,
    /// Contact cells in the window.
    pub contact_cells: Vec<f64>,
    /// Contact area of the window in square metre, corrected at the edges of contact.
    pub area_m2: Vec<f64>,
    /// Friction force of the window in newton, 0 if it carries no load.
    pub friction_force_n: Vec<f64>,
    /// Load of the window in newton.
    pub load_n: Vec<f64>,
}

impl Record {
    /// Computes the record of the windows of one track.
    pub(super) fn from_contacts(windows: &[WindowContact], law: &dyn WindowLaw) -> Self {
        Self {
            position_m: windows.iter().map(|w| w.position_m).collect(),
            friction: windows.iter().map(|w| law.coefficient(w).unwrap_or(f64::NAN)).collect(),
            contact_cells: windows.iter().map(|w| w.contact_cells).collect(),
            area_m2: windows.iter().map(WindowContact::bearing_area_m2).collect(),
            friction_force_n: windows.iter().map(|w| law.force_n(w)).collect(),
            load_n: windows.iter().map(|w| w.load_n).collect(),
        }
    }

    /// Converts the records of a level to one process under constant load: μ̄ + (F − μ̄N)/N̄, with F and N the friction
    /// force and load of a window, N̄ the mean load and μ̄ = ΣF/ΣN.
    ///
    /// It is F/N linearised about the mean load, the friction of a body that rests on many windows. A window with
    /// little load has little weight, while its own quotient F/N may be huge. If windows share the load evenly, the two
    /// agree. Unlike the quotient it is a moving average along the strip, so the correlation of a window applies to it.
    /// Returns μ̄ and the records. A window without load has μ̄. If no window carries load, all values are NaN.
    pub fn at_mean_load(records: &[Self]) -> (f64, Vec<Self>) {
        let windows = records.iter().map(|record| record.load_n.len()).sum::<usize>() as f64;
        let force_n: f64 = records.iter().flat_map(|record| &record.friction_force_n).sum();
        let load_n: f64 = records.iter().flat_map(|record| &record.load_n).sum();
        let (mean, mean_load_n) = (force_n / load_n, load_n / windows);
        let linearised = records
            .iter()
            .map(|record| {
                let of = |(force_n, load_n): (&f64, &f64)| mean + (force_n - mean * load_n) / mean_load_n;
                let friction = record.friction_force_n.iter().zip(&record.load_n).map(of).collect();
                Self { friction, ..record.clone() }
            })
            .collect();
        (mean, linearised)
    }
}

/// A strip without a solution.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FailedStrip {
    /// Index of the realisation.
    pub index: usize,
    /// Reason of the failure.
    pub reason: String,
}

/// Solved strips at one level of contact.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct SolvedStrips {
    /// Records in the order of realisations and then of tracks, failed strips left out.
    pub records: Vec<Record>,
    /// Number of records per strip: tracks of the window.
    pub tracks: usize,
    /// Records of each rectangle of [`Window::narrower`].
    pub narrower: Vec<Vec<Record>>,
    /// Strips left out.
    pub failures: Vec<FailedStrip>,
    /// Mean depth of the plane below the highest point of each strip, in metre.
    pub penetration_m: f64,
    /// Mean pressure over all strips in pascal.
    pub mean_pressure_pa: f64,
    /// Mean pressure of every strip in pascal, failed ones left out.
    pub strip_pressures_pa: Vec<f64>,
    /// Contact stiffness of every strip over its area in Pa/m, failed strips left out. Empty at other levels than
    /// [`Strips::stiff_level`] and on free strips.
    pub strip_stiffnesses_pa_per_m: Vec<f64>,
    /// Contact area over nominal area, corrected at the edges of contact, mean over all strips.
    pub contact_fraction: f64,
    /// Number of contact cells of all strips.
    pub contact_cells: f64,
    /// Number of cells of all strips with p = H.
    pub plastic_cells: f64,
    /// Pressure on the first strip in pascal; absent if that strip failed.
    pub sample_pressure_pa: Option<Array2<f64>>,
}

/// Block of one strip: the strip solved at every level, or the reason why it has no solution there.
type StripBlock = Vec<Result<SolvedStrips, String>>;

impl SolvedStrips {
    /// Returns ΣF/ΣN of every strip, failed ones left out.
    pub fn strip_means(&self) -> Vec<f64> {
        self.records.chunks(self.tracks).map(|strip| Record::at_mean_load(strip).0).collect()
    }

    /// Multiplies the contact area and the friction force of all windows beyond their least values by a factor
    /// ([`Strips::pitch_factor`]).
    pub fn extrapolate(&mut self, problem: &StripProblem, factor: f64) {
        let Some(least) = problem.least_coefficient().filter(|_| factor != 1.0) else { return };
        let of = |value: f64, least: f64| least + factor * (value - least);
        let hardness_pa = problem.hardness_pa.unwrap_or(f64::INFINITY);
        self.contact_fraction = of(self.contact_fraction, self.mean_pressure_pa / hardness_pa);
        for record in self.records.iter_mut().chain(self.narrower.iter_mut().flatten()) {
            record.friction.iter_mut().for_each(|friction| *friction = of(*friction, least));
            for (index, load_n) in record.load_n.iter().enumerate() {
                let (area_m2, force_n) = (&mut record.area_m2[index], &mut record.friction_force_n[index]);
                *area_m2 = of(*area_m2, load_n / hardness_pa);
                *force_n = of(*force_n, least * load_n);
            }
        }
    }

    /// Returns the mean contact stiffness over the strips in Pa/m and its standard error; `None` if it was not computed or is unknown.
    /// The standard error is NaN for a single strip.
    pub fn stiffness_pa_per_m(&self) -> Option<(f64, f64)> {
        let moments = Moments::new(&self.strip_stiffnesses_pa_per_m);
        moments.mean.is_finite().then(|| (moments.mean, moments.standard_error()))
    }

    /// Returns the fraction of the contact cells with p = H; 0 without contact.
    pub fn plastic_fraction(&self) -> f64 {
        if self.contact_cells > 0.0 { self.plastic_cells / self.contact_cells } else { 0.0 }
    }
}

impl Strips<'_> {
    /// Solves every strip at every level. The strips are the same at all levels. A level at which fewer than 95 % of the
    /// strips converged has its own error in the result.
    ///
    /// Levels do not start from one another. At the distance of percentiles this takes more iterations than the
    /// solver's own start (`time_friction`: 8 to 17 compared with 8 to 11).
    ///
    /// # Errors
    /// The monitor cancelled.
    pub fn solve(
        &self,
        levels: &[Control],
        monitor: &dyn Monitor,
    ) -> Result<Vec<Result<SolvedStrips, FrictionError>>, Cancelled> {
        self.solve_steps(levels, &Task::new(monitor, "friction", self.realisations * levels.len()))
    }

    /// Solves as [`Strips::solve`], as part of a task of one step per strip and level.
    pub(super) fn solve_steps(
        &self,
        levels: &[Control],
        task: &Task<'_>,
    ) -> Result<Vec<Result<SolvedStrips, FrictionError>>, Cancelled> {
        let strips = Loop {
            count: self.realisations,
            block_bytes: size_of::<StripBlock>(),
            steps: levels.len(),
            failure: |levels: &StripBlock| levels.iter().find_map(|level| level.as_ref().err().cloned()),
        };
        let workspace = || self.problem.half_space.workspace();
        let solve = |workspace: &mut _, index| self.solve_strip(index, levels, task, workspace);
        let mut solved = Vec::with_capacity(self.realisations);
        task.reduce(&strips, workspace, solve, |_, strip: StripBlock| solved.push(strip.into_iter()))?;
        Ok(levels.iter().map(|_| self.gather(solved.iter_mut().filter_map(Iterator::next))).collect())
    }

    /// Solves one strip at every level.
    fn solve_strip(
        &self,
        index: usize,
        levels: &[Control],
        task: &Task<'_>,
        workspace: &mut ContactWorkspace,
    ) -> Result<StripBlock, Cancelled> {
        let map = self.map(index);
        let mut solve = |level: usize| {
            let heights_m = map.complete_heights_m().map_err(|error| error.to_string())?;
            let solution = self.solution(heights_m, levels[level], None, workspace)?;
            let stiffness_pa_per_m = match self.stiff_level {
                Some(stiff) if stiff == level => self.stiffness_pa_per_m(&solution, workspace)?,
                _ => None,
            };
            Ok(self.evaluate(heights_m, &solution, stiffness_pa_per_m, index == 0))
        };
        (0..levels.len()).map(|level| task.step(|| solve(level))).collect()
    }

    /// Generates the map of strip number `index`.
    pub fn map(&self, index: usize) -> HeightMap {
        self.surface.generate(&self.normal_variables(index))
    }

    /// Draws the normal variables of strip number `index`.
    pub(super) fn normal_variables(&self, index: usize) -> Vec<f64> {
        let mut stream = random::stream(self.seed, "friction/strip", index as u64);
        random::standard_normal(&mut stream, self.surface.xi_len())
    }

    /// Returns the converged solution of one strip, or the reason why there is none.
    pub(super) fn solution(
        &self,
        heights_m: &Array2<f64>,
        control: Control,
        start: Option<&Array2<f64>>,
        workspace: &mut ContactWorkspace,
    ) -> Result<Solution, String> {
        let problem = ContactProblem::new(&self.problem.half_space, heights_m, control, self.problem.hardness_pa)
            .map_err(|error| error.to_string())?;
        let solution =
            self.problem.solver.solve_from(&problem, start, workspace, &Silent).map_err(|error| error.to_string())?;
        if solution.converged() {
            return Ok(solution);
        }
        let (iterations, residual) = (solution.iterations(), solution.residual().worst());
        Err(format!("no convergence in {iterations} iterations: residual {residual:.1e}"))
    }

    /// Returns the contact stiffness k = −dp̄/dḡ of a periodic strip in Pa/m, with the mean gap ḡ.
    ///
    /// It is the stiffness against unloading and against small vibration: plastic cells move elastically too. The mean compliance
    /// is not part of it. A free strip is a punch, whose approach contains the compliance of its whole area; it has no such
    /// stiffness.
    fn stiffness_pa_per_m(&self, solution: &Solution, workspace: &mut ContactWorkspace) -> Result<Option<f64>, String> {
        if !self.problem.is_periodic() {
            return Ok(None);
        }
        let solver =
            StiffnessSolver { motion: Motion::Unloading, tolerance: STIFFNESS_TOLERANCE, ..StiffnessSolver::default() };
        let stiffness = solver
            .solve_in(&self.problem.half_space, solution, workspace, &Silent)
            .map_err(|error| error.to_string())?;
        // Without convergence, and in complete contact, the stiffness is unknown.
        Ok(Some(if stiffness.converged { stiffness.pascal_per_m } else { f64::NAN }))
    }

    /// Evaluates the windows of a solved strip.
    fn evaluate(
        &self,
        heights_m: &Array2<f64>,
        solution: &Solution,
        stiffness_pa_per_m: Option<f64>,
        keep: bool,
    ) -> SolvedStrips {
        let StripProblem { window, law, .. } = self.problem;
        let narrower = window.narrower();
        let windows: Vec<&Window> = std::iter::once(window).chain(&narrower).collect();
        let contacts = window_contacts(solution, &windows, law.ploughs().then_some(heights_m));
        let mut records = contacts.iter().map(|tracks| -> Vec<Record> {
            tracks.iter().map(|track| Record::from_contacts(track, law.as_ref())).collect()
        });
        let (points, mean_pressure_pa) = (heights_m.len() as f64, solution.mean_pressure_pa());
        let mut solved = SolvedStrips {
            records: records.next().unwrap_or_default(),
            tracks: contacts[0].len(),
            narrower: records.collect(),
            failures: Vec::new(),
            penetration_m: solution.penetration_m(),
            mean_pressure_pa,
            strip_pressures_pa: vec![mean_pressure_pa],
            strip_stiffnesses_pa_per_m: stiffness_pa_per_m.into_iter().collect(),
            contact_fraction: solution.corrected_contact_fraction(),
            contact_cells: solution.contact_fraction() * points,
            plastic_cells: solution.plastic_fraction() * points,
            sample_pressure_pa: keep.then(|| solution.pressure_pa().clone()),
        };
        solved.extrapolate(self.problem, self.pitch_factor);
        solved
    }

    /// Returns all strips at one level from the single ones, in their order.
    fn gather(
        &self,
        strips: impl Iterator<Item = Result<SolvedStrips, String>>,
    ) -> Result<SolvedStrips, FrictionError> {
        let narrower = vec![Vec::new(); self.problem.window.narrower().len()];
        let mut level = SolvedStrips { narrower, ..SolvedStrips::default() };
        for (index, strip) in strips.enumerate() {
            match strip {
                Ok(strip) => {
                    level.tracks = strip.tracks;
                    level.penetration_m += strip.penetration_m;
                    level.mean_pressure_pa += strip.mean_pressure_pa;
                    level.strip_pressures_pa.extend(strip.strip_pressures_pa);
                    level.strip_stiffnesses_pa_per_m.extend(strip.strip_stiffnesses_pa_per_m);
                    level.contact_fraction += strip.contact_fraction;
                    level.contact_cells += strip.contact_cells;
                    level.plastic_cells += strip.plastic_cells;
                    level.records.extend(strip.records);
                    for (records, tracks) in level.narrower.iter_mut().zip(strip.narrower) {
                        records.extend(tracks);
                    }
                    level.sample_pressure_pa = level.sample_pressure_pa.or(strip.sample_pressure_pa);
                }
                Err(reason) => level.failures.push(FailedStrip { index, reason }),
            }
        }
        self.check_valid(&level.failures)?;
        let count = (self.realisations - level.failures.len()) as f64;
        level.penetration_m /= count;
        level.mean_pressure_pa /= count;
        level.contact_fraction /= count;
        Ok(level)
    }

    /// Returns an error if too few strips converged.
    pub(super) fn check_valid(&self, failures: &[FailedStrip]) -> Result<(), FrictionError> {
        let (total, wanted) = (self.realisations, self.problem.valid_share);
        let valid = total - failures.len();
        if valid < total.min(2) || (valid as f64) < wanted * total as f64 {
            let first = failures.first().map_or_else(String::new, |failure| failure.reason.clone());
            return Err(FrictionError::TooFewValid { valid, total, wanted, first });
        }
        Ok(())
    }
}
