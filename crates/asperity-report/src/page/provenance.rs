//! The rows of the provenance.

use asperity_results::Provenance;

use super::cells::{DASH, plain};
use crate::format::Dimension;

/// Largest number of instruction sets that are listed; more are counted.
const LISTED: usize = 12;

/// Returns every entry of `provenance.json` with its name, in the order of the names.
pub(super) fn rows(provenance: &Provenance) -> Vec<Vec<String>> {
    let machine = &provenance.machine;
    let sets = &machine.instruction_sets;
    let sets = if sets.len() <= LISTED { sets.join(", ") } else { format!("{} values", sets.len()) };
    let word = |word: &Option<String>| word.clone().unwrap_or_else(|| DASH.into());
    let row = |name: &str, value: String| vec![name.to_owned(), value];
    let inputs = provenance.inputs.iter().map(|(file, hash)| row(&format!("inputs · {}", spaced(file)), hash.clone()));
    let seconds =
        provenance.seconds.iter().map(|(task, time)| row(&format!("seconds · {}", spaced(task)), plain(*time, 5)));
    std::iter::once(row("asperity", provenance.asperity.clone()))
        .chain(inputs)
        .chain([
            row("machine · architecture", machine.architecture.clone()),
            row("machine · instruction sets", sets),
            row("machine · processor", word(&machine.processor)),
            row("machine · system", machine.system.clone()),
            row("machine · threads", machine.threads.to_string()),
            row("only", word(&provenance.only)),
        ])
        .chain(seconds)
        .chain([
            row("seed", provenance.seed.to_string()),
            row("started unix", Dimension::Time.show_interval(provenance.started_unix_s as f64, None)),
            row("study", provenance.study.clone()),
        ])
        .collect()
}

fn spaced(name: &str) -> String {
    name.replace('_', " ")
}
