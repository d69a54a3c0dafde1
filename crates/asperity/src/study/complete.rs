//! Text of a study file with all its values, in the order and the units of the file.

use toml::de::{DeString, DeTable, DeValue};
use toml::{Spanned, Table, Value};

use crate::study::{StoreError, StudyFile};

impl StudyFile {
    /// Returns `text`, the text of this file, with a line for each value that it leaves out at the end of the section. Returns all values in
    /// the order of their names if the text writes a section in another form, such as an inline table.
    ///
    /// # Errors
    /// A path is not Unicode.
    pub fn complete(&self, text: &str) -> Result<String, StoreError> {
        let text = text.trim_start_matches('\u{feff}');
        let resolved = self.to_table().map_err(StoreError::content)?;
        let completed = DeTable::parse(text).ok().and_then(|written| {
            let mut added = Vec::new();
            if !missing(text, written.get_ref(), &resolved, &mut added) {
                return None;
            }
            // From the last place on, so that the places before it stay.
            added.sort_by_key(|(place, _)| std::cmp::Reverse(*place));
            let insert = |mut text: String, (place, lines): (usize, String)| {
                text.insert_str(place, &format!("\n# Not stated:{lines}"));
                text
            };
            Some(added.into_iter().fold(text.to_owned(), insert))
        });
        let is_whole = |text: &String| {
            let read = Self::parse(text, "").ok().and_then(|file| file.to_table().ok());
            read.is_some_and(|read| read == resolved)
        };
        completed.filter(is_whole).map_or_else(|| self.to_text(), Ok)
    }
}

/// Adds the lines of values that a section and those below it leave out, each with the place in `text` where they belong. Returns
/// whether each value has such a place.
fn missing(text: &str, written: &DeTable<'_>, resolved: &Table, added: &mut Vec<(usize, String)>) -> bool {
    // A section with a header of its own follows the keys of the section above it.
    let has_header = |name: &Spanned<DeString<'_>>| {
        text[..name.span().start].rsplit('\n').next().is_some_and(|line| line.trim_start().starts_with('['))
    };
    let mut lines = String::new();
    for (key, value) in resolved {
        match (written.iter().find(|(name, _)| name.get_ref() == key), value) {
            (Some((name, found)), Value::Table(inner)) => {
                let DeValue::Table(table) = found.get_ref() else { return false };
                let count = added.len();
                if !missing(text, table, inner, added) || added.len() > count && !has_header(name) {
                    return false;
                }
            }
            (None, Value::Table(_)) => return false,
            (None, value) => lines += &format!("\n{key} = {value}"),
            (Some(_), _) => {}
        }
    }
    let own = written.iter().filter(|(name, _)| !has_header(name));
    let last = own.map(|(_, value)| value.span().end).max();
    if lines.is_empty() {
        return true;
    }
    let Some(last) = last else { return false };
    added.push((text[last..].find('\n').map_or(text.len(), |line| last + line), lines));
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    const MACHINE: &str = "mass = \"1 kg\"\nnatural_frequency = \"316 rad/s\"\nnormal_force = \"2500 N\" # of one pad\nnominal_area = \"833 mm^2\"\n\
                           damping_ratio = \"0.17 ± 0.02\"\nbelt_velocity = \"23.7 mm/s\"\nstatic_friction = 0.1\nfriction_std = 0.0";

    fn completed(text: &str) -> String {
        let file = StudyFile::parse(text, "study.toml").unwrap();
        let completed = file.complete(text).unwrap();
        let again = StudyFile::parse(&completed, "study.toml").unwrap();
        assert_eq!(again.to_table().unwrap(), file.to_table().unwrap(), "{completed}");
        completed
    }

    #[test]
    fn a_file_keeps_its_order_units_and_comments_and_gets_the_values_that_it_leaves_out() {
        let text = format!("seed = 1\n\n[vibration]\n{MACHINE}\n\n[verdict] # of one second\nduration = \"1 s\"\n");
        let found = completed(&text);
        // The lines of the file in their order.
        let mut rest = found.lines();
        assert!(text.lines().all(|line| rest.any(|other| other == line)), "{found}");
        assert!(found.contains("friction_std = 0.0\n# Not stated:\n"), "{found}");
        assert!(found.contains("\nkinetic_share = 1.0\n") && found.contains("half_width = 0.02"), "{found}");
        assert!(found.starts_with("seed = 1\n# Not stated:\nunstated = [\"vibration."), "{found}");
        assert_eq!(completed(&found), found);
    }

    #[test]
    fn a_section_in_another_form_is_complete_too() {
        let dotted = MACHINE.lines().map(|line| format!("vibration.{line}\n")).collect::<String>();
        let found = completed(&format!("seed = 1\n{dotted}"));
        assert!(found.contains("kinetic_share = 1.0"), "{found}");
        let inner = format!("seed = 1\n[vibration]\n{MACHINE}\n[vibration.stribeck]\nuniform = [3, 5]\n[verdict]\n");
        assert!(completed(&inner).contains("half_width"));
    }
}
