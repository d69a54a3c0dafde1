//! Numbers of a solved contact.

use serde::Serialize;

use super::exact::{PerssonPressure, bush_gibson_thomas_contact_fraction};
use super::{Boundary, Clusters, ContactProblem, ContactStiffness, Solution, SolverStop, Substrate, rms_gradient};

/// Numbers of a solved contact by the keys of `asperity contact --json`; what is undefined is none.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ContactNumbers {
    /// Fraction of the cells with pressure.
    pub contact_fraction: f64,
    /// Fraction of the area in contact, corrected for cells at the border of the contact.
    pub contact_fraction_corrected: f64,
    /// Fraction of the cells at the hardness.
    pub plastic_fraction: f64,
    /// Mean pressure over the whole map.
    pub mean_pressure_pa: f64,
    /// Total force on the map.
    pub load_n: f64,
    /// Highest pressure.
    pub max_pressure_pa: f64,
    /// Mean gap over the whole map.
    pub mean_gap_m: f64,
    /// Height of the flat above the mean of the undeformed heights.
    pub separation_m: f64,
    /// Depth of the flat below the highest undeformed point.
    pub penetration_m: f64,
    /// Displacement of the mean plane per mean pressure of a periodic surface.
    pub mean_compliance_m_per_pa: Option<f64>,
    /// Number of clusters: groups of contact cells that share edges.
    pub clusters: usize,
    /// Fraction of the cells in contact that belong to the largest cluster.
    pub largest_cluster_fraction: Option<f64>,
    /// Area of the largest cluster.
    pub largest_cluster_m2: f64,
    /// Elastic energy ½ Σ p u, with that of the stated mean compliance.
    pub elastic_energy_j: f64,
    /// Plastic work: the hardness times the displaced volume.
    pub plastic_work_j: f64,
    /// Contact modulus E* of the pair; at the surface of a layer.
    pub contact_modulus_pa: f64,
    /// Root mean square gradient of the heights by forward differences.
    pub rms_gradient: f64,
    /// Contact fraction of Persson's theory for a half-space.
    pub persson_contact_fraction: Option<f64>,
    /// Fraction at the hardness in Persson's theory for a half-space.
    pub persson_plastic_fraction: Option<f64>,
    /// Contact fraction of Bush, Gibson and Thomas for light elastic contact of a half-space.
    pub bgt_contact_fraction: Option<f64>,
    /// Load per approach, if computed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contact_stiffness_n_per_m: Option<f64>,
    /// Mean pressure per approach, if computed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contact_stiffness_pa_per_m: Option<f64>,
    /// Iterations of the solver.
    pub iterations: usize,
    /// Largest relative residual, computed afresh from the pressure.
    pub residual: f64,
    /// Whether the residual is below the tolerance.
    pub converged: bool,
}

impl ContactNumbers {
    /// Collects the numbers of a solution of `problem`, with its clusters and its stiffness, if that was computed.
    pub fn new(
        problem: &ContactProblem<'_>,
        solution: &Solution,
        clusters: &Clusters,
        stiffness: Option<ContactStiffness>,
    ) -> Self {
        let half_space = problem.half_space();
        let (mean_pressure_pa, modulus_pa) = (solution.mean_pressure_pa(), half_space.modulus_pa());
        let rms_gradient = rms_gradient(problem.heights_m(), half_space.grid(), half_space.boundary());
        let persson = PerssonPressure::new(mean_pressure_pa, modulus_pa, rms_gradient, problem.hardness_pa());
        let bush = bush_gibson_thomas_contact_fraction(mean_pressure_pa, modulus_pa, rms_gradient);
        // Both theories apply to a half-space only.
        let is_half_space = matches!(half_space.substrate(), Substrate::HalfSpace { .. });
        let known = |fraction: f64| is_half_space.then_some(fraction);
        Self {
            contact_fraction: solution.contact_fraction(),
            contact_fraction_corrected: solution.corrected_contact_fraction(),
            plastic_fraction: solution.plastic_fraction(),
            mean_pressure_pa,
            load_n: solution.load_n(),
            max_pressure_pa: solution.max_pressure_pa(),
            mean_gap_m: solution.mean_gap_m(),
            separation_m: solution.separation_m(),
            penetration_m: solution.penetration_m(),
            mean_compliance_m_per_pa: match solution.boundary() {
                Boundary::Free => None,
                Boundary::Periodic { mean_compliance_m_per_pa } => Some(mean_compliance_m_per_pa),
            },
            clusters: clusters.count(),
            largest_cluster_fraction: clusters.largest_fraction(),
            largest_cluster_m2: clusters.largest_m2(),
            elastic_energy_j: solution.elastic_energy_j(),
            plastic_work_j: solution.plastic_work_j(),
            contact_modulus_pa: modulus_pa,
            rms_gradient,
            persson_contact_fraction: known(persson.contact_fraction()),
            persson_plastic_fraction: known(persson.plastic_fraction()),
            bgt_contact_fraction: known(bush),
            contact_stiffness_n_per_m: stiffness.map(|stiffness| stiffness.newton_per_m),
            contact_stiffness_pa_per_m: stiffness.map(|stiffness| stiffness.pascal_per_m),
            iterations: solution.iterations(),
            residual: solution.residual().worst(),
            converged: solution.stop_reason() == SolverStop::Converged,
        }
    }
}
