//! Warning about a record whose mean drifts.

use asperity_base::correlation::Stationarity;

/// Level of each of the two tests for drift.
const LEVEL: f64 = 0.01;

/// Returns a warning if the mean of a record changes along it: by a trend, or by a wandering level. NaN is a missing value, and `std`
/// the standard deviation of the values. Records that are too short for the tests have no warning.
pub(super) fn warning(values: &[f64], step_m: f64, std: f64) -> Option<String> {
    let found = Stationarity::new(&[values], 1, step_m).ok()?;
    let change = found.trend.estimate * step_m * values.len() as f64 / std;
    let (what, p_value) = match found.wander {
        _ if found.trend.p_value < LEVEL => {
            (format!("drifts by {change:+.2} standard deviations"), found.trend.p_value)
        }
        Some(wander) if wander.p_value < LEVEL => ("wanders".into(), wander.p_value),
        _ => return None,
    };
    Some(format!(
        "the mean of the record {what} along it (p = {p_value:.1e}): mean, standard deviation and correlation include this change, and their \
         intervals may miss the values of a steady record; cut the running-in, or remove the trend"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use asperity_base::random::stream;
    use asperity_testing::autoregressive;

    /// Returns how many of 40 records of 400 correlation lengths have a warning if their mean changes by that many standard deviations.
    fn warned(change: impl Fn(f64) -> f64) -> usize {
        let record = |index: u64| -> Vec<f64> {
            let steady = autoregressive((-0.1_f64).exp(), 4000, &mut stream(61, "drift", index));
            steady.iter().enumerate().map(|(i, value)| value + change(i as f64 / 4000.0)).collect()
        };
        (0..40).filter(|index| warning(&record(*index), 1e-6, 1.0).is_some()).count()
    }

    #[test]
    fn drifting_records_have_a_warning_and_steady_ones_have_none() {
        // At most 2 % of steady records are expected to have a warning. A running-in that ends after a third of the record has a smaller trend.
        let found = [warned(|_| 0.0), warned(|x| 1.5 * x), warned(|x| 2.0 * (-9.0 * x).exp())];
        assert!(found[0] <= 3 && found[1] >= 36 && found[2] >= 10, "{found:?} of 40");
    }

    #[test]
    fn the_warning_states_the_size_of_the_drift() {
        let mut values = autoregressive(0.9, 4000, &mut stream(62, "drift", 0));
        values.iter_mut().enumerate().for_each(|(i, value)| *value -= 3.0 * i as f64 / 4000.0);
        values[100] = f64::NAN;
        let found = warning(&values, 1e-6, 1.0).unwrap();
        let change: f64 = found.split("drifts by ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
        // The slope of 200 correlation lengths has a standard error of √(12·2/200) = .35 over the record.
        assert!((change + 3.0).abs() < 1.0, "{found}");
        assert_eq!(warning(&values[..50], 1e-6, 1.0), None);
    }
}
