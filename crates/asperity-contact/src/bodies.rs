//! Contact of two rough elastic bodies, reduced to one rough half-space and a rigid flat.

use ndarray::{Array2, s};

use crate::{ContactError, Elastic, Solution};
use asperity_base::map::{Grid, HeightMap};

/// One of two bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Body {
    /// The lower body. Its heights point upwards, and the contact is solved in its coordinates.
    Lower,
    /// The upper body, which faces the lower one.
    Upper,
}

/// Two elastic bodies in contact. Frictionless contact depends only on the sum of their compliances and of their
/// heights.
///
/// # References
/// K. L. Johnson, *Contact Mechanics*, Cambridge University Press (1985), §4.2,
/// <https://doi.org/10.1017/CBO9781139171731>.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ElasticPair {
    lower: Elastic,
    upper: Elastic,
}

impl ElasticPair {
    /// Creates a pair of bodies.
    ///
    /// # Errors
    /// Both are rigid.
    pub fn new(lower: Elastic, upper: Elastic) -> Result<Self, ContactError> {
        let pair = Self { lower, upper };
        let (parameter, value) = ("contact modulus of two bodies", pair.contact_modulus_pa());
        if value.is_finite() {
            Ok(pair)
        } else {
            Err(ContactError::Parameter { parameter, value, unit: "Pa", wanted: "finite" })
        }
    }

    /// Returns the contact modulus E* in pascal, 1/E* = (1−ν₁²)/E₁ + (1−ν₂²)/E₂.
    pub fn contact_modulus_pa(&self) -> f64 {
        let (lower, upper) = (self.lower.contact_modulus_pa(), self.upper.contact_modulus_pa());
        let (softer, stiffer) = (lower.min(upper), lower.max(upper));
        // Against a rigid body this is exactly the modulus of the other body.
        softer / (1.0 + softer / stiffer)
    }

    /// Returns the fraction of the displacement in `body`: its compliance (1−ν²)/E over the sum of both compliances.
    pub fn displacement_fraction(&self, body: Body) -> f64 {
        let (own, other) = match body {
            Body::Lower => (self.lower, self.upper),
            Body::Upper => (self.upper, self.lower),
        };
        let ratio = own.contact_modulus_pa() / other.contact_modulus_pa();
        // For a rigid body against an elastic one the ratio is infinite and the fraction zero.
        1.0 / (1.0 + ratio)
    }

    /// Returns the elastic displacement of the surface of `body` into itself in metre, in the coordinates of the lower
    /// body. `solution` is a contact solved with the contact modulus of the pair.
    pub fn displacement_of(&self, body: Body, solution: &Solution) -> Array2<f64> {
        solution.displacement_m() * self.displacement_fraction(body)
    }
}

/// Orientation of the upper map. In either case heights point out of its own material, so summits of both bodies meet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Orientation {
    /// As measured, seen from outside. To face the lower body the map is turned over about the y axis: x becomes −x, its
    /// last column lies on the first of the lower body, and rows stay.
    #[default]
    Mirrored,
    /// In the coordinates of the lower body: points of equal row and column face each other.
    Aligned,
}

/// Largest difference of two equal pitches, in cells over the whole map. Files round pitches to a few digits.
const SAME_PITCH_CELLS: f64 = 0.01;

/// Returns the composite roughness z = z₁ + z₂ in metre of two facing maps, in the coordinates of the lower one.
///
/// The gap between the undeformed bodies is d − z₁ − z₂, the gap between this map and a flat. Means, slopes and
/// curvatures add. For independent maps the mean squares add too. A height that is missing in either map is missing in
/// the result.
///
/// # Errors
/// The grids differ, in points or by more than a hundredth of a cell over the map, or no height is present in both.
pub fn composite(lower: &HeightMap, upper: &HeightMap, orientation: Orientation) -> Result<HeightMap, ContactError> {
    let grid = lower.grid();
    if !same(grid, upper.grid()) {
        return Err(ContactError::Grids { lower: grid.into(), upper: upper.grid().into() });
    }
    let facing = match orientation {
        Orientation::Mirrored => upper.heights_m().slice(s![.., ..;-1]),
        Orientation::Aligned => upper.heights_m().view(),
    };
    let points = grid.points();
    HeightMap::new(grid, lower.heights_m() + &facing).map_err(|_| ContactError::Missing { missing: points, points })
}

fn same(lower: Grid, upper: Grid) -> bool {
    let close = |a: f64, b: f64, points: usize| (a / b - 1.0).abs() * points as f64 <= SAME_PITCH_CELLS;
    lower.shape() == upper.shape()
        && close(lower.dx_m(), upper.dx_m(), lower.nx())
        && close(lower.dy_m(), upper.dy_m(), lower.ny())
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::array;

    #[test]
    fn compliances_add_and_share_the_displacement() {
        let steel = Elastic::new(210e9, 0.3).unwrap();
        let rubber = Elastic::new(5e6, 0.5).unwrap();
        let pair = ElasticPair::new(steel, rubber).unwrap();
        let compliance = (1.0 - 0.09) / 210e9 + 0.75 / 5e6;
        assert!((pair.contact_modulus_pa() * compliance - 1.0).abs() < 1e-14);
        let (lower, upper) = (pair.displacement_fraction(Body::Lower), pair.displacement_fraction(Body::Upper));
        assert!((lower - 0.91 / 210e9 / compliance).abs() < 1e-15 && (lower + upper - 1.0).abs() < 1e-15);
        let twins = ElasticPair::new(steel, steel).unwrap();
        assert_eq!((twins.displacement_fraction(Body::Lower), twins.displacement_fraction(Body::Upper)), (0.5, 0.5));
        let rigid = ElasticPair::new(steel, Elastic::RIGID).unwrap();
        assert_eq!(rigid.contact_modulus_pa(), steel.contact_modulus_pa());
        assert_eq!((rigid.displacement_fraction(Body::Lower), rigid.displacement_fraction(Body::Upper)), (1.0, 0.0));
    }

    #[test]
    fn invalid_elastic_constants_are_refused() {
        for (modulus, ratio) in
            [(0.0, 0.3), (-1.0, 0.3), (f64::NAN, 0.3), (f64::INFINITY, 0.3), (1.0, 0.6), (1.0, -1.0)]
        {
            assert!(matches!(Elastic::new(modulus, ratio), Err(ContactError::Parameter { .. })), "{modulus} {ratio}");
        }
        let error = ElasticPair::new(Elastic::RIGID, Elastic::RIGID).unwrap_err();
        assert!(matches!(error, ContactError::Parameter { parameter: "contact modulus of two bodies", .. }));
    }

    #[test]
    fn the_upper_map_is_mirrored_unless_it_is_aligned() {
        let grid = Grid::new(3, 2, 1.0, 0.5).unwrap();
        let map = |heights| HeightMap::new(grid, heights).unwrap();
        let lower = map(array![[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
        let upper = map(array![[10.0, 20.0, 30.0], [40.0, 50.0, f64::NAN]]);
        let mirrored = composite(&lower, &upper, Orientation::default()).unwrap();
        assert_eq!(mirrored.heights_m().row(0), array![31.0, 22.0, 13.0]);
        assert!(mirrored.heights_m()[[1, 0]].is_nan() && mirrored.heights_m()[[1, 2]] == 46.0);
        let laid = composite(&lower, &upper, Orientation::Aligned).unwrap();
        assert_eq!(laid.heights_m().row(0), array![11.0, 22.0, 33.0]);
        assert!(laid.heights_m()[[1, 2]].is_nan() && laid.missing_points() == 1);
    }

    #[test]
    fn maps_on_different_grids_are_refused_with_both_pitches() {
        let map = |nx, dx_m| {
            let grid = Grid::new(nx, 4, dx_m, 2e-6).unwrap();
            HeightMap::from_function(grid, |x, y| x + y).unwrap()
        };
        let lower = map(100, 1e-6);
        assert!(composite(&lower, &map(100, 1.00005e-6), Orientation::Aligned).is_ok());
        for upper in [map(101, 1e-6), map(100, 1.0002e-6)] {
            let error = composite(&lower, &upper, Orientation::Aligned).unwrap_err();
            assert_eq!(error, ContactError::Grids { lower: lower.grid().into(), upper: upper.grid().into() });
        }
        let error = composite(&lower, &map(99, 3e-6), Orientation::Aligned).unwrap_err().to_string();
        assert!(error.contains("100 × 4 points at 1e-6 m × 2e-6 m") && error.contains("99 × 4 at 3e-6 m"), "{error}");
        let grid = Grid::new(2, 2, 1.0, 1.0).unwrap();
        let left = HeightMap::new(grid, array![[1.0, f64::NAN], [1.0, f64::NAN]]).unwrap();
        let error = composite(&left, &left, Orientation::Mirrored).unwrap_err();
        assert_eq!(error, ContactError::Missing { missing: 4, points: 4 });
    }
}
