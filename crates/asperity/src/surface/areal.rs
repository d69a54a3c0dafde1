//! Areal texture parameters of ISO 25178-2 on maps with missing points.
//!
//! Heights are taken about their mean; remove the form first ([`super::level`]). Every parameter belongs to a bandwidth,
//! from the pixel to the field, and to the form and outliers that were removed.

mod hybrid;
mod material;
mod spatial;

use thiserror::Error;

use crate::map::HeightMap;
use crate::stats::Moments;

pub use material::{Core, EquivalentLine, MaterialRatio};
pub use spatial::{Decay, decay};

/// Why a map has no texture parameters.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ArealError {
    /// All heights are equal: shape, slope and correlation of no roughness are undefined.
    #[error("all {present} heights that are present are equal; a surface without roughness has no texture parameters")]
    Flat {
        /// Heights present.
        present: usize,
    },
}

/// Texture parameters; lengths in metre, areas per area as fractions. `None` is undefined, with the reason at the field.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameters {
    /// Heights present.
    pub present: usize,
    /// Heights missing.
    pub missing: usize,
    /// Arithmetical mean height Sa.
    pub sa_m: f64,
    /// Root-mean-square height Sq.
    pub sq_m: f64,
    /// Skewness Ssk.
    pub ssk: f64,
    /// Kurtosis Sku, 3 for normal heights.
    pub sku: f64,
    /// Maximum peak height Sp.
    pub sp_m: f64,
    /// Maximum pit height Sv, positive.
    pub sv_m: f64,
    /// Maximum height Sz = Sp + Sv.
    pub sz_m: f64,
    /// Root-mean-square gradient Sdq by forward differences, over the points whose right and lower neighbours are
    /// present; `None` when there is no such point.
    pub sdq: Option<f64>,
    /// Sdq by the seven-point differences of ISO 25178-2, over the present points whose three neighbours on every side
    /// are present; `None` when there is no such point.
    pub sdq_7point: Option<f64>,
    /// Developed interfacial area ratio Sdr: the triangulated area over the projected one, less one, over the cells whose
    /// four corners are present; each cell counts the mean of its two triangulations. `None` when there is no such cell.
    pub sdr: Option<f64>,
    /// Autocorrelation length Sal: the shortest distance over which the correlation falls to 0.2; `None` when it does so
    /// in no direction within half the field.
    pub sal_m: Option<f64>,
    /// Texture aspect ratio Str: Sal over the longest such distance; `None` when some direction does not decay.
    pub str_ratio: Option<f64>,
    /// Core height Sk, by the secant of [`EquivalentLine::Secant`], as the four that follow.
    pub sk_m: f64,
    /// Reduced peak height Spk.
    pub spk_m: f64,
    /// Reduced dale height Svk.
    pub svk_m: f64,
    /// Material ratio Smrk1 at the upper end of the core, a fraction.
    pub smrk1: f64,
    /// Material ratio Smrk2 at the lower end of the core, a fraction.
    pub smrk2: f64,
    /// Peak extreme height Sxp between the material ratios 2.5 % and 50 %.
    pub sxp_m: f64,
    /// Peak material volume Vmp per area, above the material ratio 10 %.
    pub vmp_m: f64,
    /// Core material volume Vmc per area, between 10 % and 80 %.
    pub vmc_m: f64,
    /// Core void volume Vvc per area, between 10 % and 80 %.
    pub vvc_m: f64,
    /// Dale void volume Vvv per area, below 80 %.
    pub vvv_m: f64,
}

impl Parameters {
    /// Names and values in SI as in tables and JSON; `None` is undefined.
    pub fn named(&self) -> [(&'static str, Option<f64>); 22] {
        [
            ("Sa_m", Some(self.sa_m)),
            ("Sq_m", Some(self.sq_m)),
            ("Ssk", Some(self.ssk)),
            ("Sku", Some(self.sku)),
            ("Sp_m", Some(self.sp_m)),
            ("Sv_m", Some(self.sv_m)),
            ("Sz_m", Some(self.sz_m)),
            ("Sdq", self.sdq),
            ("Sdq_7point", self.sdq_7point),
            ("Sdr", self.sdr),
            ("Sal_m", self.sal_m),
            ("Str", self.str_ratio),
            ("Sk_m", Some(self.sk_m)),
            ("Spk_m", Some(self.spk_m)),
            ("Svk_m", Some(self.svk_m)),
            ("Smrk1", Some(self.smrk1)),
            ("Smrk2", Some(self.smrk2)),
            ("Sxp_m", Some(self.sxp_m)),
            ("Vmp_m", Some(self.vmp_m)),
            ("Vmc_m", Some(self.vmc_m)),
            ("Vvc_m", Some(self.vvc_m)),
            ("Vvv_m", Some(self.vvv_m)),
        ]
    }
}

/// The texture parameters of a map about its mean height.
///
/// # References
/// ISO 25178-2:2021; ISO 13565-2:1996 for the Sk family.
///
/// # Errors
/// [`ArealError::Flat`] when the heights do not vary.
pub fn parameters(map: &HeightMap) -> Result<Parameters, ArealError> {
    let moments = Moments::of_values(map.heights_m().iter().copied());
    let flat = ArealError::Flat { present: moments.n };
    // Equal heights may differ from their mean by its rounding.
    if moments.std <= 8.0 * f64::EPSILON * moments.mean.abs() || moments.std == 0.0 {
        return Err(flat);
    }
    let heights = || map.present_m().map(|z| z - moments.mean);
    let sp_m = heights().fold(f64::NEG_INFINITY, f64::max);
    let sv_m = -heights().fold(f64::INFINITY, f64::min);
    let decay = decay(map, 0.2).map_err(|_| flat)?;
    let ratio = MaterialRatio::of(heights());
    let core = ratio.core(EquivalentLine::Secant);
    let volumes = ratio.volumes(0.1, 0.8);
    Ok(Parameters {
        present: moments.n,
        missing: map.missing_points(),
        sa_m: heights().map(f64::abs).sum::<f64>() / moments.n as f64,
        sq_m: moments.std,
        ssk: moments.skewness,
        sku: moments.excess_kurtosis + 3.0,
        sp_m,
        sv_m,
        sz_m: sp_m + sv_m,
        sdq: hybrid::gradient_forward(map),
        sdq_7point: hybrid::gradient_seven_points(map),
        sdr: hybrid::developed_area_ratio(map),
        sal_m: decay.shortest_m,
        str_ratio: decay.aspect_ratio(),
        sk_m: core.sk_m,
        spk_m: core.spk_m,
        svk_m: core.svk_m,
        smrk1: core.smrk1,
        smrk2: core.smrk2,
        sxp_m: ratio.height_m(0.025) - ratio.height_m(0.5),
        vmp_m: volumes.peak_material_m,
        vmc_m: volumes.core_material_m,
        vvc_m: volumes.core_void_m,
        vvv_m: volumes.dale_void_m,
    })
}

#[cfg(test)]
mod tests;
