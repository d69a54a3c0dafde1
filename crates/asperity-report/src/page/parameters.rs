//! The parameters of a measured surface, in groups, and the distributions fitted to its heights.

use asperity_results::{MeasuredSurface, Pair, PartStatistics, SurfaceResult, SurfaceStatistics, Table};

use crate::Run;
use crate::cells::DASH;
use crate::fits::{HeightFit, height_fits};
use crate::format::{Dimension, significant};
use crate::page::data_table::DataTable;
use crate::run::RESULTS;
use crate::words::in_words;

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
            ("Std_rad", "Std", "direction of the lay, anticlockwise from x; meaningful if Str is small"),
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
            ("psd_upper_limit", "", "limit of the reliable spectrum"),
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
            ("outliers", "", "points rejected as outliers"),
        ],
    ),
    ("Form", &[("form_radius_m", "R", "radius of the cylinder or sphere that was removed")]),
];

/// Returns all parameters in the order of the table.
fn all() -> impl Iterator<Item = &'static Parameter> {
    GROUPS.iter().flat_map(|(_, parameters)| parameters.iter())
}

/// Returns the place of a surface parameter in its table, its symbol and its meaning, by its key.
pub(crate) fn parameter(key: &str) -> Option<(usize, &'static str, &'static str)> {
    all()
        .enumerate()
        .find(|(_, (own, _, _))| *own == key)
        .map(|(place, (_, symbol, meaning))| (place, *symbol, *meaning))
}

/// The cells of a parameter of a scan or of a part.
struct Known {
    value: String,
    interval: String,
    /// Standard deviations of one scan and between scans.
    stds: [String; 2],
}

impl Known {
    fn new(measured: &MeasuredSurface, key: &str) -> Option<Self> {
        match measured {
            MeasuredSurface::Stated {} => None,
            MeasuredSurface::Scan(scan) => Self::of_scan(scan, key),
            MeasuredSurface::Part(part) => Self::of_part(part, key),
        }
    }

    fn of_scan(scan: &SurfaceStatistics, key: &str) -> Option<Self> {
        let counts = [Some(scan.nx), Some(scan.ny), Some(scan.missing_points), Some(scan.outliers)];
        Self::of_text(counts, &scan.psd_upper_limit, key).or_else(|| {
            let spread = scan.intervals.get(key);
            let error = if key == "hurst" { scan.hurst_se } else { spread.map(|spread| spread.standard_error) };
            Some(Self::of_number(key, scan.number(key)?, spread.map(|spread| spread.interval), error, [None; 2]))
        })
    }

    fn of_part(part: &PartStatistics, key: &str) -> Option<Self> {
        let counts = [part.nx, part.ny, Some(part.missing_points), Some(part.outliers)];
        let pooled = part.pooled.get(key);
        Self::of_text(counts, &part.psd_upper_limit, key).or_else(|| {
            let value = match key {
                "dx_m" => part.dx_m,
                "dy_m" => part.dy_m,
                "psd_reliable_low_rad_per_m" => Some(part.psd_reliable_low_rad_per_m),
                "psd_reliable_high_rad_per_m" => Some(part.psd_reliable_high_rad_per_m),
                "hurst_range_low_m" => part.hurst_range_low_m,
                "hurst_range_high_m" => part.hurst_range_high_m,
                _ => pooled.map(|pooled| pooled.value),
            };
            let error = pooled.map(|pooled| pooled.standard_error);
            let stds = pooled.map_or([None; 2], |pooled| [pooled.within_std, pooled.between_std]);
            Some(Self::of_number(key, value?, pooled.map(|pooled| pooled.interval), error, stds))
        })
    }

    /// Formats a count or a word.
    fn of_text(counts: [Option<usize>; 4], psd_upper_limit: &str, key: &str) -> Option<Self> {
        const COUNTS: [&str; 4] = ["nx", "ny", "missing_points", "outliers"];
        let word = (key == "psd_upper_limit").then(|| psd_upper_limit.replace('_', " "));
        let place = COUNTS.iter().position(|count| *count == key);
        let value = word.or_else(|| counts[place?].map(|count| count.to_string()))?;
        Some(Self { value, interval: DASH.into(), stds: [DASH, DASH].map(str::to_owned) })
    }

    /// Formats value and interval with three digits, and more if the interval is narrower, and the standard deviations.
    fn of_number(
        key: &str,
        value: f64,
        interval: Option<Pair>,
        standard_error: Option<f64>,
        stds: [Option<f64>; 2],
    ) -> Self {
        let dimension = Dimension::of_key(key).1;
        let (mut text, interval) = match (interval, standard_error) {
            (Some(limits), _) => dimension.show_apart(value, limits.into()),
            (None, Some(error)) => (dimension.show_short(value), format!("s.e. {}", dimension.show_short(error))),
            // Pixel sizes are exact.
            (None, None) if matches!(key, "dx_m" | "dy_m") => (dimension.show(value), DASH.into()),
            (None, None) => (dimension.show_short(value), DASH.into()),
        };
        // A wavelength is easier to judge than a wavenumber.
        if dimension == Dimension::Wavenumber && value > 0.0 {
            text += &format!(" ({})", Dimension::Length.show_short(std::f64::consts::TAU / value));
        }
        let stds = stds.map(|std| std.map_or_else(|| DASH.into(), |std| dimension.show_short(std)));
        Self { value: text, interval, stds }
    }
}

/// Returns a parameter with its unit and its interval.
pub(super) fn value(measured: &MeasuredSurface, key: &str) -> Option<String> {
    let Known { value, interval, .. } = Known::new(measured, key)?;
    Some(if interval == DASH { value } else { format!("{value} {interval}") })
}

/// Returns the groups of parameters in the results: meaning, symbol, value and interval.
pub(super) fn table(measured: &MeasuredSurface) -> DataTable {
    let mut rows = Vec::new();
    for (title, parameters) in GROUPS {
        let present = parameters.iter().filter_map(|(key, symbol, meaning)| {
            let Known { value, interval, stds: [within, between] } = Known::new(measured, key)?;
            Some(vec![(*meaning).to_owned(), (*symbol).to_owned(), value, interval, within, between])
        });
        let present: Vec<_> = present.collect();
        if !present.is_empty() {
            rows.push(vec![title.to_owned()]);
            rows.extend(present);
        }
    }
    let caption = match measured {
        MeasuredSurface::Part(part) => format!("Surface parameters of the part from {} scans", part.scan_count),
        _ => "Surface parameters".to_owned(),
    };
    let headers = ["Parameter", "Symbol", "Value", "95 % interval", "Std of one scan", "Std between scans"];
    DataTable::new(&caption, &headers, rows, RESULTS).without_empty_columns()
}

/// Returns every scan of a part with its most important parameters.
pub(super) fn scans(surface: &SurfaceResult) -> Option<DataTable> {
    const KEYS: [(&str, &str); 6] = [
        ("Sq_m", "Sq"),
        ("Ssk", "Ssk"),
        ("Sku", "Sku"),
        ("Sdq", "Sdq"),
        ("correlation_length_x_m", "ℓx"),
        ("correlation_length_y_m", "ℓy"),
    ];
    let rows = surface.part()?.scans.iter().map(|scan| {
        let cell = |(key, _): &(&str, &str)| {
            Known::of_scan(&scan.statistics, key).map_or_else(|| DASH.into(), |known| known.value)
        };
        std::iter::once(scan.file.clone()).chain(KEYS.iter().map(cell)).collect()
    });
    let headers: Vec<&str> = std::iter::once("Scan").chain(KEYS.iter().map(|(_, symbol)| *symbol)).collect();
    Some(DataTable::new("Scans of the part", &headers, rows.collect(), RESULTS))
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
    Some(DataTable::new(&caption, &headers, rows, "tables/height_fits.csv").without_empty_columns())
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
    use asperity_results::{Companions, PooledResult, ScanOfPart, SpreadResult};

    #[test]
    fn every_parameter_is_listed_once() {
        let mut keys: Vec<&str> = all().map(|(key, _, _)| *key).collect();
        let count = keys.len();
        keys.sort_unstable();
        keys.dedup();
        assert_eq!(keys.len(), count);
        assert_eq!(parameter("Sa_m").map(|p| p.0), Some(0));
    }

    fn scan(sq_m: f64, ssk: Option<f64>, interval: Option<Pair>) -> SurfaceStatistics {
        let spread = interval.map(|interval| SpreadResult { interval, standard_error: 2e-8 });
        let intervals = Companions(vec![("Sq_m".into(), spread), ("Ssk".into(), None)]);
        SurfaceStatistics { nx: 4, Sq_m: sq_m, Ssk: ssk, intervals, ..SurfaceStatistics::default() }
    }

    #[test]
    fn groups_precede_their_parameters_and_intervals_are_beside_them() {
        let table = |interval| table(&MeasuredSurface::Scan(Box::new(scan(1.0234e-6, Some(0.5), interval))));
        let found = table(Some([9.9e-7, 1.06e-6]));
        let spaced: Vec<Vec<String>> =
            found.rows.iter().map(|row| row.iter().map(|cell| cell.replace('\u{a0}', " ")).collect()).collect();
        assert_eq!(spaced[0], ["Height"]);
        let row = |symbol: &str| spaced.iter().find(|row| row.get(1).is_some_and(|own| own == symbol)).unwrap();
        assert_eq!(row("Sq")[2..], ["1.023 µm", "[0.990, 1.060]"].map(str::to_owned));
        assert_eq!(row("Ssk")[2..], ["0.5".to_owned(), "–".to_owned()]);
        assert!(spaced.contains(&vec!["Map".to_owned()]) && !spaced.contains(&vec!["Form".to_owned()]));
        // Without any interval there is no column for them.
        assert_eq!(table(None).headers.len(), 3);
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
        assert!(table.caption.ends_with("from 2 scans") && table.headers.len() == 6, "{:?}", table.headers);
        let cells = table.rows[1][4..].iter().map(|cell| cell.replace('\u{a0}', " ")).collect::<Vec<_>>();
        assert_eq!(cells, ["20 nm", "120 nm"]);
        let found = scans_of(measured).unwrap();
        assert_eq!(found.rows.len(), 2);
        assert_eq!((found.rows[1][0].as_str(), found.rows[1][2].as_str()), ("b.x3p", "–"));
        assert!(scans_of(MeasuredSurface::Stated {}).is_none());
    }

    fn scans_of(measured: MeasuredSurface) -> Option<DataTable> {
        scans(&SurfaceResult { measured, ..SurfaceResult::default() })
    }
}
