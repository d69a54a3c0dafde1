//! Campaigns: rows that equal single runs, rows of failures, parts and restarts, and errors of their files.

use std::fs;
use std::path::Path;
use std::sync::LazyLock;

use asperity_testing::StudyText;
use ndarray::Array2;
use serde_json::Value;
use tempfile::TempDir;

use crate::support::{listing, npy, run_in, written};
#[cfg(target_os = "linux")]
use crate::support::{send, start_in, wait_for, wait_until};

/// A machine with linear weakening: some milliseconds with its verdict.
static MACHINE: LazyLock<String> = LazyLock::new(|| {
    StudyText::new(5, &["vibration"])
        .with("vibration", "static_friction = \"0.3 ± 0.01\"\nfriction_std = 0\ndamping_ratio = 0.05")
        .with("vibration", "dimensionless_belt_velocity = 0.1\nvelocity_law = \"linear\"")
        .with("vibration", "linear_weakening = \"0.1 ± 0.02\"")
        .with("verdict", "evaluations = 1000")
        .to_string()
});
/// A stated surface with friction and vibration, in a second.
static CHAIN: LazyLock<String> = LazyLock::new(|| {
    StudyText::new(5, &["surface", "material", "friction", "vibration"])
        .with("surface", "covariance = \"squared_exponential\"")
        .with("friction", "percentiles = [50.0]")
        .with("vibration", "damping_ratio = 0.4\nstribeck = 4.2\ndamping_sweep = [0.3, 0.5, 2]")
        .with("vibration", "trajectories = 32\nduration = 30.0")
        .to_string()
});

/// Returns a folder with a study and a campaign that varies it.
fn bench(study: &str, campaign: &str) -> TempDir {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("study.toml"), study).unwrap();
    fs::write(folder.path().join("sweep.toml"), format!("study = \"study.toml\"\n{campaign}")).unwrap();
    folder
}

const GRID: &str =
    "[values]\n\"vibration.damping_ratio\" = [0.03, 0.05, 0.08]\nvibration.normal_force = [\"2 kN\", \"4 kN\"]\n";

/// Returns the files of a campaign that equal campaigns give equal bytes.
fn results(campaign: &Path) -> [Vec<u8>; 2] {
    ["results.json", "members.csv"].map(|name| fs::read(campaign.join(name)).unwrap())
}

#[test]
#[ignore = "slow"]
fn a_campaign_is_a_folder_that_is_reproduced_and_resumed() {
    let folder = bench(&MACHINE, GRID);
    let at = folder.path();
    let found = run_in(at, "campaign sweep.toml --json").json(0);
    let members = found["members"].as_array().unwrap();
    assert_eq!((members.len(), &found["keys"][1]["unit"]), (6, &Value::from("N")));
    // The library compares members with single runs.
    assert!(members.iter().all(|member| member["failed"] == false && member["probability_interval"].is_array()));
    let campaign = at.join("campaigns/sweep");
    let names =
        ["COMPLETE", "campaign.toml", "figures", "members.csv", "provenance.json", "report.html", "results.json"];
    assert_eq!(written(&campaign), names);
    let rows = fs::read_to_string(campaign.join("members.csv")).unwrap();
    assert!(rows.starts_with("member,scan,vibration.damping_ratio,vibration.normal_force_n,friction_mean"), "{rows}");
    assert_eq!(rows.lines().count(), 7);
    // The resolved file gives the same from elsewhere.
    let before = results(&campaign);
    assert_eq!(run_in(at, "campaign campaigns/sweep/campaign.toml --out again").code, 0);
    assert_eq!(results(&at.join("again")), before);
    assert_eq!(run_in(at, "campaign sweep.toml --resume").code, 0);
    let shown = run_in(at, "campaign sweep.toml --resume").stdout;
    assert!(shown.contains("How probable is vibration? ") && shown.contains("\n\nmembers "), "{shown}");
    run_in(at, "campaign sweep.toml").refuses(2, &["campaigns/sweep is not empty: a run is already there"]);
    run_in(at, "campaign sweep.toml --resume --seed 6").refuses(2, &["another campaign"]);
    run_in(at, "report campaigns/sweep").refuses(3, &["is a campaign"]);
}

#[test]
#[ignore = "slow"]
fn members_with_the_same_contact_share_its_solution() {
    let folder =
        bench(&CHAIN, "[values]\nsurface.rms_height = [\"1 um\", \"2 um\"]\nvibration.damping_ratio = [0.35, 0.45]\n");
    let at = folder.path();
    let found = run_in(at, "campaign sweep.toml --json");
    assert!(found.stderr.contains("4 members; 2 friction stages"), "{found:?}");
    let members = found.json(0)["members"].clone();
    let status = run_in(at, "status campaigns/sweep --json").json(0);
    let counts: Vec<_> =
        status["rounds"].as_array().unwrap().iter().map(|round| round["done"].as_u64().unwrap()).collect();
    assert_eq!(counts, [2, 4], "{status}");
    for (index, (height, damping)) in [("1 um", "0.35"), ("2 um", "0.45")].into_iter().enumerate() {
        let study = CHAIN.replace("rms_height = \"1 um\"", &format!("rms_height = \"{height}\""));
        fs::write(at.join("one.toml"), study.replace("damping_ratio = 0.4", &format!("damping_ratio = {damping}")))
            .unwrap();
        // Members of exact values have no verdict, which has warnings of its own.
        let run = run_in(at, "run one.toml --only vibration --force --json").json(0);
        let (member, point) = (&members[3 * index], &run["friction"]["operating_point"]);
        assert_eq!((&member["friction_mean"], &member["friction_std"]), (&point["mean"], &point["std"]));
        for key in ["limit_damping_ratio", "kind"] {
            assert_eq!(member[key], run["vibration"][key], "{key}");
        }
        assert_eq!(member["warnings"].as_u64().unwrap() as usize, run["warnings"].as_array().unwrap().len());
    }
}

/// Writes a wavy map of 64 × 64 points.
fn scan(folder: &Path, name: &str, wave: f64) {
    let height = |(y, x): (usize, usize)| 1e-6 * ((wave * x as f64).sin() + (0.9 * wave * y as f64).cos());
    npy(folder, name, Array2::from_shape_fn((64, 64), height));
}

#[test]
fn a_campaign_of_another_schema_version_is_not_resumed() {
    let folder = bench(&MACHINE, "[values]\n\"vibration.damping_ratio\" = [0.05]\n");
    let at = folder.path();
    let resume = || run_in(at, "campaign sweep.toml --out c --resume");
    assert_eq!((resume().code, resume().code), (0, 0));
    let results = fs::read_to_string(at.join("c/results.json")).unwrap();
    for (version, found) in [
        ("\"schema_version\": 7,", "schema_version 7"),
        ("\"schema_version\": \"1\",", "schema_version \"1\""),
        ("\"schema_version\": null,", "no schema_version"),
        ("", "no schema_version"),
    ] {
        fs::write(at.join("c/results.json"), results.replace("\"schema_version\": 1,", version)).unwrap();
        resume().refuses(3, &[found, "reads version 1", "run the campaign again", "asperity campaign c/campaign.toml"]);
    }
    fs::write(at.join("c/results.json"), results).unwrap();
    fs::remove_file(at.join("c/COMPLETE")).unwrap();
    resume().refuses(3, &["c is not a finished run", "COMPLETE"]);
}

#[cfg(unix)]
#[test]
#[ignore = "slow"]
fn an_unusable_scan_is_a_row_with_its_reason() {
    let surface = "[surface]\nfile = \"any.npy\"\npixel_size = \"1 um\"\n";
    let folder = bench(&format!("seed = 1\n{surface}"), "scans = \"lot-*/**/*.npy\"\n");
    let at = folder.path();
    run_in(at, "campaign sweep.toml").refuses(3, &["sweep.toml:2", "no file matches"]);
    for (lot, name, wave) in [("lot-2", "b.npy", 0.5), ("lot-1/deep", "a.npy", 0.7)] {
        fs::create_dir_all(at.join(lot)).unwrap();
        scan(&at.join(lot), name, wave);
    }
    fs::write(at.join("lot-2/bad.npy"), "no heights").unwrap();
    std::os::unix::fs::symlink("nowhere.npy", at.join("lot-2/lost.npy")).unwrap();
    let found = run_in(at, "campaign sweep.toml --json").json(0);
    let members = found["members"].as_array().unwrap();
    let names: Vec<&str> = members.iter().map(|member| member["scan"].as_str().unwrap()).collect();
    assert_eq!(names, ["lot-1/deep/a.npy", "lot-2/b.npy", "lot-2/bad.npy", "lot-2/lost.npy"]);
    let failed: Vec<bool> = members.iter().map(|member| member["failed"].as_bool().unwrap()).collect();
    assert_eq!(failed, [false, false, true, true], "{found}");
    for (place, name) in [(2, "lot-2/bad.npy"), (3, "lot-2/lost.npy")] {
        let reason = members[place]["reason"].as_str().unwrap();
        assert!(reason.starts_with(name), "{reason}");
    }
    assert_eq!(found["warnings"][0], "2 of 4 members have no answer");
    // So is a missing file of a list.
    fs::write(
        at.join("list.toml"),
        "study = \"study.toml\"\n[values]\nsurface.file = [\"lot-2/b.npy\", \"gone.npy\"]\n",
    )
    .unwrap();
    let found = run_in(at, "campaign list.toml --json").json(0);
    let gone = &found["members"][1];
    assert!(
        gone["reason"].as_str().unwrap().starts_with("gone.npy") && !found["members"][0]["failed"].as_bool().unwrap()
    );
    // Without any answer the rows are still written.
    fs::write(at.join("lot-2/b.npy"), "no heights").unwrap();
    fs::write(at.join("lot-1/deep/a.npy"), "").unwrap();
    let found = run_in(at, "campaign sweep.toml --json --force");
    assert!(found.stderr.contains("no member has an answer"), "{found:?}");
    assert_eq!(found.json(4)["members"].as_array().unwrap().len(), 4);
}

#[test]
#[ignore = "slow"]
fn parts_make_the_whole_campaign() {
    let exact = MACHINE.replace("\"0.3 ± 0.01\"", "0.3").replace("\"0.1 ± 0.02\"", "0.1");
    let folder = bench(&exact, &format!("{GRID}[sample]\ncount = 3\nvibration.static_friction = \"0.3 ± 0.02\"\n"));
    let at = folder.path();
    assert_eq!(run_in(at, "campaign sweep.toml --out whole/sweep").code, 0);
    for number in [1, 2] {
        let line = format!("campaign sweep.toml --shard {number}/2 --out parts/{number} --threads {number} --json");
        let part = run_in(at, &line).json(0);
        assert_eq!((&part["rounds"][0]["done"], &part["rounds"][0]["expected"]), (&Value::from(9), &Value::from(18)));
    }
    run_in(at, "merge parts/1 --out all").refuses(3, &["campaign: members (9 of 18 blocks)"]);
    assert_eq!(run_in(at, "merge parts/1 parts/2 --out all").code, 0);
    assert_eq!(results(&at.join("all")), results(&at.join("whole/sweep")));
    assert_eq!(
        fs::read(at.join("all/campaign.toml")).unwrap(),
        fs::read(at.join("whole/sweep/campaign.toml")).unwrap()
    );
    // A campaign with another seed has other samples.
    assert_eq!(run_in(at, "campaign sweep.toml --out other --seed 6").code, 0);
    assert_ne!(results(&at.join("other")), results(&at.join("whole/sweep")));
}

#[cfg(target_os = "linux")]
#[test]
#[ignore = "slow"]
fn a_killed_campaign_goes_on_with_the_same_bytes() {
    let machine = MACHINE.replace("evaluations = 1000", "evaluations = 4096\nhalf_width = 0.01");
    let folder =
        bench(&machine, "[values]\nvibration.damping_ratio = [0.03, 0.04, 0.045, 0.05, 0.055, 0.06, 0.065, 0.08]\n");
    let at = folder.path();
    assert_eq!(run_in(at, "campaign sweep.toml --out whole/sweep").code, 0);
    let started = start_in(at, "campaign sweep.toml --out killed/sweep --threads 1");
    let blocks = at.join("killed/.asperity-blocks");
    let has_members = |stage: &String| listing(&blocks.join(stage)).iter().any(|name| name.ends_with(".blocks"));
    let stages = || listing(&blocks).into_iter().filter(|name| blocks.join(name).is_dir()).collect::<Vec<_>>();
    wait_until("the first members", || blocks.is_dir() && stages().iter().any(has_members));
    send("-KILL", &started);
    assert_ne!(wait_for(started).code, 0);
    let before = run_in(at, "status killed/sweep --json").json(0)["rounds"][0]["done"].as_u64().unwrap();
    assert!((1..8).contains(&before), "{before} members before the kill");
    assert_eq!(run_in(at, "campaign sweep.toml --out killed/sweep --threads 2").code, 0);
    assert_eq!(results(&at.join("killed/sweep")), results(&at.join("whole/sweep")));
}

#[test]
fn a_law_per_unit_of_dimensionless_velocity_under_another_load_is_a_warning() {
    let exact = MACHINE.replace("\"0.3 ± 0.01\"", "0.3").replace("\"0.1 ± 0.02\"", "0.1");
    let in_si = exact
        .replace("dimensionless_belt_velocity = 0.1", "belt_velocity = \"0.4 m/s\"\nstribeck = \"0.5 s/m\"")
        .replace("velocity_law = \"linear\"\nlinear_weakening = 0.1\n", "");
    let forces = "[values]\nvibration.normal_force = [\"2 kN\", \"3 kN\"]\n";
    let both = ["`linear_weakening` and `dimensionless_belt_velocity` are per unit", "vibration.normal_force changes"];
    for (study, campaign, words) in [
        (&exact, forces, &both[..]),
        (&exact, "[values]\nvibration.damping_ratio = [0.1, 0.2]\n", &[]),
        (&in_si, forces, &[]),
        (&in_si.replace("\"0.5 s/m\"", "4.2"), forces, &["`stribeck` is per unit"]),
    ] {
        let folder = bench(study, campaign);
        let found = run_in(folder.path(), "campaign sweep.toml --json").json(0);
        let warnings = found["warnings"].as_array().unwrap();
        assert_eq!(warnings.len(), usize::from(!words.is_empty()), "{campaign}: {warnings:?}");
        assert!(words.iter().all(|word| warnings[0].as_str().unwrap().contains(word)), "{warnings:?}");
    }
}

#[test]
fn errors_of_a_campaign_name_its_line() {
    let cases: [(&str, u32, &[&str]); 17] = [
        ("[values]\nvibration.damping_rati = [0.1]\n", 3, &["vibration.damping_rati", "did you mean `damping_ratio`?"]),
        ("[values]\n\"vibration.mass\" = [\"1 kg\", \"2 m\"]\n", 3, &["`m` is not a unit of mass"]),
        ("[values]\nvibration.damping_ratio = 0.1\n", 3, &["a list of values"]),
        ("[values]\n\nvibration.damping_ratio = [0.1, -0.1]\n", 4, &["damping_ratio", "-0.1"]),
        ("[values.vibration]\nmass = [\"1 kg\"]\n[zip]\nvibration.mass = [\"2 kg\"]\n", 5, &["listed twice"]),
        ("[zip]\nvibration.damping_ratio = [0.1, 0.2]\nvibration.mass = [\"1 kg\"]\n", 4, &["has 1 value,", "has 2"]),
        ("[sample]\nvibration.damping_ratio = \"0.1 .. 0.2\"\n", 2, &["no `count`"]),
        ("[sample]\ncount = 2\nvibration.damping_ratio = 0.1\n", 4, &["not a distribution"]),
        ("[sample]\ncount = 2\nvibration.damping_ratio = \"0.01 ± 0.02\"\n", 4, &["lies outside"]),
        ("[sample]\ncount = 0\nvibration.damping_ratio = \"0.1 .. 0.2\"\n", 3, &["a whole number from 1 to 100000"]),
        ("[sample]\ncount = 100000000000\nvibration.damping_ratio = \"0.1 .. 0.2\"\n", 3, &["to 100000"]),
        (
            "[values]\nseed = [1, 2, 3]\n[sample]\ncount = 50000\nvibration.damping_ratio = \"0.1 .. 0.2\"\n",
            1,
            &["150000 members, more than 100000"],
        ),
        ("[value]\nvibration.damping_ratio = [0.1]\n", 2, &["did you mean `values`?"]),
        ("", 1, &["nothing differs"]),
        ("scans = [\"a\"]\n", 2, &["found [\"a\"], expected one pattern"]),
        ("scans = \"*.toml\"\n", 2, &["the study states its friction"]),
        ("[values]\nfriction.window = [\"1 mm\"]\n", 3, &["need a [surface] section"]),
    ];
    for (campaign, line, words) in cases {
        let folder = bench(&MACHINE, campaign);
        let found = run_in(folder.path(), "campaign sweep.toml");
        found.refuses(2, words);
        assert!(found.stderr.contains(&format!("sweep.toml:{line}: ")), "{campaign}: {found:?}");
        assert_eq!(listing(folder.path()), ["study.toml", "sweep.toml"]);
    }
    let folder = bench(&MACHINE.replace("mass = ", "mas = "), GRID);
    run_in(folder.path(), "campaign sweep.toml").refuses(2, &["study.toml:3: ", "did you mean `mass`?"]);
    let folder = bench(&MACHINE, GRID);
    fs::remove_file(folder.path().join("study.toml")).unwrap();
    run_in(folder.path(), "campaign sweep.toml").refuses(3, &["study.toml: no such file"]);
}
