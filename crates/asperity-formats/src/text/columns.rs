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

/// Returns the columns that the last line of a header with a name for each of them names, as `choose` sees it. Their units may stand in the
/// line below.
pub(crate) fn named<T>(head: &[u8], choose: impl Fn(&[Column]) -> Option<T>) -> Option<T> {
    let text = utf8_or_latin1(head);
    let mut below: Option<&str> = None;
    text.lines().rev().find_map(|line| {
        let mut columns = columns_in(line);
        let units = below.replace(line).and_then(|below| units_in(below, columns.len()));
        for (column, unit) in columns.iter_mut().zip(units.into_iter().flatten()).filter(|(_, unit)| !unit.is_empty()) {
            column.unit.get_or_insert(unit);
        }
        choose(&columns)
    })
}

/// Returns the units of a line, one for each of several columns. The first two are lengths, or empty like the unit of an index.
fn units_in(line: &str, columns: usize) -> Option<Vec<String>> {
    let line = line.trim_matches(['#', '%', ' ', '\r']);
    let separated = line.contains([',', ';', '\t']);
    let words = line.split(|c: char| matches!(c, ',' | ';' | '\t') || !separated && c == ' ').map(bare);
    let units: Vec<String> = words.filter(|word| separated || !word.is_empty()).map(str::to_owned).collect();
    let are_units =
        units.iter().take(2).all(|word| word.is_empty() || is_unit(word)) && units.iter().any(|word| is_unit(word));
    (units.len() == columns && are_units).then_some(units)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_may_stand_in_the_line_below_the_names() {
        let units = |head: &str| {
            named(head.as_bytes(), |columns| {
                let is_named = columns.iter().any(|column| column.name == "Height");
                is_named
                    .then(|| columns.iter().map(|column| column.unit.clone().unwrap_or_default()).collect::<Vec<_>>())
            })
        };
        for head in ["Position;Height\nmm;µm\n", "# Position, Height\n# [mm], [µm]\n", "Position Height\n(mm) (µm)\n"]
        {
            assert_eq!(units(head), Some(vec!["mm".into(), "µm".into()]), "{head}");
        }
        assert_eq!(units("No.;Position;Height\n;mm;µm"), Some(vec!["".into(), "mm".into(), "µm".into()]));
        // Lines of other words or another number of columns are no units, and a unit beside the name counts.
        for head in
            ["Position;Height\nfirst;second", "Position;Height\nmm", "Position;Height\n;", "Position;Height\n\nmm;µm"]
        {
            assert_eq!(units(head), Some(vec![String::new(), String::new()]), "{head}");
        }
        assert_eq!(units("Position [m];Height\nmm;µm"), Some(vec!["m".into(), "µm".into()]));
    }

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
