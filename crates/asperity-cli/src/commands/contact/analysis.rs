//! Scalar results of a solved contact.

use asperity::contact::exact::{PerssonPressure, bush_gibson_thomas_contact_fraction};
use asperity::contact::{
    Clusters, ContactError, ContactProblem, ContactStiffness, Neighbours, Solution, StiffnessSolver, Substrate,
    rms_gradient,
};

use crate::failure::{Failure, Kind};
use crate::output::Answer;

/// Clusters, energies, theoretical contact fractions, and the stiffness if requested.
pub(super) struct Analysis {
    pub(super) clusters: Clusters,
    elastic_energy_j: f64,
    plastic_work_j: f64,
    modulus_pa: f64,
    is_half_space: bool,
    rms_gradient: f64,
    persson: PerssonPressure,
    stiffness: Option<ContactStiffness>,
}

impl Analysis {
    pub(super) fn new(
        problem: &ContactProblem<'_>,
        solution: &Solution,
        stiffness: bool,
    ) -> Result<Self, ContactError> {
        let half_space = problem.half_space();
        let (grid, boundary) = (half_space.grid(), half_space.boundary());
        let (mean_pressure_pa, modulus_pa) = (solution.mean_pressure_pa(), half_space.modulus_pa());
        let rms_gradient = rms_gradient(problem.heights_m(), grid, boundary);
        let solved = || StiffnessSolver::default().solve(half_space, solution);
        Ok(Self {
            clusters: solution.clusters(Neighbours::Edges),
            elastic_energy_j: solution.elastic_energy_j(),
            plastic_work_j: solution.plastic_work_j(),
            modulus_pa,
            is_half_space: matches!(half_space.substrate(), Substrate::HalfSpace { .. }),
            rms_gradient,
            persson: PerssonPressure::new(mean_pressure_pa, modulus_pa, rms_gradient, problem.hardness_pa()),
            stiffness: stiffness.then(solved).transpose()?,
        })
    }

    /// Adds the results to an answer.
    pub(super) fn add_to(&self, answer: Answer) -> Answer {
        let mean_pressure_pa = self.persson.mean_pressure_pa;
        let bush = bush_gibson_thomas_contact_fraction(mean_pressure_pa, self.modulus_pa, self.rms_gradient);
        // Both theories apply to a half-space only.
        let known = |fraction: f64| self.is_half_space.then_some(fraction);
        let answer = answer
            .with("clusters", self.clusters.count())
            .with("largest_cluster_fraction", self.clusters.largest_fraction())
            .with("largest_cluster_m2", self.clusters.largest_m2())
            .with("elastic_energy_j", self.elastic_energy_j)
            .with("plastic_work_j", self.plastic_work_j)
            .with("contact_modulus_pa", self.modulus_pa)
            .with("rms_gradient", self.rms_gradient)
            .with("persson_contact_fraction", known(self.persson.contact_fraction()))
            .with("persson_plastic_fraction", known(self.persson.plastic_fraction()))
            .with("bgt_contact_fraction", known(bush));
        match self.stiffness {
            None => answer,
            Some(stiffness) => answer
                .with("contact_stiffness_n_per_m", stiffness.newton_per_m)
                .with("contact_stiffness_pa_per_m", stiffness.pascal_per_m),
        }
    }

    /// Fails if the stiffness was requested and did not converge.
    pub(super) fn check_stiffness(&self) -> Result<(), Failure> {
        match self.stiffness {
            Some(stiffness) if !stiffness.converged => Err(Failure::new(
                Kind::NotConverged,
                format!(
                    "the contact stiffness did not converge in {} iterations: residual {:.1e}",
                    stiffness.iterations, stiffness.residual
                ),
            )),
            _ => Ok(()),
        }
    }
}
