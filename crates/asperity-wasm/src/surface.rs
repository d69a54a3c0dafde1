//! Surfaces: a scan, or a stated random surface.

mod contact;
mod friction;
mod settings;

use std::cell::OnceCell;

use asperity::correlation::{CorrelationFamily, radial_spectrum};
use asperity::keys::{DefaultValue, KEYS, Key, label};
use asperity::map::{BoundaryKind, Grid, HeightMap};
use asperity::study::{Field, TwinOptions, Twins, draw_map, surface_statistics};
use asperity::surface::model::{CovarianceRequest, Measurable, SurfaceModel, SurfaceModelError, SurfaceRequest};
use asperity::surface::preparation::Prepared;
use asperity::surface::scanned::ScannedSurface;
use asperity::translation::TranslationKind;
use asperity_formats::{Format, Scan, read_bytes_with};
use asperity_report::live;
use serde_json::{Map, Value, json};
use wasm_bindgen::prelude::*;

use crate::answer::{Answer, Failure, read};
use settings::{ScanSettings, StatedSurface};

/// Returns the inputs of a study as JSON: the `label` and the `default` of each, if it is a number or a word, by
/// `section.name`, for lists also of their elements.
#[wasm_bindgen]
pub fn inputs() -> String {
    let entry = |(name, default): (String, Option<Value>)| {
        let label = label(&name);
        (name, json!({ "label": label, "default": default }))
    };
    let of_key = |key: &'static Key| {
        let elements = key.elements.into_iter().flatten().enumerate();
        let elements = elements.map(|(place, _)| (format!("{}[{place}]", key.path()), None));
        let default = key.default.and_then(|default| match default.value {
            DefaultValue::Number(number) => Some(number.into()),
            DefaultValue::Word(word) => Some(word.into()),
            DefaultValue::Pair(_) => None,
        });
        elements.chain([(key.path(), default)])
    };
    let inputs: Map<String, Value> = KEYS.iter().flat_map(of_key).map(entry).collect();
    Value::from(inputs).to_string()
}

/// Measured or stated rough surface.
#[wasm_bindgen]
pub struct Surface {
    seed: u64,
    name: String,
    /// Map that is shown: the prepared scan, or the first random map.
    map: HeightMap,
    origin: Origin,
    /// Central part of the map that is pressed, without missing heights, and how many were filled in.
    pressed: OnceCell<(HeightMap, usize)>,
    twin: OnceCell<(HeightMap, Vec<String>)>,
    model: OnceCell<SurfaceModel>,
}

/// Origin of a surface.
enum Origin {
    Scan { scan: Box<Scan>, prepared: Box<Prepared>, settings: ScanSettings },
    Stated(Box<StatedSurface>),
}

#[wasm_bindgen]
impl Surface {
    /// Reads a scan from the content of a file. `name` names the file in messages. The settings may have the keys
    /// `channel`, `pixel_size_m`, `height_unit` and `level`; `seed` is required.
    pub fn from_file(bytes: &[u8], name: String, settings: &str) -> Result<Self, JsError> {
        Ok(Self::from_scan(bytes, name, settings)?)
    }

    /// Draws a stated surface with normal heights and a self-affine spectrum, the map of `asperity surface generate` for
    /// the same settings: `seed`, `points`, `size_m`, `boundary`, `rms_height_m`, `correlation_length_m` and `hurst`.
    pub fn stated(settings: &str) -> Result<Self, JsError> {
        Ok(Self::from_settings(settings)?)
    }

    /// Returns the properties of the map: origin, size, warnings and `statistics`, with the keys of `asperity surface
    /// stats --json`. The map is drawn as `svg`, with room for its twin if there are two columns.
    pub fn describe(&self, columns: usize) -> Result<Answer, JsError> {
        Ok(self.description(columns)?)
    }

    /// Returns the reliable wavenumbers, and the radially averaged power spectral density drawn as `svg`.
    pub fn spectrum(&self) -> Result<Answer, JsError> {
        Ok(self.radial()?)
    }

    /// Draws the map and a random one like it as `svg`: a twin of a scan as `asperity surface twin` draws it, or a second
    /// map of a stated surface.
    pub fn twin(&self, columns: usize) -> Result<Answer, JsError> {
        Ok(self.drawn_twin().and_then(|(twin, warnings)| {
            Answer::new(&json!({ "warnings": warnings, "svg": self.drawn(Some(twin), columns)? }))
        })?)
    }

    /// Presses the map against a rigid flat, with keys of `asperity contact --json`. A map with more than 256 points
    /// along a side is cut to its central part, whose missing heights are filled as `asperity surface fill` does. The
    /// pressure is drawn as `svg`.
    pub fn contact(&self, request: &str) -> Result<Answer, JsError> {
        Ok(self.pressed(request)?)
    }

    /// Solves a long periodic strip of the surface and slides a window along it. The friction coefficient at the mean load
    /// along the first strip is drawn as `svg`.
    pub fn friction(&self, request: &str) -> Result<Answer, JsError> {
        Ok(self.slid(request)?)
    }
}

impl Surface {
    fn new(seed: u64, name: String, map: HeightMap, origin: Origin) -> Self {
        Self { seed, name, map, origin, pressed: OnceCell::new(), twin: OnceCell::new(), model: OnceCell::new() }
    }

    pub(crate) fn from_scan(bytes: &[u8], name: String, settings: &str) -> Result<Self, Failure> {
        let settings: ScanSettings = read(settings)?;
        let scan = read_bytes_with(bytes, &settings.options()?)?;
        let prepared = settings.preparation().apply(HeightMap::try_from(scan.clone())?)?;
        let origin = Origin::Scan { scan: Box::new(scan), prepared: Box::new(prepared.clone()), settings };
        Ok(Self::new(settings_seed(&origin), name, prepared.map, origin))
    }

    pub(crate) fn from_settings(settings: &str) -> Result<Self, Failure> {
        let stated: StatedSurface = read(settings)?;
        let model = stated.model()?;
        let generated = model.patch(stated.grid()?, stated.is_periodic())?;
        let map = draw_map(generated.surface.as_ref(), stated.seed, 0);
        let surface = Self::new(stated.seed, "stated surface".into(), map, Origin::Stated(Box::new(stated)));
        Ok(Self { model: OnceCell::from(model), ..surface })
    }

    /// Returns the boundary that suits the map: a scan ends at its border.
    fn boundary(&self) -> BoundaryKind {
        match &self.origin {
            Origin::Stated(stated) => stated.boundary(),
            Origin::Scan { .. } => BoundaryKind::Free,
        }
    }

    pub(crate) fn description(&self, columns: usize) -> Result<Answer, Failure> {
        let (prepared, own) = match &self.origin {
            Origin::Scan { scan, prepared, .. } => (
                (**prepared).clone(),
                json!({
                    "format": scan.format.map(Format::name),
                    "channel": scan.channel_name(),
                    "channels": scan.channels,
                    "warnings": scan.warnings,
                }),
            ),
            Origin::Stated(stated) => {
                let warnings: &[String] = &[];
                (stated.prepared(&self.map), json!({ "warnings": warnings }))
            }
        };
        let scanned = ScannedSurface::new(prepared)?;
        let mut numbers = with_size(self.map.grid(), own);
        numbers["name"] = self.name.as_str().into();
        numbers["boundary"] = self.boundary().name().into();
        numbers["statistics"] = serde_json::to_value(surface_statistics(&scanned.statistics))?;
        numbers["svg"] = self.drawn(None, columns)?.into();
        Answer::new(&numbers)
    }

    /// Draws the map, and a random one beside it or below.
    fn drawn(&self, twin: Option<&HeightMap>, columns: usize) -> Result<String, Failure> {
        let names = match self.origin {
            Origin::Scan { .. } => ["Scan", "Random twin"],
            Origin::Stated(_) => ["Random map", "Second random map"],
        };
        let fields: Vec<Field> = [Some(&self.map), twin].into_iter().flatten().map(field).collect();
        let maps: Vec<(&str, &Field)> = names.into_iter().zip(&fields).collect();
        Ok(live::heights(&maps, columns)?)
    }

    pub(crate) fn radial(&self) -> Result<Answer, Failure> {
        let found = radial_spectrum(&self.map)?;
        let (low, high) = (found.reliable.low_rad_per_m, found.reliable.high_rad_per_m);
        Answer::new(&json!({
            "reliable_low_rad_per_m": low,
            "reliable_high_rad_per_m": high,
            "svg": live::spectrum(&found.q_rad_per_m, &found.psd_m4, (low, high)),
        }))
    }

    /// Returns the twin with its warnings; draws it at the first call.
    fn drawn_twin(&self) -> Result<&(HeightMap, Vec<String>), Failure> {
        if let Some(twin) = self.twin.get() {
            return Ok(twin);
        }
        let twin = match &self.origin {
            Origin::Scan { scan, settings, .. } => {
                let mut options = TwinOptions::new(self.seed);
                options.surface.level = settings.level;
                let twins = Twins::new((**scan).clone(), &self.name, &options)?;
                (twins.draw(0), twins.warnings().to_vec())
            }
            Origin::Stated(stated) => {
                let generated = self.model()?.patch(stated.grid()?, stated.is_periodic())?;
                (draw_map(generated.surface.as_ref(), self.seed, 1), generated.warnings)
            }
        };
        Ok(self.twin.get_or_init(|| twin))
    }

    /// Returns the model of random surfaces like this one; fits it at the first call.
    fn model(&self) -> Result<&SurfaceModel, Failure> {
        if let Some(model) = self.model.get() {
            return Ok(model);
        }
        let model = match &self.origin {
            Origin::Stated(stated) => stated.model()?,
            Origin::Scan { prepared, .. } => {
                let scanned = ScannedSurface::without_intervals((**prepared).clone())?;
                match SurfaceModel::new(measured(CovarianceRequest::Empirical), Some(&scanned)) {
                    // A short scan has no covariance of its own.
                    Err(SurfaceModelError::Empirical(_)) => {
                        SurfaceModel::new(measured(CovarianceRequest::Measured), Some(&scanned))?.0
                    }
                    found => found?.0,
                }
            }
        };
        Ok(self.model.get_or_init(|| model))
    }
}

fn settings_seed(origin: &Origin) -> u64 {
    match origin {
        Origin::Scan { settings, .. } => settings.seed,
        Origin::Stated(stated) => stated.seed,
    }
}

/// Returns the request for a random surface with the heights of a scan and all Fourier modes.
fn measured(covariance: CovarianceRequest) -> SurfaceRequest {
    SurfaceRequest::Translated {
        rms_height_m: Measurable::Measured,
        covariance,
        families: CorrelationFamily::ALL.to_vec(),
        marginal: Measurable::Measured,
        shortest_wave_m: None,
        translation: TranslationKind::Plain,
        expansion: None,
    }
}

/// Returns the heights of a map as a field.
fn field(map: &HeightMap) -> Field {
    let grid = map.grid();
    Field::new([grid.dx_m(), grid.dy_m()], "m", map.heights_m().clone())
}

/// Adds the size of a map to an object.
fn with_size(grid: Grid, mut numbers: Value) -> Value {
    for (key, value) in [("nx", grid.nx()), ("ny", grid.ny())] {
        numbers[key] = value.into();
    }
    for (key, value) in [("dx_m", grid.dx_m()), ("dy_m", grid.dy_m())] {
        numbers[key] = value.into();
    }
    numbers
}
