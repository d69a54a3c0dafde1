//! Tests of the completions in a real shell, and of the manual pages.

use std::fs;
use std::process::Command;

use crate::support::asperity;

/// Returns the completions that bash offers for the last word of a command line.
fn bash_offers(folder: &std::path::Path, words: &[&str]) -> Vec<String> {
    let script = r#"
        source completions.bash || exit 1
        COMP_WORDS=("$@")
        COMP_CWORD=$(($# - 1))
        function=$(complete -p asperity | sed 's/.*-F \([^ ]*\) .*/\1/')
        "$function" asperity "${COMP_WORDS[COMP_CWORD]}" "${COMP_WORDS[COMP_CWORD - 1]}"
        printf '%s\n' "${COMPREPLY[@]}"
    "#;
    let output = Command::new("bash").args(["-c", script, "bash"]).args(words).current_dir(folder).output().unwrap();
    assert!(output.status.success() && output.stderr.is_empty(), "{words:?}: {output:?}");
    String::from_utf8(output.stdout).unwrap().split_whitespace().map(str::to_owned).collect()
}

#[test]
fn bash_completes_commands_flags_and_values() {
    let folder = tempfile::tempdir().unwrap();
    let script = asperity("completions bash");
    assert_eq!((script.code, script.stderr.as_str()), (0, ""));
    fs::write(folder.path().join("completions.bash"), script.stdout).unwrap();
    let offers = |words: &[&str]| bash_offers(folder.path(), words);
    assert_eq!(offers(&["asperity", "conta"]), ["contact"]);
    assert_eq!(offers(&["asperity", "contact", "--mean-p"]), ["--mean-pressure"]);
    assert_eq!(offers(&["asperity", "contact", "--boundary", "per"]), ["periodic"]);
    assert_eq!(offers(&["asperity", "surface", "tw"]), ["twin"]);
}

#[test]
fn every_shell_has_completions_and_an_unknown_one_is_refused() {
    for (shell, word) in
        [("zsh", "#compdef asperity"), ("fish", "complete -c asperity"), ("powershell", "Register-ArgumentCompleter")]
    {
        let script = asperity(&format!("completions {shell}"));
        assert!(script.code == 0 && script.stdout.contains(word), "{shell}: {script:?}");
        assert!(script.stdout.contains("critical-damping"), "{shell}: {script:?}");
    }
    asperity("completions csh").refuses(2, &["csh", "bash", "zsh", "fish", "powershell"]);
}

#[test]
fn each_command_has_a_manual_page() {
    let folder = tempfile::tempdir().unwrap();
    let pages = folder.path().join("man");
    assert_eq!(asperity(&format!("manual {}", pages.display())).code, 0);
    let page = |name: &str| fs::read_to_string(pages.join(name)).unwrap();
    assert!(page("asperity.1").contains("Exit codes"));
    assert!(page("asperity-surface-twin.1").contains("\\-\\-seed"));
    // The command that writes the pages is for packagers and has no page of its own.
    assert!(!pages.join("asperity-manual.1").exists());
}
