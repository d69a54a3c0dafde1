//! Laws fitted to the heights of a scan, and how much a scan says about them.

use crate::correlation::{Autocorrelation, MeasuredCovariance, MeasuredCovarianceError};
use crate::law::Marginal;
use crate::law::fit::{Family, Ranking, rank_by_aic};
use crate::stats::{Histogram, Moments, sorted_present};
use crate::study::{StudyError, Table};

/// Heights that are fitted: as many order statistics at equal distances of a larger map say the same of its law.
const MOST_FITTED: usize = 16_384;
/// Fitted laws that are drawn beside the histogram.
const DRAWN: usize = 3;

/// The number of independent heights that a map is worth, 1/β with β the mean of ρ over all pairs of its points
/// ([`MeasuredCovariance`]), at least 1 and at most the heights present.
///
/// Where the correlation swings below zero, as on filtered maps, the mean is known far better than anything else; there
/// the number of independent patches N/Σρ², which is never less than 1/β of a positive correlation, takes its place.
pub(super) fn effective_heights(correlation: &Autocorrelation) -> f64 {
    let present = correlation.present() as f64;
    let effective = match MeasuredCovariance::new(correlation) {
        Ok(covariance) => {
            let report = covariance.report();
            report.mean_share.recip().min(report.standard_error.powi(-2))
        }
        Err(MeasuredCovarianceError::FewPatches { patches, .. }) => patches,
        Err(MeasuredCovarianceError::NoPairs) => present,
    };
    effective.clamp(1.0, present)
}

/// The laws of [`Family::HEIGHTS`] that fit the heights, best first.
pub(super) struct HeightFits {
    sorted_m: Vec<f64>,
    ranking: Ranking,
}

impl HeightFits {
    pub(super) fn of(heights_m: impl Iterator<Item = f64>, effective_size: f64) -> Self {
        let sorted_m = sorted_present(heights_m);
        let stride = sorted_m.len().div_ceil(MOST_FITTED).max(1);
        let thinned: Vec<f64> = sorted_m.iter().copied().skip(stride / 2).step_by(stride).collect();
        let ranking = rank_by_aic(&Family::HEIGHTS, &thinned, Some(effective_size));
        Self { sorted_m, ranking }
    }

    /// Table `height_pdf`: the histogram with the normal law of equal moments, the best fits in columns named after their
    /// laws, and `fitted`: the law that the study states, or the best fit where it uses the measured heights.
    pub(super) fn densities(&self, marginal: &Marginal) -> Result<Table, StudyError> {
        let histogram = Histogram::of(&self.sorted_m).map_err(StudyError::Heights)?;
        let moments = Moments::of(&self.sorted_m);
        let normal = Marginal::normal(moments.mean, moments.std)?;
        let stated = (!matches!(marginal, Marginal::Empirical { .. })).then_some(marginal);
        let centres = histogram.centres();
        let density = |law: Option<&Marginal>| -> Vec<f64> {
            centres.iter().map(|z| law.map_or(f64::NAN, |law| law.pdf(*z))).collect()
        };
        let best = self.ranking.fits.first().map(|fit| &fit.law);
        let mut columns = vec![
            ("height_m".to_owned(), centres.clone()),
            ("density_per_m".to_owned(), histogram.density()),
            ("fitted_density_per_m".to_owned(), density(stated.or(best))),
            ("normal_density_per_m".to_owned(), density(Some(&normal))),
        ];
        columns.extend(stated.map(|law| ("study_density_per_m".to_owned(), density(Some(law)))));
        let drawn = self.ranking.fits.iter().take(DRAWN).filter(|fit| fit.family != Family::Normal);
        columns.extend(drawn.map(|fit| (format!("{}_density_per_m", fit.law.name()), density(Some(&fit.law)))));
        Ok(Table::new(columns))
    }

    /// Table `height_fits`: one row per law in the order of Akaike's criterion. The law of a row is the one whose parameters,
    /// in columns named after it, are not empty. None when no law could be fitted.
    pub(super) fn table(&self) -> Option<Table> {
        let Ranking { fits, goodness, effective_size, .. } = &self.ranking;
        let least = fits.first()?.aic_correlated(*effective_size);
        let delta: Vec<f64> = fits.iter().map(|fit| fit.aic_correlated(*effective_size) - least).collect();
        let weights: f64 = delta.iter().map(|delta| (-0.5 * delta).exp()).sum();
        let tails = |i: usize| goodness[i].anderson_darling.map_or(f64::NAN, |found| found.p_value);
        let rows = 0..fits.len();
        let mut columns = vec![
            ("rank".to_owned(), rows.clone().map(|i| (i + 1) as f64).collect()),
            ("free_parameters".to_owned(), fits.iter().map(|fit| fit.family.parameters() as f64).collect()),
            ("delta_aic".to_owned(), delta.clone()),
            ("akaike_weight".to_owned(), delta.iter().map(|delta| (-0.5 * delta).exp() / weights).collect()),
            ("ks_distance".to_owned(), goodness.iter().map(|found| found.kolmogorov_smirnov.statistic).collect()),
            ("ks_p_value".to_owned(), goodness.iter().map(|found| found.kolmogorov_smirnov.p_value).collect()),
            ("anderson_darling_p_value".to_owned(), rows.clone().map(tails).collect()),
            ("effective_heights".to_owned(), vec![*effective_size; fits.len()]),
        ];
        for (row, fit) in fits.iter().enumerate() {
            for (parameter, value) in fit.law.parameters() {
                let name = format!("{}_{parameter}{}", fit.law.name(), unit_suffix(parameter));
                let values = rows.clone().map(|i| if i == row { value } else { f64::NAN }).collect();
                columns.push((name, values));
            }
        }
        Some(Table::new(columns))
    }
}

/// Unit of a law's parameter as the end of a column's name.
fn unit_suffix(parameter: &str) -> &'static str {
    match parameter {
        "mean" | "std" | "shift" | "scale" | "low" | "high" | "xi" | "lambda" => "_m",
        _ => "",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{Grid, HeightMap};
    use crate::random;
    use ndarray::Array2;

    fn white(nx: usize, ny: usize) -> Vec<f64> {
        random::standard_normal(&mut random::stream(41, "height fits", 0), nx * ny)
    }

    #[test]
    fn repeated_heights_count_once() {
        // Blocks of 4 × 4 equal heights: ρ is a triangle whose integral is the block, so n_eff is the number of blocks.
        let (blocks, side) = (32, 128);
        let heights = white(blocks, blocks);
        let block = Array2::from_shape_fn((side, side), |(row, column)| heights[row / 4 * blocks + column / 4]);
        let map = HeightMap::new(Grid::new(side, side, 1.0, 1.0).unwrap(), block).unwrap();
        let found = effective_heights(&Autocorrelation::estimate(&map).unwrap());
        // The estimate of Σρ itself scatters by tens of percent.
        assert!((0.5..2.0).contains(&(found / (blocks * blocks) as f64)), "{found}");
    }

    #[test]
    fn every_row_of_the_table_has_the_parameters_of_one_law() {
        let heights: Vec<f64> = white(64, 64).iter().map(|g| 1e-6 * (0.5 * g).sinh()).collect();
        let fits = HeightFits::of(heights.into_iter(), 1000.0);
        let table = fits.table().unwrap();
        let column = |name: &str| table.column(name).unwrap();
        // sinh(g/2) is Johnson's S_U with γ = 0, δ = 2 and λ = 1 µm; δ has a standard error of about δ/√(n/2).
        assert_eq!(column("rank")[0], 1.0);
        assert!((column("johnson_su_delta")[0] - 2.0).abs() < 0.3, "{table:?}");
        assert!((column("johnson_su_lambda_m")[0] / 1e-6 - 1.0).abs() < 0.2);
        assert!(column("normal_std_m")[0].is_nan());
        assert_eq!(column("delta_aic")[0], 0.0);
        assert!(column("delta_aic").is_sorted());
        assert!((column("akaike_weight").iter().sum::<f64>() - 1.0).abs() < 1e-12);
        let densities = fits.densities(&Marginal::empirical(vec![0.0, 1.0]).unwrap()).unwrap();
        assert_eq!(densities.column("fitted_density_per_m"), densities.column("johnson_su_density_per_m"));
        assert!(densities.column("study_density_per_m").is_none());
        let stated = fits.densities(&Marginal::normal(0.0, 1e-6).unwrap()).unwrap();
        assert_eq!(stated.column("fitted_density_per_m"), stated.column("study_density_per_m"));
    }
}
