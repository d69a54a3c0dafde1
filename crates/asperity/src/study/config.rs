//! What a study file says.
//!
//! Every key is checked: an unknown one is an error that names its line and the nearest known key.

use std::fmt;
use std::path::{Path, PathBuf};

use asperity_base::choice;
use asperity_formats::{Channel, FormatError, ReadOptions, Scan};
use serde::de::{self, IgnoredAny, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

use crate::map::BoundaryKind;
use crate::quantity::{Area, Compliance, Length, Pressure};
use crate::study::scatter::{LengthScatter, NumberScatter};
pub use crate::study::vibration_section::{MapOver, MapSection, Stribeck, Upscaling, VelocityLaw, VibrationSection};
use crate::surface::level::Level;
use crate::surface::preparation::Preparation;
use crate::surface::{CovarianceSource, SurfaceGenerator};
use crate::translation::TranslationKind;

/// A study: which scan or model, which stages, and the seed of every random draw.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Study {
    /// Seed of every random draw.
    pub seed: u64,
    /// The measured or modelled surface; needed by pressure and friction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub surface: Option<SurfaceSection>,
    /// Elastic and plastic properties; needed by every stage but the first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub material: Option<MaterialSection>,
    /// The law of the random pressure.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pressure: Option<PressureSection>,
    /// The friction coefficient as a process.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction: Option<FrictionSection>,
    /// Stick-slip of a mass on a belt.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vibration: Option<VibrationSection>,
}

/// One scan, or several of one part: `"a.x3p"` or `["a.x3p", "b.x3p"]`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged, expecting = "expected the name of a scan, or a list of names")]
pub enum ScanFiles {
    /// One scan.
    One(PathBuf),
    /// Scans of one part.
    Several(Vec<PathBuf>),
}

impl ScanFiles {
    /// Their names.
    pub fn paths(&self) -> &[PathBuf] {
        match self {
            Self::One(path) => std::slice::from_ref(path),
            Self::Several(paths) => paths,
        }
    }

    /// The same under other names.
    #[must_use]
    pub fn map(&self, name: impl Fn(&Path) -> PathBuf) -> Self {
        match self {
            Self::One(path) => Self::One(name(path)),
            Self::Several(paths) => Self::Several(paths.iter().map(|path| name(path)).collect()),
        }
    }
}

impl From<&str> for ScanFiles {
    fn from(path: &str) -> Self {
        Self::One(path.into())
    }
}

/// `[surface]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SurfaceSection {
    /// Scan file, relative to the study file, or a list of scans of one part. Of several scans the statistics are pooled
    /// ([`crate::study::PooledStatistics`]), and random surfaces have the correlation of all pairs of heights and the law of
    /// all heights, each scan counted from its own form; their pixels must have the same size. Maps and figures show the
    /// first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<ScanFiles>,
    /// The height map to read of a file that holds several: its name, or its number counted from 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub channel: Option<String>,
    /// Pixel size (x, y) of a scan that states none, or one for both; overrides the file's.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "one_or_two")]
    pub pixel_size: Option<[Length; 2]>,
    /// Unit of the heights of a scan that states none, such as `um`; overrides the file's, and a conversion factor in the header
    /// of a text.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub height_unit: Option<String>,
    /// Form removed from the scan.
    #[serde(default)]
    pub level: Level,
    /// Heights farther from the median than this many robust standard deviations count as missing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub outliers: Option<f64>,
    /// Cutoff of the S-filter: shorter waves of the scan are taken out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub s_filter: Option<Length>,
    /// Cutoff of the L-filter: longer waves of the scan are taken out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub l_filter: Option<Length>,
    /// Whether the L-filter is robust against grooves and spikes.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub robust_filter: bool,
    /// How random surfaces are made.
    #[serde(default)]
    pub generator: SurfaceGenerator,
    /// Their covariance; the Weierstrass–Mandelbrot generator takes none.
    #[serde(default)]
    pub covariance: CovarianceSource,
    /// Their standard deviation of height, when not measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rms_height: Option<Length>,
    /// Their correlation lengths (x, y) or one for both, when not measured: the parameter ℓ of the model
    /// ([`crate::correlation::CorrelationModel`]). Of the exponential and the squared exponential model it is the lag at which
    /// the correlation is 1/e; of the Matérn model it is the scale, of the self-affine one the roll-off length, and the
    /// correlation falls to 1/e elsewhere.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "one_or_two")]
    pub correlation_length: Option<[Length; 2]>,
    /// Hurst exponent of a self-affine model.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hurst: Option<f64>,
    /// Smoothness ν of a Matérn model.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub smoothness: Option<f64>,
    /// Fractal dimension, 2 to 3, of the Weierstrass–Mandelbrot generator.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fractal_dimension: Option<f64>,
    /// Marginal law of the heights: `measured`, `normal`, `beta:A,B`, …; the Weierstrass–Mandelbrot generator takes none.
    #[serde(default = "measured")]
    pub marginal: String,
    /// How the marginal is imposed.
    #[serde(default)]
    pub translation: TranslationKind,
    /// Terms of the Karhunen–Loève expansion. When left out, as many as hold 90 % of the slope variance of a patch, or all Fourier
    /// modes where those are more than 400.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub modes: Option<usize>,
    /// Whether patches have the constant Fourier mode, by which they differ in mean height. Without it the variance of the other
    /// modes is scaled to the whole. Of a Karhunen–Loève expansion on periodic patches.
    #[serde(default = "yes", skip_serializing_if = "is_true")]
    pub mean_mode: bool,
    /// What is done about the variance that a Karhunen–Loève expansion of normal heights leaves out: `true` scales all heights of
    /// a patch by one factor, so that the modes hold the whole variance on average over the patch, `false` lets the heights be
    /// lower. When left out, the marginal law is imposed at every point, as with any other law.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rescale: Option<bool>,
}

/// One length for x and y, `"20 um"`, or one for each, `["20 um", "10 um"]`.
fn one_or_two<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<[Length; 2]>, D::Error> {
    struct OneOrTwo;
    impl<'de> Visitor<'de> for OneOrTwo {
        type Value = [Length; 2];

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("a length with its unit, such as \"20 um\", or a list of two, along x and y")
        }

        fn visit_str<E: de::Error>(self, text: &str) -> Result<[Length; 2], E> {
            let both = text.parse().map_err(E::custom)?;
            Ok([both, both])
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<[Length; 2], A::Error> {
            let x = seq.next_element()?.ok_or_else(|| de::Error::invalid_length(0, &self))?;
            let y = seq.next_element()?.ok_or_else(|| de::Error::invalid_length(1, &self))?;
            match seq.next_element::<IgnoredAny>()? {
                None => Ok([x, y]),
                Some(_) => Err(de::Error::invalid_length(3, &self)),
            }
        }
    }
    deserializer.deserialize_any(OneOrTwo).map(Some)
}

impl Default for SurfaceSection {
    /// What an empty section says.
    fn default() -> Self {
        Self {
            file: None,
            channel: None,
            pixel_size: None,
            height_unit: None,
            level: Level::default(),
            outliers: None,
            s_filter: None,
            l_filter: None,
            robust_filter: false,
            generator: SurfaceGenerator::default(),
            covariance: CovarianceSource::default(),
            rms_height: None,
            correlation_length: None,
            hurst: None,
            smoothness: None,
            fractal_dimension: None,
            marginal: measured(),
            translation: TranslationKind::default(),
            modes: None,
            mean_mode: yes(),
            rescale: None,
        }
    }
}

impl SurfaceSection {
    /// Names of the scans; none for a surface without.
    pub fn files(&self) -> &[PathBuf] {
        self.file.as_ref().map_or(&[], ScanFiles::paths)
    }

    /// The scans, none for a surface without. `folder` is that of the study file.
    ///
    /// # Errors
    /// A file cannot be read, or holds no such channel; the height unit is no unit of length.
    pub fn read_scans(&self, folder: &Path) -> Result<Vec<Scan>, FormatError> {
        let channel = self.channel.as_deref().map(Channel::from);
        let height_unit = self.height_unit.as_deref().map(str::parse).transpose()?;
        let pitch_m = self.pixel_size.map(|[x, y]| (x.0, y.0));
        let options = ReadOptions { channel, height_unit, pitch_m };
        self.files().iter().map(|file| asperity_formats::read_with(&folder.join(file), &options)).collect()
    }

    /// What is done to the scan before anything is read off it.
    pub fn preparation(&self) -> Preparation {
        Preparation {
            level: self.level,
            outliers: self.outliers,
            s_filter_m: self.s_filter.map(|cutoff| cutoff.0),
            l_filter_m: self.l_filter.map(|cutoff| cutoff.0),
            robust: self.robust_filter,
        }
    }
}

/// `[material]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MaterialSection {
    /// Young's modulus.
    pub youngs_modulus: Pressure,
    /// Poisson's ratio.
    #[serde(default = "poisson_ratio")]
    pub poisson_ratio: f64,
    /// Hardness, the highest pressure; without it contact is elastic.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hardness: Option<Pressure>,
    /// Shear strength τ_max of the contacts; needed by friction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shear_strength: Option<Pressure>,
}

/// `[pressure]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PressureSection {
    /// Size (x, y) of a patch.
    pub size: [Length; 2],
    /// Points (x, y) of a patch.
    pub points: [usize; 2],
    /// Boundary of a patch.
    #[serde(default = "free")]
    pub boundary: BoundaryKind,
    /// Cell [row, column] whose pressure is studied, counted from 0 at the top left; when left out, the centre [ny/2, nx/2].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cell: Option<[usize; 2]>,
    /// Mean compliance of a periodic patch.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mean_compliance: Option<Compliance>,
    /// Percentage of the heights (of the ensemble) above the plane before deformation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub percentile: Option<f64>,
    /// Depth of the plane below the highest point of each patch.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub penetration: Option<Length>,
    /// Mean pressure on each patch.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mean_pressure: Option<Pressure>,
    /// Contact solves given to each method.
    #[serde(default = "fine_solves")]
    pub fine_solves: usize,
    /// Contact solves of the reference run.
    #[serde(default = "reference_samples")]
    pub reference_samples: usize,
    /// Leading variables of the chaos expansion.
    #[serde(default = "variables")]
    pub variables: usize,
    /// Total degree of the chaos expansion.
    #[serde(default = "degree")]
    pub degree: usize,
    /// Whether the normal stiffness of the contact is estimated too.
    #[serde(default)]
    pub stiffness: bool,
    /// Relative tolerance of each contact solve.
    #[serde(default = "solve_tolerance")]
    pub tolerance: f64,
}

choice! {
    /// Friction law of a window; see [`crate::friction::law`].
    #[derive(Default)]
    pub enum FrictionLawKind: "friction law" {
        /// F = τ_max A_c (the paper's).
        #[default]
        BowdenTabor = "bowden_tabor",
        /// F = τ_max A_c + αN.
        PressureDependent = "pressure_dependent",
        /// F = τ_max A_c and the ploughing of yielded contacts.
        AdhesionPloughing = "adhesion_ploughing",
        /// F = μN.
        Coulomb = "coulomb",
    }
}

choice! {
    /// Shape of the window.
    #[derive(Default)]
    pub enum WindowShape: "shape of the window" {
        /// All of its length and width.
        #[default]
        Rectangle = "rectangle",
        /// The ellipse in it.
        Ellipse = "ellipse",
    }
}

/// `[friction]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrictionSection {
    /// Size (x, y) of a strip; it slides along x.
    #[serde(default = "strip")]
    pub strip: [Length; 2],
    /// Points (x, y) of a strip.
    #[serde(default = "strip_points")]
    pub points: [usize; 2],
    /// Length of the window along x.
    #[serde(default = "window")]
    pub window: Length,
    /// Width of the window along y; when left out, that of the strip. Windows narrower than a periodic strip are laid side by
    /// side, and what each sees is a record of its own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub window_width: Option<Length>,
    /// Shape of the window.
    #[serde(default, skip_serializing_if = "is_default")]
    pub window_shape: WindowShape,
    /// Law of friction. `shear_strength` of `[material]` is its τ_max.
    #[serde(default, skip_serializing_if = "is_default")]
    pub law: FrictionLawKind,
    /// α of the pressure-dependent law.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pressure_coefficient: Option<f64>,
    /// μ of Coulomb's law.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coefficient: Option<f64>,
    /// Boundary of a strip.
    #[serde(default = "periodic")]
    pub boundary: BoundaryKind,
    /// Mean compliance of a periodic strip.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mean_compliance: Option<Compliance>,
    /// Levels: percentages of the heights (of the ensemble) above the plane, which is one plane in space for all strips. When left
    /// out, five of them, unless other levels are stated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub percentiles: Option<Vec<f64>>,
    /// Further levels: mean pressures on every strip.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub mean_pressures: Vec<Pressure>,
    /// Further levels: depths of the plane below the highest point of every strip.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub penetrations: Vec<Length>,
    /// Area over which windows average, for the `area` upscaling; when left out, that of `[vibration]`, or else 833 mm².
    #[serde(skip_serializing_if = "Option::is_none")]
    pub nominal_area: Option<Area>,
    /// Strips per level.
    #[serde(default = "realisations")]
    pub realisations: usize,
    /// Relative tolerance of each contact solve.
    #[serde(default = "solve_tolerance")]
    pub tolerance: f64,
    /// What of the surface is uncertain.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub uncertainty: Option<UncertaintySection>,
}

/// `[friction.uncertainty]`: standard deviations of the surface's parameters about their values in the study, independent of
/// each other. At least one is stated.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct UncertaintySection {
    /// Of the root mean square height, which is lognormal.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rms_height: Option<LengthScatter>,
    /// Of the correlation length along x, which is lognormal; that along y and all lags keep their ratio to it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub correlation_length: Option<LengthScatter>,
    /// Of the skewness of the heights, which is normal. Heights then have Johnson's law.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub skewness: Option<NumberScatter>,
    /// Surfaces, each of other parameters.
    #[serde(default = "uncertainty_points")]
    pub points: usize,
    /// Strips of each surface, the same for all; when left out, half as many as for the levels, at least 4.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub realisations: Option<usize>,
}

impl UncertaintySection {
    /// Number of uncertain parameters.
    pub fn parameters(&self) -> usize {
        let stated = [self.rms_height.is_some(), self.correlation_length.is_some(), self.skewness.is_some()];
        stated.into_iter().filter(|stated| *stated).count()
    }
}

impl FrictionSection {
    /// Strips of each surface of the uncertainty.
    pub fn uncertainty_realisations(&self) -> usize {
        let stated = self.uncertainty.as_ref().and_then(|uncertainty| uncertainty.realisations);
        stated.unwrap_or((self.realisations / 2).max(4))
    }

    /// Width of the window.
    pub fn window_width(&self) -> Length {
        self.window_width.unwrap_or(self.strip[1])
    }

    /// Percentages of the heights above the plane: those stated or, where no level is stated, the usual ones.
    pub fn percentiles(&self) -> &[f64] {
        match &self.percentiles {
            Some(stated) => stated,
            None if self.mean_pressures.is_empty() && self.penetrations.is_empty() => &PERCENTILES,
            None => &[],
        }
    }

    /// Number of its levels.
    pub fn levels(&self) -> usize {
        self.percentiles().len() + self.mean_pressures.len() + self.penetrations.len()
    }
}

impl Default for FrictionSection {
    fn default() -> Self {
        Self {
            strip: strip(),
            points: strip_points(),
            window: window(),
            window_width: None,
            window_shape: WindowShape::default(),
            law: FrictionLawKind::default(),
            pressure_coefficient: None,
            coefficient: None,
            boundary: periodic(),
            mean_compliance: None,
            percentiles: None,
            mean_pressures: Vec::new(),
            penetrations: Vec::new(),
            nominal_area: None,
            realisations: realisations(),
            tolerance: solve_tolerance(),
            uncertainty: None,
        }
    }
}

fn measured() -> String {
    "measured".into()
}
fn yes() -> bool {
    true
}
#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde hands over references")]
fn is_true(value: &bool) -> bool {
    *value
}
fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}
fn poisson_ratio() -> f64 {
    0.3
}
fn free() -> BoundaryKind {
    BoundaryKind::Free
}
fn periodic() -> BoundaryKind {
    BoundaryKind::Periodic
}
fn fine_solves() -> usize {
    500
}
fn reference_samples() -> usize {
    5000
}
fn variables() -> usize {
    8
}
fn degree() -> usize {
    3
}
fn solve_tolerance() -> f64 {
    1e-6
}
fn strip() -> [Length; 2] {
    [Length(6e-3), Length(75e-6)]
}
fn strip_points() -> [usize; 2] {
    [2048, 32]
}
fn window() -> Length {
    Length(600e-6)
}
/// Levels of a friction stage that states none.
const PERCENTILES: [f64; 5] = [5.0, 10.0, 25.0, 50.0, 75.0];
fn realisations() -> usize {
    20
}
fn uncertainty_points() -> usize {
    32
}
