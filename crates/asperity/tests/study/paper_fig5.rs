//! Figure 5 of the paper: cycles against damping under stochastic friction.

use std::fs;
use std::path::PathBuf;

use asperity::monitor::Silent;
use asperity::study::StudyFile;

/// ζ, mean number of cycles of 4,000 trajectories and its standard error from two independent codes, and the number
/// without noise.
const KNOWN: [(f64, f64, f64, u64); 3] = [(0.17, 68.99, 0.10, 99), (0.22, 34.31, 0.11, 0), (0.25, 17.18, 0.08, 0)];

#[test]
#[ignore = "slow"]
fn noise_removes_cycles_below_critical_damping_and_adds_some_above_it() {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../studies/paper_fig5.toml");
    let mut study = StudyFile::parse(&fs::read_to_string(&path).unwrap(), "paper_fig5.toml").unwrap();
    let section = study.vibration.as_mut().unwrap();
    section.trajectories = 400;
    let map = section.map.as_mut().unwrap();
    (map.depth, map.trajectories) = (0, 20);
    let outcome = study.check().unwrap().run(path.parent().unwrap(), None, &Silent).unwrap();
    let (_, points) = outcome.tables.iter().find(|(name, _)| name.as_str() == "map_points").unwrap();
    let [damping, share] = ["damping_ratio", "sustained_share"].map(|name| points.column(name).unwrap());
    for (damping, share) in damping.iter().zip(share) {
        assert!(*damping > 0.1 || *share > 0.95, "{damping}: {share}");
    }
    let vibration = outcome.results.vibration.unwrap();
    assert!((vibration.correlation_length.unwrap() - 0.01).abs() < 2e-6);
    let critical = vibration.critical_damping_ratio.unwrap();
    assert!((critical - 0.204_830_150_584_523).abs() < 1e-10);
    let damping = &vibration.paper.damping;
    assert_eq!(damping.len(), 12);
    for (ratio, mean, se, deterministic) in KNOWN {
        let found = damping.iter().find(|d| (d.damping_ratio - ratio).abs() < 1e-9).unwrap();
        assert_eq!(found.cycles_deterministic, deterministic);
        assert!((found.cycles_mean - mean).abs() < 3.0 * found.cycles_se.hypot(se), "{found:?} instead of {mean}");
    }
    // The fall of the time in vibration, smeared by noise about the sharp end; at the damping ratios of the sweep it
    // agrees with the sweep.
    let crossings = &vibration.paper.crossings;
    assert_eq!(crossings.iter().map(|c| c.share).collect::<Vec<_>>(), [0.95, 0.5, 0.05]);
    for crossing in crossings {
        let ([low, high], ratio) = (crossing.damping_ratio_interval.unwrap(), crossing.damping_ratio.unwrap());
        assert!(low <= ratio && ratio <= high && high - low < 0.02, "{crossing:?}");
        for found in damping {
            // The fractions fall with the damping, up to sampling errors.
            let slack = 3.0 * found.vibration_share_se;
            if found.damping_ratio < low {
                assert!(found.vibration_share > crossing.share - slack, "{found:?} and {crossing:?}");
            }
            if found.damping_ratio > high {
                assert!(found.vibration_share < crossing.share + slack, "{found:?} and {crossing:?}");
            }
        }
    }
    let at = |k: usize| crossings[k].damping_ratio.unwrap();
    assert!(at(0) < critical - 0.01 && at(0) < at(1) && at(1) < at(2) && at(2) > critical, "{crossings:?}");
    for pair in damping.windows(2) {
        assert!(pair[1].cycles_mean < pair[0].cycles_mean);
        assert!(pair[1].sustained_share_interval[0] <= pair[0].sustained_share_interval[1], "{pair:?}");
    }
    // Averaged over the nominal area, the same friction changes the cycles only near their end.
    let area = &vibration.area;
    assert!(area.friction_std < 0.02 * vibration.paper.friction_std);
    // There the fall is as sharp as the end itself.
    for crossing in &area.crossings {
        assert!((crossing.damping_ratio.unwrap() - critical).abs() < 0.01, "{crossing:?}");
    }
    for found in area.damping.iter().filter(|d| d.damping_ratio < critical - 0.01) {
        assert!(found.difference_mean.abs() < 0.5, "{found:?}");
    }
    let motion = vibration.paper.motion.unwrap();
    assert!(motion.exit_rate_interval.unwrap()[0] > 0.0 && motion.entry_rate.unwrap() > motion.exit_rate.unwrap());
    assert!(motion.stick_share > 0.05 && motion.stick_share < 0.2);
}
