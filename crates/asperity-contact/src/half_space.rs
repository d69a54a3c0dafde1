//! Compliance of a half-space: computes the normal displacement of a pressure on a grid.

use crate::pyramid::{Pyramid, PyramidWork};
use crate::slabs::Slabs;
use crate::substrate::PointLoad;
use crate::{Boundary, ContactError, Substrate};
use asperity_base::fourier::{Convolution, ConvolutionWork, ROWS_OF_SLAB, good_length, signed_index};
use asperity_base::map::Grid;

/// A linear elastic half-space of contact modulus E* = E/(1−ν²), or a layered one, discretised in cells of constant
/// pressure.
///
/// Any number of threads can share it; each needs its own [`ContactWorkspace`].
#[derive(Debug, Clone)]
pub struct HalfSpace {
    grid: Grid,
    substrate: Substrate,
    boundary: Boundary,
    /// The compliance in m/Pa; its symbol is real, because the kernel is even.
    exact: Convolution<f64>,
    compliance: Vec<f64>,
    /// In single precision, over `unit_m_per_pa`, for the steps of a solver.
    quick: Convolution<f32>,
    unit_m_per_pa: f64,
    /// Compliance under the mean pressure, and its inverse.
    mean: MeanMode,
    stiffness: Stiffness,
    unit_pa_per_m: f64,
    /// The same half-space on cells twice as wide, for initial pressures; `None` on odd or small grids.
    coarse: Option<Box<HalfSpace>>,
}

/// Preconditioner: E*|q|/2, the inverse of the compliance except for the boundary, over some unit.
#[derive(Debug, Clone)]
enum Stiffness {
    /// Approximation for square cells that can be halved.
    Pyramid(Pyramid),
    Spectral(Convolution<f32>, Vec<f64>),
}

impl Stiffness {
    /// Creates the preconditioner and returns it with its unit in Pa/m; `torus` is the padded size of its convolution.
    fn new(substrate: &Substrate, grid: Grid, boundary: Boundary, torus: (usize, usize)) -> (Self, f64) {
        let (nx, ny) = (grid.nx(), grid.ny());
        let square = (grid.dx_m() / grid.dy_m() - 1.0).abs() < 1e-9;
        let pyramid = match substrate {
            Substrate::HalfSpace { .. } if square => Pyramid::new(ny, nx, boundary != Boundary::Free),
            _ => None,
        };
        if let Some(pyramid) = pyramid {
            return (Self::Pyramid(pyramid), 0.5 * substrate.modulus_pa() / grid.dx_m());
        }
        let plan = Convolution::<f32>::new((ny, nx), torus);
        let q = wavenumber_rad_per_m(grid, torus);
        let shortest = q(nx / 2, (ny / 2) as f64);
        let shortest = if shortest > 0.0 { shortest } else { 1.0 };
        // If a thin layer hardly yields to long waves, these are the stiffest.
        let longest = std::f64::consts::TAU / grid.width_m().max(grid.height_m());
        let unit_pa_per_m = substrate.stiffness_pa_per_m(shortest).max(substrate.stiffness_pa_per_m(longest));
        let symbol = plan.symbol(|kx, ky| match q(kx, ky) {
            q if q > 0.0 => substrate.stiffness_pa_per_m(q) / unit_pa_per_m,
            _ => 0.0,
        });
        (Self::Spectral(plan, symbol), unit_pa_per_m)
    }
}

/// Scratch memory for a [`Stiffness`].
#[derive(Debug, Clone)]
enum StiffnessWork {
    Pyramid(PyramidWork),
    Spectral(ConvolutionWork<f32>),
}

/// Response to the mean pressure: displacement per pressure in m/Pa, and its approximate inverse in Pa/m. On the free
/// boundary the compliance is the sum over the padded grid.
#[derive(Debug, Clone, Copy)]
pub(super) struct MeanMode {
    compliance: f64,
    stiffness: f64,
}

impl MeanMode {
    /// Returns the displacement in metre by a uniform pressure on a periodic half-space.
    pub(super) fn displacement_m(self, pressure_pa: f64) -> f64 {
        self.compliance * pressure_pa
    }
}

/// Largest number of cells for which the scratch memory of both precisions is kept at the same time.
pub(super) const MOST_KEPT: usize = 1 << 21;
/// Cells along either side of the coarsest grid.
const COARSEST: usize = 8;

/// Least fraction of Love's coefficient of a cell for itself that must remain with a layer. The error is 10⁻¹⁰ of it.
const LEAST_LEFT: f64 = 1e-8;

/// Scratch memory of one thread.
///
/// A solver reuses it in the next solve on the same half-space; allocation would take much of the time of small
/// problems. On another half-space it is allocated anew.
#[derive(Debug, Clone, Default)]
pub struct ContactWorkspace {
    /// Key of the scratch memory: the grid, whether the patch is free, and whether the substrate is homogeneous.
    fits: Option<(Grid, bool, bool)>,
    pub(super) transforms: Transforms,
    pub(super) near: Slabs,
    /// Workspace of the half-space on cells twice as wide, once it is used.
    pub(super) coarse: Option<Box<ContactWorkspace>>,
}

/// Scratch memory for applying compliance and preconditioner, allocated on first use.
#[derive(Debug, Clone, Default)]
pub(super) struct Transforms {
    exact: Option<ConvolutionWork<f64>>,
    quick: Option<ConvolutionWork<f32>>,
    stiffness: Option<StiffnessWork>,
}

impl HalfSpace {
    /// Plans the transforms and computes the kernel for `grid` and the contact modulus E* in pascal.
    ///
    /// On the free boundary the kernel is Love's solution for a cell of constant pressure, applied by a zero-padded
    /// convolution, which is exact for the discretised problem. On the periodic boundary a pressure wave
    /// p̂ e^{iqx} moves the surface by û = 2p̂/(E*|q|).
    ///
    /// # Errors
    /// The modulus is not positive, or the mean compliance is negative.
    ///
    /// # References
    /// A. E. H. Love, *Phil. Trans. R. Soc. A* **228** (1929) 377, <https://doi.org/10.1098/rsta.1929.0009>.
    /// H. M. Stanley and T. Kato, *J. Tribology* **119** (1997) 481, <https://doi.org/10.1115/1.2833523>.
    pub fn new(grid: Grid, modulus_pa: f64, boundary: Boundary) -> Result<Self, ContactError> {
        Self::with_substrate(Substrate::HalfSpace { modulus_pa }, grid, boundary)
    }

    /// Creates a half-space like [`HalfSpace::new`], on any substrate.
    ///
    /// On the free boundary the compliance is Love's coefficients of the layer's material plus the change by the layer,
    /// with an error of 10⁻¹⁰ of the largest. On the periodic boundary the mean compliance of a layer on a rigid base
    /// is finite and replaces the given one.
    ///
    /// # Errors
    /// A modulus or thickness is not positive, a Poisson ratio is out of range, or the mean compliance is negative.
    /// With a free boundary, also a layer so much thinner than a cell that almost nothing remains of Love's
    /// coefficients and the result would be inaccurate.
    pub fn with_substrate(substrate: Substrate, grid: Grid, boundary: Boundary) -> Result<Self, ContactError> {
        substrate.validate()?;
        let (boundary, point_load) = match (boundary, &substrate) {
            (Boundary::Periodic { mean_compliance_m_per_pa: value }, _) if !(value.is_finite() && value >= 0.0) => {
                let (parameter, unit, wanted) = ("mean compliance", "m/Pa", "zero or positive");
                return Err(ContactError::Parameter { parameter, value, unit, wanted });
            }
            (Boundary::Periodic { mean_compliance_m_per_pa }, _) => {
                let own = substrate.mean_compliance_m_per_pa();
                let mean_compliance_m_per_pa = own.unwrap_or(mean_compliance_m_per_pa);
                (Boundary::Periodic { mean_compliance_m_per_pa }, None)
            }
            (Boundary::Free, Substrate::HalfSpace { .. }) => (boundary, None),
            (Boundary::Free, Substrate::Layer(layer)) => {
                (boundary, Some(PointLoad::new(layer, grid.width_m().hypot(grid.height_m()))))
            }
        };
        Self::build(substrate, point_load.as_ref(), grid, boundary)
    }

    fn build(
        substrate: Substrate,
        point_load: Option<&PointLoad>,
        grid: Grid,
        boundary: Boundary,
    ) -> Result<Self, ContactError> {
        let (nx, ny) = (grid.nx(), grid.ny());
        let longest_m = grid.width_m().max(grid.height_m());
        let padded = |length: &dyn Fn(usize) -> usize| (length(ny), length(nx));
        let (torus, stiffness_torus) = match boundary {
            // A stiffness decays as 1/r³, so a narrow margin decouples opposite edges.
            Boundary::Free => (padded(&|n| good_length(2 * n - 1)), padded(&|n| good_length(n + (n / 16).max(2)))),
            Boundary::Periodic { .. } => ((ny, nx), (ny, nx)),
        };
        let exact = Convolution::<f64>::new((ny, nx), torus);
        let (compliance, mean) = match boundary {
            Boundary::Free => {
                let compliance = love_symbol(&exact, grid, substrate.modulus_pa(), point_load)?;
                let mean = MeanMode {
                    compliance: compliance[0] * (exact.nx() * exact.ny()) as f64,
                    stiffness: substrate.stiffness_pa_per_m(std::f64::consts::PI / longest_m),
                };
                (compliance, mean)
            }
            Boundary::Periodic { mean_compliance_m_per_pa } => {
                let q = wavenumber_rad_per_m(grid, torus);
                let compliance = exact.symbol(|kx, ky| substrate.compliance_m_per_pa(q(kx, ky)));
                let stiffness = mean_stiffness_pa_per_m(grid, &substrate, mean_compliance_m_per_pa);
                (compliance, MeanMode { compliance: mean_compliance_m_per_pa, stiffness })
            }
        };
        let quick = Convolution::<f32>::new((ny, nx), torus);
        let points = (exact.nx() * exact.ny()) as f64;
        // The constant term of a periodic half-space is infinite here and replaced on use.
        let unit_m_per_pa = points * compliance.iter().filter(|c| c.is_finite()).fold(0.0_f64, |a, c| a.max(c.abs()));

        let (stiffness, unit_pa_per_m) = Stiffness::new(&substrate, grid, boundary, stiffness_torus);
        let halved = |n: usize| n.is_multiple_of(2) && n / 2 >= COARSEST;
        let coarse = if halved(nx) && halved(ny) {
            let grid = Grid::new(nx / 2, ny / 2, 2.0 * grid.dx_m(), 2.0 * grid.dy_m()).ok();
            grid.and_then(|grid| Self::build(substrate, point_load, grid, boundary).ok()).map(Box::new)
        } else {
            None
        };
        Ok(Self {
            grid,
            substrate,
            boundary,
            exact,
            compliance,
            quick,
            unit_m_per_pa,
            mean,
            stiffness,
            unit_pa_per_m,
            coarse,
        })
    }

    /// Returns the customary mean compliance of a periodic half-space, 2/(E* q_min) = max(L)/(πE*), in m/Pa: the
    /// compliance of its longest wave.
    pub fn default_mean_compliance_m_per_pa(grid: Grid, modulus_pa: f64) -> f64 {
        grid.width_m().max(grid.height_m()) / (std::f64::consts::PI * modulus_pa)
    }

    /// Returns the grid.
    pub fn grid(&self) -> Grid {
        self.grid
    }

    /// Returns the contact modulus E* in pascal of the body at the surface.
    pub fn modulus_pa(&self) -> f64 {
        self.substrate.modulus_pa()
    }

    /// Returns the elastic body under the surface.
    pub fn substrate(&self) -> Substrate {
        self.substrate
    }

    /// Returns the condition beyond the edge of the grid.
    pub fn boundary(&self) -> Boundary {
        self.boundary
    }

    /// Returns the same half-space on cells twice as wide.
    pub(super) fn coarse(&self) -> Option<&Self> {
        self.coarse.as_deref()
    }

    /// Creates scratch memory for one thread.
    pub fn workspace(&self) -> ContactWorkspace {
        ContactWorkspace::default()
    }

    /// Clears the workspace if it was used with another half-space.
    pub(super) fn prepare(&self, workspace: &mut ContactWorkspace) {
        let homogeneous = matches!(self.substrate, Substrate::HalfSpace { .. });
        let fits = Some((self.grid, self.boundary == Boundary::Free, homogeneous));
        if workspace.fits != fits {
            *workspace = ContactWorkspace { fits, ..ContactWorkspace::default() };
        }
    }

    /// Computes the displacement u = S p in metre of the pressure `pressure_pa`; both row-major with nx·ny values.
    ///
    /// # Panics
    /// If a slice does not fit the grid.
    pub fn displace(&self, pressure_pa: &[f64], displacement_m: &mut [f64], workspace: &mut ContactWorkspace) {
        self.displace_as(self.mean, pressure_pa, displacement_m, workspace);
    }

    /// Computes the displacement like [`HalfSpace::displace`], with the response `mean` to the mean pressure.
    fn displace_as(
        &self,
        mean: MeanMode,
        pressure_pa: &[f64],
        displacement_m: &mut [f64],
        workspace: &mut ContactWorkspace,
    ) {
        let columns = self.grid.nx();
        let points = self.grid.points();
        assert!(pressure_pa.len() == points && displacement_m.len() == points, "fields do not fit the grid");
        self.prepare(workspace);
        let chunk = ROWS_OF_SLAB * columns;
        let mut slabs: Vec<_> = pressure_pa.chunks(chunk).zip(displacement_m.chunks_mut(chunk)).collect();
        let fill = |(pressure_pa, _): &mut (&[f64], &mut [f64]), row: usize, out: &mut [f64]| {
            out.copy_from_slice(&pressure_pa[row % ROWS_OF_SLAB * columns..][..columns]);
            out.iter().any(|p| *p != 0.0)
        };
        let take = |(_, displacement_m): &mut (&[f64], &mut [f64]), row: usize, values: &[f64]| {
            displacement_m[row % ROWS_OF_SLAB * columns..][..columns].copy_from_slice(values);
        };
        self.displace_by(mean, &mut slabs, fill, take, &mut workspace.transforms);
    }

    /// Computes displacements with the response `mean` to the mean pressure. `fill` writes the pressures of a slab, row
    /// by row, into zeros and returns false for an empty row; `take` receives the displacements.
    pub(super) fn displace_by<S: Send>(
        &self,
        mean: MeanMode,
        slabs: &mut [S],
        fill: impl Fn(&mut S, usize, &mut [f64]) -> bool + Sync,
        take: impl Fn(&mut S, usize, &[f64]) + Sync,
        transforms: &mut Transforms,
    ) {
        let constant = self.exact.factor(mean.compliance);
        let is_large = self.grid.points() > MOST_KEPT;
        if is_large {
            *transforms = Transforms::default();
        }
        let work = transforms.exact.get_or_insert_with(|| self.exact.work());
        self.exact.forward(&self.compliance, 1.0, constant, slabs, fill, work);
        self.exact.backward(slabs, take, work);
        if is_large {
            transforms.exact = None;
        }
    }

    /// Returns the response to the mean pressure. On the periodic boundary another mean compliance in m/Pa can be
    /// given; on the free boundary it is ignored.
    pub(super) fn mean_mode(&self, mean_compliance_m_per_pa: Option<f64>) -> MeanMode {
        match (self.boundary, mean_compliance_m_per_pa) {
            (Boundary::Periodic { .. }, Some(compliance)) => {
                MeanMode { compliance, stiffness: mean_stiffness_pa_per_m(self.grid, &self.substrate, compliance) }
            }
            _ => self.mean,
        }
    }

    /// Transforms pressures over some unit, in single precision, and returns Σ p·S p over that unit squared and
    /// [`HalfSpace::compliance_unit_m_per_pa`]; see [`Convolution::forward`]. [`HalfSpace::compliance_backward`] then
    /// returns S p.
    pub(super) fn compliance_forward<S: Send>(
        &self,
        mean: MeanMode,
        slabs: &mut [S],
        fill: impl Fn(&mut S, usize, &mut [f32]) -> bool + Sync,
        transforms: &mut Transforms,
    ) -> f64 {
        let constant = self.quick.factor(mean.compliance / self.unit_m_per_pa);
        let work = transforms.quick.get_or_insert_with(|| self.quick.work());
        self.quick.forward(&self.compliance, self.unit_m_per_pa, constant, slabs, fill, work)
    }

    /// Passes the displacement to `take`, over the unit of the pressures and [`HalfSpace::compliance_unit_m_per_pa`];
    /// see [`Convolution::backward`].
    pub(super) fn compliance_backward<S: Send>(
        &self,
        slabs: &mut [S],
        take: impl Fn(&mut S, usize, &[f32]) + Sync,
        transforms: &mut Transforms,
    ) {
        let work = transforms.quick.get_or_insert_with(|| self.quick.work());
        self.quick.backward(slabs, take, work);
    }

    /// Returns the largest compliance in m/Pa.
    pub(super) fn compliance_unit_m_per_pa(&self) -> f64 {
        self.unit_m_per_pa
    }

    /// Multiplies displacements over some unit, in single precision, by E*|q|/2: the preconditioner. `take` receives
    /// the result over the unit of the displacements and [`HalfSpace::stiffness_unit_pa_per_m`].
    pub(super) fn stiffen<S: Send>(
        &self,
        mean: MeanMode,
        slabs: &mut [S],
        fill: impl Fn(&mut S, usize, &mut [f32]) -> bool + Sync,
        take: impl Fn(&mut S, usize, &[f32]) + Sync,
        transforms: &mut Transforms,
    ) {
        // A very stiff mean mode would swamp the other waves with its rounding error.
        let mean = (mean.stiffness / self.unit_pa_per_m).min(1.0);
        let work = transforms.stiffness.get_or_insert_with(|| match &self.stiffness {
            Stiffness::Pyramid(pyramid) => StiffnessWork::Pyramid(pyramid.work()),
            Stiffness::Spectral(plan, _) => StiffnessWork::Spectral(plan.work()),
        });
        match (&self.stiffness, work) {
            (Stiffness::Pyramid(pyramid), StiffnessWork::Pyramid(work)) => {
                pyramid.apply(mean, slabs, fill, take, work);
            }
            (Stiffness::Spectral(plan, symbol), StiffnessWork::Spectral(work)) => {
                plan.forward(symbol, 1.0, plan.factor(mean), slabs, fill, work);
                plan.backward(slabs, take, work);
            }
            _ => panic!("the workspace belongs to another half-space"),
        }
    }

    /// Returns about the largest stiffness in Pa/m.
    pub(super) fn stiffness_unit_pa_per_m(&self) -> f64 {
        self.unit_pa_per_m
    }
}

/// Returns the stiffness of the preconditioner against a mean displacement on the periodic boundary. A mean compliance
/// of zero has no inverse; then it is about three times the stiffness of the longest wave.
fn mean_stiffness_pa_per_m(grid: Grid, substrate: &Substrate, mean_compliance_m_per_pa: f64) -> f64 {
    if mean_compliance_m_per_pa > 0.0 {
        1.0 / mean_compliance_m_per_pa
    } else {
        let longest_m = grid.width_m().max(grid.height_m());
        10.0 / std::f64::consts::PI * substrate.stiffness_pa_per_m(std::f64::consts::TAU / longest_m)
    }
}

/// Returns |q| in rad/m of the wavenumbers kx and ky on a torus (ny, nx) of points with the grid's pitch.
fn wavenumber_rad_per_m(grid: Grid, (ny, nx): (usize, usize)) -> impl Fn(usize, f64) -> f64 {
    let step_x = std::f64::consts::TAU / (nx as f64 * grid.dx_m());
    let step_y = std::f64::consts::TAU / (ny as f64 * grid.dy_m());
    move |kx, ky| (kx as f64 * step_x).hypot(ky * step_y)
}

/// Computes the symbol of Love's influence coefficients plus the change by a layer, wrapped around the padded grid.
fn love_symbol(
    plan: &Convolution<f64>,
    grid: Grid,
    modulus_pa: f64,
    layer: Option<&PointLoad>,
) -> Result<Vec<f64>, ContactError> {
    let (rows, columns) = (plan.ny(), plan.nx());
    let (nx, ny) = (grid.nx() as f64, grid.ny() as f64);
    let added = layer.map(|layer| layer.coefficients_m_per_pa(grid));
    let coefficient = |cells_x: f64, cells_y: f64| {
        let (x_m, y_m) = (cells_x * grid.dx_m(), cells_y * grid.dy_m());
        let added = added.as_ref().map_or(0.0, |added| added[cells_y as usize * grid.nx() + cells_x as usize]);
        love_coefficient(x_m, y_m, grid.dx_m(), grid.dy_m(), modulus_pa) + added
    };
    // The cropped convolution does not read lags beyond the patch.
    let fill = |row: usize, out: &mut [f64]| {
        let cells_y = signed_index(row, rows).abs();
        for (column, value) in out.iter_mut().enumerate() {
            let cells_x = signed_index(column, columns).abs();
            *value = if cells_x < nx && cells_y < ny { coefficient(cells_x, cells_y) } else { 0.0 };
        }
    };
    let left = coefficient(0.0, 0.0) / love_coefficient(0.0, 0.0, grid.dx_m(), grid.dy_m(), modulus_pa);
    if left.is_nan() || left < LEAST_LEFT {
        let (parameter, unit) = ("compliance of a cell on the layer over that on a half-space", "(relative)");
        let wanted = "above 1e-8: the layer is too thin, or its material too incompressible, for cells of this size";
        return Err(ContactError::Parameter { parameter, value: left, unit, wanted });
    }
    Ok(plan.symbol_of_kernel(fill))
}

/// Returns the displacement at (x, y) of a unit pressure on the rectangle of sides `dx_m` × `dy_m` about the origin, in
/// m/Pa.
///
/// With a = dx/2, b = dy/2 it is Love's closed form of (1/πE*) ∬ dx'dy'/r. The logarithms are computed as differences of
/// asinh, which do not cancel at negative arguments. Farther than 100 half-sides the multipole series to fourth order
/// (relative error below 10⁻¹²) replaces the closed form, whose own cancellation grows as (r/a)².
///
/// # References
/// A. E. H. Love, *Phil. Trans. R. Soc. A* **228** (1929) 377, <https://doi.org/10.1098/rsta.1929.0009>.
pub fn love_coefficient(x_m: f64, y_m: f64, dx_m: f64, dy_m: f64, modulus_pa: f64) -> f64 {
    let (a, b) = (0.5 * dx_m, 0.5 * dy_m);
    let integral = if x_m.hypot(y_m) > 100.0 * a.max(b) {
        distant_rectangle(x_m, y_m, a, b)
    } else {
        // Difference of asinh: c·[asinh(t₁/c) − asinh(t₀/c)], which vanishes with c.
        let strip = |c: f64, t1: f64, t0: f64| {
            if c == 0.0 { 0.0 } else { c * ((t1 / c.abs()).asinh() - (t0 / c.abs()).asinh()) }
        };
        strip(x_m + a, y_m + b, y_m - b) - strip(x_m - a, y_m + b, y_m - b) + strip(y_m + b, x_m + a, x_m - a)
            - strip(y_m - b, x_m + a, x_m - a)
    };
    integral / (std::f64::consts::PI * modulus_pa)
}

/// Returns ∬ dx'dy'/r over a distant rectangle of half-sides a, b, by the Taylor series of 1/r about its centre.
fn distant_rectangle(x: f64, y: f64, a: f64, b: f64) -> f64 {
    let r2 = x * x + y * y;
    let (x2, y2) = (x * x / r2, y * y / r2);
    let (a2, b2) = (a * a / r2, b * b / r2);
    let second = (a2 * (3.0 * x2 - 1.0) + b2 * (3.0 * y2 - 1.0)) / 6.0;
    let along = |c2: f64| 105.0 * c2 * c2 - 90.0 * c2 + 9.0;
    let mixed = 105.0 * x2 * y2 - 12.0;
    let fourth = (a2 * a2 * along(x2) + b2 * b2 * along(y2)) / 120.0 + a2 * b2 * mixed / 36.0;
    4.0 * a * b / r2.sqrt() * (1.0 + second + fourth)
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_base::random;

    #[test]
    fn a_uniformly_pressed_square_has_loves_displacement() {
        // w E*/(p s): centre, corner, and the centres of neighbouring squares.
        let at = |x: f64, y: f64| love_coefficient(x, y, 1.0, 1.0, 1.0);
        for ((x, y), wanted) in [
            ((0.0, 0.0), 1.122199704678),
            ((0.5, 0.5), 0.561099852339),
            ((1.0, 0.0), 0.330421493289),
            ((1.0, 1.0), 0.230678359050),
            ((2.0, 0.0), 0.160775771645),
            ((3.0, 0.0), 0.106589684640),
            ((10.0, 0.0), 0.031844239912),
        ] {
            assert!((at(x, y) - wanted).abs() < 1e-11, "({x}, {y}): {}", at(x, y));
        }
    }

    #[test]
    fn the_mean_displacement_of_a_square_has_its_closed_form() {
        // (1/π) ∬∬ 1/r over pairs of points of the unit square, in closed form.
        let closed = 4.0 / std::f64::consts::PI * (1.0_f64.asinh() + (1.0 - 2.0_f64.sqrt()) / 3.0);
        assert!((closed - 0.946402008819).abs() < 1e-12);
        // The displacement has logarithmic edges, which the double exponential rule x = ½ tanh(½π sinh t) integrates
        // accurately.
        let step = 0.1;
        let nodes: Vec<(f64, f64)> = (-33..=33)
            .map(|k| {
                let t = step * f64::from(k);
                let inner = std::f64::consts::FRAC_PI_2 * t.sinh();
                let weight = 0.5 * step * std::f64::consts::FRAC_PI_2 * t.cosh() / inner.cosh().powi(2);
                (0.5 * inner.tanh(), weight)
            })
            .collect();
        let mut mean = 0.0;
        for (x, weight_x) in &nodes {
            for (y, weight_y) in &nodes {
                mean += weight_x * weight_y * love_coefficient(*x, *y, 1.0, 1.0, 1.0);
            }
        }
        assert!((mean - closed).abs() < 1e-12, "{mean} for {closed}");
    }

    #[test]
    fn a_rectangle_has_the_displacement_of_its_four_quarters() {
        for (dx, dy) in [(1.0, 1.0), (1.0, 64.0), (0.01, 1.0)] {
            for (x, y) in [(0.0, 0.0), (0.3, 0.1), (-1.0, 2.0), (7.0, -40.0), (3e3, 1e3)] {
                let whole = love_coefficient(x, y, dx, dy, 3.0);
                let quarter = |sx: f64, sy: f64| {
                    love_coefficient(x - 0.25 * sx * dx, y - 0.25 * sy * dy, 0.5 * dx, 0.5 * dy, 3.0)
                };
                let sum = quarter(1.0, 1.0) + quarter(1.0, -1.0) + quarter(-1.0, 1.0) + quarter(-1.0, -1.0);
                assert!((sum / whole - 1.0).abs() < 2e-10, "({x}, {y}) {dx} × {dy}: {:e}", sum / whole - 1.0);
            }
        }
    }

    #[test]
    fn the_mean_compliance_can_be_replaced_only_on_a_periodic_half_space() {
        let grid = Grid::new(8, 6, 1.0, 1.0).unwrap();
        let p = random::standard_normal(&mut random::stream(1, "mean mode", 0), grid.points());
        let mean_p = p.iter().sum::<f64>() / p.len() as f64;
        for (boundary, shift) in
            [(Boundary::Periodic { mean_compliance_m_per_pa: 2.0 }, (5.0 - 2.0) * mean_p), (Boundary::Free, 0.0)]
        {
            let half_space = HalfSpace::new(grid, 3.0, boundary).unwrap();
            let (mut own, mut other) = (vec![0.0; p.len()], vec![0.0; p.len()]);
            let mut workspace = half_space.workspace();
            half_space.displace(&p, &mut own, &mut workspace);
            half_space.displace_as(half_space.mean_mode(Some(5.0)), &p, &mut other, &mut workspace);
            assert!(own.iter().zip(&other).all(|(a, b)| (b - a - shift).abs() < 1e-13));
        }
    }

    #[test]
    fn the_preconditioner_inverts_the_compliance_of_a_periodic_half_space() {
        let grid = Grid::new(9, 12, 0.5, 0.25).unwrap();
        let boundary = Boundary::Periodic { mean_compliance_m_per_pa: 0.7 };
        let half_space = HalfSpace::new(grid, 3.0, boundary).unwrap();
        let p = random::standard_normal(&mut random::stream(1, "stiffness", 0), grid.points());
        let (mut u, mut workspace) = (vec![0.0; p.len()], half_space.workspace());
        half_space.displace(&p, &mut u, &mut workspace);
        let mut back = vec![0.0; p.len()];
        let fill = |_: &mut &mut [f64], row: usize, out: &mut [f32]| {
            out.iter_mut().zip(&u[9 * row..]).for_each(|(out, u)| *out = *u as f32);
            true
        };
        let unit = half_space.stiffness_unit_pa_per_m();
        let take = |out: &mut &mut [f64], row: usize, values: &[f32]| {
            out[9 * row..].iter_mut().zip(values).for_each(|(out, value)| *out = unit * f64::from(*value));
        };
        let mut slabs = [back.as_mut_slice()];
        half_space.stiffen(half_space.mean_mode(None), &mut slabs, fill, take, &mut workspace.transforms);
        assert!(p.iter().zip(&back).all(|(a, b)| (a - b).abs() < 1e-5));
    }

    #[test]
    fn single_precision_displacements_of_a_step_are_accurate() {
        let (nx, ny) = (37, 40);
        let grid = Grid::new(nx, ny, 1e-6, 0.7e-6).unwrap();
        let periodic = Boundary::Periodic { mean_compliance_m_per_pa: 3e-17 };
        for boundary in [Boundary::Free, periodic] {
            let half_space = HalfSpace::new(grid, 2e11, boundary).unwrap();
            let mut workspace = half_space.workspace();
            // Pressure on every third cell of most rows.
            let mut p = random::standard_normal(&mut random::stream(1, "step", 0), grid.points());
            p.iter_mut().enumerate().filter(|(i, _)| i % 3 != 0 || i / nx % 5 >= 3).for_each(|(_, p)| *p = 0.0);
            let mut wanted = vec![0.0; p.len()];
            half_space.displace(&p, &mut wanted, &mut workspace);
            let largest = wanted.iter().fold(0.0, |a: f64, b| a.max(b.abs()));

            let fill = |_: &mut &mut [f64], row: usize, out: &mut [f32]| {
                out.iter_mut().zip(&p[row * nx..]).for_each(|(out, p)| *out = *p as f32);
                row % 5 < 3
            };
            let (unit_m, mean) = (half_space.compliance_unit_m_per_pa(), half_space.mean_mode(None));
            let mut found = vec![0.0; p.len()];
            let mut slabs: Vec<_> = found.chunks_mut(ROWS_OF_SLAB * nx).collect();
            let transforms = &mut workspace.transforms;
            let energy = unit_m * half_space.compliance_forward(mean, &mut slabs, fill, transforms);
            let work: f64 = p.iter().zip(&wanted).map(|(p, u)| p * u).sum();
            assert!((energy / work - 1.0).abs() < 1e-5, "{energy:e} {work:e}");
            let take = |slab: &mut &mut [f64], row: usize, values: &[f32]| {
                let out = &mut slab[row % ROWS_OF_SLAB * nx..][..nx];
                out.iter_mut().zip(values).for_each(|(out, value)| *out = unit_m * f64::from(*value));
            };
            half_space.compliance_backward(&mut slabs, take, transforms);
            let error = found.iter().zip(&wanted).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(error < 1e-6 * largest, "{error:e} of {largest:e}");
        }
    }

    #[test]
    fn near_and_far_forms_agree_where_they_meet() {
        for (dx, dy) in [(1.0, 1.0), (1.0, 0.3), (0.2, 1.0)] {
            let a: f64 = 0.5 * f64::max(dx, dy);
            for angle in [0.0, 0.3, 0.8, 1.2, std::f64::consts::FRAC_PI_2] {
                let (sin, cos) = f64::sin_cos(angle);
                let r = 99.9 * a;
                let near = love_coefficient(r * cos, r * sin, dx, dy, 1.0) * std::f64::consts::PI;
                let far = distant_rectangle(r * cos, r * sin, 0.5 * dx, 0.5 * dy);
                assert!((near / far - 1.0).abs() < 2e-11, "{}", near / far - 1.0);
            }
        }
    }

    #[test]
    fn the_free_operator_is_the_dense_sum_of_love_coefficients() {
        let grid = Grid::new(9, 7, 1.0, 0.7).unwrap();
        let half_space = HalfSpace::new(grid, 2.0, Boundary::Free).unwrap();
        let p = random::standard_normal(&mut random::stream(1, "half-space", 0), grid.points());
        let mut u = vec![0.0; grid.points()];
        half_space.displace(&p, &mut u, &mut half_space.workspace());
        for i in 0..grid.points() {
            let mut wanted = 0.0;
            for j in 0..grid.points() {
                let x = ((i % 9) as f64 - (j % 9) as f64) * grid.dx_m();
                let y = ((i / 9) as f64 - (j / 9) as f64) * grid.dy_m();
                wanted += love_coefficient(x.abs(), y.abs(), grid.dx_m(), grid.dy_m(), 2.0) * p[j];
            }
            assert!((u[i] - wanted).abs() < 1e-13);
        }
    }

    #[test]
    fn a_pressure_wave_displaces_the_periodic_surface_by_2_over_modulus_and_wavenumber() {
        let grid = Grid::new(12, 10, 0.5, 0.25).unwrap();
        let compliance = 0.3;
        let boundary = Boundary::Periodic { mean_compliance_m_per_pa: compliance };
        let half_space = HalfSpace::new(grid, 3.0, boundary).unwrap();
        let (qx, qy) = (2.0 * std::f64::consts::TAU / grid.width_m(), -3.0 * std::f64::consts::TAU / grid.height_m());
        let wave = |i: usize| (qx * (i % 12) as f64 * 0.5 + qy * (i / 12) as f64 * 0.25 + 0.4).cos();
        let p: Vec<f64> = (0..grid.points()).map(|i| 2.0 + wave(i)).collect();
        let mut u = vec![0.0; grid.points()];
        half_space.displace(&p, &mut u, &mut half_space.workspace());
        for i in 0..grid.points() {
            let wanted = 2.0 * compliance + 2.0 / (3.0 * f64::hypot(qx, qy)) * wave(i);
            assert!((u[i] - wanted).abs() < 1e-13);
        }
    }
}
