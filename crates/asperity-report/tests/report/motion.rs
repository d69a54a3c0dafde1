//! The vibration section.

use crate::documents::{text, words};
use crate::synthetic::full_run;
use asperity_report::render;

#[test]
fn the_vibration_section_has_limits_rates_and_the_portrait() {
    let run = full_run();
    let html = text(&render(&run).unwrap().html).replace('\u{a0}', " ");
    for wanted in [
        "0.1516 [0.1514, 0.1518]",
        "Losses of vibration per τ in it",
        ">overtaking</th>",
        "vibration takes more than 5 % of the time",
        "0.00826 [0.00787, 0.00867]",
        "0.995 [0.982, 0.999]",
        "0.11370 ± 0.00070",
        "Distribution of the points at which the mass leaves the belt",
        "tables/phase_cloud.csv",
    ] {
        assert!(html.contains(wanted), "{wanted:?} is on the page");
    }
    let portrait = words(&run, "limit_cycle");
    for wanted in ["many trajectories", "one stochastic trajectory", "deterministic limit cycle"] {
        assert!(portrait.contains(&wanted.to_owned()), "{wanted} in {portrait:?}");
    }
    let lost = words(&run, "sustained_over_damping");
    assert!(
        lost.contains(&"Sustained vibration, fraction".to_owned()) && lost.contains(&"Cycles per period 2π".to_owned())
    );
    // Constant friction has no motion; and a run without the length of the trajectories.
    let mut run = full_run();
    run.tables.remove("phase_cloud");
    run.inputs.retain(|input| input.key != "duration");
    run.results.vibration.as_mut().unwrap().paper.motion = None;
    let html = text(&render(&run).unwrap().html);
    assert!(!html.contains("Losses of vibration per τ in it"));
    assert!(!words(&run, "limit_cycle").contains(&"many trajectories".to_owned()));
    assert!(!words(&run, "sustained_over_damping").contains(&"Cycles per period 2π".to_owned()));
}
