//! Names of the codes in the header of a PLU file.

/// Types of a measurement, with the article for messages.
pub(super) const TYPES: [&str; 9] = [
    "an image",
    "a profile",
    "multiple profiles",
    "a topography",
    "multiple profiles at coordinates",
    "the thickness at one point",
    "data of a custom application",
    "topographies at coordinates",
    "thicknesses at coordinates",
];

/// Measurement principles.
pub(super) const ALGORITHMS: [&str; 17] = [
    "confocal intensity",
    "confocal gradient",
    "phase shifting interferometry",
    "vertical scanning interferometry",
    "extended phase shifting interferometry",
    "confocal thickness",
    "interferometric thickness",
    "focus variation",
    "tracking and confocal",
    "confocal scanning",
    "focus variation",
    "vertical scanning interferometry, smart noise reduction",
    "vertical scanning interferometry, centre of mass",
    "confocal coarse shift, single sampling",
    "confocal coarse shift, double sampling",
    "confocal coarse shift, quadruple sampling",
    "confocal random points",
];

/// Assembly of a topography.
pub(super) const METHODS: [&str; 2] = ["one field of view", "extended (stitched)"];

/// Areas of the camera.
pub(super) const AREAS: [&str; 7] = [
    "128 × 128 points",
    "256 × 256 points",
    "512 × 512 points",
    "all of the camera",
    "256 rows of the camera",
    "128 rows of the camera",
    "coordinates",
];

/// Instruments.
pub(super) const HARDWARE: [&str; 12] = [
    "PLµ",
    "PLµ 2300 XGA",
    "PLµ 2300 XGA T5",
    "PLµ 2300 SXGA",
    "PLµ 3300",
    "DCM 3D",
    "PLu neox",
    "DCM 3D, revision 2",
    "PLu apex, prototype",
    "S neox",
    "DCM8",
    "PLu apex",
];

/// Objectives with the same code in the known tables of all versions. Other codes remain numbers.
const OBJECTIVES: [&str; 19] = [
    "",
    "Nikon EPI SLWD 20×",
    "Nikon EPI SLWD 50×",
    "Nikon EPI SLWD 100×",
    "Nikon EPI 20×",
    "Nikon EPI 50×",
    "Nikon EPI 10×",
    "Nikon EPI 100×",
    "Nikon EPI ELWD 10×",
    "Nikon EPI ELWD 20×",
    "Nikon EPI ELWD 50×",
    "Nikon EPI ELWD 100×",
    "Nikon interferometric TI 2.5×",
    "Nikon interferometric TI 5×",
    "Nikon interferometric DI 10×",
    "Nikon interferometric DI 20×",
    "Nikon interferometric DI 50×",
    "Nikon EPI 5×",
    "Nikon EPI 150×",
];

/// Returns the name of a code, or the code if it has no name.
pub(super) fn name_of(names: &[&str], code: u32) -> String {
    let name = usize::try_from(code).ok().and_then(|code| names.get(code)).filter(|name| !name.is_empty());
    name.map_or_else(|| format!("code {code}"), |name| (*name).to_owned())
}

/// Returns the name of an objective.
pub(super) fn objective(code: u32) -> String {
    name_of(&OBJECTIVES, code)
}

/// Returns the name of a version of the format.
pub(super) fn version(code: u8) -> String {
    const VERSIONS: [(u8, &str); 7] =
        [(0, "2000"), (255, "2006"), (254, "2010A"), (253, "2011"), (252, "2011B"), (251, "2012"), (250, "2013")];
    let version = VERSIONS.into_iter().find(|(known, _)| *known == code);
    version.map_or_else(|| format!("code {code}"), |(_, name)| name.to_owned())
}
