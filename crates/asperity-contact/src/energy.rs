//! Energy stored in a contact, and spent on it.

use crate::Solution;

impl Solution {
    /// Elastic energy ½ Σ p u ΔA in joule, with u = S p.
    ///
    /// On a periodic half-space u holds the mean compliance c of its [`Boundary`](crate::Boundary), which adds
    /// ½ c p̄² A₀; what is left is the energy of the rough interface.
    ///
    /// With [`plastic_work_j`](Self::plastic_work_j) it is the work ∫ F dδ of pressing from first touch.
    pub fn elastic_energy_j(&self) -> f64 {
        let work: f64 = self.pressure_pa.iter().zip(&self.displacement_m).map(|(p, u)| p * u).sum();
        0.5 * work * self.grid.cell_area_m2()
    }

    /// Work of plastic flow Σ p u_pl ΔA in joule: the hardness times the volume displaced. All of it was done at p = H, as long
    /// as no cell fell below the hardness again while the surfaces were pressed together.
    pub fn plastic_work_j(&self) -> f64 {
        let plastic_m = self.plastic_displacement_m();
        let work: f64 = self.pressure_pa.iter().zip(&plastic_m).map(|(p, u)| p * u).sum();
        work * self.grid.cell_area_m2()
    }
}
