//! A friction process fitted to a record: `cargo run --example friction`.
//!
//! The record is simulated from a known process and written as text in columns, like the file of a tribometer.

#![expect(clippy::print_stdout, reason = "the numbers are what this example shows")]

use std::error::Error;

use asperity::friction::measured::{
    Abscissa, ColumnTable, DistributionChoice, FittedRecord, MeasuredRecord, RecordColumns, RecordPreparation,
};
use asperity::friction::process::{FrictionProcess, ProcessModel, TranslationKind};

fn main() -> Result<(), Box<dyn Error>> {
    // μ = 0.21 ± 0.008, Beta(2.1, 5), correlation e^{−s/ℓ} with ℓ = 250 µm (Gaus et al. 2016); 10,000 values every 10 µm.
    let (mean, std, length_m) = (0.21, 0.008, 250e-6);
    let model = ProcessModel {
        correlation: TranslationKind::Corrected,
        ..ProcessModel::new("beta:2.1,5".parse()?, std, length_m)
    };
    let process = FrictionProcess::with_step(model, 10e-6)?;
    let mut path = process.path(11, 0);
    let mut text = String::from("s [mm], mu [-]\n");
    for i in 0..10_000 {
        text += &format!("{:.2},{:.6}\n", 0.01 * f64::from(i), mean + path.next_value());
    }

    let columns = RecordColumns {
        column: "mu".into(),
        unit: None,
        abscissa: Abscissa::Distance { column: "s".into(), unit: None },
        velocity_m_per_s: None,
        normal_force: None,
    };
    let record = MeasuredRecord::new(&ColumnTable::read(text.as_bytes())?, &columns)?;
    let fitted =
        FittedRecord::new(&RecordPreparation::default().apply(&record)?, DistributionChoice::Auto, "simulated")?
            .process;

    let interval = |ends: Option<[f64; 2]>, unit: f64, digits: usize| match ends {
        Some([low, high]) => format!("[{:.digits$}, {:.digits$}]", low * unit, high * unit),
        None => "–".to_owned(),
    };
    println!("quantity              fitted     95 % interval       true");
    println!("mean                  {:.4}     {}    {mean:.4}", fitted.mean, interval(fitted.mean_interval, 1.0, 4));
    println!("standard deviation    {:.5}    {}  {std:.5}", fitted.std, interval(fitted.std_interval, 1.0, 5));
    let found = fitted.correlation.ok_or("no correlation")?;
    println!(
        "correlation length    {:.0} µm     {} µm       {:.0} µm",
        1e6 * found.length_m,
        interval(found.length_interval_m, 1e6, 0),
        1e6 * length_m
    );
    println!("correlation           {}                       exponential", found.shape.name());
    let law = fitted.marginal.ok_or("no distribution")?;
    println!("distribution          {}, skewness {:+.2}              beta, skewness +0.56", law.name(), law.skewness());
    Ok(())
}
