//! The page of a scan and its twins, complete, partial and hostile.

use asperity_results::{
    Comparison, CovarianceResult, CurveComparison, DistributionResult, Field, Provenance, StatisticComparison, Table,
    TwinModel,
};
use ndarray::Array2;

use crate::documents::{check_figure, check_page, elements, text, without_scripts};
use crate::synthetic::{edit, edit_field, example};
use asperity_report::{TwinRun, render_twins};

fn field(nx: usize, ny: usize, phase: f64) -> Field {
    let height = |(row, column)| 1e-6 * (0.3 * column as f64 + phase).sin() * (0.2 * row as f64).cos();
    Field::new([1e-6, 1e-6], "m", Array2::from_shape_fn((ny, nx), height))
}

fn table(abscissa: &str, unit: &str, x: Vec<f64>, scan: impl Fn(f64) -> f64) -> Table {
    let values = |factor: f64| x.iter().map(|x| factor * scan(*x)).collect::<Vec<f64>>();
    let columns = [("scan", 1.0), ("twins_mean", 0.95), ("twins_low", 0.7), ("twins_high", 1.2)];
    let named = columns.map(|(name, factor)| (format!("{name}{unit}"), values(factor)));
    Table::new(std::iter::once((abscissa.to_owned(), x.clone())).chain(named))
}

fn statistic(target: f64, mean: f64, std: f64) -> StatisticComparison {
    let (low, high) = (mean - 2.0 * std, mean + 2.0 * std);
    StatisticComparison {
        target: Some(target),
        mean: Some(mean),
        std: Some(std),
        band: Some([low, high]),
        inside: Some(target > low && target < high),
        defined: 10,
    }
}

fn comparison(nx: usize, ny: usize) -> Comparison {
    let covariance = CovarianceResult {
        model: "matern".into(),
        length_x_m: 3e-6,
        length_y_m: 4e-6,
        decay_length_x_m: 3.7e-6,
        decay_length_y_m: 4.9e-6,
        ..CovarianceResult::default()
    };
    let marginal = DistributionResult { name: "empirical".into(), ..DistributionResult::default() };
    let own = example::comparison();
    let undefined = StatisticComparison { target: None, inside: None, ..statistic(0.0, 0.4, 0.1) };
    let twins = [
        ("Sdq", statistic(0.3, 0.2, 0.02)),
        ("Sq_m", statistic(5e-7, 5.1e-7, 2e-8)),
        ("Ssk", statistic(-0.4, -0.3, 0.1)),
        ("correlation_length_x_m", statistic(3.1e-6, 3e-6, 2e-7)),
        ("Str", undefined),
    ];
    let curve = |inside_share| CurveComparison { inside_share: Some(inside_share), ..CurveComparison::default() };
    Comparison {
        points: [nx, ny],
        inside: 3,
        compared: 4,
        model: TwinModel { covariance: Some(covariance), marginal, ..own.model },
        twins: twins.map(|(name, statistic)| (name.to_owned(), statistic)).into(),
        curves_inside: 54,
        curves_compared: 60,
        curves: vec![("height_pdf".into(), curve(0.97)), ("acf_x".into(), curve(0.74))],
        warnings: vec!["1 of 4 statistics lies outside.".into()],
        ..own
    }
}

fn run(nx: usize, ny: usize) -> TwinRun {
    let lags: Vec<f64> = (0..20).map(|i| f64::from(i) * 1e-6).collect();
    let wavenumbers: Vec<f64> = (1..40).map(|i| f64::from(i) * 1e5).collect();
    let heights: Vec<f64> = (-20..=20).map(|i| f64::from(i) * 1e-7).collect();
    let spectrum = |q: f64| 1e-18 / (1.0 + (q * 3e-6).powi(2));
    let mut scan = field(nx, ny, 0.0);
    edit_field(&mut scan, |values| values[[0, 5]] = f64::NAN);
    TwinRun {
        name: "bench.x3p".into(),
        comparison: comparison(nx, ny),
        tables: [
            ("height_pdf", table("height_m", "_per_m", heights, |z| 8e5 * (-0.5 * (z / 5e-7).powi(2)).exp())),
            ("acf_x", table("lag_m", "", lags.clone(), |lag| (-lag / 3e-6).exp())),
            ("acf_y", table("lag_m", "", lags, |lag| (-lag / 4e-6).exp())),
            ("psd_x", table("wavenumber_rad_per_m", "_m3", wavenumbers.clone(), spectrum)),
            ("psd_y", table("wavenumber_rad_per_m", "_m3", wavenumbers, spectrum)),
        ]
        .map(|(name, table)| (name.to_owned(), table))
        .into(),
        scan: Some(scan),
        twins: vec![field(nx, ny, 1.0), field(nx, ny, 2.0)],
        provenance: Some(Provenance { asperity: "0.1.0".into(), seed: 4, ..Provenance::default() }),
    }
}

#[test]
fn the_page_shows_maps_functions_parameters_and_limits() {
    let report = render_twins(&run(40, 30)).unwrap();
    let names: Vec<&str> = report.figures.iter().map(|figure| figure.name.as_str()).collect();
    assert_eq!(names, ["maps", "parameters", "height_pdf", "acf", "psd"]);
    let html = text(&report.html);
    for wanted in [
        "Twins of bench.x3p",
        "3 of 4 statistics and 90 % of the points of the curves lie within",
        "height density 97 %, autocorrelation along x 74 %. 95 % are expected by chance",
        "Outside: Sdq. About 0.2 are expected outside by chance.",
        "Matérn covariance",
        "Lengths (scale of the model) 3 µm along x and 4 µm along y; correlation lengths (to 1/e) 3.7 µm and 4.9 µm.",
        "10 maps of 40 × 30 points",
        "500 nm",
        "510 nm [470, 550]",
        "class=\"outside\">outside",
        "at 97 %",
        "Twins are stationary.",
        "The plane was removed.",
        "1 of 4 statistics lies outside.",
        "Grigoriu",
        "tables/acf_x.csv",
    ] {
        assert!(html.contains(wanted), "the page says {wanted:?}");
    }
    let maps = text(&report.figures[0].svg);
    assert!(["Scan", "Twin 1", "Twin 2", "x (µm)", "y (µm)", "missing (1 points)"].iter().all(|t| maps.contains(t)));
    // One colour scale: one bar.
    assert_eq!(maps.matches("Height (").count(), 1);
    assert_eq!(report, render_twins(&run(40, 30)).unwrap(), "equal runs give equal bytes");
}

#[test]
fn parameters_are_in_the_order_of_the_tables() {
    let html = text(&render_twins(&run(40, 30)).unwrap().html);
    let place = |meaning: &str| html.find(meaning).unwrap_or_else(|| panic!("{meaning}"));
    let places =
        ["Root mean square height", "Skewness of the heights", "Texture aspect ratio", "correlation length along x"]
            .map(place);
    assert!(places.is_sorted(), "{places:?}");
    // An undefined value is a dash.
    assert!(html.contains("<td>–</td>"));
}

#[test]
fn wide_maps_are_one_below_the_other() {
    let height = |nx, ny| -> f64 {
        let svg = render_twins(&run(nx, ny)).unwrap().figures[0].svg.clone();
        let view = svg.split("viewBox=\"").nth(1).unwrap().split('"').next().unwrap();
        view.rsplit(' ').next().unwrap().parse().unwrap()
    };
    assert!(height(40, 40) < 400.0);
    // 450 px wide and a quarter as high, three times, with titles.
    assert!(height(80, 20) > 400.0);
    for (nx, ny) in [(2, 400), (400, 2), (2, 2), (30, 60)] {
        let report = render_twins(&run(nx.max(6), ny)).unwrap();
        elements(&report.figures[0].svg);
        assert!(height(nx.max(6), ny) < 1600.0);
    }
}

#[test]
fn every_figure_is_well_formed_and_readable_and_the_page_loads_nothing() {
    let report = render_twins(&run(40, 30)).unwrap();
    for figure in &report.figures {
        assert!(elements(&figure.svg) > 20, "{} is drawn", figure.name);
        check_figure(figure);
    }
    check_page(&report.html);
}

#[test]
fn absent_and_undefined_data_are_left_out() {
    let empty = render_twins(&TwinRun::default()).unwrap();
    assert!(empty.figures.is_empty() && empty.html.contains("</html>"));
    let full = run(12, 12);
    for name in full.tables.keys() {
        let one = TwinRun { tables: [(name.clone(), full.tables[name].clone())].into(), ..TwinRun::default() };
        assert_eq!(render_twins(&one).unwrap().figures.len(), 1, "{name}");
        for hidden in 0..5 {
            let mut one = one.clone();
            edit(&mut one.tables, name, |columns| columns[hidden].1.fill(f64::NAN));
            for figure in render_twins(&one).unwrap().figures {
                elements(&figure.svg);
                assert!(!figure.svg.contains("NaN"), "{name}, column {hidden}");
            }
        }
    }
    // One twin has no band.
    let mut single = full.clone();
    single.twins.truncate(1);
    for (_, statistic) in &mut single.comparison.twins {
        *statistic = StatisticComparison { std: None, band: None, inside: None, ..*statistic };
    }
    let names: Vec<String> = render_twins(&single).unwrap().figures.into_iter().map(|figure| figure.name).collect();
    assert_eq!(names, ["maps", "height_pdf", "acf", "psd"]);
}

#[test]
fn hostile_strings_are_escaped_and_bad_fields_refused() {
    const EVIL: &str = "\"><script>alert(1)</script><img src=x onerror=alert(1)> & '";
    let mut run = run(12, 12);
    run.name = EVIL.into();
    run.comparison.warnings.push(EVIL.into());
    run.comparison.model.covariance.as_mut().unwrap().model = EVIL.into();
    run.comparison.model.marginal.name = EVIL.into();
    run.comparison.twins.push((EVIL.into(), statistic(1.0, 5.0, 0.1)));
    run.provenance.as_mut().unwrap().inputs.insert(EVIL.into(), EVIL.into());
    let report = render_twins(&run).unwrap();
    assert!(!without_scripts(&report.html).contains("<img"));
    for figure in &report.figures {
        elements(&figure.svg);
        assert!(!figure.svg.contains("<script") && !figure.svg.contains("<img"));
    }
}
