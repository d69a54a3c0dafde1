//! The laws fitted to heights, read from the table `height_fits`.

use crate::Table;

/// Laws as columns name them, and as a reader does.
const LAWS: [(&str, &str); 9] = [
    ("johnson_su", "Johnson SU"),
    ("johnson_sb", "Johnson SB"),
    ("johnson_sl", "Johnson SL"),
    ("johnson_sn", "Johnson SN"),
    ("lognormal", "Lognormal"),
    ("weibull", "Weibull"),
    ("gamma", "Gamma"),
    ("normal", "Normal"),
    ("beta", "Beta"),
];

/// A row of the table.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct HeightFit {
    pub(crate) rank: usize,
    /// The law as columns name it.
    pub(crate) law: &'static str,
    /// Names of the parameters with their unit suffixes, and values in SI.
    pub(crate) parameters: Vec<(String, f64)>,
    pub(crate) delta_aic: f64,
    pub(crate) weight: f64,
    pub(crate) distance: f64,
    pub(crate) p_value: f64,
}

impl HeightFit {
    /// The law as a reader calls it.
    pub(crate) fn name(&self) -> &'static str {
        LAWS.iter().find(|(law, _)| *law == self.law).map_or(self.law, |(_, name)| name)
    }
}

/// The rows whose law is known, best first: that whose parameters are there.
pub(crate) fn height_fits(table: &Table) -> Vec<HeightFit> {
    let rows = table.columns.first().map_or(0, |(_, values)| values.len());
    let fits = (0..rows).filter_map(|row| {
        let parameters = |law: &str| -> Vec<(String, f64)> {
            let own = |(name, values): &(String, Vec<f64>)| {
                let name = name.strip_prefix(law)?.strip_prefix('_')?;
                Some((name.to_owned(), values.get(row).copied().filter(|value| value.is_finite())?))
            };
            table.columns.iter().filter_map(own).collect()
        };
        let (law, parameters) =
            LAWS.iter().map(|(law, _)| (*law, parameters(law))).find(|(_, parameters)| !parameters.is_empty())?;
        let cell = |name: &str| table.column(name).and_then(|values| values.get(row)).copied().unwrap_or(f64::NAN);
        Some(HeightFit {
            rank: row + 1,
            law,
            parameters,
            delta_aic: cell("delta_aic"),
            weight: cell("akaike_weight"),
            distance: cell("ks_distance"),
            p_value: cell("ks_p_value"),
        })
    });
    fits.collect()
}
