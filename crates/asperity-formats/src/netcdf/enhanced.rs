//! NetCDF-4: variables are HDF5 datasets, and dimensions are datasets that are dimension scales.

use std::collections::HashMap;

use super::contents::{Attribute, Contents, MAX_ENTRIES, MAX_NUMBERS, Value, Variable};
use crate::Result;
use crate::hdf5::{File, Object, shown_name};

/// Attributes that connect datasets and are not shown to the user.
const HIDDEN: [&[u8]; 7] = [
    b"CLASS",
    b"NAME",
    b"DIMENSION_LIST",
    b"REFERENCE_LIST",
    b"_Netcdf4Dimid",
    b"_Netcdf4Coordinates",
    b"_NCProperties",
];

/// Start of the NAME of a dataset that is a dimension but not a variable.
const NO_VARIABLE: &str = "This is a netCDF dimension but not a netCDF variable";

/// Reads the variables of the root group.
pub(super) fn read(file: &File) -> Result<Contents> {
    let mut contents = Contents::default();
    let Some(root) = file.find("")? else { return Ok(contents) };
    let mut room = MAX_ENTRIES;
    contents.attributes = attributes(file, &root, &mut room)?;
    let mut scales = HashMap::new();
    let mut tied = Vec::new();
    for link in file.links(&root)? {
        let object = file.object(link.address)?;
        let dataset = match file.dataset(&object) {
            Ok(Some(dataset)) => dataset,
            Ok(None) => continue,
            // A dataset of an unsupported kind is not a map; other datasets may be.
            Err(error) => {
                contents.first_error = contents.first_error.or(Some(error));
                continue;
            }
        };
        let name = shown_name(link.name);
        let (mut references, mut is_variable) = (None, true);
        for attribute in file.attributes(&object)? {
            match attribute.name {
                b"CLASS" if file.value(&attribute, |value| value.text())?.as_deref() == Some("DIMENSION_SCALE") => {
                    scales.insert(link.address, contents.dimensions.len());
                    let length = dataset.shape.first().copied().unwrap_or_default();
                    contents.dimensions.push((name.clone(), length));
                }
                b"NAME" => {
                    let name = file.value(&attribute, |value| value.text())?;
                    is_variable = !name.is_some_and(|name| name.starts_with(NO_VARIABLE));
                }
                b"DIMENSION_LIST" => references = file.value(&attribute, |value| value.objects().map(Some))?,
                _ => (),
            }
        }
        if !is_variable {
            continue;
        }
        tied.push(references);
        contents.variables.push(Variable {
            name,
            dimensions: Vec::new(),
            sample: dataset.sample().map(|(sample, _)| sample),
            shape: dataset.shape,
            attributes: attributes(file, &object, &mut room)?,
            at: link.address,
            record_bytes: None,
        });
    }
    for (variable, references) in contents.variables.iter_mut().zip(tied) {
        let place = |address: &usize| scales.get(address).copied();
        variable.dimensions = match references {
            Some(references) => references.iter().take(variable.shape.len()).map(place).collect(),
            None => vec![place(&variable.at)],
        };
    }
    Ok(contents)
}

/// Returns the attributes of an object up to the limit.
fn attributes(file: &File, object: &Object, room: &mut usize) -> Result<Vec<Attribute>> {
    let mut attributes = Vec::new();
    for attribute in file.attributes(object)? {
        if HIDDEN.contains(&attribute.name) || *room == 0 {
            continue;
        }
        let value = file.value(&attribute, |value| {
            Ok(Some(match value.text()? {
                Some(text) => Value::Text(text),
                None => Value::Numbers(value.numbers(MAX_NUMBERS)?),
            }))
        });
        // An attribute that cannot be read is neither a unit nor a fill value.
        if let Ok(Some(value)) = value {
            *room -= 1;
            attributes.push((shown_name(attribute.name), value));
        }
    }
    Ok(attributes)
}

/// Returns the numbers of a variable in row order.
pub(super) fn numbers(file: &File, variable: &Variable) -> Result<Vec<f64>> {
    let dataset = file.dataset(&file.object(variable.at)?)?;
    let numbers = dataset.map(|dataset| file.numbers(&dataset)).transpose()?.flatten();
    Ok(numbers.unwrap_or_default())
}
