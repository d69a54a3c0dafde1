//! Stick-slip cycle of a mass on a belt: `cargo run --example stick_slip`.
//!
//! The machine of N. Gaus, C. Proppe and C. Zaccardi (2016). Times are in units of 1/ω₀, displacements in N/c. The
//! reference values come from a high-precision integration.

#![expect(clippy::print_stdout, reason = "the numbers are what this example shows")]

use std::error::Error;

use asperity::vibration::law::Stribeck;
use asperity::vibration::{Oscillator, Parameters, critical_damping, limit_cycle};

fn main() -> Result<(), Box<dyn Error>> {
    let law = Stribeck { kinetic: 0.1, decay: 4.2 }.into();
    let machine = Parameters { static_friction: 0.1, law, damping_ratio: 0.17, belt_velocity: 0.003, forcing: None };
    let oscillator = Oscillator::new(machine)?;
    let motion = limit_cycle(&oscillator)?;
    let cycle = motion.cycle().ok_or("no limit cycle")?;
    let reattachment = cycle.reattachment_displacement.ok_or("no stick")?;
    let limits = critical_damping(&oscillator)?;

    println!("kind of motion: {}", cycle.kind.name());
    println!("quantity                         computed              reference");
    for (name, found, reference) in [
        ("period", cycle.period, 6.372_163_483_739_709),
        ("time in slip", cycle.slip_duration, 5.644_059_891_168_911),
        ("displacement at re-attachment", reattachment, 0.096_795_689_222_687_6),
        ("least displacement", cycle.displacement_min, 0.095_239_651_620_418_2),
        ("largest displacement", cycle.displacement_max, 0.101_931_013_749_859_7),
        ("damping ratio that ends it", limits.critical_damping_ratio, 0.204_830_150_584_523),
    ] {
        println!("{name:<32} {found:<21.15} {reference:<.15}");
    }

    // In SI units: with 2.5 kN, 1 kg and 316 rad/s the unit of displacement is 25 mm.
    let unit_m = 2500.0 / (1.0 * 316.0_f64.powi(2));
    let amplitude_m = 0.5 * (cycle.displacement_max - cycle.displacement_min) * unit_m;
    println!("amplitude {:.1} µm at {:.1} Hz", 1e6 * amplitude_m, 316.0 / cycle.period);
    Ok(())
}
