//! Elastic energy and plastic work of a contact.

use crate::Solution;

impl Solution {
    /// Returns the elastic energy ½ Σ p u ΔA in joule, with u = S p.
    ///
    /// On a periodic half-space u includes the mean compliance c of its [`Boundary`](crate::Boundary), which adds
    /// ½ c p̄² A₀. The rest is the energy of the rough interface.
    ///
    /// Its sum with [`plastic_work_j`](Self::plastic_work_j) is the work ∫ F dδ of loading from first touch.
    pub fn elastic_energy_j(&self) -> f64 {
        let work: f64 = self.pressure_pa.iter().zip(&self.displacement_m).map(|(p, u)| p * u).sum();
        0.5 * work * self.grid.cell_area_m2()
    }

    /// Returns the work of plastic flow Σ p u_pl ΔA in joule: the hardness times the displaced volume. It assumes that
    /// no cell fell below the hardness again during loading, so all plastic work was done at p = H.
    pub fn plastic_work_j(&self) -> f64 {
        let plastic_m = self.plastic_displacement_m();
        let work: f64 = self.pressure_pa.iter().zip(&plastic_m).map(|(p, u)| p * u).sum();
        work * self.grid.cell_area_m2()
    }
}
