//! The parameters of a measured surface, in groups, and the distributions fitted to its heights.

use asperity_results::{Answer, LabelledField, MeasuredSurface, SurfaceResult, SurfaceStatistics, Table};

use crate::Run;
use crate::cells::DASH;
use crate::fits::{HeightFit, height_fits};
use crate::format::{Dimension, significant};
use crate::page::answer_table::{cell, entries, shown};
use crate::page::data_table::DataTable;
use crate::words::in_words;

/// Groups of parameters, each with its first one, in the order of the fields.
const GROUPS: [(&str, &str); 7] = [
    ("nx", "Map"),
    ("Sa_m", "Height"),
    ("Sdq", "Hybrid"),
    ("Sal_m", "Spatial"),
    ("Sk_m", "Functional, core by the least-squares line (ISO 25178-2)"),
    ("Vmp_m", "Volume"),
    ("psd_reliable_low_rad_per_m", "Spectrum and correlation"),
];

/// Returns the place of a surface parameter among the fields, its symbol, and its meaning, by its key.
pub(crate) fn parameter(key: &str) -> Option<(usize, String, String)> {
    let found = SurfaceStatistics::fields().into_iter().enumerate().find(|(_, field)| field.key == key);
    found.map(|(place, field)| (place, symbol(key).to_owned(), field.label))
}

/// Returns the symbol of a parameter, that of ISO 25178 from its key; empty for numbers without one.
fn symbol(key: &str) -> &str {
    match key {
        "Sdq_7point" => "Sdq (7 points)",
        "correlation_length_x_m" => "ℓx",
        "correlation_length_y_m" => "ℓy",
        "hurst" => "H",
        "fractal_dimension" => "D",
        "form_radius_m" => "R",
        _ => key.split('_').next().filter(|name| name.starts_with(char::is_uppercase)).unwrap_or_default(),
    }
}

/// Returns a parameter with its unit and its interval; `None` where undefined.
pub(super) fn value(measured: &MeasuredSurface, key: &str) -> Option<String> {
    let fields = SurfaceStatistics::fields();
    let entry = entries(&fields).find(|entry| entry.key == key)?;
    Some(cell(entry, &measured.json())).filter(|cell| cell != DASH)
}

/// Returns the groups of parameters in the results: meaning, value with its interval, and of a part the standard deviations.
pub(super) fn table(measured: &MeasuredSurface) -> DataTable {
    let (values, fields) = (measured.json(), SurfaceStatistics::fields());
    let mut rows = Vec::new();
    // `results.json` also has the family of Sk by the flattest secant.
    for entry in entries(&fields).filter(|entry| !entry.key.contains("_secant")) {
        let LabelledField { key, label, .. } = entry;
        rows.extend(GROUPS.iter().find(|(first, _)| first == key).map(|(_, title)| vec![(*title).to_owned()]));
        let std = |ending: &str| shown(key, &values[format!("{key}{ending}")], None, None);
        let row =
            [label.clone(), symbol(key).to_owned(), cell(entry, &values), std("_within_std"), std("_between_std")];
        rows.extend((row[2] != DASH).then(|| Vec::from(row)));
    }
    let caption = match measured {
        MeasuredSurface::Part(part) => format!("Surface parameters of the part from {} scans", part.scan_count),
        _ => "Surface parameters".to_owned(),
    };
    let headers = ["Parameter", "Symbol", "Value, 95 % interval", "Std of one scan", "Std between scans"];
    DataTable::new(&caption, &headers, rows).without_empty_columns()
}

/// Returns every scan of a part with its most important parameters.
pub(super) fn scans(surface: &SurfaceResult) -> Option<DataTable> {
    const KEYS: [&str; 7] = ["file", "Sq_m", "Ssk", "Sku", "Sdq", "correlation_length_x_m", "correlation_length_y_m"];
    Some(DataTable::listed("Scans of the part", &surface.part()?.scans, |key| KEYS.contains(&key)))
}

/// Returns the distributions fitted to the heights, best first.
pub(super) fn distributions(run: &Run) -> Option<DataTable> {
    let table: &Table = run.tables.get("height_fits")?;
    let cell = |value: f64, digits| significant(value, digits);
    let rows = height_fits(table)
        .iter()
        .map(|fit| {
            vec![
                fit.rank.to_string(),
                in_words(fit.distribution),
                parameters_of(fit),
                cell(fit.delta_aic, 3),
                cell(fit.weight, 2),
                cell(fit.distance, 2),
                cell(fit.p_value, 2),
            ]
        })
        .collect();
    let size = table.defined_column("effective_heights").and_then(|values| values.first()).filter(|n| n.is_finite());
    let size = size.map_or(String::new(), |n| {
        format!("; effective sample size of the correlated heights: {}", significant(*n, 2))
    });
    // The figures and this table show the first of several scans.
    let first = run.results.surface.as_ref().and_then(SurfaceResult::part).and_then(|part| part.scans.first());
    let of = first.map_or(String::new(), |scan| format!(" of {}", scan.file));
    let caption = format!("Distributions fitted to the heights{of}, ranked by Akaike’s criterion{size}");
    let headers = ["Rank", "Distribution", "Parameters", "ΔAIC", "Weight", "KS distance", "p (KS)"];
    Some(DataTable::new(&caption, &headers, rows).without_empty_columns())
}

/// Formats the parameters with the symbols of the literature.
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
    use asperity_results::{Companions, Pair, PartStatistics, PooledResult, ScanOfPart, SpreadResult};

    #[test]
    fn groups_begin_with_a_parameter_in_the_order_of_the_fields() {
        let places: Vec<usize> = GROUPS.iter().map(|(first, _)| parameter(first).unwrap().0).collect();
        assert!(places.is_sorted() && places[0] == 0, "{places:?}");
        let sq = parameter("Sq_m").map(|(_, symbol, meaning)| (symbol, meaning));
        assert_eq!(sq, Some(("Sq".to_owned(), "Root mean square height".to_owned())));
        assert_eq!(["nx", "hurst", "Sk_secant_m"].map(symbol), ["", "H", "Sk"]);
    }

    fn scan(sq_m: f64, ssk: Option<f64>, interval: Option<Pair>) -> SurfaceStatistics {
        let spread = interval.map(|interval| SpreadResult { interval, standard_error: 2e-8 });
        let intervals = Companions(vec![("Sq_m".into(), spread), ("Ssk".into(), None)]);
        SurfaceStatistics { nx: 4, Sq_m: sq_m, Ssk: ssk, intervals, ..SurfaceStatistics::default() }
    }

    #[test]
    fn groups_precede_their_parameters_and_intervals_are_beside_them() {
        let measured = scan(1.0234e-6, Some(0.5), Some([9.9e-7, 1.06e-6]));
        let found = table(&MeasuredSurface::Scan(Box::new(measured)));
        let spaced: Vec<Vec<String>> =
            found.rows.iter().map(|row| row.iter().map(|cell| cell.replace('\u{a0}', " ")).collect()).collect();
        let row = |symbol: &str| spaced.iter().find(|row| row.get(1).is_some_and(|own| own == symbol)).unwrap();
        assert_eq!(row("Sq")[2], "1.023 µm [0.990, 1.060]");
        assert_eq!(row("Ssk")[2], "0.5");
        let height = spaced.iter().position(|row| row == &["Height"]).unwrap();
        assert_eq!((spaced[0].as_slice(), spaced[height + 1][1].as_str()), (&["Map".to_owned()][..], "Sa"));
        assert!(spaced.iter().all(|row| row[0] != "Kurtosis of the heights, 3 for a normal distribution"));
        // A scan has no standard deviations between scans.
        assert_eq!(found.headers.len(), 3);
    }

    #[test]
    fn a_part_has_standard_deviations_between_scans_and_a_row_for_each_scan() {
        let pooled = PooledResult {
            value: 1.1e-6,
            interval: [0.9e-6, 1.3e-6],
            standard_error: 1e-7,
            within_std: Some(2e-8),
            between_std: Some(1.2e-7),
        };
        let scans = [("a.x3p", 1e-6), ("b.x3p", 1.2e-6)];
        let scans = scans.map(|(file, sq_m)| ScanOfPart { file: file.into(), statistics: scan(sq_m, None, None) });
        let part = PartStatistics {
            scan_count: 2,
            pooled: Companions(vec![("Sq_m".into(), Some(pooled))]),
            scans: scans.into(),
            ..PartStatistics::default()
        };
        let measured = MeasuredSurface::Part(Box::new(part));
        let table = table(&measured);
        assert!(table.caption.ends_with("from 2 scans") && table.headers.len() == 5, "{:?}", table.headers);
        let row = table.rows.iter().find(|row| row[0] == "Root mean square height").unwrap();
        let cells = row[3..].iter().map(|cell| cell.replace('\u{a0}', " ")).collect::<Vec<_>>();
        assert_eq!(cells, ["20 nm", "120 nm"]);
        let found = scans_of(measured).unwrap();
        assert_eq!(found.rows.len(), 2);
        assert_eq!((found.rows[1][0].as_str(), found.rows[1][1].as_str()), ("b.x3p", "1.2\u{a0}µm"));
        assert!(scans_of(MeasuredSurface::Stated {}).is_none());
    }

    fn scans_of(measured: MeasuredSurface) -> Option<DataTable> {
        scans(&SurfaceResult { measured, ..SurfaceResult::default() })
    }
}
