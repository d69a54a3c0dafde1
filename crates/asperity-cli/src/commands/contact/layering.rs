//! What lies under the surface.

use asperity::contact::{Base, Elastic, Layer};
use asperity::quantity::{Length, Pressure};
use clap::Args;

use crate::args;
use crate::failure::Failure;

/// A layer and its base; without these the surface is a half-space.
#[derive(Debug, Args)]
pub(super) struct Layering {
    /// Thickness of a layer of the surface's material, bonded to a base.
    #[arg(long, value_name = "Q", value_parser = args::positive_quantity::<Length>, allow_hyphen_values = true)]
    layer_thickness: Option<Length>,
    /// The base is rigid.
    #[arg(long, requires = "layer_thickness", conflicts_with = "base_youngs_modulus")]
    rigid_base: bool,
    /// Young's modulus of an elastic base.
    #[arg(long, value_name = "Q", value_parser = args::positive_quantity::<Pressure>, allow_hyphen_values = true,
          requires = "layer_thickness")]
    base_youngs_modulus: Option<Pressure>,
    /// Poisson's ratio of an elastic base; 0.3 when left out.
    #[arg(long, value_name = "X", value_parser = args::poisson_ratio, allow_hyphen_values = true,
          requires = "base_youngs_modulus", conflicts_with = "rigid_base")]
    base_poisson_ratio: Option<f64>,
}

/// Poisson's ratio of a base, as of a surface, unless told.
const POISSON_RATIO: f64 = 0.3;

impl Layering {
    /// The layer of `material`, if there is one.
    pub(super) fn layer(&self, material: Elastic) -> Result<Option<Layer>, Failure> {
        let Some(thickness) = self.layer_thickness else { return Ok(None) };
        let base = match self.base_youngs_modulus {
            Some(modulus) => {
                let poisson_ratio = self.base_poisson_ratio.unwrap_or(POISSON_RATIO);
                Base::Elastic(Elastic::new(modulus.0, poisson_ratio).map_err(Failure::usage)?)
            }
            None if self.rigid_base => Base::Rigid,
            None => {
                return Err(Failure::usage(
                    "--layer-thickness needs to know what the layer lies on: --rigid-base or --base-youngs-modulus Q",
                ));
            }
        };
        Ok(Some(Layer { thickness_m: thickness.0, material, base }))
    }

    /// A warning where the layer is thinner than the surface is high.
    pub(super) fn doubt(&self, heights_span_m: f64) -> Option<String> {
        let thickness = self.layer_thickness.filter(|thickness| thickness.0 < heights_span_m)?;
        Some(format!(
            "the heights span {heights_span_m:.1e} m, more than the layer's thickness {thickness}, \
             which is taken as the same everywhere"
        ))
    }
}
