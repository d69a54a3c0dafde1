//! Tests of the flags of every command, and of messages about wrong ones.

use crate::support::asperity;

#[test]
fn help_and_version_are_data_and_name_every_command_and_exit_code() {
    let help = asperity("--help");
    assert_eq!((help.code, help.stderr.as_str()), (0, ""));
    for word in ["init", "run", "schema", "vibration", "--threads", "--quiet", "130", "not converged"] {
        assert!(help.stdout.contains(word), "{word}: {help:?}");
    }
    let version = asperity("--version");
    assert_eq!(version.stdout, format!("asperity {}\n", env!("CARGO_PKG_VERSION")));
}

#[test]
fn a_wrong_command_or_flag_is_a_usage_error_with_the_nearest_right_one() {
    asperity("").refuses(2, &["Usage"]);
    asperity("surface").refuses(2, &["Usage"]);
    asperity("contct").refuses(2, &["contct", "contact"]);
    asperity("surface convert a.npy").refuses(2, &["OUTPUT"]);
    asperity("surface convert a.npy b.npy --pixelsize 1um").refuses(2, &["--pixelsize", "--pixel-size"]);
    asperity("surface convert a.npy b.npy --threads 0").refuses(2, &["--threads", "at least 1"]);
    asperity("--threads 1000000000 surface convert a.npy b.npy").refuses(2, &["--threads", "at most"]);
    asperity("--threads two surface convert a.npy b.npy").refuses(2, &["--threads", "two"]);
}

#[test]
fn errors_and_warnings_have_colours_where_they_are_asked_for() {
    let refused = |variables: &[(&str, &str)]| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_asperity"));
        command.args(["run", "absent.toml"]).env_remove("CLICOLOR_FORCE");
        String::from_utf8(command.envs(variables.iter().copied()).output().unwrap().stderr).unwrap()
    };
    assert!(refused(&[]).starts_with("error: absent.toml"));
    assert!(refused(&[("CLICOLOR_FORCE", "1")]).starts_with("\u{1b}[31m\u{1b}[1merror:\u{1b}[0m absent.toml"));
}

#[test]
fn thousands_of_threads_in_the_environment_are_refused() {
    let formats = |threads: &str| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_asperity"));
        command.arg("formats").env("RAYON_NUM_THREADS", threads).output().unwrap()
    };
    let refused = formats("5000");
    assert_eq!(refused.status.code(), Some(2));
    let message = String::from_utf8(refused.stderr).unwrap();
    assert!(message.contains("RAYON_NUM_THREADS: 5000") && message.contains("at most 1024"), "{message}");
    for usual in ["", "0", "3", "many"] {
        assert!(formats(usual).status.success(), "{usual}");
    }
}

#[test]
fn a_schema_is_one_json_object_with_the_name_of_its_file() {
    for (line, id, key) in [
        ("schema", "urn:asperity:results:1", "/$defs/Results/properties/schema_version"),
        ("schema results", "urn:asperity:results:1", "/$defs/Results/properties/verdict"),
        ("schema results", "urn:asperity:results:1", "/$defs/CampaignResults/properties/members"),
        ("schema study", "urn:asperity:study", "/properties/vibration"),
    ] {
        let schema = asperity(line).json(0);
        assert_eq!(schema["$id"], id, "{line}");
        assert!(schema.pointer(key).unwrap()["description"].is_string(), "{line}: {key}");
    }
    asperity("schema report").refuses(2, &["report", "study", "results"]);
}

#[test]
fn a_wrong_seed_is_named_and_help_of_outputs_refers_to_formats() {
    for line in [
        "run study.toml --seed",
        "surface generate spec.toml --out a.x3p --seed",
        "surface fill scan.x3p --out a.x3p --seed",
        "surface twin scan.x3p --out twins --seed",
        "vibration ensemble --seed",
        "friction simulate process.json --length 1mm --step 1um --out m.csv --seed",
    ] {
        for seed in ["-1", "1.5", "9223372036854775808"] {
            asperity(&format!("{line} {seed}")).refuses(2, &["--seed", "whole number from 0 to 9223372036854775807"]);
        }
    }
    // The help of a command describes its results.
    for (command, words) in [
        ("stats", ["at which it falls to 1/e", "structure functions", "95 % intervals"]),
        ("generate", ["falls to 1/e", "the scale for matern", "roll-off length"]),
        ("modes", ["in m on an interval", "in m² on a rectangle", "The variance is 1"]),
        ("twin", ["comparison.json", "roll-off", "39"]),
    ] {
        let help = asperity(&format!("surface {command} --help")).stdout;
        let help = help.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(words.iter().all(|word| help.contains(word)), "{words:?}: {help}");
    }
    for command in ["generate", "fill", "convert"] {
        let help = asperity(&format!("surface {command} --help")).stdout;
        assert!(help.contains("asperity formats") && !help.contains(".dat"), "{help}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn computations_beyond_the_memory_are_refused_before_they_start() {
    let line = "surface modes --covariance exponential --correlation-length 1m --size 1m --points 20000000 --modes 2";
    asperity(line).refuses(5, &["eigenproblem", "GB of memory are free"]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_a_lack_of_resources() {
    // /dev/full answers every write with "no space left".
    let line = "surface modes --covariance exponential --correlation-length 1m --size 1m --points 8 --modes 2 --json";
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_asperity"))
        .args(line.split_whitespace())
        .stdout(std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap())
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(5), "{output:?}");
}
