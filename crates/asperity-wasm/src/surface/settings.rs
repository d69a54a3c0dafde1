//! Settings of surfaces.

use asperity::choice::ByName;
use asperity::correlation::{CorrelationFamily, CorrelationModel};
use asperity::distribution::Marginal;
use asperity::map::{BoundaryKind, Grid, HeightMap, MapError, checked_pitch_m};
use asperity::surface::level::Level;
use asperity::surface::model::{CovarianceRequest, Measurable, SurfaceModel, SurfaceModelError, SurfaceRequest};
use asperity::surface::preparation::{Preparation, Prepared};
use asperity::translation::TranslationKind;
use asperity_formats::{Channel, ReadOptions};
use serde::Deserialize;

use crate::answer::Failure;

/// Settings of a scan.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ScanSettings {
    pub(super) seed: u64,
    #[serde(default)]
    channel: Option<String>,
    #[serde(default)]
    pixel_size_m: Option<(f64, f64)>,
    #[serde(default)]
    height_unit: Option<String>,
    pub(super) level: Level,
}

impl ScanSettings {
    pub(super) fn options(&self) -> Result<ReadOptions, Failure> {
        Ok(ReadOptions {
            channel: self.channel.as_deref().map(Channel::from),
            height_unit: self.height_unit.as_deref().map(str::parse).transpose()?,
            pitch_m: self.pixel_size_m.map(checked_pitch_m).transpose()?,
            ..ReadOptions::default()
        })
    }

    pub(super) fn preparation(&self) -> Preparation {
        Preparation { level: self.level, ..Preparation::default() }
    }
}

/// Random surface with normal heights and a self-affine spectrum, and the grid of its map.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StatedSurface {
    pub(super) seed: u64,
    points: [usize; 2],
    size_m: [f64; 2],
    boundary: ByName<BoundaryKind>,
    rms_height_m: f64,
    correlation_length_m: [f64; 2],
    hurst: f64,
}

impl StatedSurface {
    pub(super) fn grid(&self) -> Result<Grid, MapError> {
        let ([nx, ny], [width_m, height_m]) = (self.points, self.size_m);
        Grid::with_size(nx, ny, width_m, height_m)
    }

    pub(super) fn boundary(&self) -> BoundaryKind {
        self.boundary.0
    }

    pub(super) fn is_periodic(&self) -> bool {
        self.boundary() == BoundaryKind::Periodic
    }

    pub(super) fn model(&self) -> Result<SurfaceModel, SurfaceModelError> {
        let request = SurfaceRequest::Translated {
            rms_height_m: Measurable::Stated(self.rms_height_m),
            covariance: CovarianceRequest::Stated {
                model: CorrelationModel::SelfAffine { hurst: self.hurst },
                lengths_m: self.correlation_length_m,
            },
            families: CorrelationFamily::ALL.to_vec(),
            marginal: Measurable::Stated(Marginal::STANDARD_NORMAL),
            shortest_wave_m: None,
            translation: TranslationKind::Plain,
            expansion: None,
        };
        Ok(SurfaceModel::new(request, None)?.0)
    }

    /// Returns a drawn map for its statistics; no form is removed.
    pub(super) fn prepared(&self, map: &HeightMap) -> Prepared {
        Prepared { map: map.clone(), outliers: 0, lost: 0, radius_m: None, level: Level::None }
    }
}
