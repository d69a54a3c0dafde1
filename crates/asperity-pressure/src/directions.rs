//! Named directions in the space of ξ.

use crate::Problem;
use crate::rotated_variables::{RotatedVariables, responses};

/// Orthonormal directions, each the part of a named mean height that is orthogonal to the previous ones.
#[derive(Debug, Clone, Default)]
pub(super) struct NamedDirections {
    pub(super) names: Vec<String>,
    directions: RotatedVariables,
}

impl NamedDirections {
    /// Creates the directions of the height of the cell and of the mean heights of rings around it, from the innermost
    /// outwards, `most` in all.
    ///
    /// Ring n reaches up to 2ⁿ⁻¹ times the finer pitch. The result is empty if there are too many variables ξ.
    pub(super) fn from_cell(problem: &Problem<'_>, most: usize) -> Self {
        let mut named = Self::default();
        for (ring, response) in responses(problem) {
            if named.names.len() == most {
                break;
            }
            if let Some(directions) = named.directions.with(&response) {
                named.directions = directions;
                named.names.push(if ring == 0 { "height of the cell".to_owned() } else { format!("ring {ring}") });
            }
        }
        named
    }

    /// Creates the directions of the leading variables ξ themselves.
    pub(super) fn leading(xi_len: usize, most: usize) -> Self {
        let unit = |j: usize| (0..xi_len).map(|i| if i == j { 1.0 } else { 0.0 }).collect();
        let count = most.min(xi_len);
        Self {
            names: (1..=count).map(|mode| format!("mode {mode}")).collect(),
            directions: RotatedVariables::from_orthonormal((0..count).map(unit).collect()),
        }
    }

    /// Returns the rotated variables of ξ.
    pub(super) fn apply(&self, xi: &[f64]) -> Vec<f64> {
        self.directions.apply(xi)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::gaussian_surface;
    use asperity_base::random::{standard_normal, stream};
    use asperity_contact::Control;
    use asperity_surface::RandomSurface;

    #[test]
    fn the_first_direction_is_the_height_of_the_cell() {
        let (surface, half_space) = gaussian_surface(16, 40);
        let problem = Problem::new(&surface, &half_space, Control::Plane { height_m: 0.0 }, None).unwrap();
        let problem = problem.at_cell(3, 5).unwrap();
        let named = NamedDirections::from_cell(&problem, 4);
        assert_eq!(named.names, ["height of the cell", "ring 1", "ring 2", "ring 3"]);
        let xi_samples: Vec<Vec<f64>> = (0..3).map(|i| standard_normal(&mut stream(1, "directions", i), 40)).collect();
        let ratio = |xi: &Vec<f64>| surface.generate(xi).heights_m()[[3, 5]] / named.apply(xi)[0];
        assert!((ratio(&xi_samples[0]) / ratio(&xi_samples[1]) - 1.0).abs() < 1e-9);
        let leading = NamedDirections::leading(40, 2);
        assert_eq!((leading.apply(&xi_samples[0]), leading.names[1].as_str()), (xi_samples[0][..2].to_vec(), "mode 2"));
    }
}
