//! Distributions fitted to heights, read from the table `height_fits`.

use asperity_results::Table;

/// Distributions by their name in columns.
const DISTRIBUTIONS: [&str; 9] =
    ["johnson_su", "johnson_sb", "johnson_sl", "johnson_sn", "lognormal", "weibull", "gamma", "normal", "beta"];

/// A fitted distribution: a row of the table.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct HeightFit {
    pub(crate) rank: usize,
    /// Name of the distribution in columns.
    pub(crate) distribution: &'static str,
    /// Names of the parameters with their unit suffixes, and values in SI.
    pub(crate) parameters: Vec<(String, f64)>,
    pub(crate) delta_aic: f64,
    pub(crate) weight: f64,
    pub(crate) distance: f64,
    pub(crate) p_value: f64,
}

/// Returns the rows of known distributions, best first. The columns with parameters identify the distribution of a row.
pub(crate) fn height_fits(table: &Table) -> Vec<HeightFit> {
    let rows = table.columns().first().map_or(0, |(_, values)| values.len());
    let fits = (0..rows).filter_map(|row| {
        let parameters = |distribution: &str| -> Vec<(String, f64)> {
            let own = |(name, values): &(String, Vec<f64>)| {
                let name = name.strip_prefix(distribution)?.strip_prefix('_')?;
                Some((name.to_owned(), values.get(row).copied().filter(|value| value.is_finite())?))
            };
            table.columns().iter().filter_map(own).collect()
        };
        let mut known = DISTRIBUTIONS.into_iter().map(|distribution| (distribution, parameters(distribution)));
        let (distribution, parameters) = known.find(|(_, parameters)| !parameters.is_empty())?;
        let cell =
            |name: &str| table.defined_column(name).and_then(|values| values.get(row)).copied().unwrap_or(f64::NAN);
        Some(HeightFit {
            rank: row + 1,
            distribution,
            parameters,
            delta_aic: cell("delta_aic"),
            weight: cell("akaike_weight"),
            distance: cell("ks_distance"),
            p_value: cell("ks_p_value"),
        })
    });
    fits.collect()
}
