//! Contact solutions on a design of samples ξ.

use serde::{Deserialize, Serialize};

use crate::field_samples::{Field, FieldSamples};
use crate::{CellObservation, FailureReason, PressureError, Problem};
use asperity_base::blocks::{Loop, Task};
use asperity_base::monitor::Monitor;
use asperity_chaos::{Design, DiscreteDistribution, SamplingMethod};
use asperity_contact::ContactWorkspace;

/// Sample without a solution.
#[derive(Debug, Clone, PartialEq)]
pub struct Failure {
    /// Index of the sample in its design.
    pub index: usize,
    /// Reason of the failure.
    pub reason: String,
}

/// Settings of a sampled run.
#[derive(Debug, Clone, Copy)]
pub struct Sampling<'a> {
    /// Placement of the samples ξ.
    pub method: SamplingMethod,
    /// Number of independent randomisations among which the samples are divided.
    pub replicates: usize,
    /// Seed. Runs with another stage are independent.
    pub seed: u64,
    /// Name of the run.
    pub stage: &'a str,
    /// Number of samples, rounded up to a multiple of the replicates.
    pub samples: usize,
    /// Stride along either side of the cells whose pressures are kept in addition to the problem's cell.
    pub site_stride: Option<usize>,
    /// Memory limit in bytes for whole pressure fields of the leading samples; every cell's sum over all samples is
    /// kept as well. `None` keeps neither.
    pub field_bytes: Option<usize>,
    /// Smallest fraction (0 to 1) of the contact problems that must be solved.
    pub valid_fraction: f64,
}

impl<'a> Sampling<'a> {
    /// Creates the settings for independent samples.
    pub fn monte_carlo(seed: u64, stage: &'a str, samples: usize, valid_fraction: f64) -> Self {
        Self {
            method: SamplingMethod::MonteCarlo,
            replicates: 1,
            seed,
            stage,
            samples,
            site_stride: None,
            field_bytes: None,
            valid_fraction,
        }
    }
}

/// Contact problems of a sampled run.
struct SamplePlan<'a> {
    problem: &'a Problem<'a>,
    sampling: Sampling<'a>,
    /// One design for each replicate, equally large.
    designs: Vec<Design>,
    /// Number of leading samples whose whole fields are kept.
    kept_fields: usize,
}

/// Results of one solved sample.
#[derive(Serialize, Deserialize)]
struct SampleBlock {
    observation: CellObservation,
    /// Pressures of the sites in pascal.
    sites: Vec<f32>,
    field: Option<Field>,
}

impl<'a> SamplePlan<'a> {
    fn new(problem: &'a Problem<'a>, sampling: Sampling<'a>) -> Result<Self, PressureError> {
        let Sampling { method, replicates, seed, stage, samples, field_bytes, .. } = sampling;
        let each = samples.div_ceil(replicates.max(1));
        let design = Design::new(method, seed, stage, each, problem.surface().xi_len())?;
        let designs = (0..replicates.max(1)).map(|number| design.replicate(number)).collect::<Result<Vec<_>, _>>()?;
        let points = problem.half_space().grid().points();
        let kept_fields = field_bytes.map_or(0, |bytes| bytes / (size_of::<f32>() * points));
        Ok(Self { problem, sampling, designs, kept_fields })
    }

    fn solve(&self, index: usize, workspace: &mut ContactWorkspace) -> Result<SampleBlock, FailureReason> {
        let Sampling { site_stride, field_bytes, .. } = self.sampling;
        let solution = self.problem.solve(&xi(&self.designs, index), workspace)?;
        let observation = self.problem.observation(&solution, workspace)?;
        let is_site = |row: usize, column: usize| {
            site_stride.is_some_and(|stride| row.is_multiple_of(stride) && column.is_multiple_of(stride))
        };
        let sites = solution.pressure_pa().indexed_iter().filter(|((row, column), _)| is_site(*row, *column));
        let sites = sites.map(|(_, p)| *p as f32).collect();
        let field = field_bytes.map(|_| Field::new(&solution, index < self.kept_fields));
        Ok(SampleBlock { observation, sites, field })
    }
}

/// Returns the leading `variables` normal variables ξ of a sample of several designs.
fn leading_xi(designs: &[Design], index: usize, variables: usize) -> Vec<f64> {
    let each = designs[0].samples();
    designs[index / each].leading_xi(index % each, variables)
}

/// Returns the normal variables ξ of a sample of several designs.
fn xi(designs: &[Design], index: usize) -> Vec<f64> {
    leading_xi(designs, index, designs[0].dimensions())
}

/// Pressures of a design of samples in index order, and the failed samples.
#[derive(Debug, Clone)]
pub struct Samples {
    /// One design for each replicate, equally large.
    designs: Vec<Design>,
    /// Indices of the solved samples.
    indices: Vec<usize>,
    observations: Vec<CellObservation>,
    /// Pressures of the sites in pascal for each solved sample.
    sites: Vec<Vec<f32>>,
    fields: Option<FieldSamples>,
    failures: Vec<Failure>,
}

/// Solves the contact problems in parallel. The result does not depend on the number of threads.
///
/// # Errors
/// The design cannot be created, too few problems were solved, or the monitor cancelled.
pub fn solve(problem: &Problem<'_>, sampling: Sampling<'_>, monitor: &dyn Monitor) -> Result<Samples, PressureError> {
    let plan = SamplePlan::new(problem, sampling)?;
    let half_space = problem.half_space();
    let mut solved = Samples {
        designs: plan.designs.clone(),
        indices: Vec::new(),
        observations: Vec::new(),
        sites: Vec::new(),
        fields: sampling.field_bytes.map(|_| FieldSamples::new(half_space)),
        failures: Vec::new(),
    };
    let samples = solved.posed();
    let task = Task::new(monitor, sampling.stage, samples);
    let block_bytes = sampling.field_bytes.map_or(0, |_| Field::POINT_BYTES * half_space.grid().points());
    let block = |workspace: &mut ContactWorkspace, index| {
        task.step(|| plan.solve(index, workspace).map_err(|reason| reason.to_string()))
    };
    let blocks = Loop {
        count: samples,
        block_bytes,
        steps: 1,
        failure: |block: &Result<_, String>| block.as_ref().err().cloned(),
    };
    task.reduce(&blocks, || half_space.workspace(), block, |index, block| solved.add(index, block))?;
    match solved.failures.first() {
        Some(first)
            if (solved.len() as f64) < sampling.valid_fraction * samples as f64 || solved.indices.is_empty() =>
        {
            Err(PressureError::TooFewValid {
                stage: sampling.stage.to_owned(),
                valid: solved.len(),
                samples,
                wanted_percent: 100.0 * sampling.valid_fraction,
                first_index: first.index,
                first_reason: first.reason.clone(),
            })
        }
        _ => Ok(solved),
    }
}

impl Samples {
    fn add(&mut self, index: usize, block: Result<SampleBlock, String>) {
        match block {
            Ok(SampleBlock { observation, sites, field }) => {
                self.indices.push(index);
                self.observations.push(observation);
                self.sites.push(sites);
                if let (Some(fields), Some(field)) = (&mut self.fields, field) {
                    fields.add(field);
                }
            }
            Err(reason) => self.failures.push(Failure { index, reason }),
        }
    }

    /// Returns the number of solved samples.
    pub fn len(&self) -> usize {
        self.indices.len()
    }

    /// Returns false: [`solve`] refuses runs without a solved sample.
    pub fn is_empty(&self) -> bool {
        self.indices.is_empty()
    }

    /// Returns the number of contact problems including failed ones.
    pub fn posed(&self) -> usize {
        self.designs.iter().map(Design::samples).sum()
    }

    /// Returns the results of the solutions in index order.
    pub fn observations(&self) -> &[CellObservation] {
        &self.observations
    }

    /// Returns the failed samples in index order.
    pub fn failures(&self) -> &[Failure] {
        &self.failures
    }

    /// Returns the normal variables ξ of the solved sample number `position`.
    pub fn xi(&self, position: usize) -> Vec<f64> {
        xi(&self.designs, self.indices[position])
    }

    /// Returns the leading `variables` entries of ξ of every solved sample.
    pub fn leading_xi(&self, variables: usize) -> Vec<Vec<f64>> {
        self.indices.iter().map(|index| leading_xi(&self.designs, *index, variables)).collect()
    }

    /// Returns the number of independent randomisations.
    pub fn replicates(&self) -> usize {
        self.designs.len()
    }

    /// Returns the randomisation of the solved sample number `position`.
    pub(super) fn replicate_of(&self, position: usize) -> usize {
        self.indices[position] / self.designs[0].samples()
    }

    /// Returns the kept pressures of the sites in pascal for each solved sample.
    pub fn sites(&self) -> &[Vec<f32>] {
        &self.sites
    }

    /// Returns the fields if they were requested.
    pub(super) fn fields(&self) -> Option<&FieldSamples> {
        self.fields.as_ref()
    }

    /// Returns the samples without fields.
    pub(super) fn without_fields(self) -> Self {
        Self { fields: None, ..self }
    }

    /// Returns the pressures of the solved samples in pascal.
    pub(super) fn pressures_pa(&self) -> Vec<f64> {
        self.observations.iter().map(|o| o.pressure_pa).collect()
    }

    /// Returns the number K of samples in contact.
    pub fn in_contact(&self) -> usize {
        self.observations.iter().filter(|o| o.pressure_pa > 0.0).count()
    }

    /// Returns K/K_t, the fraction of samples in contact.
    pub fn contact_probability(&self) -> f64 {
        self.in_contact() as f64 / self.len() as f64
    }

    /// Returns the empirical distribution of the pressure in pascal.
    ///
    /// # Errors
    /// A pressure is not finite.
    pub fn distribution(&self) -> Result<DiscreteDistribution, PressureError> {
        Ok(DiscreteDistribution::empirical(&self.pressures_pa())?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::gaussian_surface;
    use asperity_base::map::{Grid, HeightMap};
    use asperity_base::monitor::Silent;
    use asperity_contact::{Boundary, ContactError, Control, HalfSpace};
    use asperity_surface::RandomSurface;
    use std::sync::atomic::{AtomicUsize, Ordering};

    /// Surface that is flat, and therefore refused by the contact solver, for ξ < `flat_below`.
    struct OftenFlat {
        grid: Grid,
        flat_below: f64,
    }

    impl RandomSurface for OftenFlat {
        fn xi_len(&self) -> usize {
            1
        }

        fn grid(&self) -> Grid {
            self.grid
        }

        fn generate(&self, xi: &[f64]) -> HeightMap {
            let amplitude = if xi[0] < self.flat_below { 0.0 } else { 1.0 };
            HeightMap::from_function(self.grid, |x, y| amplitude * (x + 2.0 * y).sin()).unwrap()
        }
    }

    fn solve_often_flat(flat_below: f64, valid_fraction: f64) -> Result<Samples, PressureError> {
        let surface = OftenFlat { grid: Grid::new(6, 6, 1.0, 1.0).unwrap(), flat_below };
        let half_space = HalfSpace::new(surface.grid, 1.0, Boundary::Free).unwrap();
        let problem = Problem::new(&surface, &half_space, Control::Plane { height_m: 0.5 }, None)?;
        let sampling = Sampling::monte_carlo(1, "often_flat", 40, valid_fraction);
        solve(&problem, Sampling { method: SamplingMethod::LatinHypercube, ..sampling }, &Silent)
    }

    #[test]
    fn failed_samples_are_recorded_with_index_and_reason() {
        // Φ(−1.6449) = 5 %: exactly two of forty strata.
        let samples = solve_often_flat(-1.644_853_627, 0.95).unwrap();
        assert_eq!((samples.len(), samples.posed(), samples.failures().len()), (38, 40, 2));
        for failure in samples.failures() {
            assert_eq!(failure.reason, ContactError::Flat.to_string());
            assert!((0..samples.len()).all(|i| samples.indices[i] != failure.index));
        }
        assert!((0..samples.len()).all(|i| samples.xi(i)[0] > -1.645));
    }

    #[test]
    fn fields_are_kept_on_request_and_can_be_dropped() {
        let surface = OftenFlat { grid: Grid::new(6, 6, 1.0, 1.0).unwrap(), flat_below: -9.0 };
        let half_space = HalfSpace::new(surface.grid, 1.0, Boundary::Free).unwrap();
        let problem = Problem::new(&surface, &half_space, Control::Plane { height_m: 0.5 }, None).unwrap();
        let sampling = Sampling { field_bytes: Some(1 << 10), ..Sampling::monte_carlo(1, "fields", 4, 1.0) };
        let samples = solve(&problem, sampling, &Silent).unwrap();
        let pressures_pa = samples.pressures_pa();
        assert!(samples.fields().is_some());
        let samples = samples.without_fields();
        assert!(samples.fields().is_none() && samples.pressures_pa() == pressures_pa);
    }

    #[test]
    fn statistics_of_too_few_valid_samples_are_refused() {
        let error = solve_often_flat(0.0, 0.95).unwrap_err();
        assert!(matches!(error, PressureError::TooFewValid { valid: 20, samples: 40, .. }), "{error}");
        assert!(error.to_string().contains("flat"));
        assert_eq!(solve_often_flat(0.0, 0.5).unwrap().len(), 20);
    }

    #[test]
    fn a_cancelled_run_returns_an_error_and_progress_reaches_the_total() {
        struct Watch {
            cancel: bool,
            most: AtomicUsize,
        }
        impl Monitor for Watch {
            fn progress(&self, what: &str, done: usize, total: usize) {
                assert_eq!((what, total), ("watched", 12));
                self.most.fetch_max(done, Ordering::Relaxed);
            }
            fn cancelled(&self) -> bool {
                self.cancel
            }
        }
        let (surface, half_space) = gaussian_surface(8, 4);
        let problem = Problem::new(&surface, &half_space, Control::Plane { height_m: 0.0 }, None).unwrap();
        let run = |watch: &Watch| solve(&problem, Sampling::monte_carlo(1, "watched", 12, 0.95), watch);
        let watch = Watch { cancel: false, most: AtomicUsize::new(0) };
        assert_eq!(run(&watch).unwrap().len(), 12);
        assert_eq!(watch.most.load(Ordering::Relaxed), 12);
        let stop = Watch { cancel: true, most: AtomicUsize::new(0) };
        assert!(matches!(run(&stop), Err(PressureError::Cancelled(_))));
    }

    #[test]
    fn a_single_sample_equals_that_of_its_run() {
        let (surface, half_space) = gaussian_surface(12, 10);
        let problem = Problem::new(&surface, &half_space, Control::Plane { height_m: 0.0 }, None).unwrap();
        let sampling = Sampling { replicates: 4, ..Sampling::monte_carlo(3, "alone", 20, 0.95) };
        let samples = solve(&problem, Sampling { method: SamplingMethod::Sobol, ..sampling }, &Silent).unwrap();
        let design = Design::new(SamplingMethod::Sobol, 3, "alone", 5, 10).unwrap();
        let xi = design.replicate(2).unwrap().xi(3);
        assert_eq!(samples.xi(13), xi);
        assert_eq!((samples.replicate_of(13), samples.replicates()), (2, 4));
        let alone = problem.observe(&xi, &mut half_space.workspace()).unwrap();
        assert_eq!(samples.observations()[13], alone);
    }
}
