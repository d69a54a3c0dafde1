//! Verdict of a study.

use std::io::Write;
use std::path::PathBuf;

use asperity::study::{Stage, Table, VERDICT_SAMPLES, folder_of};
use asperity_report::{verdict_answer, verdict_sentence, verdict_text};
use clap::Args;

use super::study_file;
use crate::args;
use crate::failure::{Failure, Kind};
use crate::monitor::Terminal;
use crate::output::{Answer, check_target, print, print_sentences, replace_file, with_bold, write_verb};

/// Computes how probable vibration is, what decides it, and what changes it.
///
/// Takes the uncertain values of the study into account. Runs the stages that it needs and writes no folder.
#[derive(Debug, Args)]
pub(crate) struct Verdict {
    /// Study file with a [vibration] section.
    study: PathBuf,
    /// Seed to use instead of the study's.
    #[arg(long, value_name = "N", value_parser = args::seed, allow_hyphen_values = true)]
    seed: Option<u64>,
    /// CSV file for the sampled machines: kind of motion, uncertain values in SI, friction coefficient, margin (ζ − ζ_v; with mode
    /// coupling μ_c − μ), and the stiffness of a computed contact.
    #[arg(long, value_name = "FILE")]
    export_samples: Option<PathBuf>,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

impl Verdict {
    pub(crate) fn run(&self, monitor: &Terminal) -> Result<(), Failure> {
        let (study, text) = study_file::study(&self.study, self.seed)?;
        let folder = folder_of(&self.study);
        if let Some(file) = &self.export_samples {
            check_target("--export-samples", file, &[&self.study])?;
        }
        let outcome = study.run(folder, Some(Stage::Verdict), monitor).or_else(|e| {
            let reason = Answer::default().with("reason", e.to_string());
            Err(study_file::failure(&self.study, Some(&text), &e).print(reason, self.json)?)
        })?;
        for warning in &outcome.results.warnings {
            monitor.warn(warning);
        }
        monitor.check()?;
        let Some(verdict) = &outcome.results.verdict else {
            return Err(Failure::new(Kind::Runtime, "the study has no verdict"));
        };
        if let Some(file) = &self.export_samples {
            let samples = outcome.tables.get(VERDICT_SAMPLES).map_or(Ok(Vec::new()), Table::to_csv);
            let text = String::from_utf8(samples.map_err(|e| Failure::new(Kind::Runtime, e.to_string()))?)
                .map_err(|e| Failure::new(Kind::Runtime, e.to_string()))?;
            // The table names its rows after the kind of motion.
            let text = text.replacen("name", "kind", 1);
            let verb = write_verb(file);
            replace_file(file, |out| out.write_all(text.as_bytes()))?;
            monitor.note(&format!("{verb} {}", file.display()));
        }
        if self.json {
            let answer = Answer::default().with("sentence", verdict_sentence(verdict));
            return answer.and(Answer::new(verdict)?).print(true);
        }
        // Sentences, then tables, whose lines stay whole.
        let text = verdict_text(verdict);
        let (sentences, tables) = text.split_once("\n\n").unwrap_or((&text, ""));
        let mut sentences: Vec<String> = sentences.lines().map(str::to_owned).collect();
        sentences.iter_mut().take(1).for_each(|first| *first = with_bold(first, &verdict_answer(verdict)));
        print_sentences(&sentences)?;
        if tables.is_empty() { Ok(()) } else { print(&format!("\n{tables}")) }
    }
}
