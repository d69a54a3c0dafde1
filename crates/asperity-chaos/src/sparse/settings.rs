//! Settings of a sparse regression.

use super::growing_fit::GrowingFit;
use super::search::Search;
use super::{least_angle, matching_pursuit};

/// Method that selects terms.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum SparseMethod {
    /// The term most correlated with the residual enters; then all coefficients are refitted.
    ///
    /// # References
    /// Pati, Rezaiifar & Krishnaprasad, *Proc. 27th Asilomar Conf.* (1993) 40,
    /// <https://doi.org/10.1109/ACSSC.1993.342465>.
    #[default]
    OrthogonalMatchingPursuit,
    /// Terms enter in the order of least-angle regression; their coefficients are fitted by least squares (hybrid
    /// LARS).
    ///
    /// # References
    /// Efron, Hastie, Johnstone & Tibshirani, *Ann. Statist.* **32** (2004) 407, <https://doi.org/10.1214/009053604000000067>.
    /// Blatman & Sudret, *J. Comput. Phys.* **230** (2011) 2345, <https://doi.org/10.1016/j.jcp.2010.12.021>.
    LeastAngle,
}

impl SparseMethod {
    /// Searches models of up to `limit` terms.
    pub(super) fn search<'a, 'c>(self, start: GrowingFit<'a, 'c>, limit: usize, patience: usize) -> Search<'a, 'c> {
        match self {
            Self::OrthogonalMatchingPursuit => matching_pursuit::search(start, limit, patience),
            Self::LeastAngle => least_angle::search(start, limit, patience),
        }
    }
}

/// Criterion that selects the number of terms.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SizeCriterion {
    /// The smallest corrected leave-one-out error, [`Attempt::corrected`](super::Attempt::corrected), on one path. It ignores that the left-out
    /// sample took part in the selection. For noisy responses and more candidates than samples, matching pursuit finds
    /// models of almost as many terms as samples whose leave-one-out error vanishes but which predict nothing.
    CorrectedLeaveOneOut,
    /// The smallest cross-validation error: terms are selected and fitted without each of `folds` parts of the samples
    /// and tested on that part. One more path with the selected number of terms uses all samples. The parts are a fixed
    /// random partition.
    ///
    /// # References
    /// Stone, *J. R. Stat. Soc. B* **36** (1974) 111, <https://doi.org/10.1111/j.2517-6161.1974.tb00994.x>.
    CrossValidation {
        /// Number of parts, between two and the number of samples.
        folds: usize,
    },
}

/// Settings of a sparse regression.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SparseRegression {
    /// Method that selects terms.
    pub method: SparseMethod,
    /// Criterion that selects the number of terms.
    pub size: SizeCriterion,
    /// Maximum number of terms of a model including the constant. It is also limited by the number of samples less one.
    pub max_terms: Option<usize>,
    /// Fraction of the largest number of terms after which a path without a new minimum of the corrected leave-one-out
    /// error ends (at least ten terms). With 1 the whole path is evaluated.
    pub patience: f64,
}

impl Default for SparseRegression {
    fn default() -> Self {
        let size = SizeCriterion::CrossValidation { folds: 10 };
        Self { method: SparseMethod::default(), size, max_terms: None, patience: 0.1 }
    }
}
