//! Comparison of a scan with its twins, statistic by statistic.

use crate::map::HeightMap;
use crate::stats::{quantile_sorted, sorted_present};
use crate::study::result::{CurveComparison, StatisticComparison, SurfaceStatistics, finite, pair};
use crate::study::surface_result::surface_statistics;
use crate::study::{StudyError, Table, sentence};
use crate::surface::preparation::Prepared;
use crate::surface::scanned::ScannedSurface;

use super::band::Scale::{Above, Linear, Share};
use super::band::{CHANCE_OUTSIDE, Scale, Spread};
use super::curve::{Curve, CurveKind};

type Reading = fn(&SurfaceStatistics) -> Option<f64>;

/// Scale of positive statistics.
const POSITIVE: Scale = Above(0.0);

/// Fraction of points inside the band below which a spectrum has a warning.
const FEW_INSIDE: f64 = 0.8;

/// Compared statistics; a kurtosis is at least 1.
const STATISTICS: [(&str, Scale, Reading); 24] = [
    ("Sa_m", POSITIVE, |s| Some(s.Sa_m)),
    ("Sq_m", POSITIVE, |s| Some(s.Sq_m)),
    ("Ssk", Linear, |s| s.Ssk),
    ("Sku", Above(1.0), |s| s.Sku),
    ("Sp_m", POSITIVE, |s| Some(s.Sp_m)),
    ("Sv_m", POSITIVE, |s| Some(s.Sv_m)),
    ("Sz_m", POSITIVE, |s| Some(s.Sz_m)),
    ("Sdq", POSITIVE, |s| s.Sdq),
    ("Sdq_7point", POSITIVE, |s| s.Sdq_7point),
    ("Sdr", POSITIVE, |s| s.Sdr),
    ("Sal_m", POSITIVE, |s| s.Sal_m),
    ("Str", Share, |s| s.Str),
    ("correlation_length_x_m", POSITIVE, |s| s.correlation_length_x_m),
    ("correlation_length_y_m", POSITIVE, |s| s.correlation_length_y_m),
    ("hurst", Share, |s| s.hurst),
    ("Sk_m", POSITIVE, |s| Some(s.Sk_m)),
    ("Spk_m", POSITIVE, |s| Some(s.Spk_m)),
    ("Svk_m", POSITIVE, |s| Some(s.Svk_m)),
    ("Smrk1", Share, |s| Some(s.Smrk1)),
    ("Smrk2", Share, |s| Some(s.Smrk2)),
    ("Vmp_m", POSITIVE, |s| Some(s.Vmp_m)),
    ("Vmc_m", POSITIVE, |s| Some(s.Vmc_m)),
    ("Vvc_m", POSITIVE, |s| Some(s.Vvc_m)),
    ("Vvv_m", POSITIVE, |s| Some(s.Vvv_m)),
];

/// Statistics and functions of the scan before its twins are drawn.
pub(super) struct Target {
    pub(super) statistics: SurfaceStatistics,
    pub(super) curves: Vec<Curve>,
}

/// Statistics and functions of one twin: values in the order of [`STATISTICS`], and at the abscissas of the target's
/// curves.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct TwinTraits {
    statistics: Vec<f64>,
    curves: Vec<Vec<f64>>,
}

impl Target {
    pub(super) fn new(measured: &ScannedSurface) -> Self {
        let curves = Curve::all(&measured.map, &measured.correlation);
        Self { statistics: surface_statistics(&measured.statistics), curves }
    }

    /// Measures a twin like the scan.
    pub(super) fn measure_twin(&self, twin: Prepared) -> Result<TwinTraits, StudyError> {
        let ScannedSurface { map, statistics, correlation, .. } = ScannedSurface::without_intervals(twin)?;
        let statistics = surface_statistics(&statistics);
        let statistics = STATISTICS.iter().map(|(_, _, read)| read(&statistics).unwrap_or(f64::NAN)).collect();
        let curves = self.curves.iter().map(|curve| curve.evaluate_on(&map, &correlation)).collect();
        Ok(TwinTraits { statistics, curves })
    }

    /// Compares every statistic of the scan with those of its twins.
    pub(super) fn compare_statistics(&self, twins: &[TwinTraits]) -> Vec<(String, StatisticComparison)> {
        let entries = STATISTICS.iter().enumerate().map(|(i, (name, scale, read))| {
            let spread = Spread::new(twins.iter().map(|twin| twin.statistics[i]), *scale);
            let target = read(&self.statistics).and_then(finite);
            let inside = target.zip(spread.band).map(|(value, band)| band.contains(value));
            let comparison = StatisticComparison {
                target,
                mean: finite(spread.mean),
                std: finite(spread.std),
                band: spread.band.map(pair),
                inside,
                defined: spread.defined,
            };
            ((*name).to_owned(), comparison)
        });
        entries.collect()
    }

    /// Compares every function of the scan with those of its twins; returns its table too, and a sentence about a spectrum that
    /// often lies outside of its band.
    pub(super) fn compare_curves(
        &self,
        twins: &[TwinTraits],
    ) -> Vec<(&'static str, CurveComparison, Table, Option<String>)> {
        let compare = |(i, curve): (usize, &Curve)| {
            let scale = if curve.kind.is_spectrum() { POSITIVE } else { Linear };
            let spreads: Vec<Spread> = (0..curve.x.len())
                .map(|place| Spread::new(twins.iter().map(|twin| twin.curves[i][place]), scale))
                .collect();
            // A density below zero is an artefact of a symmetric band.
            let least = if curve.kind.is_density() { 0.0 } else { f64::NEG_INFINITY };
            let low = spreads.iter().map(|s| s.band.map_or(f64::NAN, |band| band.low.max(least))).collect();
            let high = spreads.iter().map(|s| s.band.map_or(f64::NAN, |band| band.high)).collect();
            let compared: Vec<bool> = spreads
                .iter()
                .zip(&curve.y)
                // If all twins are equal, as at zero lag, there is nothing to compare.
                .filter(|(spread, value)| value.is_finite() && spread.std > 0.0)
                .filter_map(|(spread, value)| Some(spread.band?.contains(*value)))
                .collect();
            let (inside, points) = (compared.iter().filter(|inside| **inside).count(), compared.len());
            let comparison = CurveComparison { inside_share: finite(inside as f64 / points as f64), inside, points };
            let sentence = comparison.inside_share.filter(|share| curve.kind.is_spectrum() && *share < FEW_INSIDE);
            let sentence = sentence.map(|share| {
                let ratios = curve.y.iter().zip(&spreads).map(|(scan, twins)| scan / twins.mean);
                spectrum_sentence(curve.kind, share, ratios)
            });
            let unit = curve.kind.unit();
            let table = Table::new([
                (curve.kind.abscissa().to_owned(), curve.x.clone()),
                (format!("scan{unit}"), curve.y.clone()),
                (format!("twins_mean{unit}"), spreads.iter().map(|spread| spread.mean).collect()),
                (format!("twins_low{unit}"), low),
                (format!("twins_high{unit}"), high),
            ]);
            (curve.kind.name(), comparison, table, sentence)
        };
        self.curves.iter().enumerate().map(compare).collect()
    }
}

/// Returns the statistics of every twin, one row each.
pub(super) fn statistics_table(twins: &[TwinTraits]) -> Table {
    let number = ("twin", (1..=twins.len()).map(|number| number as f64).collect());
    let columns = STATISTICS.iter().enumerate().map(|(i, (name, _, _))| {
        let values = twins.iter().map(|twin| twin.statistics[i]).collect();
        (*name, values)
    });
    Table::new(std::iter::once(number).chain(columns))
}

/// Returns a sentence about the statistics outside their band; `None` if there are none.
pub(super) fn outside_sentence(twins: &[(String, StatisticComparison)]) -> Option<String> {
    let compared = twins.iter().filter(|(_, statistic)| statistic.inside.is_some()).count();
    let outside: Vec<String> = twins
        .iter()
        .filter(|(_, statistic)| statistic.inside == Some(false))
        .map(|(name, statistic)| {
            let (label, is_length) = name.strip_suffix("_m").map_or((name.as_str(), false), |label| (label, true));
            let shown = |value: f64| if is_length { sentence::si(value, "m") } else { sentence::digits(value) };
            let [low, high] = statistic.band.unwrap_or([f64::NAN; 2]).map(shown);
            let target = shown(statistic.target.unwrap_or(f64::NAN));
            format!("{} ({target}, twins {low} to {high})", label.replace('_', " "))
        })
        .collect();
    (!outside.is_empty()).then(|| {
        format!(
            "{} of {} of the scan {} outside of the 95 % band of its twins (about {} expected by chance): {}",
            outside.len(),
            sentence::count(compared, "statistic", "statistics"),
            if outside.len() == 1 { "lies" } else { "lie" },
            sentence::digits((CHANCE_OUTSIDE * compared as f64 * 10.0).round() / 10.0),
            outside.join(", ")
        )
    })
}

/// Returns a sentence about a spectrum with a `share` of points inside the band, given the ratios of the scan and the mean of its
/// twins.
fn spectrum_sentence(kind: CurveKind, share: f64, ratios: impl Iterator<Item = f64>) -> String {
    let ratios = sorted_present(ratios.filter(|ratio| ratio.is_finite()));
    let [low, middle, high] = [0.1, 0.5, 0.9].map(|p| sentence::significant(quantile_sorted(&ratios, p), 2));
    format!(
        "the {} of the scan lies in the 95 % band of its twins at only {} % of the wavenumbers: it is {middle} times the mean of \
         the twins, from {low} to {high} times at 80 % of the wavenumbers",
        kind.label(),
        sentence::significant(100.0 * share, 2),
    )
}

/// Returns a twin with the scan's missing points.
pub(super) fn masked(twin: &HeightMap, scan: &HeightMap) -> Result<HeightMap, StudyError> {
    let mut heights = twin.heights_m().clone();
    heights.zip_mut_with(scan.heights_m(), |z, measured| *z = if measured.is_nan() { f64::NAN } else { *z });
    HeightMap::new(twin.grid(), heights).map_err(|error| StudyError::Map { file: "a twin".into(), error })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correlation::Axis;

    #[test]
    fn a_sentence_names_a_spectrum_outside_its_band_and_by_how_much() {
        let ratios = (0..=10).map(|i| 0.5 + 0.1 * f64::from(i));
        assert_eq!(
            spectrum_sentence(CurveKind::Spectrum(Axis::X), 0.27, ratios.chain([f64::NAN])),
            "the power spectrum along x of the scan lies in the 95 % band of its twins at only 27 % of the wavenumbers: it is 1 times \
             the mean of the twins, from 0.6 to 1.4 times at 80 % of the wavenumbers"
        );
    }

    #[test]
    fn a_sentence_names_outliers_and_the_number_expected_by_chance() {
        let statistic = |inside| StatisticComparison {
            target: Some(0.3),
            mean: Some(0.1),
            std: Some(0.05),
            band: Some([0.0, 0.2]),
            inside,
            defined: 8,
        };
        let mut all: Vec<_> = ["Sq_m", "Sdq", "Str"].map(|name| (name.to_owned(), statistic(Some(true)))).into();
        assert_eq!(outside_sentence(&all), None);
        (all[0].1, all[1].1) = (statistic(Some(false)), statistic(Some(false)));
        assert_eq!(
            outside_sentence(&all).unwrap(),
            "2 of 3 statistics of the scan lie outside of the 95 % band of its twins (about 0.2 expected by chance): \
             Sq (300 mm, twins 0 m to 200 mm), Sdq (0.3, twins 0 to 0.2)"
        );
    }
}
