use super::*;
use crate::monitor::Silent;

const MACHINE: &str = "seed = 5\n[vibration]\nmass = \"1 kg\"\nnatural_frequency = \"316 rad/s\"\nnormal_force = \"2.5 kN\"\n\
                       nominal_area = \"833 mm^2\"\nstatic_friction = 0.3\nfriction_std = 0\ndimensionless_belt_velocity = 0.1\n\
                       stribeck = 4.2\ndamping_ratio = 0.05\n";

fn campaign(lines: &str, study: &str, seed: Option<u64>) -> Result<Campaign, StudyFileError> {
    Campaign::parse(&format!("study = \"study.toml\"\n{lines}"), Path::new("sweep.toml"), study, seed)
}

/// Returns the values of all members.
fn values(campaign: &Campaign) -> Vec<Vec<InputValue>> {
    let rows = campaign.results(vec![Err("not computed".into()); campaign.members()]);
    rows.members.into_iter().map(|member| member.values).collect()
}

fn numbers(campaign: &Campaign) -> Vec<Vec<f64>> {
    let number = |value: &InputValue| match value {
        InputValue::Number(number) => *number,
        InputValue::Name(text) => panic!("{text} is not a number"),
    };
    values(campaign).iter().map(|row| row.iter().map(number).collect()).collect()
}

#[test]
fn a_grid_has_all_combinations_in_the_order_written() {
    let lines = "[values]\nvibration.normal_force = [\"2 kN\", \"4000 N\"]\n\"vibration.damping_ratio\" = [0.1, 0.2]\n\
                 [zip]\nvibration.mass = [\"1 kg\", \"2 kg\"]\nseed = [7, 8]\n";
    let found = numbers(&campaign(lines, MACHINE, None).unwrap());
    let mut wanted = Vec::new();
    for force in [2e3, 4e3] {
        for damping in [0.1, 0.2] {
            wanted.extend([[1.0, 7.0], [2.0, 8.0]].map(|[mass, seed]| vec![force, damping, mass, seed]));
        }
    }
    assert_eq!(found, wanted);
}

#[test]
fn each_stratum_of_a_sampled_distribution_has_one_member() {
    let lines = "[sample]\ncount = 50\nvibration.normal_force = \"8 .. 12 kN\"\nvibration.damping_ratio = { normal = [0.2, 0.01] }\n";
    let sampled = campaign(lines, MACHINE, None).unwrap();
    let found = numbers(&sampled);
    let mut strata: Vec<usize> = found.iter().map(|row| ((row[0] - 8e3) / 80.0) as usize).collect();
    strata.sort();
    assert_eq!(strata, (0..50).collect::<Vec<_>>());
    // Half of a normal distribution lies below its mean.
    assert_eq!(found.iter().filter(|row| row[1] < 0.2).count(), 25);
    assert_ne!(numbers(&campaign(lines, MACHINE, Some(6)).unwrap()), found);
    assert_eq!(numbers(&campaign(lines, MACHINE, Some(5)).unwrap()), found);
    assert!(sampled.results(Vec::new()).keys.iter().all(|key| key.sampled));
}

#[test]
fn values_that_exclude_each_other_are_a_row_with_the_reason() {
    let study = "seed = 1\n[surface]\ncovariance = \"squared_exponential\"\nmarginal = \"normal\"\nrms_height = \"1 um\"\n\
                 correlation_length = \"20 um\"\n[material]\nyoungs_modulus = \"210 GPa\"\nhardness = \"2 GPa\"\n\
                 shear_strength = \"385 MPa\"\n[friction]\nstrip = [\"1600 um\", \"50 um\"]\npoints = [256, 8]\nwindow = \"100 um\"\n\
                 percentiles = [50.0]\nrealisations = 8\n";
    let lines = "[values]\nfriction.strip = [[\"800 um\", \"50 um\"], [\"1600 um\", \"50 um\"]]\nfriction.window = [\"60 um\", \"100 um\"]\n";
    let found = campaign(lines, study, None).unwrap();
    assert_eq!(found.refused.keys().collect::<Vec<_>>(), [&1], "{:?}", found.refused);
    assert!(found.refused[&1].contains("window"), "{:?}", found.refused);
    // A quantity that cannot be uncertain stays as stated.
    assert_eq!(values(&found)[2][1], InputValue::Name("60 um".into()));
}

#[test]
fn a_resolved_campaign_is_the_same_from_every_folder() {
    let lines = "seed = 9\n[sample]\ncount = 4\nvibration.normal_force = \"8 .. 12 kN\"\n";
    let found = campaign(lines, MACHINE, Some(11)).unwrap();
    let resolved = found.resolved();
    assert!(resolved.contains("seed = 11\n[sample]") && !resolved.contains("\"study.toml\""), "{resolved}");
    let again = Campaign::parse(&resolved, Path::new("/elsewhere/campaign.toml"), MACHINE, None).unwrap();
    assert_eq!(numbers(&again), numbers(&found));
    assert_eq!((again.study_folder(), again.seed(), again.resolved()), (found.study_folder(), 11, resolved));
}

#[test]
fn a_member_is_its_study() {
    let found = campaign("[values]\nvibration.damping_ratio = [0.05, 0.3]\n", MACHINE, None).unwrap();
    let results = found.run_with(None, &Silent).unwrap();
    for (member, damping) in results.members.iter().zip(["0.05", "0.3"]) {
        let text = MACHINE.replace("damping_ratio = 0.05", &format!("damping_ratio = {damping}"));
        let outcome = Study::parse(&text, "study.toml").unwrap().run(Path::new("."), None, &Silent).unwrap();
        let vibration = outcome.results.vibration.unwrap();
        assert_eq!(member.answers.limit_damping_ratio, vibration.limit_damping_ratio);
        assert_eq!((member.answers.kind, member.failed), (Some(vibration.kind), false));
        assert_eq!(member.answers.warnings, Some(outcome.results.warnings.len()));
    }
}
