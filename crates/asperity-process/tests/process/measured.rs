//! Measured friction records: recovers a known process from the files of a tribometer.
use std::collections::BTreeMap;
use std::fmt::Write;
use std::sync::Mutex;

use asperity_base::correlation::Observation;
use asperity_base::distribution::Marginal;
use asperity_base::monitor::Monitor;
use asperity_base::random;
use asperity_base::stats::NORMAL_95;
use asperity_process::measured::{
    Abscissa, ColumnTable, Detrend, DistributionChoice, FittedRecord, MeasuredError, MeasuredRecord, NormalForce,
    PreparedRecord, RecordColumns, RecordPreparation,
};
use asperity_process::{CorrelationShape, FittedProcess, FrictionProcess, ProcessModel, TranslationKind};
use asperity_testing::autoregressive;

const LENGTH_M: f64 = 250e-6;
const STEP_M: f64 = 10e-6;
const MEAN: f64 = 0.21;
const STD: f64 = 0.008;

/// Returns an Ornstein–Uhlenbeck process under a copula with Beta(2.1, 5) margins, 1 kHz at 10 mm/s over 60 s, and a
/// drift of zero mean.
fn planted() -> Vec<f64> {
    let marginal: Marginal = "beta:2.1,5".parse().unwrap();
    let model = ProcessModel { correlation: TranslationKind::Corrected, ..ProcessModel::new(marginal, STD, LENGTH_M) };
    let process = FrictionProcess::with_step(model, STEP_M).unwrap();
    let mut path = process.path(11, 0);
    let n = 60_000;
    (0..n).map(|i| MEAN + path.next_value() + 0.02 * (i as f64 / (n - 1) as f64 - 0.5)).collect()
}

/// Returns a file of force over time under 20 N, in the format of a logger with decimal commas.
fn time_file(mu: &[f64]) -> String {
    let mut text = String::from("Rig 3; pin on disc\nOperator;A. B.\nZeit;Reibkraft;Kommentar\nms;mN;\n");
    for (i, mu) in mu.iter().enumerate() {
        writeln!(text, "{};{:?};", i, mu * 20e3).unwrap();
    }
    text.replace('.', ",")
}

/// Returns a file of μ over distance.
fn distance_file(mu: &[f64]) -> String {
    let mut text = String::from("# track 2\n# s [mm], mu [-]\n");
    for (i, mu) in mu.iter().enumerate() {
        writeln!(text, "{:.3},{mu:?}", i as f64 * 0.01).unwrap();
    }
    text
}

fn by_time(column: &str) -> RecordColumns {
    RecordColumns {
        column: column.into(),
        unit: None,
        abscissa: Abscissa::Time { column: "Zeit".into(), unit: None },
        velocity_m_per_s: Some(10e-3),
        normal_force: Some(NormalForce::Constant { newton: 20.0 }),
    }
}

fn by_distance() -> RecordColumns {
    RecordColumns {
        column: "mu".into(),
        unit: None,
        abscissa: Abscissa::Distance { column: "s".into(), unit: None },
        velocity_m_per_s: None,
        normal_force: None,
    }
}

fn prepared(text: &str, columns: &RecordColumns) -> PreparedRecord {
    let table = ColumnTable::read(text.as_bytes()).unwrap();
    let record = MeasuredRecord::new(&table, columns).unwrap();
    RecordPreparation { detrend: Detrend::Polynomial(1), ..RecordPreparation::default() }.apply(&record).unwrap()
}

/// Asserts that a value lies within four standard errors, computed from its 95 % interval.
fn within_four_errors(name: &str, found: f64, interval: Option<[f64; 2]>, wanted: f64) {
    let [low, high] = interval.unwrap();
    let error = 0.5 * (high - low) / NORMAL_95;
    assert!((found - wanted).abs() < 4.0 * error, "{name}: {found} ± {error}, planted {wanted}");
    assert!(error < 0.15 * wanted, "{name}: the interval {low} to {high} says nothing");
}

#[test]
#[ignore = "slow"]
fn a_known_process_is_recovered_from_time_and_force_and_from_distance_and_mu() {
    let mu = planted();
    let of_time = prepared(&time_file(&mu), &by_time("Reibkraft"));
    let of_distance = prepared(&distance_file(&mu), &by_distance());
    assert!((of_time.record.step_m / STEP_M - 1.0).abs() < 1e-9 && of_time.record.warnings.is_empty());
    let fitted = FittedRecord::new(&of_time, DistributionChoice::Auto, "rig").unwrap();
    let FittedProcess { mean, std, correlation, .. } = fitted.process.clone();
    let correlation = correlation.unwrap();
    assert_eq!(correlation.shape, CorrelationShape::Exponential);
    within_four_errors("mean", mean, fitted.process.mean_interval, MEAN);
    within_four_errors("std", std, fitted.process.std_interval, STD);
    within_four_errors("length", correlation.length_m, correlation.length_interval_m, LENGTH_M);
    // The line of ±0.01 has the variance 0.02²/12 in addition to the variance of the process.
    let line = 0.02_f64.powi(2) / 12.0;
    let share = of_time.removed[0].variance_share;
    assert!((share - line / (line + STD * STD)).abs() < 0.05, "{share}");
    assert!(fitted.goodness.unwrap().kolmogorov_smirnov.p_value > 1e-3, "{:?}", fitted.goodness);
    // The effective sample size of the 60,000 values is L/2ℓ.
    assert!((fitted.moments.effective_size / 1200.0 - 1.0).abs() < 0.25, "{}", fitted.moments.effective_size);

    let other = FittedRecord::new(&of_distance, DistributionChoice::Auto, "rig").unwrap().process;
    assert!((other.mean / mean - 1.0).abs() < 1e-9 && (other.std / std - 1.0).abs() < 1e-9);
    assert!((other.correlation.unwrap().length_m / correlation.length_m - 1.0).abs() < 1e-6);

    // The tables of the figures agree with the known distribution and correlation.
    let tables = fitted.tables(&of_time);
    let column = |table: &str, name: &str| {
        let (_, columns) = tables.iter().find(|(own, _)| *own == table).unwrap();
        columns.iter().find(|(own, _)| own == name).unwrap_or_else(|| panic!("{table}.{name}")).1.clone()
    };
    let names: Vec<&str> = tables.iter().map(|(name, _)| *name).collect();
    assert_eq!(names, ["friction_record", "friction_histogram", "friction_pit", "friction_qq", "friction_acf"]);
    let (pit, high) = (column("friction_pit", "density"), column("friction_pit", "high"));
    assert!((pit.iter().sum::<f64>() / 20.0 - 1.0).abs() < 1e-9);
    let outside = pit.iter().zip(&high).filter(|(density, high)| (**density - 1.0).abs() > 2.0 * (*high - 1.0));
    assert_eq!(outside.count(), 0, "{pit:?}");
    let (fit, seen) = (column("friction_qq", "fitted"), column("friction_qq", "measured"));
    assert!(fit.iter().zip(&seen).all(|(a, b)| (a - b).abs() < 0.3 * STD));
    let (acf, model) = (column("friction_acf", "acf"), column("friction_acf", "exponential"));
    assert!(acf.iter().zip(&model).all(|(a, b)| (a - b).abs() < 0.15));

    // A record simulated from the fitted process has the statistics of the original record.
    let file = fitted.process.to_json().unwrap();
    let process = FittedProcess::from_json(&file).unwrap();
    assert_eq!(process, fitted.process);
    let twin = process.simulate(0.6, STEP_M, 5, 0).unwrap();
    let record = MeasuredRecord { friction: twin, ..of_time.record.clone() };
    let twin = RecordPreparation::default().apply(&record).unwrap();
    let again = FittedRecord::new(&twin, DistributionChoice::Auto, "twin").unwrap().process;
    within_four_errors("mean of the twin", again.mean, again.mean_interval, mean);
    within_four_errors("std of the twin", again.std, again.std_interval, std);
    let length = again.correlation.unwrap();
    within_four_errors("length of the twin", length.length_m, length.length_interval_m, correlation.length_m);
}

/// Monitor that keeps the last report of every task.
#[derive(Default)]
struct Reports(Mutex<BTreeMap<String, (usize, usize)>>);

impl Monitor for Reports {
    fn progress(&self, what: &str, done: usize, total: usize) {
        self.0.lock().unwrap().insert(what.into(), (done, total));
    }

    fn cancelled(&self) -> bool {
        false
    }
}

#[test]
fn the_progress_of_a_fit_ends_at_its_total_and_changes_nothing() {
    let mu: Vec<f64> = planted().into_iter().take(1000).collect();
    let prepared = prepared(&distance_file(&mu), &by_distance());
    let reports = Reports::default();
    let fitted = FittedRecord::monitored(&prepared, DistributionChoice::Auto, "rig", &reports).unwrap();
    assert_eq!(fitted, FittedRecord::new(&prepared, DistributionChoice::Auto, "rig").unwrap());
    let reports = reports.0.into_inner().unwrap();
    assert!(reports.values().all(|(done, total)| done == total), "{reports:?}");
    assert_eq!(reports.keys().collect::<Vec<_>>(), ["correlation fits", "steps of the fit"]);
}

#[test]
#[ignore = "slow"]
fn bounds_the_normal_distribution_and_the_empirical_one_can_be_selected() {
    let mu: Vec<f64> = planted().into_iter().take(12_000).collect();
    let prepared = prepared(&distance_file(&mu), &by_distance());
    for (choice, name) in
        [("beta:0.15,0.4", "beta"), ("normal", "normal"), ("weibull", "weibull"), ("empirical", "empirical")]
    {
        let choice: DistributionChoice = choice.parse().unwrap();
        let fitted = FittedRecord::new(&prepared, choice, "rig").unwrap();
        assert_eq!(fitted.process.marginal.as_ref().unwrap().name(), name);
        assert_eq!(fitted.process.marginal.as_ref().unwrap().name() == "empirical", fitted.goodness.is_none());
        fitted.process.model(1.0).unwrap();
    }
    let outside = FittedRecord::new(&prepared, "beta:0.2,0.21".parse().unwrap(), "rig").unwrap_err();
    assert!(matches!(outside, MeasuredError::Distribution(_)), "{outside}");
    for text in ["gamma", "beta:1", "beta:2,1", ""] {
        assert!(text.parse::<DistributionChoice>().is_err(), "{text}");
    }
}

#[test]
#[ignore = "slow"]
fn gaps_remain_gaps_and_have_little_effect() {
    let mut mu = planted();
    let whole = prepared(&distance_file(&mu), &by_distance());
    let text = distance_file(&mu);
    mu[20_000..21_000].fill(f64::NAN);
    // Some rows have no value; others are missing.
    let holed: String = text
        .lines()
        .enumerate()
        .filter(|(line, _)| !(40_000..41_000).contains(line))
        .map(|(line, row)| match row.split_once(',') {
            Some((s, _)) if (20_002..21_002).contains(&line) => format!("{s},NaN\n"),
            _ => format!("{row}\n"),
        })
        .collect();
    let holed = prepared(&holed, &by_distance());
    assert_eq!(holed.record.friction.len(), whole.record.friction.len());
    assert_eq!(holed.record.present(), whole.record.present() - 2000);
    assert!(holed.record.warnings.iter().any(|warning| warning.contains("remain gaps")), "{:?}", holed.record.warnings);
    let [whole, holed] =
        [whole, holed].map(|record| FittedRecord::new(&record, DistributionChoice::Auto, "rig").unwrap().process);
    assert!((holed.std / whole.std - 1.0).abs() < 0.02);
    let [whole, holed] = [whole, holed].map(|process| process.correlation.unwrap().length_m);
    assert!((holed / whole - 1.0).abs() < 0.05);
}

#[test]
fn wrong_requests_report_the_value_found_and_the_value_wanted() {
    let mu: Vec<f64> = planted().into_iter().take(500).collect();
    let table = ColumnTable::read(time_file(&mu).as_bytes()).unwrap();
    let refused = |columns: &RecordColumns, words: &[&str]| {
        let error = MeasuredRecord::new(&table, columns).unwrap_err();
        assert!(error.is_request(), "{error}");
        for word in words {
            assert!(error.to_string().contains(word), "`{word}` in {error}");
        }
    };
    let right = by_time("Reibkraft");
    assert!(MeasuredRecord::new(&table, &right).is_ok());
    refused(&by_time("Reibung"), &["no column `Reibung`", "1 `Zeit [ms]`", "2 `Reibkraft [mN]`", "3 `Kommentar`"]);
    refused(&RecordColumns { velocity_m_per_s: None, ..right.clone() }, &["sliding velocity"]);
    refused(&RecordColumns { velocity_m_per_s: Some(-1.0), ..right.clone() }, &["sliding velocity is -1", "positive"]);
    refused(&RecordColumns { normal_force: None, ..right.clone() }, &["`Reibkraft` is a force", "normal force"]);
    refused(&RecordColumns { unit: Some("-".into()), ..right.clone() }, &["is a friction coefficient"]);
    refused(&RecordColumns { unit: Some("bar".into()), ..right.clone() }, &["`bar` is not a unit of force"]);
    let by_length = Abscissa::Distance { column: "Zeit".into(), unit: None };
    refused(&RecordColumns { abscissa: by_length, ..right.clone() }, &["`Zeit`", "`ms` is not a unit of length"]);
    let rate = Abscissa::SamplingRate { hertz: 0.0 };
    refused(&RecordColumns { abscissa: rate, ..right.clone() }, &["sampling rate is 0"]);
    // At 1 kHz.
    for velocity in [1e-200, 1e-13, 1e19, 1e300] {
        let columns = RecordColumns { velocity_m_per_s: Some(velocity), ..right.clone() };
        refused(&columns, &["the distance between values is", "1e-15 to 1e15 m"]);
    }
    let rate = Abscissa::SamplingRate { hertz: 1e-200 };
    refused(&RecordColumns { abscissa: rate, ..right.clone() }, &["the distance between values is", "e198 m"]);
    for newton in [1e-300, 1e-31, 1e33] {
        let normal_force = Some(NormalForce::Constant { newton });
        let columns = RecordColumns { normal_force, ..right.clone() };
        refused(&columns, &["the largest friction coefficient is", "1e-30 to 1e30", "units"]);
    }
    let normal_force = Some(NormalForce::Column { column: "Kommentar".into(), unit: None });
    refused(&RecordColumns { normal_force, ..right.clone() }, &["`Kommentar` has no unit", "N or mN"]);
    // Without a time column the sampling rate gives the same result.
    let rate = Abscissa::SamplingRate { hertz: 1000.0 };
    let by_rate = MeasuredRecord::new(&table, &RecordColumns { abscissa: rate, ..right.clone() }).unwrap();
    let by_column = MeasuredRecord::new(&table, &right).unwrap();
    assert!(by_rate.friction == by_column.friction && (by_rate.step_m / by_column.step_m - 1.0).abs() < 1e-9);
}

#[test]
fn distances_and_coefficients_outside_double_precision_are_errors() {
    let of = |step: f64, scale: f64| {
        let text: String =
            (0..20).map(|i| format!("{:e},{:e}\n", f64::from(i) * step, scale * f64::from(3 + i % 3))).collect();
        let table = ColumnTable::read(format!("s [m],mu\n{text}").as_bytes()).unwrap();
        MeasuredRecord::new(&table, &by_distance())
    };
    assert!(of(1e-14, 1e-29).is_ok() && of(1e14, 1e29).is_ok());
    for step in [1e-200, 1e-16, 1e16, 1e300] {
        assert!(
            matches!(of(step, 1.0), Err(MeasuredError::Step { step_m }) if (step_m / step - 1.0).abs() < 1e-9),
            "{step}"
        );
    }
    for scale in [1e-200, 1e-31, 1e31, 1e200] {
        let error = of(1.0, scale).unwrap_err();
        assert!(matches!(error, MeasuredError::Magnitude { largest } if largest == 5.0 * scale), "{error}");
    }
}

/// Fits a record at steps of one metre.
fn fitted(friction: Vec<f64>, decimation: usize) -> Result<FittedRecord, MeasuredError> {
    let record = MeasuredRecord {
        start_m: 0.0,
        step_m: 1.0,
        friction,
        velocity_m_per_s: None,
        strokes_m: vec![],
        warnings: vec![],
    };
    let prepared = RecordPreparation { decimation, ..RecordPreparation::default() }.apply(&record)?;
    FittedRecord::new(&prepared, "normal".parse().unwrap(), "rig")
}

/// Returns μ of mean 0.4, standard deviation 0.03 and correlation e^{−lag/ℓ}; ℓ = 0 for uncorrelated values.
fn exponential(length: f64, values: usize, index: u64) -> Vec<f64> {
    let phi = if length > 0.0 { (-1.0 / length).exp() } else { 0.0 };
    let normal = autoregressive(phi, values, &mut random::stream(83, "unresolved", index));
    normal.into_iter().map(|value| 0.4 + 0.03 * value).collect()
}

/// Returns the numbers of records whose interval of the standard deviation contains the one of the recorded values, and
/// the one of the process.
fn covering(length: f64, values: usize, records: u64) -> (usize, usize) {
    let (mut recorded, mut process) = (0, 0);
    for index in 0..records {
        let fit = fitted(exponential(length, values, index), 1).unwrap();
        let [low, high] = fit.process.std_interval.unwrap();
        recorded += usize::from((low..=high).contains(&fit.std_measured));
        process += usize::from((low..=high).contains(&0.03));
        if fit.process.std == fit.std_measured {
            let hint = "hardly distinguishes values at points from means over the step";
            assert!(
                fit.families.chosen.length_m >= 2.0 || fit.warnings.iter().any(|warning| warning.contains(hint)),
                "{fit:?}"
            );
        }
    }
    (recorded, process)
}

#[test]
fn unresolved_records_have_the_standard_deviation_of_their_values() {
    for (length, values) in [(0.0, 200), (0.3, 300)] {
        let (recorded, process) = covering(length, values, 10);
        assert!(recorded == 10 && process >= 7, "ℓ = {length}, {values} values: {recorded}, {process} of 10");
    }
}

#[test]
#[ignore = "slow"]
fn intervals_of_unresolved_records_cover_the_standard_deviation() {
    // Of 100, 95 % are 95 ± 2.2. Chance selects noise or means in less than one record in a hundred.
    let cases = [(0.0, 50, 100), (0.0, 200, 100), (0.0, 600, 100), (0.0, 4000, 30), (0.1, 600, 100), (0.3, 600, 100)];
    for (length, values, records) in cases.into_iter().chain([(0.6, 600, 100), (1.0, 600, 100), (1.0, 2000, 40)]) {
        let (recorded, process) = covering(length, values, records);
        let least = records as usize * 88 / 100;
        assert!(
            recorded + 1 >= records as usize && process >= least,
            "ℓ = {length}: {recorded}, {process} of {records}"
        );
    }
}

#[test]
#[ignore = "slow"]
fn means_over_a_step_near_the_correlation_length_are_recognised_in_long_records() {
    for (length, least) in [(0.5, 7), (1.0, 10), (2.0, 10)] {
        let fits = (0..10).map(|index| {
            let fine = exponential(20.0 * length, 80_000, 1000 + index);
            fitted(fine.chunks_exact(20).map(|part| part.iter().sum::<f64>() / 20.0).collect(), 1).unwrap()
        });
        let means: Vec<FittedRecord> = fits.filter(|fit| fit.observation == Observation::Means).collect();
        let covering = means.iter().filter(|fit| {
            let [low, high] = fit.process.std_interval.unwrap();
            (low..=high).contains(&0.03)
        });
        assert!(means.len() >= least && covering.count() + 2 >= means.len(), "ℓ = {length}: {} of 10", means.len());
    }
}

#[test]
fn averages_of_uncorrelated_values_have_their_own_standard_deviation() {
    // Means of ten values that are uncorrelated do not determine the correlation length, or the effect of averaging.
    let fit = fitted(exponential(0.0, 3000, 5), 10).unwrap();
    assert!(fit.families.chosen.interval.low == 0.0 && fit.process.std == fit.std_measured, "{:?}", fit.families);
    assert!(fit.warnings.iter().any(|warning| warning.contains("the effect of the averaging is unknown")));
}

#[test]
fn forces_are_divided_row_by_row_and_the_other_direction_is_reversed() {
    let text = "t [s],F [N],N [kN]\n0,-1,0.01\n1,-2,0.02\n2,-3,0\n3,-5,0.02\n";
    let table = ColumnTable::read(text.as_bytes()).unwrap();
    let columns = RecordColumns {
        column: "F".into(),
        unit: None,
        abscissa: Abscissa::Time { column: "t".into(), unit: None },
        velocity_m_per_s: Some(0.5),
        normal_force: Some(NormalForce::Column { column: "N".into(), unit: None }),
    };
    let record = MeasuredRecord::new(&table, &columns).unwrap();
    assert!((record.friction[0] - 0.1).abs() < 1e-15 && (record.friction[1] - 0.1).abs() < 1e-15);
    assert!(record.friction[2].is_nan() && (record.friction[3] - 0.25).abs() < 1e-15 && record.step_m == 0.5);
    for word in ["not above zero", "sign was reversed", "remain gaps"] {
        assert!(record.warnings.iter().any(|warning| warning.contains(word)), "{:?}", record.warnings);
    }
}

#[test]
fn normal_forces_without_compression_are_an_error() {
    let table = ColumnTable::read(b"t [s],F [N],N [kN]\n0,1,-0.01\n1,2,-0.02\n2,3,0\n").unwrap();
    let columns = RecordColumns {
        column: "F".into(),
        unit: None,
        abscissa: Abscissa::Time { column: "t".into(), unit: None },
        velocity_m_per_s: Some(0.5),
        normal_force: Some(NormalForce::Column { column: "N".into(), unit: None }),
    };
    let error = MeasuredRecord::new(&table, &columns).unwrap_err().to_string();
    assert!(error.contains("column `N`, is above zero"), "{error}");
}

#[test]
fn too_short_or_constant_records_are_errors() {
    let record = |friction: Vec<f64>| {
        let record = MeasuredRecord {
            start_m: 0.0,
            step_m: STEP_M,
            friction,
            velocity_m_per_s: None,
            strokes_m: vec![],
            warnings: vec![],
        };
        let prepared = RecordPreparation::default().apply(&record).unwrap();
        FittedRecord::new(&prepared, DistributionChoice::Auto, "rig").err().unwrap()
    };
    assert!(record(vec![0.1, 0.2, 0.3]).is_too_few());
    let slow: Vec<f64> = (0..4000).map(|i| 0.2 + 0.01 * (1e-3 * f64::from(i)).sin()).collect();
    let error = record(slow);
    assert!(error.is_too_few() && error.to_string().contains("independent"), "{error}");
    let error = record(vec![0.2; 100]);
    assert!(!error.is_too_few() && !error.is_request(), "{error}");
}
