//! Flags of a layer and its base.

use asperity::contact::{Base, Elastic, Layer};
use asperity::quantity::{Length, Pressure};
use clap::Args;

use crate::args;
use crate::failure::Failure;

/// Layer and its base; a half-space by default.
#[derive(Debug, Args)]
pub(super) struct Layering {
    /// Thickness of a layer of the surface's material, bonded to a base.
    #[arg(long, value_name = "Q", value_parser = args::positive_quantity::<Length>, allow_hyphen_values = true)]
    layer_thickness: Option<Length>,
    /// Lay the layer on a rigid base.
    #[arg(long, requires = "layer_thickness", conflicts_with = "base_youngs_modulus")]
    rigid_base: bool,
    /// Young's modulus of an elastic base.
    #[arg(long, value_name = "Q", value_parser = args::positive_quantity::<Pressure>, allow_hyphen_values = true,
          requires = "layer_thickness")]
    base_youngs_modulus: Option<Pressure>,
    /// Poisson's ratio of an elastic base; 0.3 when left out.
    #[arg(long, value_name = "X", value_parser = args::of_input("material.poisson_ratio"), allow_hyphen_values = true,
          requires = "base_youngs_modulus", conflicts_with = "rigid_base")]
    base_poisson_ratio: Option<f64>,
}

impl Layering {
    /// Returns the layer of `material`, if there is one.
    pub(super) fn layer(&self, material: Elastic) -> Result<Option<Layer>, Failure> {
        let Some(thickness) = self.layer_thickness else { return Ok(None) };
        let base = match self.base_youngs_modulus {
            Some(modulus) => {
                let poisson_ratio = self.base_poisson_ratio.unwrap_or(Elastic::POISSON_RATIO);
                Base::Elastic(Elastic::new(modulus.0, poisson_ratio).map_err(Failure::usage)?)
            }
            None if self.rigid_base => Base::Rigid,
            None => {
                return Err(Failure::usage(
                    "--layer-thickness needs a base: add --rigid-base or --base-youngs-modulus Q",
                ));
            }
        };
        Ok(Some(Layer { thickness_m: thickness.0, material, base }))
    }

    /// Returns a warning if the layer is thinner than the span of the heights.
    pub(super) fn warning(&self, heights_span_m: f64) -> Option<String> {
        let thickness = self.layer_thickness.filter(|thickness| thickness.0 < heights_span_m)?;
        Some(format!(
            "the heights span {heights_span_m:.1e} m, more than the layer's thickness {thickness}, \
             which is assumed uniform"
        ))
    }
}
