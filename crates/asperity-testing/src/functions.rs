//! Published test functions of polynomial expansions, over standard variables.

use std::f64::consts::PI;

/// Function of independent variables with known statistics.
#[derive(Debug)]
pub struct TestFunction {
    /// Name and reference.
    pub name: &'static str,
    /// Number of standard normal variables, which come first. The others are uniform on [−1, 1].
    pub normal: usize,
    /// The function.
    pub evaluate: fn(&[f64]) -> f64,
    /// Mean.
    pub mean: f64,
    /// Variance.
    pub variance: f64,
    /// Sobol' indices of first order.
    pub first: &'static [f64],
    /// Total Sobol' indices.
    pub total: &'static [f64],
}

/// Ishigami's function with (a, b) = (7, 0.1). Its statistics are closed forms.
pub const ISHIGAMI: TestFunction = TestFunction {
    name: "Ishigami & Homma, ISUMA (1990) 398",
    normal: 0,
    evaluate: ishigami,
    mean: 3.5,
    variance: 13.844_587_940_719_254,
    first: &[0.313_905_19, 0.442_411_14, 0.0],
    total: &[0.557_588_86, 0.442_411_14, 0.243_683_66],
};

/// Flow through a borehole. Its statistics are reference values to the digits given, by quadrature with other programs.
pub const BOREHOLE: TestFunction = TestFunction {
    name: "Harper & Gupta, ONWI-516 (1983)",
    normal: 2,
    evaluate: borehole,
    mean: 73.7389,
    variance: 817.69,
    first: &[0.6637, 0.0, 0.0, 0.0949, 1e-5, 0.0949, 0.0907, 0.0219],
    total: &[0.6942, 0.0, 0.0, 0.1061, 1e-5, 0.1062, 0.1028, 0.0251],
};

/// Parameters a of [`SOBOL_G`]. The four further variables of the publication, of a = 99, hold 3e-4 of the variance.
pub const SOBOL_G_PARAMETERS: [f64; 4] = [0.0, 1.0, 4.5, 9.0];

/// Sobol' g function of the variables of [`SOBOL_G_PARAMETERS`]. Its statistics are closed forms: a variable contributes w = 1/(3(1 + a)²).
pub const SOBOL_G: TestFunction = TestFunction {
    name: "Saltelli & Sobol', Reliab. Eng. Syst. Saf. 50 (1995) 225",
    normal: 0,
    evaluate: sobol_g,
    mean: 1.0,
    variance: 0.465_229_058_259_361,
    first: &[0.716_492_934_9, 0.179_123_233_7, 0.023_685_716_9, 0.007_164_929_3],
    total: &[0.787_369_701_1, 0.242_267_600_4, 0.034_326_744_5, 0.010_463_384_7],
};

fn ishigami(x: &[f64]) -> f64 {
    let (first, second, third) = ((PI * x[0]).sin(), (PI * x[1]).sin(), PI * x[2]);
    first + 7.0 * second * second + 0.1 * third.powi(4) * first
}

fn borehole(x: &[f64]) -> f64 {
    let between = |low: f64, high: f64, x: f64| 0.5 * (low + high) + 0.5 * (high - low) * x;
    let well_m = 0.10 + 0.016_181_2 * x[0];
    let log_ratio = (7.71 + 1.0056 * x[1]) - well_m.ln();
    let upper = between(63_070.0, 115_600.0, x[2]);
    let head_m = between(990.0, 1110.0, x[3]) - between(700.0, 820.0, x[5]);
    let lower = between(63.1, 116.0, x[4]);
    let (length_m, conductivity) = (between(1120.0, 1680.0, x[6]), between(9855.0, 12_045.0, x[7]));
    let leak = 2.0 * length_m * upper / (log_ratio * well_m * well_m * conductivity);
    2.0 * PI * upper * head_m / (log_ratio * (1.0 + leak + upper / lower))
}

fn sobol_g(x: &[f64]) -> f64 {
    x.iter().zip(SOBOL_G_PARAMETERS).map(|(x, a)| ((2.0 * x).abs() + a) / (1.0 + a)).product()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_statistics_of_the_g_function_are_its_closed_forms() {
        let parts = SOBOL_G_PARAMETERS.map(|a| (1.0 + a).powi(-2) / 3.0);
        let variance = parts.iter().map(|part| 1.0 + part).product::<f64>() - 1.0;
        assert!((SOBOL_G.variance / variance - 1.0).abs() < 1e-12, "{variance}");
        for (place, part) in parts.iter().enumerate() {
            let others: f64 =
                parts.iter().enumerate().filter(|(at, _)| *at != place).map(|(_, other)| 1.0 + other).product();
            assert!((SOBOL_G.first[place] - part / variance).abs() < 1e-9, "{}", part / variance);
            assert!((SOBOL_G.total[place] - part * others / variance).abs() < 1e-9, "{}", part * others / variance);
        }
    }
}
