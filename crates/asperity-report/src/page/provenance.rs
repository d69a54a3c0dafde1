//! The table of the provenance.

use asperity_results::Provenance;

use crate::cells::DASH;
use crate::format::Dimension;
use crate::page::data_table::DataTable;

/// Largest number of instruction sets that are listed; more are counted.
const LISTED: usize = 12;

/// Returns every entry of `provenance.json`: the run, its inputs, the machine and the computing times.
pub(super) fn table(provenance: &Provenance) -> DataTable {
    let machine = &provenance.machine;
    let program = &provenance.program;
    let sets = &program.instruction_sets;
    let sets = if sets.len() <= LISTED { sets.join(", ") } else { format!("{} values", sets.len()) };
    let rows = [
        ("version of asperity", provenance.asperity.clone()),
        ("study", provenance.study.clone()),
        ("seed", provenance.seed.to_string()),
        ("stage", provenance.only.clone().unwrap_or_else(|| "all".into())),
        ("start", date(provenance.started_unix_s)),
        ("Machine", String::new()),
        ("system", machine.system.clone()),
        ("architecture", machine.architecture.clone()),
        ("processor", machine.processor.clone().unwrap_or_else(|| DASH.into())),
        ("instruction sets", if sets.is_empty() { DASH.into() } else { sets }),
        ("threads", machine.threads.to_string()),
        ("Program (SHA-256)", String::new()),
        ("program file", or_dash(&program.sha256)),
        ("list of libraries", or_dash(&program.dependencies_sha256)),
        ("elementary functions", or_dash(&program.functions)),
        ("Inputs (SHA-256)", String::new()),
    ];
    let rows = rows.map(|(name, value)| (name.to_owned(), value)).into_iter().chain(provenance.inputs.clone());
    let stages = provenance.stages.iter().map(|(stage, cost)| {
        let time = Dimension::Time.show_short(cost.seconds);
        let memory = cost.peak_memory_bytes.map_or_else(String::new, |bytes| format!(", {:.0} MB", 1e-6 * bytes));
        (format!("{stage} stage"), time + &memory)
    });
    let time = |(task, seconds): (&String, &f64)| (task.replace('_', " "), Dimension::Time.show_short(*seconds));
    let heading = ("Computing time, largest memory".into(), String::new());
    let times = std::iter::once(heading).chain(stages).chain(provenance.seconds.iter().map(time));
    DataTable::properties("", rows.chain(times))
}

fn or_dash(text: &str) -> String {
    if text.is_empty() { DASH.into() } else { text.into() }
}

/// Formats seconds since 1970-01-01 as date and time in UTC (H. Hinnant's algorithm for days of the Gregorian calendar).
fn date(unix_s: u64) -> String {
    let (day, minute) = (unix_s / 86_400 + 719_468, unix_s / 60 % 1440);
    // Eras of 400 years begin on 1 March.
    let (era, day) = (day / 146_097, day % 146_097);
    let year = (day - day / 1460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153;
    let day = day - (153 * month + 2) / 5 + 1;
    let (year, month) = if month < 10 { (year, month + 3) } else { (year + 1, month - 9) };
    format!("{:04}-{month:02}-{day:02} {:02}:{:02} UTC", 400 * era + year, minute / 60, minute % 60)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_follow_the_gregorian_calendar() {
        assert_eq!(date(0), "1970-01-01 00:00 UTC");
        assert_eq!(date(951_782_399), "2000-02-28 23:59 UTC");
        assert_eq!(date(951_782_400), "2000-02-29 00:00 UTC");
        assert_eq!(date(4_107_542_400), "2100-03-01 00:00 UTC");
    }
}
