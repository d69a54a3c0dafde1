//! Samples of a quantity on several models: many on coarse models, few on the fine one.

use serde::{Deserialize, Serialize};

use crate::coarse::{CoarseModel, generation_work, solution_work};
use crate::multilevel::{self, LevelSamples, MultilevelEstimate, Settings};
use crate::rotated_variables::RotatedVariables;
use crate::{CellObservation, MethodError, PressureError, PressureEstimate, Problem, Samples, stiffness};
use asperity_base::blocks::{Loop, Task};
use asperity_base::monitor::{Cancelled, Monitor};
use asperity_chaos::{Design, DiscreteDistribution, DiscreteDistributionError, SamplingMethod};
use asperity_contact::ContactWorkspace;

/// Smallest fraction of the fine samples that a coarse model must solve.
const LEAST_HAD: f64 = 0.95;
/// Number of samples used to plan the coarse models.
const PILOT: usize = 250;
/// Maximum cost of coarse solutions beyond the fine samples, relative to the fine ones.
const COARSE_FRACTION: f64 = 4.0;
/// Target fraction of the variance that coarse models may add, and the factor of the steps by which the number of
/// samples is raised.
const ADDED_VARIANCE: f64 = 1.0 / 3.0;
const SCALE_STEP: f64 = 1.1;
/// Degree of the polynomials by which a model predicts the next one.
const DEGREE: usize = 3;
/// Maximum number of rotated variables.
const MOST_VARIABLES: usize = 3;

/// Scalar result of a contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Pressure of the problem's cell in pascal; 0 out of contact.
    Pressure,
    /// Fraction A_c/A of the cells in contact.
    ContactFraction,
    /// Load over the nominal area in pascal.
    MeanPressure,
    /// Mean gap in metre.
    MeanGap,
    /// Contact stiffness: rise of the mean pressure as the plane approaches, in Pa/m ([`Problem::with_stiffness`]); 0
    /// without contact.
    Stiffness,
}

impl Quantity {
    /// All quantities.
    pub const ALL: [Self; 5] =
        [Self::Pressure, Self::ContactFraction, Self::MeanPressure, Self::MeanGap, Self::Stiffness];

    /// Returns the value, continued beyond its bounds if possible.
    ///
    /// Out of contact the gap measures the distance from contact, and at the hardness the plastic displacement measures
    /// the yielding. `kappa` converts these lengths in metre to a pressure.
    fn latent(self, observation: &CellObservation, kappa: f64) -> f64 {
        match self {
            Self::Pressure => {
                observation.pressure_pa + kappa * (observation.plastic_displacement_m - observation.gap_m)
            }
            Self::ContactFraction => observation.contact_fraction,
            Self::MeanPressure => observation.mean_pressure_pa,
            Self::MeanGap => observation.mean_gap_m,
            Self::Stiffness => observation.stiffness_pa_per_m.unwrap_or(f64::NAN),
        }
    }

    /// Returns the values of several observations, continued beyond their bounds if possible.
    pub(super) fn values(self, observations: &[CellObservation], kappa: f64) -> Vec<f64> {
        observations.iter().map(|observation| self.latent(observation, kappa)).collect()
    }

    /// Returns further covariates from a coarse solution: for the pressure, the values beside the cell.
    fn covariates(self, observation: &CellObservation, kappa: f64) -> Vec<f64> {
        let [pressure_pa, gap_m, plastic_displacement_m] = observation.beside;
        match self {
            Self::Pressure => vec![pressure_pa + kappa * (plastic_displacement_m - gap_m)],
            _ => Vec::new(),
        }
    }

    /// Returns the bounds of the value.
    pub(super) fn bounds(self, problem: &Problem<'_>) -> [f64; 2] {
        match self {
            Self::Pressure | Self::MeanPressure => [0.0, problem.hardness_pa().unwrap_or(f64::INFINITY)],
            Self::ContactFraction => [0.0, 1.0],
            Self::MeanGap => [0.0, f64::INFINITY],
            Self::Stiffness => [0.0, stiffness::largest_pa_per_m(problem.half_space())],
        }
    }
}

/// Returns the ratio of the standard deviations of the pressures in contact and of the gaps out of contact; 1 if one of
/// them is zero.
pub(super) fn kappa_pa_per_m(observations: &[CellObservation]) -> f64 {
    let spread = |in_contact: bool, quantity: fn(&CellObservation) -> f64| {
        let chosen = observations.iter().filter(|o| (o.pressure_pa > 0.0) == in_contact).map(|o| (quantity(o), 1.0));
        DiscreteDistribution::weighted(chosen).map_or(0.0, |distribution| distribution.std())
    };
    let (pressure_pa, gap_m) = (spread(true, |o| o.pressure_pa), spread(false, |o| o.gap_m));
    if pressure_pa > 0.0 && gap_m > 0.0 { pressure_pa / gap_m } else { 1.0 }
}

/// Samples that coarse models solve at once.
struct Round<'a> {
    problem: &'a Problem<'a>,
    samples: RoundSamples<'a>,
    /// Number of leading samples that each model solves, coarsest first.
    counts: Vec<usize>,
}

/// Samples of a round.
enum RoundSamples<'a> {
    /// Samples with a fine solution.
    Fine(&'a Samples),
    /// Samples of a design, with the rotation of their normal variables.
    Further(Design, RotatedVariables),
}

/// Results of one sample of a round.
#[derive(Serialize, Deserialize)]
struct CoarseBlock {
    /// Rotated normal variables; empty for samples with a fine solution.
    variables: Vec<f64>,
    /// Result of each model that solves the sample; `None` marks a failure.
    observations: Vec<Option<CellObservation>>,
}

impl Round<'_> {
    fn blocks(&self) -> usize {
        match &self.samples {
            RoundSamples::Fine(fine) => fine.len(),
            RoundSamples::Further(design, _) => design.samples(),
        }
    }

    fn solve(&self, index: usize, models: &[CoarseModel], workspaces: &mut [ContactWorkspace]) -> CoarseBlock {
        let (xi, rotation) = match &self.samples {
            RoundSamples::Fine(fine) => (fine.xi(index), None),
            RoundSamples::Further(design, rotation) => (design.xi(index), Some(rotation)),
        };
        let map = self.problem.surface().generate(&xi);
        let wanted = models.iter().zip(workspaces).zip(&self.counts).filter(|(_, count)| index < **count);
        let observations = wanted.map(|((model, workspace), _)| model.observe(self.problem, &map, workspace)).collect();
        CoarseBlock { variables: rotation.map_or_else(Vec::new, |rotation| rotation.apply(&xi)), observations }
    }

    /// Solves all samples.
    fn run(&self, models: &[CoarseModel], monitor: &dyn Monitor) -> Result<Vec<CoarseBlock>, Cancelled> {
        let task = Task::new(monitor, "pressure/coarse", self.blocks());
        let workspaces = || models.iter().map(CoarseModel::workspace).collect::<Vec<_>>();
        let coarse = Loop {
            count: self.blocks(),
            block_bytes: size_of::<CoarseBlock>(),
            steps: 1,
            failure: |block: &CoarseBlock| {
                let fails = block.observations.iter().any(Option::is_none);
                fails.then(|| "a coarser grid has no solution".to_owned())
            },
        };
        let solve = |workspaces: &mut Vec<_>, index| task.step(|| self.solve(index, models, workspaces));
        let mut found = Vec::with_capacity(coarse.count);
        task.reduce(&coarse, workspaces, solve, |_, block| found.push(block)).map(|()| found)
    }
}

/// Contact solutions on the fine grid and on coarser ones.
#[derive(Debug)]
pub struct NestedSamples {
    /// Models used, coarsest first.
    models: Vec<CoarseModel>,
    /// Results of each model for its leading samples.
    coarse: Vec<Vec<CellObservation>>,
    fine: Vec<CellObservation>,
    /// Standard normal variables of all samples.
    xi: Vec<Vec<f64>>,
}

/// Number and cost of the solutions of one coarse model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CoarseSolves {
    /// Rows and columns of its grid. The fine grid itself may be listed, solved to a looser tolerance.
    pub shape: (usize, usize),
    /// Number of solutions.
    pub solves: usize,
    /// Work of the solutions divided by the work of one fine solution, from their iterations.
    pub work_in_fine_solves: f64,
}

impl NestedSamples {
    /// Solves the samples of `fine` on the coarse models as well, and plans and computes further coarse solutions.
    ///
    /// Every model receives samples in proportion to √(V/w), where V is the variance that it removes and w its work per
    /// sample, until all coarse models together add little to the variance of the fine samples or the work limit is
    /// reached.
    ///
    /// # Errors
    /// The design cannot be created, the estimator fails ([`PressureError::Method`]), or the monitor cancels.
    pub(super) fn solve(
        problem: &Problem<'_>,
        fine: &Samples,
        seed: u64,
        monitor: &dyn Monitor,
    ) -> Result<Self, PressureError> {
        let models = CoarseModel::all(problem);
        let pilot = Round { problem, samples: RoundSamples::Fine(fine), counts: vec![fine.len(); models.len()] };
        let blocks = pilot.run(&models, monitor)?;
        let (mut samples, rotation) = Self::from_pilot(problem, fine, models, blocks)?;
        if let Some(round) = samples.plan(problem, rotation, seed)? {
            let blocks = round.run(&samples.models, monitor)?;
            samples.add(blocks);
        }
        Ok(samples)
    }

    /// Creates the samples from the first round, with the rotation of their normal variables.
    ///
    /// A model that fails on many samples (for instance if its few points have equal heights) is dropped; so is a sample
    /// on which one of the other models fails.
    fn from_pilot(
        problem: &Problem<'_>,
        fine: &Samples,
        mut models: Vec<CoarseModel>,
        blocks: Vec<CoarseBlock>,
    ) -> Result<(Self, RotatedVariables), MethodError> {
        let had = |l: usize| blocks.iter().filter(|block| block.observations[l].is_some()).count() as f64;
        let serves: Vec<bool> = (0..models.len()).map(|l| had(l) >= LEAST_HAD * fine.len() as f64).collect();
        retain(&mut models, &serves);
        let mut coarse = vec![Vec::new(); models.len()];
        let mut kept = Vec::new();
        for (position, mut block) in blocks.into_iter().enumerate() {
            retain(&mut block.observations, &serves);
            if push(&mut coarse, block.observations) {
                kept.push(position);
            }
        }
        if kept.len() < multilevel::LEAST_SAMPLES {
            return Err(MethodError::TooFewSamples { samples: kept.len(), wanted: multilevel::LEAST_SAMPLES });
        }
        let fine_observations: Vec<CellObservation> = kept.iter().map(|i| fine.observations()[*i]).collect();
        let values = Quantity::Pressure.values(&fine_observations, kappa_pa_per_m(&fine_observations));
        let (rotation, xi) =
            RotatedVariables::new(problem, MOST_VARIABLES, DEGREE, |sample| fine.xi(kept[sample]), &values)?;
        Ok((Self { models, coarse, fine: fine_observations, xi }, rotation))
    }

    /// Keeps the models that are worth their work and plans the second round; `None` if further samples are not worth
    /// it.
    fn plan<'a>(
        &mut self,
        problem: &'a Problem<'a>,
        rotation: RotatedVariables,
        seed: u64,
    ) -> Result<Option<Round<'a>>, PressureError> {
        let plan = self.allocation(problem, seed)?;
        let used: Vec<bool> = (0..self.models.len()).map(|l| plan.iter().any(|(own, _)| *own == l)).collect();
        retain(&mut self.models, &used);
        retain(&mut self.coarse, &used);
        let counts: Vec<usize> = plan.into_iter().map(|(_, more)| more).collect();
        let Some(more) = counts.iter().copied().max().filter(|more| *more > 0) else { return Ok(None) };
        let xi_len = problem.surface().xi_len();
        let design = Design::new(SamplingMethod::MonteCarlo, seed, "pressure/more", more, xi_len)?;
        Ok(Some(Round { problem, samples: RoundSamples::Further(design, rotation), counts }))
    }

    /// Returns the models to use with their numbers of further samples.
    fn allocation(&self, problem: &Problem<'_>, seed: u64) -> Result<Vec<(usize, usize)>, MethodError> {
        let fine_work = mean_work(problem.half_space().grid().shape(), &self.fine);
        let generation = generation_work(problem.half_space().grid().shape());
        let works: Vec<f64> = self
            .models
            .iter()
            .zip(&self.coarse)
            .map(|(model, observations)| generation + mean_work(model.shape(), observations))
            .collect();
        let pilot = self.fine.len().min(PILOT);
        let mut best = (f64::INFINITY, Vec::new());
        for subset in 0..1_usize << self.models.len() {
            let used: Vec<usize> = (0..self.models.len()).filter(|l| subset >> l & 1 == 1).collect();
            let nested = self.nested(Quantity::Pressure, &used, |_| pilot);
            let variances = multilevel::bracket_variances(&nested, &self.settings(Quantity::Pressure, problem, seed))?;
            // The fine model first, then the used models from the finest down.
            let costs: Vec<f64> = std::iter::once(fine_work).chain(used.iter().rev().map(|l| works[*l])).collect();
            let counts = allocate(&variances, &costs, self.fine.len());
            let n = self.fine.len() as f64;
            let samples = std::iter::once(n).chain(counts.iter().map(|more| n + *more as f64));
            let variance: f64 = variances.iter().zip(samples).map(|(v, count)| v / count).sum();
            if variance < best.0 {
                best = (variance, used.into_iter().zip(counts.into_iter().rev()).collect());
            }
        }
        Ok(best.1)
    }

    /// Adds the second round. If a sample is left out, the samples of finer models remain the leading ones.
    fn add(&mut self, blocks: Vec<CoarseBlock>) {
        for CoarseBlock { variables, observations } in blocks {
            if push(&mut self.coarse, observations) {
                self.xi.push(variables);
            }
        }
    }

    /// Estimates the distribution of a quantity from all models.
    pub(super) fn estimate(
        &self,
        quantity: Quantity,
        problem: &Problem<'_>,
        seed: u64,
    ) -> Result<MultilevelEstimate, MethodError> {
        self.estimate_with(quantity, self.models.len(), self.settings(quantity, problem, seed))
    }

    /// Estimates the distribution of the pressure with all coarse models or none.
    ///
    /// `fitted` selects prediction by polynomials. Otherwise the results of a model replace those of the next finer
    /// one.
    ///
    /// # Errors
    /// There are too few samples, or a fit fails.
    pub fn estimate_pressure(
        &self,
        problem: &Problem<'_>,
        seed: u64,
        coarse: bool,
        fitted: bool,
    ) -> Result<PressureEstimate, MethodError> {
        let settings = Settings { fitted, ..self.settings(Quantity::Pressure, problem, seed) };
        let models = if coarse { self.models.len() } else { 0 };
        let largest_pa = settings.largest;
        Ok(PressureEstimate::from_multilevel(self.estimate_with(Quantity::Pressure, models, settings)?, largest_pa))
    }

    fn estimate_with(
        &self,
        quantity: Quantity,
        models: usize,
        settings: Settings,
    ) -> Result<MultilevelEstimate, MethodError> {
        let used: Vec<usize> = (0..models).collect();
        let nested = self.nested(quantity, &used, |count| count);
        // Not finite: the stiffness if it was not computed, or that of complete contact without mean compliance.
        if let Some((index, value)) =
            nested.values.iter().flat_map(|values| values.iter().copied().enumerate()).find(|(_, q)| !q.is_finite())
        {
            return Err(DiscreteDistributionError::Value { index, value, weight: 1.0 }.into());
        }
        multilevel::estimate(&nested, &settings)
    }

    /// Returns the numbers of solutions of each coarse model, coarsest first.
    pub(super) fn coarse_solves(&self, problem: &Problem<'_>) -> Vec<CoarseSolves> {
        let fine = mean_work(problem.half_space().grid().shape(), &self.fine);
        let count = |(model, observations): (&CoarseModel, &Vec<CellObservation>)| {
            let work_in_fine_solves = observations.len() as f64 * mean_work(model.shape(), observations) / fine;
            CoarseSolves { shape: model.shape(), solves: observations.len(), work_in_fine_solves }
        };
        self.models.iter().zip(&self.coarse).map(count).collect()
    }

    fn settings(&self, quantity: Quantity, problem: &Problem<'_>, seed: u64) -> Settings {
        let [least, largest] = quantity.bounds(problem);
        Settings { seed, degree: DEGREE, fitted: true, least, largest }
    }

    /// Returns the values of a quantity on the used models and the fine one; `kept` limits the number of leading
    /// samples.
    fn nested(&self, quantity: Quantity, used: &[usize], kept: impl Fn(usize) -> usize) -> LevelSamples {
        let kappa = kappa_pa_per_m(&self.fine);
        let values = |observations: &[CellObservation]| -> Vec<f64> {
            quantity.values(&observations[..kept(observations.len())], kappa)
        };
        let mut models: Vec<Vec<f64>> = used.iter().map(|l| values(&self.coarse[*l])).collect();
        models.push(values(&self.fine));
        let most = models.iter().map(Vec::len).max().unwrap_or(0);
        let covariates = |l: &usize| {
            let observations = &self.coarse[*l];
            observations[..kept(observations.len())].iter().map(|o| quantity.covariates(o, kappa)).collect()
        };
        LevelSamples { xi: self.xi[..most].to_vec(), covariates: used.iter().map(covariates).collect(), values: models }
    }
}

/// Returns the number of samples beyond the `fine` ones for each model but the first, from the variances per sample and
/// the work of all models.
///
/// The variance at given work is minimal for samples in proportion to √(V/w). As the number of fine samples is given,
/// further coarse samples are added until all coarse models together contribute little.
fn allocate(variances: &[f64], works: &[f64], fine: usize) -> Vec<usize> {
    let n = fine as f64;
    let least = |l: usize| (variances[l] * works[0] / (variances[0] * works[l])).sqrt();
    let mut counts = vec![0; variances.len() - 1];
    let mut scale = 1.0;
    loop {
        let mut wanted: Vec<f64> = (1..variances.len()).map(|l| n * (scale * least(l)).max(1.0)).collect();
        // Models are nested: a coarser model has at least as many samples.
        for l in 1..wanted.len() {
            wanted[l] = wanted[l].max(wanted[l - 1]);
        }
        let work: f64 = wanted.iter().zip(&works[1..]).map(|(count, work)| (count - n) * work).sum();
        if work.is_nan() || work > COARSE_FRACTION * n * works[0] {
            return counts;
        }
        counts = wanted.iter().map(|count| (count - n) as usize).collect();
        let added: f64 = wanted.iter().zip(&variances[1..]).map(|(count, v)| v / count).sum();
        if added.is_nan() || added <= ADDED_VARIANCE * variances[0] / n {
            return counts;
        }
        scale *= SCALE_STEP;
    }
}

fn mean_work(shape: (usize, usize), observations: &[CellObservation]) -> f64 {
    let iterations = observations.iter().map(|o| o.iterations as f64).sum::<f64>() / observations.len().max(1) as f64;
    solution_work(shape, iterations)
}

/// Keeps the marked items.
fn retain<T>(items: &mut Vec<T>, marked: &[bool]) {
    let mut marks = marked.iter();
    items.retain(|_| marks.next() == Some(&true));
}

/// Adds one observation to each of the leading columns; returns false if one of them is missing.
fn push(columns: &mut [Vec<CellObservation>], observations: Vec<Option<CellObservation>>) -> bool {
    let Some(row) = observations.into_iter().collect::<Option<Vec<CellObservation>>>() else { return false };
    columns.iter_mut().zip(row).for_each(|(column, observation)| column.push(observation));
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn further_samples_follow_variance_over_work_and_are_nested() {
        let counts = allocate(&[1.0, 0.5, 0.9], &[1.0, 0.1, 0.1], 100);
        let ratio = (counts[1] + 100) as f64 / (counts[0] + 100) as f64;
        assert!((ratio / (0.9_f64 / 0.5).sqrt() - 1.0).abs() < 0.02, "{counts:?}");
        // Just enough that both together add little.
        let added = 0.5 / (counts[0] + 100) as f64 + 0.9 / (counts[1] + 100) as f64;
        assert!(added <= ADDED_VARIANCE / 100.0 && added * SCALE_STEP >= 0.99 * ADDED_VARIANCE / 100.0, "{counts:?}");
        // A coarser model has at least as many samples as a finer one.
        let counts = allocate(&[1.0, 0.25, 0.01], &[1.0, 1e-4, 1e-4], 100);
        assert!(counts[1] >= counts[0] && counts[0] > 0, "{counts:?}");
        // Coarse models of large variance take four times the work of the fine one at most.
        let [more] = allocate(&[1.0, 20.0], &[1.0, 0.5], 100)[..] else { panic!("one count") };
        let work = |count: f64| (count - 100.0) * 0.5 / 100.0;
        let count = (more + 100) as f64;
        assert!(work(count) <= COARSE_FRACTION && work(SCALE_STEP * count) > 0.99 * COARSE_FRACTION, "{more}");
        // Expensive models have none.
        assert_eq!(allocate(&[1.0, 0.5], &[1.0, 1000.0], 100), [0]);
    }

    #[test]
    fn kappa_is_the_ratio_of_the_spreads_in_and_out_of_contact() {
        let observation = |pressure_pa: f64, gap_m: f64| CellObservation {
            pressure_pa,
            gap_m,
            plastic_displacement_m: 0.0,
            beside: [0.0; 3],
            separation_m: 0.0,
            contact_fraction: 0.5,
            mean_pressure_pa: 1.0,
            mean_gap_m: 1.0,
            stiffness_pa_per_m: None,
            iterations: 1,
        };
        let contact = [observation(1e6, 0.0), observation(3e6, 0.0)];
        let both = [contact[0], observation(0.0, 2e-6), contact[1], observation(0.0, 6e-6)];
        assert!((kappa_pa_per_m(&both) / 0.5e12 - 1.0).abs() < 1e-12);
        // One unit where a spread is zero.
        assert_eq!(kappa_pa_per_m(&contact), 1.0);
        assert_eq!(kappa_pa_per_m(&both[..2]), 1.0);
        assert_eq!(kappa_pa_per_m(&both[1..2]), 1.0);
    }
}
