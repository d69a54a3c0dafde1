//! Laws as people write them: `normal`, `beta:2.1,5`, `weibull:1.5,2,0.1`.

use std::fmt;
use std::str::FromStr;

use super::{LawError, Marginal};

impl FromStr for Marginal {
    type Err = LawError;

    /// Reads `normal[:MEAN,STD]`, `lognormal:MU,SIGMA[,SHIFT]`, `weibull:SHAPE,SCALE[,SHIFT]` or `beta:A,B[,LOW,HIGH]`.
    /// Left out, the normal law is the standard one, the shift 0, and the Beta law lives on [0, 1].
    fn from_str(text: &str) -> Result<Self, LawError> {
        let syntax = || LawError::Syntax { text: text.trim().into() };
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
            ("beta", &[a, b]) => Self::beta(a, b, 0.0, 1.0),
            ("beta", &[a, b, low, high]) => Self::beta(a, b, low, high),
            _ => Err(syntax()),
        }
    }
}

impl fmt::Display for Marginal {
    /// The shortest text that reads back as the same law; an empirical law, which has none, shows its size.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Normal { mean: 0.0, std: 1.0 } => f.write_str("normal"),
            Self::Normal { mean, std } => write!(f, "normal:{mean},{std}"),
            Self::Lognormal { mu, sigma, shift: 0.0 } => write!(f, "lognormal:{mu},{sigma}"),
            Self::Lognormal { mu, sigma, shift } => write!(f, "lognormal:{mu},{sigma},{shift}"),
            Self::Weibull { shape, scale, shift: 0.0 } => write!(f, "weibull:{shape},{scale}"),
            Self::Weibull { shape, scale, shift } => write!(f, "weibull:{shape},{scale},{shift}"),
            Self::Beta { a, b, low: 0.0, high: 1.0 } => write!(f, "beta:{a},{b}"),
            Self::Beta { a, b, low, high } => write!(f, "beta:{a},{b},{low},{high}"),
            Self::Empirical { ref sorted } => write!(f, "empirical law of {} values", sorted.len()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn laws_read_back_what_they_show() {
        for text in
            ["normal", "normal:-1.5,2e-7", "beta:2.1,5", "beta:2.1,5,-1,3", "lognormal:0.1,0.2,3", "weibull:1.5,2"]
        {
            let law: Marginal = text.parse().unwrap();
            assert_eq!(law.to_string().parse::<Marginal>(), Ok(law.clone()));
            assert_eq!(law.to_string().split(':').next(), text.split(':').next());
        }
        assert_eq!(" beta: 2.1 , 5 ".parse(), Marginal::beta(2.1, 5.0, 0.0, 1.0));
        assert_eq!("normal".parse(), Ok(Marginal::STANDARD_NORMAL));
    }

    #[test]
    fn a_wrong_word_count_or_range_is_an_error() {
        for text in ["", "gamma:1,2", "beta", "beta:2.1", "beta:2.1,5,0", "normal:", "normal:1", "beta:2.1,x"] {
            assert!(matches!(text.parse::<Marginal>(), Err(LawError::Syntax { .. })), "{text}");
        }
        assert!(matches!("beta:-1,5".parse::<Marginal>(), Err(LawError::Parameter { parameter: "a", .. })));
        assert!(matches!("normal:0,NaN".parse::<Marginal>(), Err(LawError::Parameter { parameter: "std", .. })));
    }
}
