use super::*;
use crate::monitor::Silent;
use crate::study::result::{InputKind, InputValue};
use crate::study::{RunRecord, Share};

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
        InputValue::Integer(number) => *number as f64,
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

/// A surface with friction.
const SURFACE: &str = "seed = 1\n[surface]\ncovariance = \"squared_exponential\"\nmarginal = \"normal\"\nrms_height = \"1 um\"\n\
                       correlation_length = \"20 um\"\n[material]\nyoungs_modulus = \"210 GPa\"\nhardness = \"2 GPa\"\n\
                       shear_strength = \"385 MPa\"\n[friction]\nstrip = [\"1600 um\", \"50 um\"]\npoints = [256, 8]\n\
                       window = \"100 um\"\npercentiles = [50.0]\nrealisations = 8\n";

#[test]
fn values_that_exclude_each_other_are_a_row_with_the_reason() {
    let lines = "[values]\nfriction.strip = [[\"800 um\", \"50 um\"], [\"1600 um\", \"50 um\"]]\nfriction.window = [\"60 um\", \"100 um\"]\n";
    let found = campaign(lines, SURFACE, None).unwrap();
    assert_eq!(found.refused.keys().collect::<Vec<_>>(), [&1], "{:?}", found.refused);
    assert!(found.refused[&1].contains("window"), "{:?}", found.refused);
}

/// Returns the keys with their units.
fn keys(campaign: &Campaign) -> Vec<(String, String)> {
    campaign.results(Vec::new()).keys.into_iter().map(|key| (key.key, key.unit)).collect()
}

#[test]
fn quantities_are_numbers_in_si_with_a_column_for_each_component() {
    let lines = "[zip]\nfriction.strip = [[\"800 um\", \"50 um\"], [\"1600 um\", \"50 um\"]]\nfriction.window = [\"60 um\", \"0.1 mm\"]\n\
                 surface.correlation_length = [\"20 um\", [\"20 um\", \"10 um\"]]\nfriction.percentiles = [[50.0], [40.0, 60.0]]\n";
    let found = campaign(lines, SURFACE, None).unwrap();
    let names = ["friction.strip[0]", "friction.strip[1]", "friction.window", "surface.correlation_length[0]"];
    let names = names.into_iter().chain(["surface.correlation_length[1]", "friction.percentiles"]);
    let wanted: Vec<_> =
        names.map(|name| (name.into(), if name.ends_with("percentiles") { "" } else { "m" }.into())).collect();
    assert_eq!(keys(&found), wanted);
    let mut second = values(&found).swap_remove(1);
    // Lists of different lengths stay as stated.
    assert_eq!(second.pop(), Some(InputValue::Name("[40.0, 60.0]".into())));
    assert_eq!(second, [1600e-6, 50e-6, 1e-4, 20e-6, 10e-6].map(InputValue::Number));
}

#[test]
fn uncertain_values_are_their_centres_with_standard_deviations() {
    let lines = "[values]\nvibration.normal_force = [\"2 kN\", \"4 ± 0.5 kN\"]\n";
    let found = campaign(lines, MACHINE, None).unwrap();
    let names = ["vibration.normal_force", "vibration.normal_force_std"];
    assert_eq!(keys(&found), names.map(|name| (name.into(), "N".into())));
    assert_eq!(numbers(&found), [[2e3, 0.0], [4e3, 500.0]]);
}

#[test]
fn seeds_are_written_exactly() {
    let found = campaign("[values]\nseed = [1, 9007199254740993]\n", MACHINE, None).unwrap();
    assert_eq!(values(&found), [[InputValue::Integer(1)], [InputValue::Integer(9_007_199_254_740_993)]]);
    let results = found.results(vec![Err("not computed".into()); 2]);
    assert!(serde_json::to_string(&results).unwrap().contains("[9007199254740993]"));
    let rows = String::from_utf8(folder::members_csv(&results).unwrap()).unwrap();
    assert!(rows.contains("2,,9007199254740993,"), "{rows}");
}

#[test]
fn a_resolved_campaign_has_the_seed_of_its_study() {
    let found = campaign("[values]\nvibration.damping_ratio = [0.1]\n", MACHINE, None).unwrap();
    let resolved = found.resolved();
    assert!(resolved.starts_with("seed = 5\n"), "{resolved}");
    let other = MACHINE.replace("seed = 5", "seed = 6");
    let again = Campaign::parse(&resolved, Path::new("/elsewhere/campaign.toml"), &other, None).unwrap();
    assert_eq!(again.seed(), 5);
}

#[test]
fn each_distinct_warning_is_listed_once_with_its_members() {
    let answered =
        |warnings: [&str; 2]| Ok(Answered { warnings: warnings.map(str::to_owned).to_vec(), ..Answered::default() });
    let found = member_warnings(&[
        answered(["3 of 10 windows carry no load", "the scan is small"]),
        Err("no scan".into()),
        answered(["4 of 10 windows carry no load", "5 of 10 windows carry no load"]),
    ]);
    let found: Vec<_> = found.iter().map(|found| (found.warning.as_str(), found.members.as_slice())).collect();
    assert_eq!(found, [("3 of 10 windows carry no load", &[1, 3][..]), ("the scan is small", &[1])]);
}

#[test]
fn a_missing_file_of_some_members_is_no_input() {
    let study = SURFACE.replace("[surface]", "[surface]\nfile = \"Cargo.toml\"");
    let inputs = |lines: &str| {
        let text = format!("study = \"study.toml\"\n{lines}");
        let inputs = Campaign::parse(&text, Path::new("sweep.toml"), &study, None).unwrap().inputs();
        inputs.iter().map(|file| file.file_name().unwrap().to_string_lossy().into_owned()).collect::<Vec<_>>()
    };
    assert_eq!(inputs("[values]\nsurface.file = [\"Cargo.toml\", \"gone.x3p\"]\n"), ["study.toml", "Cargo.toml"]);
    assert_eq!(inputs("[values]\nsurface.file = [\"gone.x3p\"]\n"), ["study.toml", "gone.x3p"]);
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

/// Writes a file when a stage begins.
struct Writes<'a>(&'a Path, String);

impl Monitor for Writes<'_> {
    fn progress(&self, _what: &str, _done: usize, _total: usize) {}

    fn cancelled(&self) -> bool {
        false
    }

    fn begin(&self, _stage: &str) {
        std::fs::write(self.0, &self.1).unwrap();
    }
}

#[test]
fn no_member_is_stored_whose_file_changed_meanwhile() {
    let process = |mean: f64| {
        format!(
            "{{\"format\":\"asperity friction process\",\"version\":1,\"mean\":{mean},\"std\":0,\
             \"origin\":{{\"kind\":\"stated\",\"description\":\"\"}}}}"
        )
    };
    let temporary = tempfile::tempdir().unwrap();
    let (folder, file) = (temporary.path(), temporary.path().join("b.json"));
    std::fs::write(folder.join("a.json"), process(0.3)).unwrap();
    std::fs::write(&file, process(0.2)).unwrap();
    let study = MACHINE.replace("static_friction = 0.3\nfriction_std = 0\n", "friction_process = \"a.json\"\n");
    let text = "study = \"study.toml\"\n[values]\nvibration.friction_process = [\"a.json\", \"b.json\"]\n";
    let found = Campaign::parse(text, &folder.join("sweep.toml"), &study, None).unwrap();
    let answers = |monitor: &dyn Monitor| {
        let blocks = RunBlocks::open(&folder.join("run"), RunRecord::default(), Share::All).unwrap();
        let found = found.run_with(Some(&blocks), monitor);
        blocks.flush().unwrap();
        found.map(|results| results.members.into_iter().map(|member| member.answers.friction_mean).collect::<Vec<_>>())
    };
    let error = answers(&Writes(&file, process(0.9))).unwrap_err();
    assert!(matches!(&error, StudyError::Changed(name) if name.ends_with("b.json")), "{error}");
    std::fs::write(&file, process(0.2)).unwrap();
    assert_eq!(answers(&Silent).unwrap(), [Some(0.3), Some(0.2)]);
}

#[test]
fn a_campaign_rests_on_the_inputs_that_all_its_members_have() {
    let own = |lines: &str, study: &str| {
        let found = campaign(lines, study, None).unwrap().run_with(None, &Silent).unwrap();
        found.rests_on.into_iter().map(|input| (input.input, input.kind)).collect::<BTreeMap<_, _>>()
    };
    let uncertain = MACHINE.replace("stribeck = 4.2", "stribeck = { uniform = [4, 5], unknown = true }");
    for study in [MACHINE, &uncertain] {
        let found = own("[values]\nvibration.damping_ratio = [0.1, 0.2]\n", study);
        let kind = if study == MACHINE { InputKind::Stated } else { InputKind::Unknown };
        assert_eq!(found.get("vibration.stribeck"), Some(&kind), "{found:?}");
        assert_eq!(found.get("vibration.mass"), Some(&InputKind::Stated));
        assert_eq!(found.get("vibration.kinetic_share"), Some(&InputKind::Default));
        assert!(!found.contains_key("vibration.damping_ratio"));
        assert!(!own("[values]\nvibration.stribeck = [4.0, 4.5]\n", study).contains_key("vibration.stribeck"));
    }
}
