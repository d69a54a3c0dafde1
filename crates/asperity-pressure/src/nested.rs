//! Samples of a pressure on several models: many on coarse ones, few on the fine one.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

use crate::coarse::{CoarseModel, generation_work, solution_work};
use crate::multilevel::{self, LevelSamples, MultilevelEstimate, Settings};
use crate::rotated_variables::RotatedVariables;
use crate::{Estimate, MethodError, Observation, PressureError, Problem, Samples, stiffness};
use asperity_base::monitor::{Cancelled, Monitor};
use asperity_chaos::{Design, DiscreteDistribution, DiscreteDistributionError, SamplingMethod};

/// Least fraction of the fine samples that a coarse model has to have.
const LEAST_HAD: f64 = 0.95;
/// Samples on which it is seen what a coarse model is worth.
const PILOT: usize = 250;
/// CoarseModel solutions beyond the fine samples may cost so many times the fine ones,
const COARSE_FRACTION: f64 = 4.0;
/// and are made until they add no more than this share to the variance; their number is raised in steps of this factor.
const ADDED_VARIANCE: f64 = 1.0 / 3.0;
const SCALE_STEP: f64 = 1.1;
/// Degree of the polynomials by which a model predicts the next.
const DEGREE: usize = 3;
/// Maximum number of variables of the rotated ξ.
const MOST_VARIABLES: usize = 3;

/// A scalar that each contact has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Pressure of the problem's cell in pascal; 0 out of contact.
    Pressure,
    /// Share A_c/A of the cells in contact.
    ContactFraction,
    /// Load over the nominal area in pascal.
    MeanPressure,
    /// Mean gap in metre.
    MeanGap,
    /// Rise of the mean pressure as the plane comes down in Pa/m ([`Problem::with_stiffness`]); 0 without contact.
    Stiffness,
}

impl Quantity {
    /// All of them.
    pub const ALL: [Self; 5] =
        [Self::Pressure, Self::ContactFraction, Self::MeanPressure, Self::MeanGap, Self::Stiffness];

    /// Returns the value, continued beyond its bounds where that is known: out of contact the pressure says nothing about how far from
    /// contact the cell is, the gap does; at the hardness it says nothing about how far the cell yields, the plastic displacement
    /// does. `kappa` is the pressure that such a metre counts as.
    fn latent(self, observation: &Observation, kappa: f64) -> f64 {
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

    /// What else of a coarse solution tells about the value on a finer grid: of the pressure, that beside the cell.
    fn beside(self, observation: &Observation, kappa: f64) -> Vec<f64> {
        let [pressure_pa, gap_m, plastic_displacement_m] = observation.beside;
        match self {
            Self::Pressure => vec![pressure_pa + kappa * (plastic_displacement_m - gap_m)],
            _ => Vec::new(),
        }
    }

    /// Bounds of the value.
    pub(super) fn bounds(self, problem: &Problem<'_>) -> [f64; 2] {
        match self {
            Self::Pressure | Self::MeanPressure => [0.0, problem.hardness_pa().unwrap_or(f64::INFINITY)],
            Self::ContactFraction => [0.0, 1.0],
            Self::MeanGap => [0.0, f64::INFINITY],
            Self::Stiffness => [0.0, stiffness::largest_pa_per_m(problem.half_space())],
        }
    }
}

/// Returns the ratio of the spreads of the pressures in contact and of the gaps out of it; 1 where one of them has none.
pub(super) fn kappa_pa_per_m(observations: &[Observation]) -> f64 {
    let spread = |in_contact: bool, quantity: fn(&Observation) -> f64| {
        let chosen = observations.iter().filter(|o| (o.pressure_pa > 0.0) == in_contact).map(|o| (quantity(o), 1.0));
        DiscreteDistribution::weighted(chosen).map_or(0.0, |distribution| distribution.std())
    };
    let (pressure_pa, gap_m) = (spread(true, |o| o.pressure_pa), spread(false, |o| o.gap_m));
    if pressure_pa > 0.0 && gap_m > 0.0 { pressure_pa / gap_m } else { 1.0 }
}

/// Contact solutions on the fine grid and on coarser ones.
#[derive(Debug)]
pub struct NestedSamples {
    /// Models used, the coarsest first.
    models: Vec<CoarseModel>,
    /// What they say of the leading samples, each.
    coarse: Vec<Vec<Observation>>,
    fine: Vec<Observation>,
    /// Standard normal variables of all samples.
    normal: Vec<Vec<f64>>,
}

/// Solutions of one coarse model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CoarseSolves {
    /// Rows and columns of its grid; that of the fine one is solved to a loose tolerance.
    pub shape: (usize, usize),
    /// Number of solutions.
    pub solves: usize,
    /// Their work over that of one fine solution, by their iterations.
    pub work_in_fine_solves: f64,
}

impl NestedSamples {
    /// Solves the samples of ξ of `fine` on the coarse models too, sees what these are worth for the pressure, and solves as many more
    /// on them as pays: every model gets samples in proportion to √(V/w), with the variance V that it takes away and its work w per
    /// sample, until together they add little to the variance of the fine samples or the work is spent.
    ///
    /// # Errors
    /// The design cannot be made, or the monitor cancels.
    pub(super) fn solve(
        problem: &Problem<'_>,
        fine: &Samples,
        seed: u64,
        monitor: &dyn Monitor,
    ) -> Result<Result<Self, MethodError>, PressureError> {
        let mut models = CoarseModel::all(problem);
        let xi_samples: Vec<Vec<f64>> = (0..fine.len()).map(|i| fine.xi(i)).collect();
        let mut solved = observe(problem, &models, &xi_samples, "pressure/coarse", monitor)?;
        // A model that many samples cannot have, as where its few points are all of one height, is none; and a sample is left out that
        // one of the others cannot have.
        let had = |l: usize| solved.iter().filter(|row| row[l].is_some()).count() as f64;
        let serves: Vec<bool> = (0..models.len()).map(|l| had(l) >= LEAST_HAD * fine.len() as f64).collect();
        retain(&mut models, &serves);
        solved.iter_mut().for_each(|row| retain(row, &serves));
        let rows: Vec<Option<Vec<Observation>>> = solved.into_iter().map(|row| row.into_iter().collect()).collect();
        let kept: Vec<usize> = (0..fine.len()).filter(|i| rows[*i].is_some()).collect();
        if kept.len() < multilevel::LEAST_SAMPLES {
            let (samples, wanted) = (kept.len(), multilevel::LEAST_SAMPLES);
            return Ok(Err(MethodError::TooFewSamples { samples, wanted }));
        }
        let observations: Vec<Observation> = kept.iter().map(|i| fine.observations()[*i]).collect();
        let xi_samples: Vec<Vec<f64>> = kept.iter().map(|i| xi_samples[*i].clone()).collect();
        let coarse = columns(rows.into_iter().flatten(), models.len());
        let kappa = kappa_pa_per_m(&observations);
        let values: Vec<f64> = observations.iter().map(|o| Quantity::Pressure.latent(o, kappa)).collect();
        let rotation = match RotatedVariables::new(problem, MOST_VARIABLES, DEGREE, &xi_samples, &values) {
            Ok(rotation) => rotation,
            Err(error) => return Ok(Err(error)),
        };
        let mut samples = Self {
            models,
            coarse,
            normal: xi_samples.iter().map(|xi| rotation.apply(xi)).collect(),
            fine: observations,
        };
        let plan = match samples.plan(problem, seed) {
            Ok(plan) => plan,
            Err(error) => return Ok(Err(error)),
        };
        samples.keep(&plan);
        let more = plan.iter().map(|(_, more)| *more).max().unwrap_or(0);
        if more > 0 {
            let design =
                Design::new(SamplingMethod::MonteCarlo, seed, "pressure/more", more, problem.surface().xi_len())?;
            let counts: Vec<usize> = plan.iter().map(|(_, more)| *more).collect();
            samples.add(problem, &design, &counts, &rotation, monitor)?;
        }
        Ok(Ok(samples))
    }

    /// Which models to use, and on how many samples more.
    fn plan(&self, problem: &Problem<'_>, seed: u64) -> Result<Vec<(usize, usize)>, MethodError> {
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
            // Of the fine model first, then of those used from the finest down.
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

    /// Keeps the models of the plan.
    fn keep(&mut self, plan: &[(usize, usize)]) {
        let used: Vec<bool> = (0..self.models.len()).map(|l| plan.iter().any(|(own, _)| *own == l)).collect();
        retain(&mut self.models, &used);
        retain(&mut self.coarse, &used);
    }

    /// Solves the leading `counts` samples of ξ of a design on the models.
    fn add(
        &mut self,
        problem: &Problem<'_>,
        design: &Design,
        counts: &[usize],
        rotation: &RotatedVariables,
        monitor: &dyn Monitor,
    ) -> Result<(), Cancelled> {
        let done = AtomicUsize::new(0);
        type Row = (Vec<f64>, Vec<Observation>);
        let rows: Vec<Option<Row>> = (0..design.samples())
            .into_par_iter()
            .map_init(
                || self.models.iter().map(CoarseModel::workspace).collect::<Vec<_>>(),
                |workspaces, index| {
                    if monitor.cancelled() {
                        return Err(Cancelled);
                    }
                    let xi = design.xi(index);
                    let map = problem.surface().generate(&xi);
                    let wanted = self.models.iter().zip(workspaces).zip(counts).filter(|(_, count)| index < **count);
                    let said = wanted.map(|((model, workspace), _)| model.observe(problem, &map, workspace)).collect();
                    monitor.progress("pressure/coarse", done.fetch_add(1, Ordering::Relaxed) + 1, design.samples());
                    Ok(Option::<Vec<Observation>>::map(said, |said| (rotation.apply(&xi), said)))
                },
            )
            .collect::<Result<_, Cancelled>>()?;
        // Where one was left out the samples of finer models remain the leading ones.
        for (normal, said) in rows.into_iter().flatten() {
            self.normal.push(normal);
            self.coarse.iter_mut().zip(said).for_each(|(column, observation)| column.push(observation));
        }
        Ok(())
    }

    /// Estimates the distribution of a quantity by all models.
    pub(super) fn estimate(
        &self,
        quantity: Quantity,
        problem: &Problem<'_>,
        seed: u64,
    ) -> Result<MultilevelEstimate, MethodError> {
        self.estimate_with(quantity, self.models.len(), self.settings(quantity, problem, seed))
    }

    /// Estimates the distribution of the pressure with all coarse models or none of them. `fitted` predicts by polynomials; otherwise
    /// the results of a model stand for those of the next finer one.
    ///
    /// # Errors
    /// There are too few samples, or a fit fails.
    pub fn estimate_pressure(
        &self,
        problem: &Problem<'_>,
        seed: u64,
        coarse: bool,
        fitted: bool,
    ) -> Result<Estimate, MethodError> {
        let settings = Settings { fitted, ..self.settings(Quantity::Pressure, problem, seed) };
        let models = if coarse { self.models.len() } else { 0 };
        let largest_pa = settings.largest;
        Ok(Estimate::from_multilevel(self.estimate_with(Quantity::Pressure, models, settings)?, largest_pa))
    }

    fn estimate_with(
        &self,
        quantity: Quantity,
        models: usize,
        settings: Settings,
    ) -> Result<MultilevelEstimate, MethodError> {
        let used: Vec<usize> = (0..models).collect();
        let nested = self.nested(quantity, &used, |count| count);
        // The stiffness where it was not asked for, and that of complete contact without mean compliance.
        if let Some((index, value)) =
            nested.models.iter().flat_map(|values| values.iter().copied().enumerate()).find(|(_, q)| !q.is_finite())
        {
            return Err(DiscreteDistributionError::Value { index, value, weight: 1.0 }.into());
        }
        multilevel::estimate(&nested, &settings)
    }

    /// Returns the solutions on each coarse model, the coarsest first.
    pub(super) fn coarse_solves(&self, problem: &Problem<'_>) -> Vec<CoarseSolves> {
        let fine = mean_work(problem.half_space().grid().shape(), &self.fine);
        let count = |(model, said): (&CoarseModel, &Vec<Observation>)| {
            let work_in_fine_solves = said.len() as f64 * mean_work(model.shape(), said) / fine;
            CoarseSolves { shape: model.shape(), solves: said.len(), work_in_fine_solves }
        };
        self.models.iter().zip(&self.coarse).map(count).collect()
    }

    fn settings(&self, quantity: Quantity, problem: &Problem<'_>, seed: u64) -> Settings {
        let [least, largest] = quantity.bounds(problem);
        Settings { seed, degree: DEGREE, fitted: true, least, largest }
    }

    /// Returns the values of a quantity on the used models and the fine one, of as many leading samples as `kept` says.
    fn nested(&self, quantity: Quantity, used: &[usize], kept: impl Fn(usize) -> usize) -> LevelSamples {
        let kappa = kappa_pa_per_m(&self.fine);
        let values = |observations: &[Observation]| -> Vec<f64> {
            observations[..kept(observations.len())].iter().map(|o| quantity.latent(o, kappa)).collect()
        };
        let mut models: Vec<Vec<f64>> = used.iter().map(|l| values(&self.coarse[*l])).collect();
        models.push(values(&self.fine));
        let most = models.iter().map(Vec::len).max().unwrap_or(0);
        let beside = |l: &usize| {
            let observations = &self.coarse[*l];
            observations[..kept(observations.len())].iter().map(|o| quantity.beside(o, kappa)).collect()
        };
        LevelSamples { normal: self.normal[..most].to_vec(), beside: used.iter().map(beside).collect(), models }
    }
}

/// Returns the samples beyond the `fine` ones of each model but the first, from the variances per sample and the work of all.
///
/// Least variance at given work asks for samples in proportion to √(V/w); with the number of fine samples given, more than that
/// still pay until all coarse models together add little.
fn allocate(variances: &[f64], works: &[f64], fine: usize) -> Vec<usize> {
    let n = fine as f64;
    let least = |l: usize| (variances[l] * works[0] / (variances[0] * works[l])).sqrt();
    let mut counts = vec![0; variances.len() - 1];
    let mut scale = 1.0;
    loop {
        let mut wanted: Vec<f64> = (1..variances.len()).map(|l| n * (scale * least(l)).max(1.0)).collect();
        // Models are nested: a coarser one has no fewer samples.
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

fn mean_work(shape: (usize, usize), observations: &[Observation]) -> f64 {
    let iterations = observations.iter().map(|o| o.iterations as f64).sum::<f64>() / observations.len().max(1) as f64;
    solution_work(shape, iterations)
}

/// What every model says of each ξ; `None` where it cannot.
fn observe(
    problem: &Problem<'_>,
    models: &[CoarseModel],
    xi_samples: &[Vec<f64>],
    stage: &str,
    monitor: &dyn Monitor,
) -> Result<Vec<Vec<Option<Observation>>>, Cancelled> {
    let done = AtomicUsize::new(0);
    xi_samples
        .par_iter()
        .map_init(
            || models.iter().map(CoarseModel::workspace).collect::<Vec<_>>(),
            |workspaces, xi| {
                if monitor.cancelled() {
                    return Err(Cancelled);
                }
                let map = problem.surface().generate(xi);
                let said =
                    models.iter().zip(workspaces).map(|(model, workspace)| model.observe(problem, &map, workspace));
                let said = said.collect();
                monitor.progress(stage, done.fetch_add(1, Ordering::Relaxed) + 1, xi_samples.len());
                Ok(said)
            },
        )
        .collect()
}

/// Keeps the items that are marked.
fn retain<T>(items: &mut Vec<T>, marked: &[bool]) {
    let mut marks = marked.iter();
    items.retain(|_| marks.next() == Some(&true));
}

/// Returns the rows as columns.
fn columns(rows: impl Iterator<Item = Vec<Observation>>, count: usize) -> Vec<Vec<Observation>> {
    let mut columns = vec![Vec::new(); count];
    for row in rows {
        columns.iter_mut().zip(row).for_each(|(column, observation)| column.push(observation));
    }
    columns
}
