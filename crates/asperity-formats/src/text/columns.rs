//! Names and units of columns.

use super::header::{bare, unit};
use crate::unit::is_micro;
use crate::utf8_or_latin1;

/// Signs between the name of a column and its unit.
const BEFORE_UNIT: [char; 5] = ['[', '(', '/', '_', ' '];

/// Name of a column and the unit behind it, `Lateral (µm)`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Column {
    pub(crate) name: String,
    pub(crate) unit: Option<String>,
}

impl Column {
    fn new(word: &str) -> Self {
        let place = word.rfind(BEFORE_UNIT).unwrap_or(word.len());
        let behind = bare(word[place..].trim_start_matches(['/', '_', ' ']));
        let is_bracket = word[place..].starts_with(['[', '(']);
        let before = word[..place].trim_end_matches(BEFORE_UNIT);
        let is_known = is_bracket || is_unit(behind) && !ends_with_number(before);
        let known = Some(behind).filter(|behind| !behind.is_empty() && is_known);
        let name = if known.is_some() { before } else { word };
        Self { name: name.to_owned(), unit: known.map(str::to_owned) }
    }

    /// Returns the number of units per metre; `None` without a unit of length.
    pub(crate) fn per_metre(&self) -> Option<f64> {
        unit(self.unit.as_deref()?)
    }
}

/// Returns whether a text ends with a number, so that a unit behind it belongs to a length and not to a column.
fn ends_with_number(text: &str) -> bool {
    text.rsplit([' ', '=']).next().is_some_and(|word| word.replace(',', ".").parse::<f64>().is_ok())
}

/// Returns whether a word is a unit of length, or its prefix alone, which is to be refused. `u` is also a name of columns.
fn is_unit(word: &str) -> bool {
    unit(word).is_some() || is_micro(word) && word != "u"
}

/// Returns the columns that a line of a header names: `x [um] y [um] z [um]`, `X;Y;Z` or `# x/mm, y/mm, z/um`.
pub(crate) fn columns_in(line: &str) -> Vec<Column> {
    let line = line.rsplit(':').next().unwrap_or(line).trim_matches(['#', '%', '"', ' ', '\r']);
    let separated = line.contains([',', ';', '\t']);
    let mut columns: Vec<Column> = Vec::new();
    let words = line.split(|c: char| matches!(c, ',' | ';' | '\t') || !separated && c == ' ');
    for word in words.map(|word| word.trim_matches([' ', '"'])).filter(|word| separated || !word.is_empty()) {
        let is_unit = !separated && (word.starts_with(BEFORE_UNIT) || is_unit(word));
        match columns.last_mut().filter(|last| is_unit && last.unit.is_none() && !ends_with_number(&last.name)) {
            // A unit behind its name.
            Some(last) => last.unit = Some(bare(word.trim_start_matches('/')).to_owned()),
            None => columns.push(Column::new(word)),
        }
    }
    columns
}

/// Returns the columns that the last line of a header with a name for each of them names, as `choose` sees it. Their units may be in the
/// line below: `X;Y` and `[mm];[um]`.
pub(crate) fn named<T>(head: &[u8], choose: impl Fn(&[Column]) -> Option<T>) -> Option<T> {
    let text = utf8_or_latin1(head);
    let mut below: Vec<Column> = Vec::new();
    text.lines().rev().find_map(|line| {
        let mut columns = columns_in(line);
        let are_units = below.iter().take(2).all(|column| column.name.is_empty() && column.unit.is_some());
        let are_units = are_units && below.len() > 1 && below.len() == columns.len();
        let units = std::mem::replace(&mut below, columns.clone()).into_iter().filter(|_| are_units);
        columns.iter_mut().zip(units).for_each(|(column, of)| column.unit = column.unit.take().or(of.unit));
        choose(&columns)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_have_names_and_units_in_any_usual_form() {
        let found = |line: &str| -> Vec<String> {
            let of = |column: Column| format!("{}|{}", column.name, column.unit.unwrap_or_default());
            columns_in(line).into_iter().map(of).collect()
        };
        for line in ["x [um] z [nm]", "# x [um], z [nm]", "x_um;z_nm", "\"x (um)\"\t\"z (nm)\"", "columns: x/um, z/nm"]
        {
            assert_eq!(found(line), ["x|um", "z|nm"], "{line}");
        }
        assert_eq!(found("Lateral(µm),Total Profile(Å),,"), ["Lateral|µm", "Total Profile|Å", "|", "|"]);
        assert_eq!(found("Position (mm), Deflection (V)"), ["Position|mm", "Deflection|V"]);
        assert_eq!(found("x;max_height"), ["x|", "max_height|"]);
        // Lengths are no columns.
        for line in ["Lt 2 mm, tip 2 um", "Ra = 0.3 um, Rz = 2.1 um", "0 um, 1 um", "0 um 1 um"] {
            assert!(columns_in(line).iter().all(|column| column.unit.is_none()), "{line}");
        }
        assert_eq!(found("Position (mm), Profile 1 (um)"), ["Position|mm", "Profile 1|um"]);
    }
}
