//! Text form of distributions: `normal`, `beta:2.1,5`, `weibull:1.5,2,0.1`.

use std::fmt;
use std::str::FromStr;

use super::{DistributionError, Johnson, JohnsonSystem, Marginal};

impl FromStr for Marginal {
    type Err = DistributionError;

    /// Parses `normal[:MEAN,STD]`, `lognormal:MU,SIGMA[,SHIFT]`, `weibull:SHAPE,SCALE[,SHIFT]`,
    /// `gamma:SHAPE,SCALE[,SHIFT]`, `beta:A,B[,LOW,HIGH]`, `uniform:LOW,HIGH` (a Beta
    /// distribution), `triangular:LOW,MODE,HIGH`, `johnson:SKEWNESS,KURTOSIS[,MEAN,STD]` (kurtosis as Sku, 3 for the normal distribution) or the Johnson
    /// distributions by their parameters, `johnson_su:GAMMA,DELTA[,XI,LAMBDA]` and likewise `johnson_sb`, `johnson_sl`,
    /// `johnson_sn`. Defaults: mean 0, standard deviation 1, shift 0, Beta distribution on [0, 1], ξ = 0, λ = 1.
    fn from_str(text: &str) -> Result<Self, DistributionError> {
        let syntax = || DistributionError::Syntax { text: text.trim().into() };
        let (name, numbers) = match text.trim().split_once(':') {
            Some((name, numbers)) => (name.trim(), numbers.split(',').collect()),
            None => (text.trim(), vec![]),
        };
        let numbers: Vec<f64> =
            numbers.into_iter().map(|number| number.trim().parse().map_err(|_| syntax())).collect::<Result<_, _>>()?;
        match (name, numbers[..].as_ref()) {
            ("normal", []) => Ok(Self::STANDARD_NORMAL),
            ("normal", &[mean, std]) => Self::normal(mean, std),
            ("lognormal", &[mu, sigma]) => Self::lognormal(mu, sigma, 0.0),
            ("lognormal", &[mu, sigma, shift]) => Self::lognormal(mu, sigma, shift),
            ("weibull", &[shape, scale]) => Self::weibull(shape, scale, 0.0),
            ("weibull", &[shape, scale, shift]) => Self::weibull(shape, scale, shift),
            ("gamma", &[shape, scale]) => Self::gamma(shape, scale, 0.0),
            ("gamma", &[shape, scale, shift]) => Self::gamma(shape, scale, shift),
            ("beta", &[a, b]) => Self::beta(a, b, 0.0, 1.0),
            ("beta", &[a, b, low, high]) => Self::beta(a, b, low, high),
            ("uniform", &[low, high]) => Self::beta(1.0, 1.0, low, high),
            ("triangular", &[low, mode, high]) => Self::triangular(low, mode, high),
            ("johnson", &[skewness, kurtosis]) => Self::johnson_with_moments(0.0, 1.0, skewness, kurtosis - 3.0),
            ("johnson", &[skewness, kurtosis, mean, std]) => {
                Self::johnson_with_moments(mean, std, skewness, kurtosis - 3.0)
            }
            (name, numbers) => {
                let system = JohnsonSystem::ALL.into_iter().find(|system| system.name() == name).ok_or_else(syntax)?;
                match *numbers {
                    [gamma, delta] => Self::johnson(system, gamma, delta, 0.0, 1.0),
                    [gamma, delta, xi, lambda] => Self::johnson(system, gamma, delta, xi, lambda),
                    _ => Err(syntax()),
                }
            }
        }
    }
}

impl fmt::Display for Marginal {
    /// Formats the shortest text that parses to the same distribution; an empirical distribution has no such text and
    /// shows its size.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Normal { mean: 0.0, std: 1.0 } => f.write_str("normal"),
            Self::Normal { mean, std } => write!(f, "normal:{mean},{std}"),
            Self::Lognormal { mu, sigma, shift: 0.0 } => write!(f, "lognormal:{mu},{sigma}"),
            Self::Lognormal { mu, sigma, shift } => write!(f, "lognormal:{mu},{sigma},{shift}"),
            Self::Weibull { shape, scale, shift: 0.0 } => write!(f, "weibull:{shape},{scale}"),
            Self::Weibull { shape, scale, shift } => write!(f, "weibull:{shape},{scale},{shift}"),
            Self::Gamma { shape, scale, shift: 0.0 } => write!(f, "gamma:{shape},{scale}"),
            Self::Gamma { shape, scale, shift } => write!(f, "gamma:{shape},{scale},{shift}"),
            Self::Beta { a, b, low: 0.0, high: 1.0 } => write!(f, "beta:{a},{b}"),
            Self::Beta { a, b, low, high } => write!(f, "beta:{a},{b},{low},{high}"),
            Self::Triangular { low, mode, high } => write!(f, "triangular:{low},{mode},{high}"),
            Self::Johnson(Johnson { system, gamma, delta, xi: 0.0, lambda: 1.0 }) => {
                write!(f, "{}:{gamma},{delta}", system.name())
            }
            Self::Johnson(Johnson { system, gamma, delta, xi, lambda }) => {
                write!(f, "{}:{gamma},{delta},{xi},{lambda}", system.name())
            }
            Self::Empirical { ref sorted } => write!(f, "empirical distribution of {} values", sorted.len()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_text_of_a_distribution_parses_back() {
        for text in [
            "normal",
            "normal:-1.5,2e-7",
            "beta:2.1,5",
            "beta:2.1,5,-1,3",
            "triangular:-1,0.5,3",
            "lognormal:0.1,0.2,3",
            "weibull:1.5,2",
            "gamma:1.5,2",
            "gamma:1.5,2,-1",
            "johnson_su:0.1,2",
            "johnson_sb:-0.3,1.5,2e-7,1e-6",
            "johnson_sl:0,2,1,-3",
            "johnson_sn:1,2",
        ] {
            let marginal: Marginal = text.parse().unwrap();
            assert_eq!(marginal.to_string().parse::<Marginal>(), Ok(marginal.clone()));
            assert_eq!(marginal.to_string().split(':').next(), text.split(':').next());
        }
        assert_eq!(" beta: 2.1 , 5 ".parse(), Marginal::beta(2.1, 5.0, 0.0, 1.0));
        assert_eq!("uniform:-1,3".parse(), Marginal::beta(1.0, 1.0, -1.0, 3.0));
        assert_eq!("normal".parse(), Ok(Marginal::STANDARD_NORMAL));
        let by_moments: Marginal = "johnson:0.5,4,1,2".parse().unwrap();
        assert_eq!(by_moments.to_string().parse::<Marginal>(), Ok(by_moments));
    }

    #[test]
    fn a_wrong_word_count_or_range_is_an_error() {
        for text in [
            "",
            "gumbel:1,2",
            "gamma:1",
            "beta",
            "beta:2.1",
            "beta:2.1,5,0",
            "triangular:0,1",
            "normal:",
            "normal:1",
            "beta:2.1,x",
            "johnson",
            "johnson:1",
            "johnson:1,4,0",
            "johnson_su:1",
            "johnson_st:1,2",
        ] {
            assert!(matches!(text.parse::<Marginal>(), Err(DistributionError::Syntax { .. })), "{text}");
        }
        assert!(matches!("beta:-1,5".parse::<Marginal>(), Err(DistributionError::Parameter { parameter: "a", .. })));
        assert!(matches!(
            "normal:0,NaN".parse::<Marginal>(),
            Err(DistributionError::Parameter { parameter: "std", .. })
        ));
    }
}
