//! Campaigns: one study over lists, grids and samples of its values, and over many scans.
//!
//! A member is a function of the campaign file, the study, the scans and its number alone. Members are the blocks of one loop, so an
//! interrupted campaign goes on and parts of one are merged as those of a run.

mod answered;
mod factors;
mod folder;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use asperity_base::blocks::{self, Task};
use asperity_results::keys::SCALES;
use toml::{Table, Value};

use self::answered::{Answered, answers, member_warnings};
use self::factors::{Column, Factor, Key, MOST, Reader, SCAN, set};
pub use self::folder::{StoredCampaign, campaign_files, write_campaign};
use crate::monitor::Monitor;
use crate::study::check::FrictionSource;
use crate::study::result::{CampaignResults, MemberResult, RestsOn};
use crate::study::run::{SharedFriction, Stages};
use crate::study::verdict::rests_on::is_of;
use crate::study::{
    InvalidValue, RunBlocks, Stage, StageEstimate, Study, StudyError, StudyFile, StudyFileError, file_hash, sentence,
};

/// Name of the stage that the blocks of a campaign belong to.
const STAGE: &str = "campaign";

/// One study over many values and scans.
#[derive(Debug, Clone)]
pub struct Campaign {
    /// Text of the campaign file.
    text: String,
    /// Folder of the campaign file, an absolute path.
    folder: PathBuf,
    /// Path of the study as the file states it.
    study_path: PathBuf,
    /// Text of the study.
    study: String,
    /// The study as a table.
    table: Table,
    seed: u64,
    /// Seed in place of the study's.
    other_seed: Option<u64>,
    /// Factors, the one that changes slowest first.
    factors: Vec<Factor>,
    /// Reasons of the members whose values exclude each other.
    refused: BTreeMap<usize, String>,
    /// Numbers of the members by the friction stage that they have in common, of friction stages with several members.
    shared: Vec<Vec<usize>>,
}

/// Reason why the values of a member exclude each other.
struct Refusal {
    /// Key of the value that is wrong, if it is one.
    key: Option<String>,
    reason: String,
}

impl Campaign {
    /// Returns the path of the study that the members of a campaign file vary, relative to the file; `file` names it in errors.
    ///
    /// # Errors
    /// A key or type of the file is wrong.
    pub fn study_path(text: &str, file: &Path) -> Result<PathBuf, StudyFileError> {
        Ok(Reader { text, name: &file.display().to_string() }.file()?.study)
    }

    /// Reads the text of a campaign file and checks all its members. `study` is the text of the study that they vary, and `seed` replaces
    /// its seed and that of the campaign file.
    ///
    /// # Errors
    /// A key, type, unit or value is wrong, no scan matches, or no member is a valid study.
    pub fn parse(text: &str, file: &Path, study: &str, seed: Option<u64>) -> Result<Self, StudyFileError> {
        let name = file.display().to_string();
        let reader = Reader { text, name: &name };
        let written = reader.file()?;
        let study_file = file.with_file_name("").join(&written.study).display().to_string();
        let folder = file.parent().unwrap_or(Path::new(""));
        // Reasons leave the folder out, so that they are the same from every place.
        let folder = std::path::absolute(folder.join(".")).unwrap_or_else(|_| folder.to_path_buf());
        let own = StudyFile::parse(study, &study_file)?;
        let own_seed = own.seed;
        let mut table: Table = StudyFileError::read(study, &study_file)?;
        let other_seed = seed.or(written.seed);
        let seed = other_seed.unwrap_or(own_seed);
        let factors = reader.factors(&written, &folder, &table, &study_file, seed)?;
        let decides_sizes = |name: &str| SIZES.iter().any(|key| name.starts_with(key)) || name.starts_with("surface.");
        if !factors.iter().flat_map(Factor::keys).any(|key| decides_sizes(&key.name)) {
            // All members have the sizes that suit the scan, which is read once.
            state_sizes(&mut table, &own);
        }
        let count = factors.iter().fold(1_usize, |count, factor| count.saturating_mul(factor.len()));
        if count > MOST {
            return Err(reader.error(1, format!("the campaign has {count} members, more than {MOST}; shorten a list")));
        }
        let mut campaign = Self {
            text: text.into(),
            folder,
            study_path: written.study,
            study: study.into(),
            table,
            seed,
            other_seed,
            factors,
            refused: BTreeMap::new(),
            shared: Vec::new(),
        };
        campaign.check_values(&reader)?;
        campaign.check_members(&reader)?;
        Ok(campaign)
    }

    /// Returns the seed of the study and of the samples.
    pub fn seed(&self) -> u64 {
        self.seed
    }

    /// Returns the number of members.
    pub fn members(&self) -> usize {
        self.factors.iter().map(Factor::len).product()
    }

    /// Returns the number of friction stages that several members have in common.
    pub fn shared_stages(&self) -> usize {
        self.shared.len()
    }

    /// Returns the text of the study that the members vary.
    pub fn study_text(&self) -> &str {
        &self.study
    }

    /// Returns the study file and the data that the members read, each once. A missing file that only some members read is left out,
    /// because these members fail.
    pub fn inputs(&self) -> Vec<PathBuf> {
        let found = self.files().into_iter().filter(|(file, is_common)| *is_common || file.is_file());
        found.map(|(file, _)| file).collect()
    }

    /// Returns the study file and the data that the members read, each once, and whether all members read it.
    fn files(&self) -> Vec<(PathBuf, bool)> {
        let folder = self.study_folder();
        let members: Vec<Study> = self.one_by_one().into_iter().filter_map(|m| self.member(m).ok()).collect();
        let mut readers: BTreeMap<PathBuf, usize> = BTreeMap::new();
        for study in &members {
            let files: BTreeSet<PathBuf> =
                study.scan_paths(&folder).into_iter().chain(study.friction_process_path(&folder)).collect();
            files.into_iter().for_each(|file| *readers.entry(file).or_default() += 1);
        }
        let mut samples = Vec::new();
        sample_files(&self.table, &mut samples);
        if let Ok(campaign) = toml::from_str(&self.text) {
            sample_files(&campaign, &mut samples);
        }
        let common = samples.into_iter().map(|file| (folder.join(file), true));
        let study = (self.folder.join(&self.study_path), true);
        let of_members = readers.into_iter().map(|(file, readers)| (file, readers == members.len()));
        let mut known = BTreeSet::new();
        let all = std::iter::once(study).chain(of_members).chain(common);
        all.filter(|(file, _)| known.insert(file.clone())).collect()
    }

    /// Returns members that have every choice of every factor at least once.
    fn one_by_one(&self) -> Vec<usize> {
        let mut found = vec![0];
        let mut stride = self.members();
        for factor in &self.factors {
            stride /= factor.len();
            if !factor.is_sampled() {
                found.extend((1..factor.len()).map(|choice| choice * stride));
            }
        }
        found
    }

    /// Estimates the memory of the stages of one member.
    pub fn estimate(&self, threads: usize) -> Vec<StageEstimate> {
        let Some(first) = (0..self.members()).find_map(|member| self.member(member).ok()) else { return Vec::new() };
        let together = self.members().min(threads).max(1);
        // A member whose scan cannot be read has the reason in its row.
        let scan_points = first.scan_points(&self.study_folder()).unwrap_or(0);
        let mut found = first.estimate(scan_points, threads / together);
        found.iter_mut().for_each(|stage| stage.memory_bytes = stage.memory_together_bytes(together));
        found
    }

    fn study_folder(&self) -> PathBuf {
        let study = self.folder.join(&self.study_path);
        study.parent().map_or_else(|| self.folder.clone(), Path::to_path_buf)
    }

    /// Returns the choice of each factor of a member.
    fn choices(&self, mut member: usize) -> Vec<usize> {
        let mut found: Vec<usize> = Vec::with_capacity(self.factors.len());
        for factor in self.factors.iter().rev() {
            found.push(member % factor.len());
            member /= factor.len();
        }
        found.reverse();
        found
    }

    /// Returns the path of a scan, relative to the folder of the study if that is the folder of the campaign.
    fn scan_path(&self, name: &str) -> String {
        let is_beside = self.study_path.parent().is_some_and(|folder| folder.as_os_str().is_empty());
        if is_beside { name.to_owned() } else { self.folder.join(name).to_string_lossy().into_owned() }
    }

    /// Returns the table of a study with the choices of some factors.
    fn table_of<'a>(&self, choices: impl Iterator<Item = (&'a Factor, usize)>) -> Table {
        let mut table = self.table.clone();
        for (factor, choice) in choices {
            if let Factor::Scans(scans) = factor {
                set(&mut table, SCAN, Value::String(self.scan_path(&scans[choice])));
            }
            for (key, value) in factor.keys().into_iter().zip(factor.values(choice)) {
                set(&mut table, &key.name, value);
            }
        }
        table
    }

    fn parse_table(&self, table: &Table) -> Result<StudyFile, String> {
        let text = toml::to_string(table).map_err(|error| error.to_string())?;
        let file = self.folder.join(&self.study_path).display().to_string();
        StudyFile::parse(&text, &file).map_err(|error| error.message)
    }

    /// Returns the study of a member, or why its values are refused.
    fn member(&self, member: usize) -> Result<Study, Refusal> {
        let table = self.table_of(self.factors.iter().zip(self.choices(member)));
        let mut file = self.parse_table(&table).map_err(|reason| Refusal { key: None, reason })?;
        let varies_seed = || self.factors.iter().flat_map(Factor::keys).any(|key| key.name == "seed");
        if let Some(seed) = self.other_seed.filter(|_| !varies_seed()) {
            file.seed = seed;
        }
        let refusal = |value: InvalidValue| {
            let key = Some(format!("{}.{}", value.section, value.key));
            Refusal { key, reason: value.to_string() }
        };
        file.check().map_err(refusal)
    }

    /// Checks name, type and unit of every value in a list.
    fn check_values(&self, reader: &Reader<'_>) -> Result<(), StudyFileError> {
        for factor in self.factors.iter().filter(|factor| !factor.is_sampled()) {
            for (place, key) in factor.keys().into_iter().enumerate() {
                for choice in 0..factor.len() {
                    let value = factor.values(choice).swap_remove(place);
                    let mut table = self.table.clone();
                    set(&mut table, &key.name, value);
                    self.parse_table(&table)
                        .map_err(|message| reader.error(key.line, format!("{}: {message}", key.name)))?;
                }
            }
        }
        Ok(())
    }

    /// Checks every member. A value with which no member is a valid study is an error; other refused members have a reason.
    fn check_members(&mut self, reader: &Reader<'_>) -> Result<(), StudyFileError> {
        let folder = self.study_folder();
        let check = |study: Study| (study.friction_key(&folder), study.has(Stage::Vibration));
        let checked: Vec<Result<(Option<String>, bool), Refusal>> =
            blocks::map(0..self.members(), |member| self.member(member).map(check));
        let mut valid: Vec<Vec<bool>> = self.factors.iter().map(|factor| vec![false; factor.len()]).collect();
        let mut groups: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
        for (member, found) in checked.iter().enumerate() {
            if let Ok((key, _)) = found {
                self.choices(member).into_iter().zip(&mut valid).for_each(|(choice, valid)| valid[choice] = true);
                key.iter().for_each(|key| groups.entry(key).or_default().push(member));
            }
        }
        let has_scans = self.factors.iter().any(|factor| matches!(factor, Factor::Scans(_)));
        if has_scans && groups.is_empty() && checked.iter().flatten().any(|(_, vibrates)| *vibrates) {
            let message = "scans change no answer, because the study states its friction instead of computing it; remove `scans`, or \
                           add [friction] and remove the stated friction";
            return Err(reader.error(reader.line("scans"), message));
        }
        let mut shared: Vec<Vec<usize>> = groups.into_values().filter(|members| members.len() > 1).collect();
        shared.sort();
        let mut refused = BTreeMap::new();
        for (member, Refusal { key: wrong_key, reason }) in
            checked.iter().enumerate().filter_map(|(member, found)| Some((member, found.as_ref().err()?)))
        {
            refused.insert(member, reason.clone());
            let choices = self.factors.iter().zip(self.choices(member)).zip(&valid);
            let wrong =
                choices.filter(|((factor, choice), valid)| matches!(factor, Factor::Listed(_)) && !valid[*choice]);
            let wrong: Vec<&Key> = wrong.flat_map(|((factor, _), _)| factor.keys()).collect();
            let is_named = |key: &&&Key| wrong_key.as_ref() == Some(&key.name);
            if let Some(key) = wrong.iter().find(is_named).or(wrong.first()) {
                return Err(reader.error(key.line, reason.as_str()));
            }
        }
        if let (true, Some((_, reason))) = (refused.len() == checked.len(), refused.first_key_value()) {
            return Err(reader.error(1, format!("no member is a valid study; the first because {reason}")));
        }
        (self.refused, self.shared) = (refused, shared);
        Ok(())
    }

    /// Computes all members, with the blocks that are stored, and stores those that it computes.
    ///
    /// # Errors
    /// Blocks cannot be stored, blocks of other parts are missing ([`StudyError::Incomplete`]), or the monitor cancelled. A member that
    /// fails has its reason in the results.
    pub fn run_with(&self, blocks: Option<&RunBlocks>, monitor: &dyn Monitor) -> Result<CampaignResults, StudyError> {
        let hash = |(file, _): (PathBuf, bool)| (file_hash(&file).unwrap_or_default(), file);
        let inputs: Vec<(String, PathBuf)> = match blocks {
            Some(_) => self.files().into_iter().skip(1).map(hash).collect(),
            None => Vec::new(),
        };
        let hashes: Vec<&String> = inputs.iter().map(|(hash, _)| hash).collect();
        let scans = |factor: &Factor| match factor {
            Factor::Scans(scans) => Some(scans.clone()),
            Factor::Listed(_) | Factor::Sampled(..) => None,
        };
        let scans: Vec<Vec<String>> = self.factors.iter().filter_map(scans).collect();
        let stages = Stages { blocks, monitor };
        let members = stages.run(STAGE, &(&self.text, &self.study, self.seed, &scans, &hashes), |monitor| {
            self.compute(&inputs, monitor)
        })?;
        let members = members.ok_or(StudyError::Incomplete)?;
        Ok(self.results(members))
    }

    /// Computes the friction stages that several members have in common, then the members. Blocks depend on the files that the members
    /// read, `inputs` with their hashes.
    fn compute(
        &self,
        inputs: &[(String, PathBuf)],
        monitor: &dyn Monitor,
    ) -> Result<Vec<Result<Answered, String>>, StudyError> {
        let inner = Inner(monitor);
        let folder = self.study_folder();
        let alone = |count: usize| count >= rayon::current_num_threads();
        let groups = self.shared.len();
        let mut shared = Vec::new();
        if groups > 0 {
            let task = Task::new(monitor, "campaign: friction", groups);
            let share = |study: &Study| study.share_friction(&folder, &inner).map_err(|error| self.reason(&error));
            shared = task.try_map(groups, |group| {
                let study = self.member(self.shared[group][0]).map_err(|refusal| refusal.reason);
                let found = on(alone(groups), || study.as_ref().map_err(String::clone).and_then(share));
                study.map_or(Ok(()), |study| study.refuse_changed(&folder, inputs))?;
                Ok::<_, StudyError>(found)
            })?;
        }
        let mut shared_of: BTreeMap<usize, &Result<SharedFriction, String>> = BTreeMap::new();
        for (group, friction) in self.shared.iter().zip(&shared) {
            shared_of.extend(group.iter().map(|member| (*member, friction)));
        }
        let count = self.members();
        let task = Task::new(monitor, "campaign: members", count);
        task.try_map(count, |member| {
            let refused = self.refused.get(&member).map_or(Ok(()), |reason| Err(reason.clone()));
            let study = refused.and_then(|()| self.member(member).map_err(|refusal| refusal.reason));
            let answer = |study: &Study| {
                let friction = shared_of.get(&member).map(|friction| friction.as_ref()).transpose()?;
                let found = study.run_answers(friction, &folder, &inner).map_err(|error| self.reason(&error))?;
                let damping = study.vibration.as_ref().map(|vibration| vibration.machine.damping_ratio);
                let rests_on =
                    if self.is_first(member) { study.rests_on(&found.0, found.1.as_ref()) } else { Vec::new() };
                Ok(Answered {
                    answers: answers(&found.0, found.1.as_ref(), damping),
                    warnings: found.0.warnings,
                    rests_on,
                })
            };
            let found = on(alone(count), || study.as_ref().map_err(String::clone).and_then(answer));
            // Members with friction in common read no scan, unless they state a verdict.
            let reads = |study: &Study| study.states_verdict() || !shared_of.contains_key(&member);
            study.ok().filter(reads).map_or(Ok(()), |study| study.refuse_changed(&folder, inputs))?;
            Ok(found)
        })
    }

    /// Returns an error as the reason of a failed member, without the folder, so that it is the same from every place.
    fn reason(&self, error: &StudyError) -> String {
        let mut reason = error.to_string();
        for folder in [self.study_folder(), self.folder.clone()] {
            reason = reason.replace(&format!("{}{}", folder.display(), std::path::MAIN_SEPARATOR), "");
        }
        reason
    }

    fn results(&self, answers: Vec<Result<Answered, String>>) -> CampaignResults {
        let folder = self.study_folder();
        let columns: Vec<Vec<Column>> = self.factors.iter().map(|factor| factor.columns(&folder)).collect();
        let member_warnings = member_warnings(&answers);
        let rests_on = self.in_common(&answers);
        let members = answers.into_iter().enumerate().map(|(member, found)| {
            let (mut scan, mut values) = (None, Vec::new());
            for ((factor, columns), choice) in self.factors.iter().zip(&columns).zip(self.choices(member)) {
                if let Factor::Scans(scans) = factor {
                    scan = Some(scans[choice].clone());
                }
                values.extend(columns.iter().map(|column| column.cells[choice].clone()));
            }
            let (failed, reason) = (found.is_err(), found.as_ref().err().cloned());
            MemberResult { scan, values, failed, reason, answers: found.unwrap_or_default().answers }
        });
        let members: Vec<MemberResult> = members.collect();
        let warning = match (members.iter().filter(|member| member.failed).count(), members.len()) {
            (0, _) => None,
            (1, 1) => Some("the member has no answer".to_owned()),
            (failed, all) => {
                let have = if failed == 1 { "has" } else { "have" };
                Some(format!("{failed} of {} {have} no answer", sentence::count(all, "member", "members")))
            }
        };
        CampaignResults {
            seed: self.seed,
            keys: columns.into_iter().flatten().map(|column| column.key).collect(),
            members,
            warnings: self.changed_law().into_iter().chain(warning).collect(),
            member_warnings,
            rests_on,
            ..CampaignResults::default()
        }
    }

    /// Returns whether a member has the first choice of every factor but the scan.
    fn is_first(&self, member: usize) -> bool {
        let choices = self.factors.iter().zip(self.choices(member));
        choices.into_iter().all(|(factor, choice)| choice == 0 || matches!(factor, Factor::Scans(_)))
    }

    /// Returns the inputs of the verdict that do not differ between the members.
    fn in_common(&self, answers: &[Result<Answered, String>]) -> Vec<RestsOn> {
        let mut known = answers.iter().flatten().map(|found| &found.rests_on);
        let Some(inputs) = known.find(|inputs| !inputs.is_empty()) else { return Vec::new() };
        let mut varied: Vec<&str> = self.factors.iter().flat_map(Factor::keys).map(|key| &key.name[..]).collect();
        varied.extend(self.factors.iter().any(|factor| matches!(factor, Factor::Scans(_))).then_some(SCAN));
        let differs = |input: &RestsOn| varied.iter().any(|key| is_of(&input.input, key));
        inputs.iter().filter(|input| !differs(input)).cloned().collect()
    }

    /// Returns a warning if members whose unit of dimensionless velocity differs have a law or belt velocity per this unit.
    fn changed_law(&self) -> Option<String> {
        let names: Vec<&str> = self.factors.iter().flat_map(Factor::keys).map(|key| &key.name[..]).collect();
        let varied = SCALES.iter().find(|key| names.contains(key))?;
        let study = (0..self.members()).find_map(|member| self.member(member).ok())?;
        let vibration = study.vibration.as_ref().filter(|vibration| vibration.machine.coupled.is_none())?;
        let law =
            vibration.dimensionless_rate.filter(|_| !matches!(vibration.machine.friction, FrictionSource::File(_)));
        let velocity = study.file().vibration.as_ref().and_then(|file| file.dimensionless_belt_velocity.as_ref());
        let keys = law.map(|(key, _)| key).into_iter().chain(velocity.map(|_| "dimensionless_belt_velocity"));
        let keys: Vec<String> = keys.map(|key| format!("`{key}`")).collect();
        (!keys.is_empty()).then(|| {
            format!(
                "{} {} per unit of dimensionless velocity, which {varied} changes: members differ in law or belt velocity in SI, too; \
                 state them in SI to keep them",
                keys.join(" and "),
                if keys.len() == 1 { "is" } else { "are" }
            )
        })
    }

    /// Returns the text of the campaign file with absolute paths and the seed, which is valid in every folder.
    pub fn resolved(&self) -> String {
        let absolute = |path: &Path| Value::String(self.folder.join(path).to_string_lossy().into_owned()).to_string();
        let reader = Reader { text: &self.text, name: "" };
        let mut changes = Vec::new();
        if let (Some(span), true) = (reader.span("study"), self.study_path.is_relative()) {
            changes.push((span, absolute(&self.study_path)));
        }
        if let (Some(span), Ok(file)) = (reader.span("scans"), reader.file())
            && let Some(pattern) = file.scans.filter(|pattern| Path::new(pattern).is_relative())
        {
            let whole = format!("{}/{pattern}", glob::Pattern::escape(&self.folder.to_string_lossy()));
            changes.push((span, Value::String(whole).to_string()));
        }
        let mut first = String::new();
        match reader.span("seed") {
            Some(span) => changes.push((span, self.seed.to_string())),
            None => first = format!("seed = {}\n", self.seed),
        }
        changes.sort_by_key(|(span, _)| span.start);
        let mut text = self.text.clone();
        for (span, value) in changes.into_iter().rev() {
            text.replace_range(span, &value);
        }
        first + &text
    }
}

/// Keys that follow from the scan where a study leaves them out.
const SIZES: [&str; 3] = ["friction.strip", "friction.points", "friction.window"];

/// Writes the sizes of strips and windows that a study file has into its table.
fn state_sizes(table: &mut Table, file: &StudyFile) {
    let Some(sizes) = file.friction.as_ref().and_then(|section| Table::try_from(section).ok()) else { return };
    for name in SIZES {
        let size = name.split_once('.').and_then(|(_, key)| sizes.get(key));
        size.into_iter().for_each(|size| factors::set(table, name, size.clone()));
    }
}

/// Adds the files of samples that distributions in a table name.
pub(super) fn sample_files(table: &Table, files: &mut Vec<String>) {
    fn of_value(value: &Value, files: &mut Vec<String>) {
        match value {
            Value::Table(inner) => sample_files(inner, files),
            Value::Array(list) => list.iter().for_each(|value| of_value(value, files)),
            _ => {}
        }
    }
    for (name, value) in table {
        match (name.as_str(), value) {
            ("samples", Value::String(file)) => files.push(file.clone()),
            (_, value) => of_value(value, files),
        }
    }
}

/// Runs a block with its loops on one thread, or on all.
fn on<T>(one_thread: bool, block: impl FnOnce() -> T) -> T {
    if one_thread { blocks::on_one_thread(block) } else { block() }
}

/// Monitor of a member: neither its progress is reported nor its blocks are stored.
struct Inner<'a>(&'a dyn Monitor);

impl Monitor for Inner<'_> {
    fn progress(&self, _what: &str, _done: usize, _total: usize) {}

    fn cancelled(&self) -> bool {
        self.0.cancelled()
    }
}

#[cfg(test)]
mod tests;
