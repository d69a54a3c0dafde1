//! Tests of `asperity friction`: fits to measured records, and records drawn from fits.

use std::fmt::Write;
use std::fs;

use serde_json::Value;

use crate::support::{close, listing, number, run_in, written};

const PROCESS: &str = r#"{
  "format": "asperity friction process", "version": 1, "mean": 0.2, "std": 0.01,
  "marginal": {"beta": {"a": 2.1, "b": 5.0, "low": 0.18, "high": 0.24}},
  "correlation": {"model": "exponential", "length_m": 250e-6}
}"#;

/// A folder with a process, a record drawn from it, and the same record as forces over time under 10 N.
fn bench() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("process.json"), PROCESS).unwrap();
    let json =
        run_in(folder.path(), "friction simulate process.json --length 50mm --step 50um --seed 3 --out m.csv --json")
            .json(0);
    assert_eq!(number(&json, "values"), 1001.0);
    let csv = fs::read_to_string(folder.path().join("m.csv")).unwrap();
    assert!(csv.starts_with("position_m,fluctuation,mu\n0.0,"), "{csv:.80}");
    let mut forces = String::from("time [ms];F [N]\n");
    for (index, line) in csv.lines().skip(1).enumerate() {
        let mu: f64 = line.rsplit(',').next().unwrap().parse().unwrap();
        writeln!(forces, "{};{:?}", 5 * index, 10.0 * mu).unwrap();
    }
    fs::write(folder.path().join("forces.csv"), forces).unwrap();
    folder
}

#[test]
fn a_record_of_distance_and_one_of_time_give_the_same_process() {
    let folder = bench();
    let at = folder.path();
    let distance =
        run_in(at, "friction fit m.csv --column mu --distance-column position --out fit.json --json").json(0);
    // 10 mm/s times 5 ms is 50 µm.
    let time =
        run_in(at, "friction fit forces.csv --column F --time-column time --velocity 10mm/s --normal-force 10N --json");
    let time = time.json(0);
    for key in ["mean", "std", "correlation_length_m", "effective_size"] {
        close(number(&time, key), number(&distance, key), 1e-9);
    }
    let rate = "friction fit forces.csv --column F --sampling-rate 200Hz --velocity 10mm/s --normal-force 10N --json";
    close(number(&run_in(at, rate).json(0), "correlation_length_m"), number(&distance, "correlation_length_m"), 1e-9);
    let [low, high] = [0, 1].map(|end| distance["mean_interval"][end].as_f64().unwrap());
    assert!(low < number(&distance, "mean") && number(&distance, "mean") < high && low < 0.2 && 0.2 < high);
    assert!((number(&distance, "step_m") / 50e-6 - 1.0).abs() < 1e-9);
    assert!(
        distance["laws"].as_array().unwrap().len() > 1 && distance["correlation_models"].as_array().unwrap().len() == 2
    );
    // The written file is a valid process for `simulate`.
    let fitted: Value = serde_json::from_slice(&fs::read(at.join("fit.json")).unwrap()).unwrap();
    assert_eq!(fitted["mean"], distance["mean"]);
    assert_eq!(fitted["origin"]["kind"], "record");
    run_in(at, "friction simulate fit.json --length 5mm --step 50um --seed 1 --out twin.npy --json").json(0);
    let line = "vibration trajectory --static-friction 0.2 --stribeck 4.2 --damping-ratio 0.1 --belt-velocity 0.003 \
                --friction-file twin.npy --friction-step 0.01 --duration 20 --json";
    assert!(!run_in(at, line).json(0)["events"].as_array().unwrap().is_empty());
    let table = run_in(at, "friction fit m.csv --column mu --distance-column position");
    assert!(
        table.code == 0 && table.stdout.contains("correlation length") && table.stdout.contains("95 %"),
        "{table:?}"
    );
}

#[test]
fn a_report_contains_process_tables_and_figures() {
    let folder = bench();
    let nested = "friction fit m.csv --column mu --distance-column position --report out --out out/process.json";
    run_in(folder.path(), nested).refuses(2, &["--out", "report folder"]);
    let line = "friction fit m.csv --column mu --distance-column position --detrend high_pass:10mm --report out --json";
    let json = run_in(folder.path(), line).json(0);
    let hyphen = line.replace("high_pass", "high-pass").replace(" --report out", "");
    assert_eq!(json["trend_variance_share"], run_in(folder.path(), &hyphen).json(0)["trend_variance_share"]);
    assert!(number(&json, "trend_variance_share") > 0.0);
    assert_eq!(written(&folder.path().join("out")), ["figures", "fit.json", "friction_process.json", "tables"]);
    let names = ["friction_acf", "friction_histogram", "friction_pit", "friction_qq", "friction_record"];
    assert_eq!(listing(&folder.path().join("out/tables")), names.map(|name| format!("{name}.csv")));
    let both_widths = names.map(|name| [format!("{name}.svg"), format!("{name}_one_column.svg")]).concat();
    assert_eq!(listing(&folder.path().join("out/figures")), both_widths);
    run_in(folder.path(), line).refuses(2, &["out", "not empty", "--force"]);
    run_in(folder.path(), &format!("{line} --force")).json(0);
}

#[test]
fn wrong_flags_and_unusable_records_name_the_remedy() {
    let folder = bench();
    let at = folder.path();
    let fit = |rest: &str| run_in(at, &format!("friction fit {rest}"));
    fit("forces.csv --column Force --time-column time --velocity 1mm/s --normal-force 10N")
        .refuses(2, &["forces.csv", "`Force`", "1 `time [ms]`", "2 `F [N]`"]);
    fit("forces.csv --column F --time-column time --normal-force 10N").refuses(2, &["sliding velocity"]);
    fit("forces.csv --column F --time-column time --velocity 1mm/s").refuses(2, &["normal force"]);
    fit("forces.csv --column F").refuses(2, &["--time-column", "--sampling-rate"]);
    for cutoff in ["high_pass:-1mm", "high-pass:-1mm"] {
        fit(&format!("m.csv --column mu --distance-column position --detrend {cutoff}"))
            .refuses(2, &["--detrend", "positive"]);
    }
    fit("m.csv --column mu --distance-column position --law gamma").refuses(2, &["gamma", "weibull"]);
    fit("m.csv --column mu --distance-column position --cut 1mm,2s")
        .refuses(2, &["--cut", "two times or two distances"]);
    fit("nothing.csv --column 1 --sampling-rate 1Hz --velocity 1m/s").refuses(3, &["nothing.csv", "no such file"]);
    fs::write(at.join("broken.csv"), "t,F\n0,1\n1,x\n2,1\n3,1\n4,1\n").unwrap();
    fit("broken.csv --column F --time-column t --time-unit s --unit - --velocity 1m/s")
        .refuses(3, &["line 3, column 2 (`F`)", "`x`"]);
    let few = fit("m.csv --column mu --distance-column position --cut 0mm,0.2mm --json");
    assert_eq!(few.json(4)["converged"], Value::Bool(false));

    let simulate = |rest: &str| run_in(at, &format!("friction simulate {rest} --length 1mm --step 10um --seed 1"));
    simulate("process.json --out m.txt").refuses(2, &[".csv or .npy"]);
    simulate("m.csv --out x.csv").refuses(3, &["m.csv", "not JSON"]);
    simulate("process.json --out process.json").refuses(2, &[".csv or .npy"]);
    fs::write(at.join("wrong.json"), PROCESS.replace("\"std\"", "\"sdt\"")).unwrap();
    simulate("wrong.json --out x.csv").refuses(3, &["`sdt`", "expected one of"]);
}
