//! Roots, minima, linear systems, quadrature and isotonic regression.

mod curve;
mod dense;
mod isotonic;
mod least_squares;
mod linear;
mod minimum;
mod quadrature;
mod root;

pub use curve::{Line, cubic};
pub use dense::{
    Cholesky, NotConverged, Qr, SymmetricEigen, dense_solution, solve_upper, symmetric_eigen, triangular_condition,
};
pub use isotonic::isotonic;
pub use least_squares::{Range, least_squares};
pub use linear::{dot, inverse, solution, solve, solve_positive_definite};
pub use minimum::{GoldenSection, golden_section, scanned_minimum, simplex};
pub use quadrature::gauss_legendre;
pub use root::{bisect, newton_between, root_between, try_root_between};
