//! A scan and its twins: the content of `comparison.json`.

use serde::{Deserialize, Serialize};

use crate::{CovarianceResult, DistributionResult, Pair, SurfaceStatistics};

/// Comparison of a scan with its twins, which are random maps with the same statistics.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Comparison {
    /// File of the scan.
    pub file: String,
    /// Number of twins.
    pub count: usize,
    /// Seed of every draw.
    pub seed: u64,
    /// Points of a twin along x and y.
    pub points: [usize; 2],
    /// Pitch of a twin along x and y.
    pub pitch_m: Pair,
    /// Method of the bands.
    pub band_method: BandMethod,
    /// Probability of a band.
    pub band_level: f64,
    /// Number of statistics of the scan inside their band.
    pub inside: usize,
    /// Number of statistics that are defined on the scan and have a band.
    pub compared: usize,
    /// Number of abscissas of all functions at which the scan is inside the pointwise band. Neighbouring abscissas are correlated for
    /// density and autocorrelation: their fraction varies far more about 95 % than for as many independent values.
    pub curves_inside: usize,
    /// Number of abscissas of all functions at which scan and twins are compared.
    pub curves_compared: usize,
    /// Model of the twins.
    pub model: TwinModel,
    /// Statistics of the scan.
    pub target: SurfaceStatistics,
    /// Every statistic by name, in the order of the table.
    #[serde(with = "by_name")]
    pub twins: Vec<(String, StatisticComparison)>,
    /// Every function by the name of its table.
    #[serde(with = "by_name")]
    pub curves: Vec<(String, CurveComparison)>,
    /// Limits of the model, in sentences.
    pub limits: Vec<String>,
    /// Assumptions, in sentences.
    pub assumptions: Vec<String>,
    /// Warnings, in sentences.
    pub warnings: Vec<String>,
}

impl Comparison {
    /// Returns the fraction of the abscissas of all functions at which the scan is inside the pointwise band.
    pub fn curves_inside_share(&self) -> Option<f64> {
        (self.curves_compared > 0).then(|| self.curves_inside as f64 / self.curves_compared as f64)
    }

    /// Returns the names of the statistics of the scan outside their band.
    pub fn outside(&self) -> impl Iterator<Item = &str> {
        self.twins.iter().filter(|(_, statistic)| statistic.inside == Some(false)).map(|(name, _)| name.as_str())
    }
}

/// Method by which the ends of a band are found.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BandMethod {
    /// No band: a single twin has no variability.
    #[default]
    None,
    /// Student's prediction interval, m ± t₀.₉₇₅ s √(1 + 1/n), exact for normal values. It is applied to the logarithm of positive
    /// statistics and to the log-odds of fractions, so that no band leaves the range of its statistic.
    StudentT,
    /// The order statistics at (n + 1)·2.5 % and (n + 1)·97.5 %, for any distribution of the statistic.
    Quantiles,
}

/// Model of the twins.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TwinModel {
    /// Name of the generator.
    pub generator: String,
    /// Boundary condition at the edge of a twin: `free` or `periodic`.
    pub boundary: String,
    /// Method that imposes the marginal distribution; `null` for Weierstrass–Mandelbrot surfaces.
    pub translation: Option<String>,
    /// Standard deviation of the heights before a form is removed.
    pub rms_height_m: f64,
    /// Fraction of the twins' variance that is removed with the form, if the rms height compensates for it.
    pub form_share: Option<f64>,
    /// Covariance, if the generator uses one.
    pub covariance: Option<CovarianceResult>,
    /// Marginal distribution before a form is removed.
    pub marginal: DistributionResult,
}

/// One statistic of the scan and of its twins. `None` is undefined.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StatisticComparison {
    /// Value of the scan.
    pub target: Option<f64>,
    /// Mean over the twins.
    pub mean: Option<f64>,
    /// Standard deviation over the twins, divisor n − 1.
    pub std: Option<f64>,
    /// Interval that contains the statistic of a further twin with 95 % probability.
    pub band: Option<Pair>,
    /// Whether the value of the scan is inside.
    pub inside: Option<bool>,
    /// Number of twins on which the statistic is defined.
    pub defined: usize,
}

/// A function of the scan and of its twins.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CurveComparison {
    /// Fraction of the abscissas at which the scan is inside the pointwise band.
    pub inside_share: Option<f64>,
    /// Number of these abscissas.
    pub inside: usize,
    /// Number of abscissas compared.
    pub points: usize,
}

/// Entries of a JSON object in the order of the file.
mod by_name {
    use std::fmt;
    use std::marker::PhantomData;

    use serde::de::{MapAccess, Visitor};
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub(super) fn serialize<S: Serializer, T: Serialize>(
        entries: &[(String, T)],
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        serializer.collect_map(entries.iter().map(|(name, value)| (name, value)))
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>, T: Deserialize<'de>>(
        deserializer: D,
    ) -> Result<Vec<(String, T)>, D::Error> {
        deserializer.deserialize_map(Entries(PhantomData))
    }

    struct Entries<T>(PhantomData<T>);

    impl<'de, T: Deserialize<'de>> Visitor<'de> for Entries<T> {
        type Value = Vec<(String, T)>;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("entries by name")
        }

        fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
            let mut entries = Vec::new();
            while let Some(entry) = map.next_entry()? {
                entries.push(entry);
            }
            Ok(entries)
        }
    }
}
