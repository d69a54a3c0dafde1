//! Areal texture parameters of ISO 25178-2 on maps with missing points.
//!
//! Heights are taken about their mean; remove the form first ([`super::level`]). Every parameter belongs to a bandwidth,
//! from the pixel to the field, and to the form and outliers that were removed.

mod hybrid;
mod material;
mod spatial;

use thiserror::Error;

use asperity_base::correlation::{AreaSpectrum, Autocorrelation, RadialSpectrum};
use asperity_base::map::HeightMap;
use asperity_base::stats::{Extent, Moments};

pub use material::{Core, EquivalentLine, MaterialRatio};
pub use spatial::{Decay, decay};

/// Reason why a map has no texture parameters.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ArealError {
    /// All heights are equal; shape, slope and correlation are undefined without roughness.
    #[error("all {present} heights that are present are equal; a surface without roughness has no texture parameters")]
    Flat {
        /// Number of present heights.
        present: usize,
    },
}

/// Texture parameters; lengths in metre, areas per area as fractions. `None` is undefined; each field states the reason.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ArealParameters {
    /// Number of present heights.
    pub present: usize,
    /// Number of missing heights.
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
    /// present; `None` if there is no such point.
    pub sdq: Option<f64>,
    /// Sdq by the seven-point differences of ISO 25178-2, over the present points whose three neighbours on every side
    /// are present; `None` if there is no such point.
    pub sdq_7point: Option<f64>,
    /// Developed interfacial area ratio Sdr: the triangulated area over the projected one, minus one, over the cells
    /// whose four corners are present. Each cell counts the mean of its two triangulations. `None` if there is no such
    /// cell.
    pub sdr: Option<f64>,
    /// Autocorrelation length Sal: the shortest distance over which the correlation falls to 0.2; `None` if it falls to
    /// 0.2 in no direction within half the field.
    pub sal_m: Option<f64>,
    /// Texture aspect ratio Str: Sal over the longest such distance; `None` if the correlation does not decay in some
    /// direction.
    pub str_ratio: Option<f64>,
    /// Texture direction Std in rad, from 0 to below π: the direction of the lay, counter-clockwise from x in the map
    /// with row 0 at the top ([`asperity_base::correlation::AngularSpectrum`]). Some programs report the direction of
    /// the wavevectors instead, which is turned by π/2. Std exists for every map except tiny ones; Str shows whether
    /// there is a lay.
    pub std_rad: Option<f64>,
    /// Dominant spatial wavelength Ssw: the wavelength of the largest spectral density.
    pub ssw_m: Option<f64>,
    /// Sk, Spk, Svk, Smrk1 and Smrk2 by the least-squares line, [`EquivalentLine::LeastSquares`].
    pub core: Core,
    /// The Sk family by the secant, [`EquivalentLine::Secant`].
    pub core_secant: Core,
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

impl ArealParameters {
    /// Returns names and values in SI as in tables and JSON; `None` is undefined.
    pub fn named(&self) -> [(&'static str, Option<f64>); 31] {
        let (core, secant) = (&self.core, &self.core_secant);
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
            ("Std_rad", self.std_rad),
            ("Ssw_m", self.ssw_m),
            ("Sk_m", Some(core.sk_m)),
            ("Spk_m", Some(core.spk_m)),
            ("Svk_m", Some(core.svk_m)),
            ("Smrk1", Some(core.smrk1)),
            ("Smrk2", Some(core.smrk2)),
            ("Spkx_m", Some(core.spkx_m)),
            ("Svkx_m", Some(core.svkx_m)),
            ("Sk_secant_m", Some(secant.sk_m)),
            ("Spk_secant_m", Some(secant.spk_m)),
            ("Svk_secant_m", Some(secant.svk_m)),
            ("Smrk1_secant", Some(secant.smrk1)),
            ("Smrk2_secant", Some(secant.smrk2)),
            ("Sxp_m", Some(self.sxp_m)),
            ("Vmp_m", Some(self.vmp_m)),
            ("Vmc_m", Some(self.vmc_m)),
            ("Vvc_m", Some(self.vvc_m)),
            ("Vvv_m", Some(self.vvv_m)),
        ]
    }
}

/// Texture parameters of a map with the intermediate estimates.
#[derive(Debug, Clone)]
pub struct Analysis {
    /// The parameters.
    pub parameters: ArealParameters,
    /// Autocorrelation up to the lag at which it falls to 0.2, or to half the field.
    pub correlation: Autocorrelation,
    /// Radially averaged power spectral density.
    pub spectrum: RadialSpectrum,
}

/// Computes the texture parameters of a map about its mean height.
///
/// # References
/// ISO 25178-2:2021; ISO 13565-2:1996 for the Sk family.
///
/// # Errors
/// [`ArealError::Flat`] if all heights are equal.
pub fn parameters(map: &HeightMap) -> Result<ArealParameters, ArealError> {
    Ok(Textures::of(map)?.parameters(map))
}

/// Computes the texture parameters of a map, and the autocorrelation and spectrum used for them.
///
/// # Errors
/// The errors of [`parameters`].
pub fn analyse(map: &HeightMap) -> Result<Analysis, ArealError> {
    let textures = Textures::of(map)?;
    let parameters = textures.parameters(map);
    Ok(Analysis { parameters, spectrum: textures.radial, correlation: textures.correlation })
}

/// Moments, and what follows from correlation and spectrum of a map.
struct Textures {
    moments: Moments,
    mean_absolute_m: f64,
    extent: Extent,
    decay: Decay,
    correlation: Autocorrelation,
    radial: RadialSpectrum,
    std_rad: Option<f64>,
    ssw_m: Option<f64>,
}

impl Textures {
    fn of(map: &HeightMap) -> Result<Self, ArealError> {
        let values = map.values_m();
        let extent = Extent::new(values);
        let (moments, mean_absolute_m) = Moments::with_absolute(&extent, values);
        let flat = ArealError::Flat { present: moments.n };
        // Equal heights may differ from their mean by rounding.
        if moments.std <= 8.0 * f64::EPSILON * moments.mean.abs() || moments.std == 0.0 {
            return Err(flat);
        }
        let complete = moments.n == values.len();
        let (decay, correlation, spectrum) = if complete {
            let (decay, correlation) = spatial::decay_and_correlation(map, &extent, 0.2).map_err(|_| flat.clone())?;
            (decay, correlation, AreaSpectrum::with_extent(map, &extent).map_err(|_| flat)?)
        } else {
            // The spectrum needs the autocorrelation up to half the field.
            let correlation = Autocorrelation::estimate(map).map_err(|_| flat.clone())?;
            let decay = spatial::followed(&correlation, 0.2).map_err(|_| flat)?;
            let spectrum = AreaSpectrum::of_small_voids(map, extent.mean);
            let spectrum = spectrum.unwrap_or_else(|| AreaSpectrum::from_correlation(&correlation));
            (decay, correlation, spectrum)
        };
        let (radial, std_rad) = (spectrum.radial(), spectrum.angular().map(|angular| angular.direction_rad()));
        let ssw_m = spectrum.dominant_wavelength_m();
        Ok(Self { moments, mean_absolute_m, extent, decay, correlation, radial, std_rad, ssw_m })
    }

    fn parameters(&self, map: &HeightMap) -> ArealParameters {
        let (values, moments) = (map.values_m(), &self.moments);
        let (sp_m, sv_m) = (self.extent.largest - moments.mean, moments.mean - self.extent.least);
        let hybrid = hybrid::hybrid(map);
        let ratio = MaterialRatio::about(values, moments.mean);
        let [core, core_secant] = ratio.cores([EquivalentLine::LeastSquares, EquivalentLine::Secant]);
        let volumes = ratio.volumes(0.1, 0.8);
        ArealParameters {
            present: moments.n,
            missing: values.len() - moments.n,
            sa_m: self.mean_absolute_m,
            sq_m: moments.std,
            ssk: moments.skewness,
            sku: moments.excess_kurtosis + 3.0,
            sp_m,
            sv_m,
            sz_m: sp_m + sv_m,
            sdq: hybrid.gradient_forward,
            sdq_7point: hybrid.gradient_seven_points,
            sdr: hybrid.developed_area_ratio,
            sal_m: self.decay.shortest_m,
            str_ratio: self.decay.aspect_ratio(),
            std_rad: self.std_rad,
            ssw_m: self.ssw_m,
            core,
            core_secant,
            sxp_m: ratio.height_m(0.025) - ratio.height_m(0.5),
            vmp_m: volumes.peak_material_m,
            vmc_m: volumes.core_material_m,
            vvc_m: volumes.core_void_m,
            vvv_m: volumes.dale_void_m,
        }
    }
}

#[cfg(test)]
mod tests;
