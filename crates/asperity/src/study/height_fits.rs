//! Laws fitted to the heights of a scan, and how much a scan says about them.

use crate::correlation::Autocorrelation;
use crate::distribution::Marginal;
use crate::distribution::fit::{Family, Ranking, rank_by_aic};
use crate::stats::{Histogram, Moments, sorted_present};
use crate::study::{StudyError, Table};

/// Heights that are fitted: as many order statistics at equal distances of a larger map say the same of its law.
const MOST_FITTED: usize = 16_384;
/// Least and largest correlation at which the lobe around zero may end.
const LOW: f64 = 0.02;
const HIGH: f64 = 0.2;
/// Fitted laws that are drawn beside the histogram.
const DRAWN: usize = 3;

/// The number of independent heights that a map is worth: its area over ∬ρ, at least 1 and at most the heights present.
///
/// The integral is taken over the lobe of the correlation around zero, the lags that are connected with it above twice the
/// standard error √(Σρ²/N) of a lag, or above 0.02 where that is less; beyond, an estimate is noise. Of an exponential
/// correlation, which falls slowly, a tenth is left out. Where the correlation swings below zero, as on filtered maps, the
/// lobe alone counts: the whole integral tells how well the mean is known, which is far better than anything else.
/// That the map's mean was removed, ρ̂ = (ρ − β)/(1 − β) with β = 1/n_eff, is accounted for.
pub(super) fn effective_heights(correlation: &Autocorrelation) -> f64 {
    let present = correlation.present() as f64;
    let squares = Lobe::of(correlation, HIGH).squares;
    let lobe = Lobe::of(correlation, (2.0 * (squares / present).sqrt()).clamp(LOW, HIGH));
    let (products, pairs) = (lobe.products / (present * present), lobe.pairs / (present * present));
    let share = products / (1.0 - pairs + products);
    share.recip().clamp(1.0, present)
}

/// Sums over the lags that are connected with zero above a level of the correlation.
#[derive(Debug, Clone, Copy, Default)]
struct Lobe {
    /// Pairs of points.
    pairs: f64,
    /// Correlations times pairs.
    products: f64,
    /// Squared correlations.
    squares: f64,
}

impl Lobe {
    fn of(correlation: &Autocorrelation, level: f64) -> Self {
        let (reach_x, reach_y) = correlation.reach();
        let (reach_x, reach_y) = (reach_x as isize, reach_y as isize);
        let width = 2 * reach_x + 1;
        let place = |x: isize, y: isize| ((y + reach_y) * width + x + reach_x) as usize;
        let mut seen = vec![false; (width * (2 * reach_y + 1)) as usize];
        let mut waiting = vec![(0, 0)];
        seen[place(0, 0)] = true;
        let mut sums = Self::default();
        while let Some((x, y)) = waiting.pop() {
            let (rho, pairs) = (correlation.correlation(x, y), correlation.pairs(x, y));
            sums.pairs += pairs;
            sums.products += pairs * rho;
            sums.squares += rho * rho;
            for (x, y) in [(x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)] {
                let within = x.abs() <= reach_x && y.abs() <= reach_y && !seen[place(x, y)];
                if within && correlation.correlation(x, y) > level {
                    seen[place(x, y)] = true;
                    waiting.push((x, y));
                }
            }
        }
        sums
    }
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
        let histogram = Histogram::new(&self.sorted_m).map_err(StudyError::Heights)?;
        let moments = Moments::new(&self.sorted_m);
        let normal = Marginal::normal(moments.mean, moments.std)?;
        let stated = (!matches!(marginal, Marginal::Empirical { .. })).then_some(marginal);
        let centres = histogram.centres();
        let density = |law: Option<&Marginal>| -> Vec<f64> {
            centres.iter().map(|z| law.map_or(f64::NAN, |law| law.pdf(*z))).collect()
        };
        let best = self.ranking.fits.first().map(|fit| &fit.marginal);
        let mut columns = vec![
            ("height_m".to_owned(), centres.clone()),
            ("density_per_m".to_owned(), histogram.density()),
            ("fitted_density_per_m".to_owned(), density(stated.or(best))),
            ("normal_density_per_m".to_owned(), density(Some(&normal))),
        ];
        columns.extend(stated.map(|law| ("study_density_per_m".to_owned(), density(Some(law)))));
        let drawn = self.ranking.fits.iter().take(DRAWN).filter(|fit| fit.family != Family::Normal);
        columns
            .extend(drawn.map(|fit| (format!("{}_density_per_m", fit.marginal.name()), density(Some(&fit.marginal)))));
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
            for (parameter, value) in fit.marginal.parameters() {
                let name = format!("{}_{parameter}{}", fit.marginal.name(), unit_suffix(parameter));
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
        // Σρ over 7 × 7 lags scatters by 7/√N·…, a few percent; the tail of the triangle below the level is lost.
        assert!((0.85..1.2).contains(&(found / (blocks * blocks) as f64)), "{found}");
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
