//! Two rough elastic bodies as one rough half-space and a rigid flat.

use ndarray::{Array2, s};

use crate::{ContactError, Solution, contact_modulus_pa};
use asperity_base::map::{Grid, HeightMap};

/// A linear elastic, isotropic body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Elastic {
    /// Young's modulus in pascal, > 0.
    pub youngs_modulus_pa: f64,
    /// Poisson's ratio, above −1 and at most ½.
    pub poisson_ratio: f64,
}

impl Elastic {
    /// A body that does not yield.
    pub const RIGID: Self = Self { youngs_modulus_pa: f64::INFINITY, poisson_ratio: 0.0 };

    /// A body of Young's modulus E in pascal and Poisson's ratio ν.
    ///
    /// # Errors
    /// The modulus is not positive and finite, or the ratio not above −1 and at most ½.
    pub fn new(youngs_modulus_pa: f64, poisson_ratio: f64) -> Result<Self, ContactError> {
        let body = Self { youngs_modulus_pa, poisson_ratio };
        body.validate("Young's modulus", "Poisson's ratio").map(|()| body)
    }

    /// Refuses constants that no elastic body has, by the names given.
    pub(super) fn validate(&self, modulus: &'static str, ratio: &'static str) -> Result<(), ContactError> {
        let parameter =
            |parameter, value, unit, wanted| Err(ContactError::Parameter { parameter, value, unit, wanted });
        let Self { youngs_modulus_pa, poisson_ratio } = *self;
        if !(youngs_modulus_pa.is_finite() && youngs_modulus_pa > 0.0) {
            return parameter(modulus, youngs_modulus_pa, "Pa", "positive");
        }
        if !(poisson_ratio > -1.0 && poisson_ratio <= 0.5) {
            return parameter(ratio, poisson_ratio, "(dimensionless)", "above -1 and at most 0.5");
        }
        Ok(())
    }

    pub(super) fn shear_modulus_pa(&self) -> f64 {
        0.5 * self.youngs_modulus_pa / (1.0 + self.poisson_ratio)
    }

    /// 3 − 4ν.
    pub(super) fn kolosov(&self) -> f64 {
        3.0 - 4.0 * self.poisson_ratio
    }

    /// Contact modulus E/(1−ν²) in pascal against a rigid body; infinite for a rigid one.
    pub fn contact_modulus_pa(&self) -> f64 {
        contact_modulus_pa(self.youngs_modulus_pa, self.poisson_ratio)
    }
}

/// One of two bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Body {
    /// The one whose heights are counted upwards, in whose coordinates the contact is solved.
    Lower,
    /// The one turned over and laid upon it.
    Upper,
}

/// Two elastic bodies in contact. Frictionless contact depends on the sum of their compliances and of their heights alone.
///
/// # References
/// K. L. Johnson, *Contact Mechanics*, Cambridge University Press (1985), §4.2, <https://doi.org/10.1017/CBO9781139171731>.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair {
    lower: Elastic,
    upper: Elastic,
}

impl Pair {
    /// Two bodies.
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

    /// Contact modulus E* in pascal, 1/E* = (1−ν₁²)/E₁ + (1−ν₂²)/E₂.
    pub fn contact_modulus_pa(&self) -> f64 {
        let (lower, upper) = (self.lower.contact_modulus_pa(), self.upper.contact_modulus_pa());
        let (softer, stiffer) = (lower.min(upper), lower.max(upper));
        // Against a rigid body exactly its own.
        softer / (1.0 + softer / stiffer)
    }

    /// Share of the displacement that `body` takes: its compliance (1−ν²)/E over that of both.
    pub fn share_of(&self, body: Body) -> f64 {
        let (own, other) = match body {
            Body::Lower => (self.lower, self.upper),
            Body::Upper => (self.upper, self.lower),
        };
        let ratio = own.contact_modulus_pa() / other.contact_modulus_pa();
        // A rigid body against an elastic one: the ratio is infinite, the share zero.
        1.0 / (1.0 + ratio)
    }

    /// Elastic displacement of the surface of `body` into itself in metre, in the coordinates of the lower body, from a solution
    /// of the pair's contact modulus.
    pub fn displacement_of(&self, body: Body, solution: &Solution) -> Array2<f64> {
        solution.displacement_m() * self.share_of(body)
    }
}

/// How the heights of the upper body are given. Either way they are counted outwards from its own material, so that summits
/// of both bodies meet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Laid {
    /// As measured, looking at it from outside. To face the lower body it is turned over about the y axis: x becomes −x, its
    /// last column lies on the first of the lower body, and rows stay.
    #[default]
    Mirrored,
    /// In the coordinates of the lower body: points of equal row and column lie upon each other.
    AsLaid,
}

/// Pitches that differ less, in cells over the whole map, are the same: files state them to some digits.
const SAME_PITCH_CELLS: f64 = 0.01;

/// The composite roughness z = z₁ + z₂ in metre of two facing maps, in the coordinates of the lower one.
///
/// The gap between undeformed bodies is d − z₁ − z₂, which is that between this map and a flat. Means, slopes and curvatures
/// add; of independent maps the mean squares do. A height missing in either is missing.
///
/// # Errors
/// The grids differ, in points or by more than a hundredth of a cell over the map, or no height is present in both.
pub fn composite(lower: &HeightMap, upper: &HeightMap, laid: Laid) -> Result<HeightMap, ContactError> {
    let grid = lower.grid();
    if !same(grid, upper.grid()) {
        return Err(ContactError::Grids { lower: grid.into(), upper: upper.grid().into() });
    }
    let facing = match laid {
        Laid::Mirrored => upper.heights_m().slice(s![.., ..;-1]),
        Laid::AsLaid => upper.heights_m().view(),
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
        let pair = Pair::new(steel, rubber).unwrap();
        let compliance = (1.0 - 0.09) / 210e9 + 0.75 / 5e6;
        assert!((pair.contact_modulus_pa() * compliance - 1.0).abs() < 1e-14);
        let (lower, upper) = (pair.share_of(Body::Lower), pair.share_of(Body::Upper));
        assert!((lower - 0.91 / 210e9 / compliance).abs() < 1e-15 && (lower + upper - 1.0).abs() < 1e-15);
        let twins = Pair::new(steel, steel).unwrap();
        assert_eq!((twins.share_of(Body::Lower), twins.share_of(Body::Upper)), (0.5, 0.5));
        let rigid = Pair::new(steel, Elastic::RIGID).unwrap();
        assert_eq!(rigid.contact_modulus_pa(), steel.contact_modulus_pa());
        assert_eq!((rigid.share_of(Body::Lower), rigid.share_of(Body::Upper)), (1.0, 0.0));
    }

    #[test]
    fn impossible_bodies_are_refused() {
        for (modulus, ratio) in
            [(0.0, 0.3), (-1.0, 0.3), (f64::NAN, 0.3), (f64::INFINITY, 0.3), (1.0, 0.6), (1.0, -1.0)]
        {
            assert!(matches!(Elastic::new(modulus, ratio), Err(ContactError::Parameter { .. })), "{modulus} {ratio}");
        }
        let error = Pair::new(Elastic::RIGID, Elastic::RIGID).unwrap_err();
        assert!(matches!(error, ContactError::Parameter { parameter: "contact modulus of two bodies", .. }));
    }

    #[test]
    fn the_upper_map_is_turned_over_about_the_y_axis_unless_it_lies() {
        let grid = Grid::new(3, 2, 1.0, 0.5).unwrap();
        let map = |heights| HeightMap::new(grid, heights).unwrap();
        let lower = map(array![[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
        let upper = map(array![[10.0, 20.0, 30.0], [40.0, 50.0, f64::NAN]]);
        let mirrored = composite(&lower, &upper, Laid::default()).unwrap();
        assert_eq!(mirrored.heights_m().row(0), array![31.0, 22.0, 13.0]);
        assert!(mirrored.heights_m()[[1, 0]].is_nan() && mirrored.heights_m()[[1, 2]] == 46.0);
        let laid = composite(&lower, &upper, Laid::AsLaid).unwrap();
        assert_eq!(laid.heights_m().row(0), array![11.0, 22.0, 33.0]);
        assert!(laid.heights_m()[[1, 2]].is_nan() && laid.missing_points() == 1);
    }

    #[test]
    fn maps_on_other_grids_are_refused_with_both_pitches() {
        let map = |nx, dx_m| {
            let grid = Grid::new(nx, 4, dx_m, 2e-6).unwrap();
            HeightMap::from_function(grid, |x, y| x + y).unwrap()
        };
        let lower = map(100, 1e-6);
        assert!(composite(&lower, &map(100, 1.00005e-6), Laid::AsLaid).is_ok());
        for upper in [map(101, 1e-6), map(100, 1.0002e-6)] {
            let error = composite(&lower, &upper, Laid::AsLaid).unwrap_err();
            assert_eq!(error, ContactError::Grids { lower: lower.grid().into(), upper: upper.grid().into() });
        }
        let error = composite(&lower, &map(99, 3e-6), Laid::AsLaid).unwrap_err().to_string();
        assert!(error.contains("100 × 4 points at 1e-6 m × 2e-6 m") && error.contains("99 × 4 at 3e-6 m"), "{error}");
        let grid = Grid::new(2, 2, 1.0, 1.0).unwrap();
        let left = HeightMap::new(grid, array![[1.0, f64::NAN], [1.0, f64::NAN]]).unwrap();
        let error = composite(&left, &left, Laid::Mirrored).unwrap_err();
        assert_eq!(error, ContactError::Missing { missing: 4, points: 4 });
    }
}
