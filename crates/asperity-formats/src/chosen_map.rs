//! Choice of a map in files that also hold other quantities.

use crate::{Format, FormatError, ReadOptions, Result, Scan, per_metre, shown, some_of, unique};

/// Height map that was chosen in a file with other quantities beside heights.
#[derive(Debug)]
pub(crate) struct ChosenMap {
    /// Index among all maps of the file.
    pub(crate) map: usize,
    /// Number of units of its values per metre.
    pub(crate) per_metre: f64,
    names: Vec<String>,
    channel: usize,
    warning: Option<String>,
}

impl ChosenMap {
    /// Chooses among maps, each given by its name and its unit.
    ///
    /// # Errors
    /// No map of lengths, and [`FormatError::NoSuchChannel`].
    pub(crate) fn new(
        format: Format,
        maps: impl IntoIterator<Item = (String, String)>,
        options: &ReadOptions,
    ) -> Result<Self> {
        let (mut names, mut places, mut others) = (Vec::new(), Vec::new(), Vec::new());
        for (place, (name, unit)) in maps.into_iter().enumerate() {
            if let Some(per_metre) = per_metre(&unit) {
                names.push(name);
                places.push((place, per_metre));
            } else {
                let unit = if unit.is_empty() { "no unit".into() } else { shown(&unit) };
                others.push(format!("`{name}` ({unit})"));
            }
        }
        if names.is_empty() {
            let found = match others.as_slice() {
                [] => "the file holds no image".to_owned(),
                _ => format!("no image of the file holds lengths: {}", some_of(&others)),
            };
            return Err(FormatError::unsupported(format, found, "an image whose values have a unit of length"));
        }
        let names = unique(names);
        let channel = options.choose(format, &names)?;
        let is_told = options.channel.is_none() && !others.is_empty();
        let warning = is_told.then(|| format!("images without lengths were left out: {}", some_of(&others)));
        let (map, per_metre) = places[channel];
        Ok(Self { map, per_metre, names, channel, warning })
    }

    /// Returns the name of the map.
    pub(crate) fn name(&self) -> &str {
        &self.names[self.channel]
    }

    /// Adds the names of the maps of heights to a scan, and a warning about the others.
    pub(crate) fn add_to(self, mut scan: Scan) -> Scan {
        scan.warnings.extend(self.warning);
        scan.with_channels(self.names, self.channel)
    }
}
