//! Removal of form by least squares.

use std::fmt;
use std::str::FromStr;

use ndarray::Array2;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::map::{Grid, HeightMap, MapError};

/// What is taken out of the heights before they are called roughness.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Level {
    /// Nothing.
    None,
    /// The mean height.
    Mean,
    /// The least-squares plane.
    #[default]
    Plane,
    /// The least-squares polynomial of total degree two.
    Quadratic,
}

impl Level {
    /// Number of coefficients.
    fn terms(self) -> usize {
        match self {
            Self::None => 0,
            Self::Mean => 1,
            Self::Plane => 3,
            Self::Quadratic => 6,
        }
    }
}

impl fmt::Display for Level {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::None => "none",
            Self::Mean => "mean",
            Self::Plane => "plane",
            Self::Quadratic => "quadratic",
        })
    }
}

impl FromStr for Level {
    type Err = LevelError;

    fn from_str(text: &str) -> Result<Self, LevelError> {
        [Self::None, Self::Mean, Self::Plane, Self::Quadratic]
            .into_iter()
            .find(|level| level.to_string() == text)
            .ok_or_else(|| LevelError::Unknown { text: text.into() })
    }
}

/// Why a form could not be removed.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum LevelError {
    /// The text names no form.
    #[error("`{text}` is no form to remove; write none, mean, plane or quadratic")]
    Unknown {
        /// What was found.
        text: String,
    },
    /// The present points do not determine the form: they are too few or lie on a line or conic.
    #[error("the {present} heights that are present do not determine a {level}")]
    Undetermined {
        /// Form that was wanted.
        level: Level,
        /// Heights present.
        present: usize,
    },
}

/// A polynomial form, about the centre (x₀, y₀) of the present points:
/// z = offset + slope_x ξ + slope_y η + curvature_xx ξ² + curvature_xy ξη + curvature_yy η², ξ = x − x₀, η = y − y₀.
///
/// The first cell's centre lies at (dx/2, dy/2), and y grows with the row, downwards.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Form {
    /// x₀ in metre.
    pub centre_x_m: f64,
    /// y₀ in metre.
    pub centre_y_m: f64,
    /// Height at the centre in metre.
    pub offset_m: f64,
    /// Slope along x at the centre.
    pub slope_x: f64,
    /// Slope along y at the centre.
    pub slope_y: f64,
    /// Coefficient of ξ² in 1/m, half the curvature along x.
    pub curvature_xx_per_m: f64,
    /// Coefficient of ξη in 1/m.
    pub curvature_xy_per_m: f64,
    /// Coefficient of η² in 1/m, half the curvature along y.
    pub curvature_yy_per_m: f64,
}

impl Form {
    /// Height of the form at (x, y) in metre.
    pub fn height_m(&self, x_m: f64, y_m: f64) -> f64 {
        let (xi, eta) = (x_m - self.centre_x_m, y_m - self.centre_y_m);
        self.offset_m
            + self.slope_x * xi
            + self.slope_y * eta
            + self.curvature_xx_per_m * xi * xi
            + self.curvature_xy_per_m * xi * eta
            + self.curvature_yy_per_m * eta * eta
    }
}

/// A map without its form, and the form.
#[derive(Debug, Clone, PartialEq)]
pub struct Levelled {
    /// What is left, missing where the heights were.
    pub map: HeightMap,
    /// What was removed.
    pub form: Form,
}

/// Removes the least-squares form from the present heights; missing ones stay missing and have no say.
///
/// The monomials, in coordinates that run from −1 to 1 over the present points, are orthonormalised on those points
/// (modified Gram–Schmidt, twice), so the result does not depend on pitch, offset or mask beyond rounding. When all that
/// is left is the rounding of the heights, it is set to zero: a perfect plane has no roughness.
///
/// # Errors
/// [`LevelError::Undetermined`] when the present points do not determine the form.
pub fn remove_form(map: &HeightMap, level: Level) -> Result<Levelled, LevelError> {
    let points = Points::of(map);
    let present = points.heights_m.len();
    let mut residual = points.heights_m.clone();
    // Roughness of nanometres may sit on millimetres of offset: the mean goes first.
    let mean_m = if level == Level::None { 0.0 } else { residual.iter().sum::<f64>() / present as f64 };
    residual.iter_mut().for_each(|z| *z -= mean_m);

    let mut basis: Vec<Vec<f64>> = vec![];
    let mut monomials = [[0.0; 6]; 6];
    let mut coefficients = [0.0; 6];
    for term in 0..level.terms() {
        // Each new direction is expressed in monomials as well, so that the form can be told in plain coefficients.
        let mut expression = [0.0; 6];
        expression[term] = 1.0;
        let mut column = points.monomial(term);
        let size = norm(&column);
        for _ in 0..2 {
            for (direction, known) in basis.iter().zip(&monomials) {
                let share = dot(direction, &column);
                subtract(&mut column, share, direction);
                expression.iter_mut().zip(known).for_each(|(e, k)| *e -= share * k);
            }
        }
        let rest = norm(&column);
        if rest.is_nan() || rest <= 1e-9 * size || rest == 0.0 {
            return Err(LevelError::Undetermined { level, present });
        }
        column.iter_mut().for_each(|v| *v /= rest);
        expression.iter_mut().for_each(|e| *e /= rest);
        monomials[term] = expression;
        basis.push(column);
    }
    for _ in 0..2 {
        for (direction, expression) in basis.iter().zip(&monomials) {
            let share = dot(direction, &residual);
            subtract(&mut residual, share, direction);
            coefficients.iter_mut().zip(expression).for_each(|(c, e)| *c += share * e);
        }
    }

    // What is no larger than the rounding of the heights is not roughness.
    let rounding_m = 16.0 * f64::EPSILON * points.heights_m.iter().fold(0.0, |m: f64, z| m.max(z.abs()));
    if level != Level::None && residual.iter().all(|z| z.abs() <= rounding_m) {
        residual.fill(0.0);
    }
    let mut left = residual.into_iter();
    let heights_m = map.heights_m().mapv(|z| if z.is_nan() { z } else { left.next().unwrap_or(f64::NAN) });
    let form = points.form(mean_m, coefficients);
    let undetermined = |_: MapError| LevelError::Undetermined { level, present };
    Ok(Levelled { map: HeightMap::new(map.grid(), heights_m).map_err(undetermined)?, form })
}

/// The present heights and their scaled coordinates.
struct Points {
    u: Vec<f64>,
    v: Vec<f64>,
    heights_m: Vec<f64>,
    centre_m: [f64; 2],
    half_m: [f64; 2],
}

impl Points {
    fn of(map: &HeightMap) -> Self {
        let grid = map.grid();
        let present = || map.heights_m().indexed_iter().filter(|(_, z)| !z.is_nan());
        let ends = |place: fn(&(usize, usize)) -> usize| {
            present().fold((usize::MAX, 0), |(low, high), (at, _)| (low.min(place(&at)), high.max(place(&at))))
        };
        let axis = |(low, high): (usize, usize), pitch_m: f64| {
            // One row alone has no extent; its scaled coordinate is then 0 and the form stays undetermined.
            let centre = 0.5 * (low + high) as f64;
            let half = if high > low { 0.5 * (high - low) as f64 } else { 1.0 };
            (centre, half, (centre + 0.5) * pitch_m, half * pitch_m)
        };
        let (column, half_columns, x_m, half_x_m) = axis(ends(|at| at.1), grid.dx_m());
        let (row, half_rows, y_m, half_y_m) = axis(ends(|at| at.0), grid.dy_m());
        Self {
            u: present().map(|(at, _)| (at.1 as f64 - column) / half_columns).collect(),
            v: present().map(|(at, _)| (at.0 as f64 - row) / half_rows).collect(),
            heights_m: present().map(|(_, z)| *z).collect(),
            centre_m: [x_m, y_m],
            half_m: [half_x_m, half_y_m],
        }
    }

    /// 1, u, v, u², uv, v².
    fn monomial(&self, term: usize) -> Vec<f64> {
        let pairs = self.u.iter().zip(&self.v);
        match term {
            0 => vec![1.0; self.u.len()],
            1 => self.u.clone(),
            2 => self.v.clone(),
            3 => pairs.map(|(u, _)| u * u).collect(),
            4 => pairs.map(|(u, v)| u * v).collect(),
            _ => pairs.map(|(_, v)| v * v).collect(),
        }
    }

    fn form(&self, mean_m: f64, [c, u, v, uu, uv, vv]: [f64; 6]) -> Form {
        let [half_x_m, half_y_m] = self.half_m;
        Form {
            centre_x_m: self.centre_m[0],
            centre_y_m: self.centre_m[1],
            offset_m: mean_m + c,
            slope_x: u / half_x_m,
            slope_y: v / half_y_m,
            curvature_xx_per_m: uu / half_x_m / half_x_m,
            curvature_xy_per_m: uv / half_x_m / half_y_m,
            curvature_yy_per_m: vv / half_y_m / half_y_m,
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

fn subtract(from: &mut [f64], share: f64, direction: &[f64]) {
    from.iter_mut().zip(direction).for_each(|(value, d)| *value -= share * d);
}

/// The form as a map, for figures and tests.
impl Form {
    /// Heights of the form on a grid in metre, shape `[ny, nx]`.
    pub fn heights_m(&self, grid: Grid) -> Array2<f64> {
        Array2::from_shape_fn(grid.shape(), |(row, column)| {
            self.height_m((column as f64 + 0.5) * grid.dx_m(), (row as f64 + 0.5) * grid.dy_m())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random;

    fn noise(grid: Grid, index: u64) -> Array2<f64> {
        let values = random::standard_normal(&mut random::stream(9, "level", index), grid.points());
        Array2::from_shape_vec(grid.shape(), values).unwrap()
    }

    #[test]
    fn a_form_is_removed_and_told_at_any_pitch() {
        for pitch_m in [1e-9, 1.0, 1e6] {
            let grid = Grid::new(31, 17, pitch_m, 2.0 * pitch_m).unwrap();
            let form = Form {
                centre_x_m: 0.5 * grid.width_m(),
                centre_y_m: 0.5 * grid.height_m(),
                offset_m: 3e3 * pitch_m,
                slope_x: 0.3,
                slope_y: -0.7,
                curvature_xx_per_m: 0.02 / pitch_m,
                curvature_xy_per_m: -0.01 / pitch_m,
                curvature_yy_per_m: 0.005 / pitch_m,
            };
            let map = HeightMap::from_function(grid, |x, y| form.height_m(x, y)).unwrap();
            let levelled = remove_form(&map, Level::Quadratic).unwrap();
            assert!(levelled.map.present_m().all(|z| z == 0.0));
            let found = levelled.form;
            for (found, wanted) in [
                (found.offset_m, form.offset_m),
                (found.slope_x, form.slope_x),
                (found.slope_y, form.slope_y),
                (found.curvature_xx_per_m, form.curvature_xx_per_m),
                (found.curvature_xy_per_m, form.curvature_xy_per_m),
                (found.curvature_yy_per_m, form.curvature_yy_per_m),
            ] {
                assert!((found / wanted - 1.0).abs() < 1e-10, "{found} is not {wanted}");
            }
        }
    }

    #[test]
    fn what_is_left_is_orthogonal_to_the_form_on_the_present_points() {
        let grid = Grid::new(40, 30, 1e-6, 1e-6).unwrap();
        let mut heights = noise(grid, 0);
        // Half of the map is missing, so that the monomials are far from orthogonal.
        heights.indexed_iter_mut().filter(|((row, column), _)| row + column > 35).for_each(|(_, z)| *z = f64::NAN);
        let map = HeightMap::new(grid, heights).unwrap();
        for (level, terms) in [(Level::Mean, 1), (Level::Plane, 3), (Level::Quadratic, 6)] {
            let levelled = remove_form(&map, level).unwrap();
            assert_eq!(levelled.map.missing_points(), map.missing_points());
            let monomials: [fn(f64, f64) -> f64; 6] =
                [|_, _| 1.0, |x, _| x, |_, y| y, |x, _| x * x, |x, y| x * y, |_, y| y * y];
            for monomial in &monomials[..terms] {
                let product: f64 = levelled
                    .map
                    .heights_m()
                    .indexed_iter()
                    .filter(|(_, z)| !z.is_nan())
                    .map(|((row, column), z)| z * monomial(column as f64 / 40.0, row as f64 / 30.0))
                    .sum();
                assert!(product.abs() < 1e-11, "{level}: {product:e}");
            }
            // Form and rest make up the map again.
            let again = levelled.form.heights_m(grid) + levelled.map.heights_m();
            assert!(again.iter().zip(map.heights_m()).all(|(a, b)| b.is_nan() || (a - b).abs() < 1e-12));
        }
    }

    #[test]
    fn levelling_twice_changes_nothing_and_none_removes_nothing() {
        let grid = Grid::new(20, 20, 1.0, 1.0).unwrap();
        let map = HeightMap::new(grid, noise(grid, 1)).unwrap();
        let once = remove_form(&map, Level::Plane).unwrap().map;
        let twice = remove_form(&once, Level::Plane).unwrap().map;
        assert!(once.heights_m().iter().zip(twice.heights_m()).all(|(a, b)| (a - b).abs() < 1e-14));
        assert_eq!(remove_form(&map, Level::None).unwrap().map, map);
    }

    #[test]
    fn points_on_a_line_do_not_determine_a_plane() {
        let grid = Grid::new(10, 10, 1.0, 1.0).unwrap();
        let diagonal = Array2::from_shape_fn((10, 10), |(row, column)| if row == column { 1.0 } else { f64::NAN });
        let map = HeightMap::new(grid, diagonal).unwrap();
        let error = remove_form(&map, Level::Plane).unwrap_err();
        assert_eq!(error, LevelError::Undetermined { level: Level::Plane, present: 10 });
        assert!(remove_form(&map, Level::Mean).is_ok());
        let row = Array2::from_shape_fn((10, 10), |(row, _)| if row == 3 { 1.0 } else { f64::NAN });
        assert!(remove_form(&HeightMap::new(grid, row).unwrap(), Level::Plane).is_err());
    }

    #[test]
    fn forms_are_named_as_in_study_files() {
        for level in [Level::None, Level::Mean, Level::Plane, Level::Quadratic] {
            assert_eq!(level.to_string().parse(), Ok(level));
            assert_eq!(serde_json::to_string(&level).unwrap(), format!("\"{level}\""));
        }
        assert!("cubic".parse::<Level>().is_err());
    }
}
