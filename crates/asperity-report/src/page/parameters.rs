//! The parameters of a measured surface, in groups, and the laws of its heights.

use serde_json::Value;

use super::DataTable;
use super::json::{interval, plain};
use crate::fits::{HeightFit, height_fits};
use crate::format::{Dimension, significant};
use crate::{Run, Table};

/// Key, symbol and meaning of a parameter.
type Parameter = (&'static str, &'static str, &'static str);

/// Surface parameters by group, in the order of the table.
const GROUPS: [(&str, &[Parameter]); 9] = [
    (
        "Height",
        &[
            ("Sa_m", "Sa", "arithmetic mean height"),
            ("Sq_m", "Sq", "root mean square height"),
            ("Ssk", "Ssk", "skewness of heights"),
            ("Sku", "Sku", "kurtosis of heights (normal: 3)"),
            ("Sp_m", "Sp", "highest peak"),
            ("Sv_m", "Sv", "deepest pit"),
            ("Sz_m", "Sz", "maximum height, Sp + Sv"),
        ],
    ),
    (
        "Spatial",
        &[
            ("Sal_m", "Sal", "autocorrelation length, shortest distance to 0.2"),
            ("Str", "Str", "texture aspect ratio (1: no lay, 0: a lay)"),
            ("Std_rad", "Std", "direction of the lay, anticlockwise from x; of meaning where Str is small"),
            ("Ssw_m", "Ssw", "dominant wavelength"),
            ("correlation_length_x_m", "ℓx", "correlation length along x, to 1/e"),
            ("correlation_length_y_m", "ℓy", "correlation length along y, to 1/e"),
        ],
    ),
    (
        "Hybrid",
        &[
            ("Sdq", "Sdq", "root mean square slope, forward differences"),
            ("Sdq_7point", "Sdq", "root mean square slope, seven-point differences"),
            ("Sdr", "Sdr", "developed interfacial area ratio"),
        ],
    ),
    (
        "Functional, core by the least-squares line (ISO 25178-2)",
        &[
            ("Sk_m", "Sk", "core height"),
            ("Spk_m", "Spk", "reduced peak height"),
            ("Svk_m", "Svk", "reduced dale height"),
            ("Smrk1", "Smrk1", "material ratio of the peaks"),
            ("Smrk2", "Smrk2", "material ratio of the dales"),
            ("Spkx_m", "Spkx", "peak height above the core"),
            ("Svkx_m", "Svkx", "dale depth below the core"),
            ("Sxp_m", "Sxp", "peak extreme height, material ratios 2.5 % to 50 %"),
        ],
    ),
    (
        "Functional, core by the flattest secant",
        &[
            ("Sk_secant_m", "Sk", "core height by the secant"),
            ("Spk_secant_m", "Spk", "reduced peak height by the secant"),
            ("Svk_secant_m", "Svk", "reduced dale height by the secant"),
            ("Smrk1_secant", "Smrk1", "material ratio of the peaks by the secant"),
            ("Smrk2_secant", "Smrk2", "material ratio of the dales by the secant"),
        ],
    ),
    (
        "Volume",
        &[
            ("Vmp_m", "Vmp", "peak material volume per area"),
            ("Vmc_m", "Vmc", "core material volume per area"),
            ("Vvc_m", "Vvc", "core void volume per area"),
            ("Vvv_m", "Vvv", "dale void volume per area"),
        ],
    ),
    (
        "Spectral",
        &[
            ("psd_reliable_low_rad_per_m", "q", "spectrum reliable from (wavelength)"),
            ("psd_reliable_high_rad_per_m", "q", "spectrum reliable to (wavelength)"),
            ("psd_upper_limit", "", "what ends the reliable spectrum"),
            ("hurst", "H", "Hurst exponent"),
            ("hurst_range_low_m", "τ", "shortest lag of its fit"),
            ("hurst_range_high_m", "τ", "longest lag of its fit"),
            ("fractal_dimension", "D", "fractal dimension, 3 − H"),
        ],
    ),
    (
        "Map",
        &[
            ("nx", "nx", "points along x"),
            ("ny", "ny", "points along y"),
            ("dx_m", "Δx", "pixel size along x"),
            ("dy_m", "Δy", "pixel size along y"),
            ("missing_points", "", "missing points, rejected outliers included"),
            ("missing_fraction", "", "share of missing points"),
            ("outliers", "", "points rejected as outliers"),
        ],
    ),
    ("Form", &[("form_radius_m", "R", "radius of the cylinder or sphere that was removed")]),
];

/// All parameters in the order of the table.
fn all() -> impl Iterator<Item = &'static Parameter> {
    GROUPS.iter().flat_map(|(_, parameters)| parameters.iter())
}

/// Place of a surface parameter in its table, its symbol and its meaning, by its key.
pub(crate) fn parameter(key: &str) -> Option<(usize, &'static str, &'static str)> {
    all()
        .enumerate()
        .find(|(_, (own, _, _))| *own == key)
        .map(|(place, (_, symbol, meaning))| (place, *symbol, *meaning))
}

/// Whether a key of the results is a parameter's, or that of its standard error, interval or scatter, or is of the scans.
pub(super) fn belongs(key: &str) -> bool {
    let own = |key: &str| parameter(key).is_some();
    let companions = ["_se", "_interval", "_within_std", "_between_std"];
    matches!(key, "scans" | "scan_count")
        || own(key)
        || companions.iter().any(|suffix| key.strip_suffix(suffix).is_some_and(own))
}

/// The groups of parameters that the results hold: meaning, symbol, value and interval.
pub(super) fn table(surface: &Value) -> DataTable {
    let mut rows = Vec::new();
    for (title, parameters) in GROUPS {
        let present: Vec<&Parameter> = parameters.iter().filter(|(key, _, _)| !surface[*key].is_null()).collect();
        if present.is_empty() {
            continue;
        }
        rows.push(vec![title.to_owned()]);
        rows.extend(present.into_iter().map(|(key, symbol, meaning)| {
            let (value, interval) = shown(surface, key);
            let std = |of: &str| spread(&surface[&format!("{key}_{of}_std")], key);
            vec![(*meaning).to_owned(), (*symbol).to_owned(), value, interval, std("within"), std("between")]
        }));
    }
    let caption = match surface["scan_count"].as_u64() {
        Some(count) => format!("Surface parameters of the part from {count} scans"),
        None => "Surface parameters".to_owned(),
    };
    let headers = ["Parameter", "Symbol", "Value", "95 % interval", "Std of one scan", "Std between scans"];
    DataTable::new(&caption, &headers, rows, "results.json").without_empty_columns()
}

/// A standard deviation of a parameter in its unit, or a dash.
fn spread(value: &Value, key: &str) -> String {
    value.as_f64().map_or_else(|| "–".into(), |value| Dimension::of_key(key).1.show_short(value))
}

/// Every scan of a part with the parameters that are asked for first.
pub(super) fn scans(surface: &Value) -> Option<DataTable> {
    const KEYS: [(&str, &str); 6] = [
        ("Sq_m", "Sq"),
        ("Ssk", "Ssk"),
        ("Sku", "Sku"),
        ("Sdq", "Sdq"),
        ("correlation_length_x_m", "ℓx"),
        ("correlation_length_y_m", "ℓy"),
    ];
    let rows = surface["scans"].as_array()?.iter().map(|scan| {
        let file = scan["file"].as_str().unwrap_or("–").to_owned();
        std::iter::once(file).chain(KEYS.iter().map(|(key, _)| shown(scan, key).0)).collect()
    });
    let headers: Vec<&str> = std::iter::once("Scan").chain(KEYS.iter().map(|(_, symbol)| *symbol)).collect();
    Some(DataTable::new("Scans of the part", &headers, rows.collect(), "results.json"))
}

/// A parameter's value and interval, or dashes: three digits, more where the interval is narrower.
fn shown(surface: &Value, key: &str) -> (String, String) {
    let none = || "–".to_owned();
    let Some(value) = surface[key].as_f64().filter(|_| surface[key].is_f64()) else {
        return (plain(&surface[key]).replace('_', " "), none());
    };
    let dimension = Dimension::of_key(key).1;
    let standard_error = surface[&format!("{key}_se")].as_f64();
    let (text, limits) = match (interval(surface, key), standard_error) {
        (Some(limits), _) => dimension.show_apart(value, limits),
        (None, Some(error)) => (dimension.show_short(value), format!("s.e. {}", dimension.show_short(error))),
        // The pixels are known, not estimated.
        (None, None) if matches!(key, "dx_m" | "dy_m") => (dimension.show(value), none()),
        (None, None) => (dimension.show_short(value), none()),
    };
    match dimension {
        // A wavenumber says little to the eye.
        Dimension::Wavenumber if value > 0.0 => {
            let wavelength = Dimension::Length.show_short(std::f64::consts::TAU / value);
            (format!("{text} ({wavelength})"), limits)
        }
        _ => (text, limits),
    }
}

/// The laws fitted to the heights, best first.
pub(super) fn laws(run: &Run) -> Option<DataTable> {
    let table: &Table = run.tables.get("height_fits")?;
    let cell = |value: f64, digits| significant(value, digits);
    let rows = height_fits(table)
        .iter()
        .map(|fit| {
            vec![
                fit.rank.to_string(),
                fit.name().to_owned(),
                parameters_of(fit),
                cell(fit.delta_aic, 3),
                cell(fit.weight, 2),
                cell(fit.distance, 2),
                cell(fit.p_value, 2),
            ]
        })
        .collect();
    let worth = table.column("effective_heights").and_then(|values| values.first()).filter(|n| n.is_finite());
    let worth = worth.map_or(String::new(), |n| {
        format!("; the correlated heights are worth {} independent ones", significant(*n, 2))
    });
    // Of several scans the figures and this table show the first.
    let of = run.results["surface"]["scans"][0]["file"].as_str().map_or(String::new(), |file| format!(" of {file}"));
    let caption = format!("Laws fitted to the heights{of}, ranked by Akaike’s criterion{worth}");
    let headers = ["Rank", "Law", "Parameters", "ΔAIC", "Weight", "KS distance", "p (KS)"];
    Some(DataTable::new(&caption, &headers, rows, "tables/height_fits.csv").without_empty_columns())
}

/// Parameters with the symbols of the literature.
fn parameters_of(fit: &HeightFit) -> String {
    let symbol = |name: &str| match name {
        "mu" => "µ",
        "sigma" => "σ",
        "gamma" => "γ",
        "delta" => "δ",
        "xi" => "ξ",
        "lambda" => "λ",
        _ => "",
    };
    let shown = fit.parameters.iter().map(|(key, value)| {
        let (name, dimension) = Dimension::of_key(key);
        let name = if symbol(name).is_empty() { name } else { symbol(name) };
        format!("{name} = {}", dimension.show_short(*value)).replace(' ', "\u{a0}")
    });
    shown.collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn every_parameter_is_listed_once() {
        let mut keys: Vec<&str> = all().map(|(key, _, _)| *key).collect();
        let count = keys.len();
        keys.sort_unstable();
        keys.dedup();
        assert_eq!(keys.len(), count);
        assert_eq!(parameter("Sa_m").map(|p| p.0), Some(0));
        assert!(belongs("Sq_m_interval") && belongs("Sq_m_se") && !belongs("covariance"));
        assert!(belongs("Sq_m_within_std") && belongs("scans"));
    }

    #[test]
    fn groups_stand_above_their_parameters_and_intervals_beside_them() {
        let surface =
            json!({"Sq_m": 1.0234e-6, "Sq_m_interval": [9.9e-7, 1.06e-6], "Ssk": 0.5, "Ssk_interval": null, "nx": 4});
        let table = table(&surface);
        let spaced: Vec<Vec<String>> =
            table.rows.iter().map(|row| row.iter().map(|cell| cell.replace('\u{a0}', " ")).collect()).collect();
        assert_eq!(spaced[0], ["Height"]);
        assert_eq!(spaced[1], ["root mean square height", "Sq", "1.023 µm", "[0.990, 1.060]"].map(|t| t.to_owned()));
        assert_eq!(spaced[2][2..], ["0.5".to_owned(), "–".to_owned()]);
        assert_eq!(spaced[3], ["Map"]);
        // Without any interval there is no column for them.
        assert_eq!(super::table(&json!({"Ssk": 0.5})).headers.len(), 3);
    }

    #[test]
    fn a_part_of_several_scans_has_their_scatter_and_a_row_for_each() {
        let scan = |file: &str, sq_m: f64| json!({"file": file, "Sq_m": sq_m, "Ssk": null});
        let surface = json!({
            "scan_count": 2, "Sq_m": 1.1e-6, "Sq_m_interval": [0.9e-6, 1.3e-6], "Sq_m_se": 1e-7,
            "Sq_m_within_std": 2e-8, "Sq_m_between_std": 1.2e-7, "scans": [scan("a.x3p", 1e-6), scan("b.x3p", 1.2e-6)],
        });
        let table = table(&surface);
        assert!(table.caption.ends_with("from 2 scans") && table.headers.len() == 6, "{:?}", table.headers);
        let cells = table.rows[1][4..].iter().map(|cell| cell.replace('\u{a0}', " ")).collect::<Vec<_>>();
        assert_eq!(cells, ["20 nm", "120 nm"]);
        let scans = scans(&surface).unwrap();
        assert_eq!(scans.rows.len(), 2);
        assert_eq!((scans.rows[1][0].as_str(), scans.rows[1][2].as_str()), ("b.x3p", "–"));
        assert!(super::scans(&json!({"Sq_m": 1e-6})).is_none());
    }
}
