//! Mean friction against the shortest waves of the strips and against their pitch: plan, blocks and reduction.
//!
//! In elastic contact μ is inversely proportional to the root-mean-square slope of the surface, which its shortest waves determine.
//! Strips of the random surface are solved again at the mean pressure of the operating level, without the waves below cutoffs in
//! octaves, and on halves of the pitch. All use the same random numbers, so the ratio of their friction to that of the unchanged
//! strips has a smaller variance than either. The mean of the operating level is multiplied by this ratio.

use asperity_base::blocks::Task;
use asperity_base::monitor::{Cancelled, Monitor};
use asperity_base::stats::{Interval, ratio_95};
use asperity_contact::{Boundary, Control, rms_gradient};
use asperity_surface::RandomSurface;
use asperity_surface::filter::{Edges, Respaced};

use crate::solved_level::SolvedLevel;
use crate::strip::StripProblem;

/// Number of strips for each cutoff.
pub const STRIPS: usize = 4;
/// Largest number of octaves above the cutoff of the unchanged strips.
const OCTAVES: u32 = 4;
/// Largest cutoff over the shorter side of a strip.
const LONGEST: f64 = 1.0;
/// Work of a strip of half the pitch over the work of a strip: four times the cells and a few iterations more.
const HALVED_WORK: f64 = 5.0;
/// Largest work over the work of the levels; longer strips are halved,
const WORK: f64 = 0.3;
/// but not below this fraction of their length, so many widths or so many points.
const SHORTEST: f64 = 1.0 / 16.0;
const LEAST_WIDTHS: f64 = 4.0;
const LEAST_POINTS: usize = 64;
/// Most halvings of the pitch, the number of strips of the levels that cost as much if the levels have fewer, and the most cells of a strip.
const HALVINGS: u32 = 3;
const AFFORDABLE: usize = 60;
const CELLS: usize = 1 << 21;
/// Relative change of μ below which a change is negligible.
const NEGLIGIBLE: f64 = 0.01;

/// Strips that are solved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CutoffPlan {
    /// Points (x, y) of a strip at the pitch of the levels.
    pub points: [usize; 2],
    /// Length of a strip in metre.
    pub length_m: f64,
    /// Length of the shortest wave of the unchanged strips in metre: twice the pitch, or longer.
    pub cutoff_m: f64,
    /// Octaves above the cutoff of the unchanged strips.
    pub octaves: u32,
    /// Halvings of the pitch that are affordable, at least one.
    pub halvings: u32,
}

impl CutoffPlan {
    /// Plans the strips for levels with `solves` strips in all of this number of points and size in metre. Waves of the surface are
    /// not shorter than `shortest_m`, nor than twice the pitch.
    pub fn new([mut nx, ny]: [usize; 2], [length_m, width_m]: [f64; 2], solves: usize, shortest_m: f64) -> Self {
        let (whole, dx_m, dy_m) = (nx, length_m / nx as f64, width_m / ny as f64);
        let longest_m = LONGEST * length_m.min(width_m) * (1.0 + 1e-9);
        let cutoff_m = shortest_m.max(2.0 * dx_m.max(dy_m));
        let fits = |octave: &u32| cutoff_m * f64::from(1_u32 << octave) <= longest_m;
        let octaves = (1..=OCTAVES).take_while(fits).count() as u32;
        let plan = |nx: usize| {
            let work = |halvings: u32| STRIPS as f64 * nx as f64 / whole as f64 * HALVED_WORK.powi(halvings as i32);
            let affords = |halvings: &u32| {
                work(*halvings) <= solves.max(AFFORDABLE) as f64 && (nx * ny) << (2 * halvings) <= CELLS
            };
            let halvings = 1 + (2..=HALVINGS).take_while(affords).count() as u32;
            Self { points: [nx, ny], length_m: nx as f64 * dx_m, cutoff_m, octaves, halvings }
        };
        let halves = |nx: usize| {
            let shorter = (nx / 2) as f64;
            nx.is_multiple_of(2)
                && shorter >= SHORTEST * whole as f64
                && nx / 2 >= LEAST_POINTS
                && shorter * dx_m >= LEAST_WIDTHS * width_m
        };
        while plan(nx).work(whole) > WORK * solves as f64 && halves(nx) {
            nx /= 2;
        }
        plan(nx)
    }

    /// Returns the work in solutions of strips of `nx` points along x, with one halving of the pitch.
    pub fn work(&self, nx: usize) -> f64 {
        let fraction = self.points[0] as f64 / nx as f64;
        STRIPS as f64 * fraction * (f64::from(1 + self.octaves) + HALVED_WORK)
    }
}

/// Contact problems, random surface and level of a study of the cutoff.
pub struct CutoffStudy<'a> {
    plan: CutoffPlan,
    problem: &'a StripProblem,
    surface: &'a dyn RandomSurface,
    edges: Edges,
    control: Control,
    seed: u64,
}

/// Strips of one cutoff or pitch.
#[derive(Debug, Clone, PartialEq)]
pub struct CutoffBlock {
    /// ΣF/ΣN of each strip.
    means: Vec<f64>,
    /// Fraction of the contact cells at the hardness.
    pub plastic_fraction: f64,
    /// Root-mean-square slope of the strips.
    pub rms_slope: f64,
}

impl<'a> CutoffStudy<'a> {
    /// Prepares the strips of a plan at a mean pressure in pascal. `problem` has the pitch of the levels; `closes` states whether the maps
    /// of `surface`, on its grid, are periodic.
    pub fn new(
        plan: CutoffPlan,
        problem: &'a StripProblem,
        (surface, closes): (&'a dyn RandomSurface, bool),
        pascal: f64,
        seed: u64,
    ) -> Self {
        let edges = if closes { Edges::Periodic } else { Edges::Mirrored };
        Self { plan, problem, surface, edges, control: Control::MeanPressure { pascal }, seed }
    }

    /// Returns the larger pitch of the unchanged strips in metre.
    pub fn pitch_m(&self) -> f64 {
        let grid = self.problem.grid();
        grid.dx_m().max(grid.dy_m())
    }

    /// Returns the number of cutoffs, of which the first leaves the strips unchanged.
    pub fn cutoffs(&self) -> usize {
        self.plan.octaves as usize + 1
    }

    /// Returns cutoff number `index`, which doubles from one to the next, in metre.
    pub fn cutoff_m(&self, index: usize) -> f64 {
        self.plan.cutoff_m * f64::from(1_u32 << index)
    }

    /// Returns the task of the strips of a number of cutoffs and pitches.
    pub fn task<'t>(&self, blocks: usize, monitor: &'t dyn Monitor) -> Task<'t> {
        Task::new(monitor, "friction cut-off", blocks * STRIPS)
    }

    /// Solves the strips of cutoff number `index`; returns the reason if a strip has no solution or carries no load.
    ///
    /// # Errors
    /// The monitor cancelled.
    pub fn solve(&self, index: usize, task: &Task<'_>) -> Result<Result<CutoffBlock, String>, Cancelled> {
        let own = self.surface;
        if index == 0 {
            return self.solve_strips(self.problem, own, task);
        }
        self.solve_strips(self.problem, &Respaced::smoothed(own, self.edges, self.cutoff_m(index)), task)
    }

    /// Solves the unchanged strips on `problem`, whose pitch is that of the levels halved a number of times; returns the reason if a strip
    /// has no solution.
    ///
    /// # Errors
    /// The monitor cancelled.
    pub fn solve_halved(
        &self,
        problem: &StripProblem,
        halvings: u32,
        task: &Task<'_>,
    ) -> Result<Result<CutoffBlock, String>, Cancelled> {
        self.solve_finer(problem, self.surface, halvings, task)
    }

    fn solve_finer(
        &self,
        problem: &StripProblem,
        surface: &dyn RandomSurface,
        halvings: u32,
        task: &Task<'_>,
    ) -> Result<Result<CutoffBlock, String>, Cancelled> {
        let Some(rest) = halvings.checked_sub(1) else { return self.solve_strips(problem, surface, task) };
        match Respaced::with_half_the_pitch(surface, self.edges) {
            Ok(finer) => self.solve_finer(problem, &finer, rest, task),
            Err(error) => Ok(Err(error.to_string())),
        }
    }

    fn solve_strips(
        &self,
        problem: &StripProblem,
        surface: &dyn RandomSurface,
        task: &Task<'_>,
    ) -> Result<Result<CutoffBlock, String>, Cancelled> {
        let strips = problem.strips(surface, STRIPS, self.seed);
        let level = match strips.solve_steps(&[self.control], task)?.remove(0) {
            Ok(level) => level,
            Err(error) => return Ok(Err(error.to_string())),
        };
        let means = level.strip_means();
        if means.iter().any(|mean| !mean.is_finite()) {
            return Ok(Err("a strip carries no load".into()));
        }
        let squares = (0..STRIPS).map(|index| {
            // Differences across the edges are not slopes of the surface.
            rms_gradient(strips.map(index).heights_m(), problem.grid(), Boundary::Free).powi(2)
        });
        let rms_slope = (squares.sum::<f64>() / STRIPS as f64).sqrt();
        Ok(Ok(CutoffBlock { means, plastic_fraction: level.plastic_fraction(), rms_slope }))
    }
}

impl CutoffBlock {
    /// Returns the relative change of the mean from other strips of the same random numbers, and half of its 95 % interval.
    pub fn change_from(&self, other: &Self) -> [f64; 2] {
        let [ratio, half] = ratio(&self.means, &other.means);
        [ratio - 1.0, half]
    }
}

/// Mean friction of the operating level, which the ratios of blocks multiply.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OperatingMean {
    /// Mean.
    pub mean: f64,
    /// Half of its 95 % interval; 0 if friction does not vary, `None` if unknown.
    pub half: Option<f64>,
}

impl OperatingMean {
    /// Returns the mean of a level at the mean load.
    pub fn new(level: &SolvedLevel) -> Self {
        let process = &level.process;
        let varies = process.moments.std > 0.0;
        let interval = process.estimates.mean.map(|mean| mean.interval);
        let half = if varies { interval.map(|i| 0.5 * (i.high - i.low)) } else { Some(0.0) };
        Self { mean: level.mean, half }
    }

    /// Returns the mean of changed strips with its 95 % interval.
    pub fn of(&self, changed: &CutoffBlock, unchanged: &CutoffBlock) -> (f64, Option<Interval>) {
        let [ratio, ratio_half] = ratio(&changed.means, &unchanged.means);
        let mean = self.mean * ratio;
        let half = self.half.map(|half| (ratio * half).hypot(self.mean * ratio_half));
        (mean, half.map(|half| Interval { low: mean - half, high: mean + half }))
    }

    /// Returns the difference between the means of changed and unchanged strips with its 95 % interval.
    pub fn change(&self, changed: &CutoffBlock, unchanged: &CutoffBlock) -> (f64, Interval) {
        let [ratio, ratio_half] = ratio(&changed.means, &unchanged.means);
        let (change, half) = (self.mean * ratio - self.mean, self.mean * ratio_half);
        (change, Interval { low: change - half, high: change + half })
    }

    /// Returns the smallest change that is not negligible.
    pub fn material(&self) -> f64 {
        self.half.unwrap_or(0.0).max(NEGLIGIBLE * self.mean)
    }
}

/// Returns the ratio of the sums over strips of the same random numbers, and half of its 95 % interval.
fn ratio(changed: &[f64], unchanged: &[f64]) -> [f64; 2] {
    ratio_95(&changed.iter().zip(unchanged).map(|(a, b)| [*a, *b]).collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_base::random::{self, standard_normal};
    use asperity_base::stats::NORMAL_95;
    use asperity_testing::covered;

    #[test]
    fn common_factors_have_a_ratio_without_an_interval_and_others_students() {
        let [value, half] = ratio(&[0.11, 0.22, 0.33], &[0.1, 0.2, 0.3]);
        assert!((value - 1.1).abs() < 1e-12 && half < 1e-12);
        // Residuals ∓1 about the ratio 1: s² = 2/(2·1), over the mean 10, times t = 12.706 of one degree of freedom.
        let [value, half] = ratio(&[9.0, 11.0], &[10.0, 10.0]);
        assert!((value - 1.0).abs() < 1e-12 && (half - 12.706_205 * 0.1).abs() < 1e-6, "{half}");
    }

    #[test]
    fn intervals_of_changed_strips_cover_the_change_and_the_mean() {
        // Strips of the mean 0.3, of which the changed ones have three quarters, and a known mean of the level with normal errors.
        let (repeats, ratio, mean, std) = (1000, 0.75, 0.3, 0.004);
        let mut held = [0; 2];
        for repeat in 0..repeats {
            let z = standard_normal(&mut random::stream(5, "changed strips", repeat as u64), 3 * STRIPS + 1);
            let strips = |factor: f64, own: usize| {
                let strip = |i: usize| mean * factor * (1.0 + 0.1 * z[i] + 0.03 * z[own * STRIPS + i]);
                let means = (0..STRIPS).map(strip).collect();
                CutoffBlock { means, plastic_fraction: 0.0, rms_slope: 0.1 }
            };
            let (unchanged, changed) = (strips(1.0, 1), strips(ratio, 2));
            let level = OperatingMean { mean: mean + std * z[3 * STRIPS], half: Some(NORMAL_95 * std) };
            held[0] += usize::from(level.of(&changed, &unchanged).1.unwrap().contains(ratio * mean));
            held[1] += usize::from(level.change(&changed, &unchanged).1.contains((ratio - 1.0) * mean));
        }
        for (kind, held) in ["friction without short waves", "change of friction by half the pitch"].iter().zip(held) {
            let fraction = covered(kind, "four strips", held, repeats);
            assert!(fraction >= 0.93, "{kind}: {fraction}");
        }
    }

    #[test]
    fn the_strips_cost_less_than_a_third_of_the_levels() {
        let (points, size_m) = ([2048, 32], [6e-3, 75e-6]);
        for levels in [5, 6] {
            let plan = CutoffPlan::new(points, size_m, levels * 20, 0.0);
            let fraction = plan.work(points[0]) / (levels * 20) as f64;
            assert!(fraction <= WORK && fraction > 0.1, "{fraction}");
        }
        let wanted =
            CutoffPlan { points: [2048, 64], length_m: 3e-3, cutoff_m: 2.0 * 6e-3 / 4096.0, octaves: 4, halvings: 2 };
        assert_eq!(CutoffPlan::new([4096, 64], size_m, 6 * 20, 1e-7), wanted);
        // Longer waves leave fewer octaves up to the width.
        let long = CutoffPlan::new([4096, 64], size_m, 6 * 20, 1e-5);
        assert_eq!((long.cutoff_m, long.octaves), (1e-5, 2));
        // One level of few strips: the shortest strips, at least four widths and 64 points.
        let short = CutoffPlan::new([4096, 64], size_m, 2, 0.0);
        assert_eq!((short.points, short.halvings), ([256, 64], 3));
        // Many short strips: as many cells as are allowed.
        assert_eq!(CutoffPlan::new([512, 64], size_m, 5000, 0.0).halvings, 3);
        assert_eq!(CutoffPlan::new([2048, 64], size_m, 5000, 0.0).halvings, 2);
        assert_eq!(CutoffPlan::new([512, 64], size_m, 60, 0.0).halvings, 2);
    }
}
