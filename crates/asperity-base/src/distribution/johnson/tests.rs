use super::super::{DistributionError, Marginal};
use super::*;

fn marginal(text: &str) -> Marginal {
    text.parse().unwrap()
}

/// Mean, standard deviation, skewness and excess kurtosis by mpmath at 40 digits: quadrature over g of x(g)ᵏ φ(g).
/// scipy.stats.johnsonsu.stats(γ, δ) agrees for S_U within its accuracy.
#[test]
fn moments_are_those_of_the_defining_integrals() {
    for (text, wanted) in [
        ("johnson_su:-1.1,1.5", [1.0001429789305496, 1.1296000464452673, 1.8415716189867606, 9.007000833090832]),
        ("johnson_su:0,2", [0.0, 0.569526676592119, 0.0, 1.5078621849296507]),
        ("johnson_su:2.5,1.2", [-5.5944950071859845, 5.734529394331465, -3.937435699573269, 37.154183373011364]),
        ("johnson_su:-3,8", [0.3868616491520599, 0.13501309676345388, 0.1363886824597786, 0.08886292602283836]),
        ("johnson_sb:0.5,0.8", [0.38240153606826344, 0.2325459489492311, 0.4411023913023028, -0.7743918587445635]),
        ("johnson_sb:0,0.3", [0.5, 0.37968795736947347, 0.0, -1.629782733559675]),
        ("johnson_sb:-2,1.5", [0.7721526859798541, 0.11172805641551363, -0.8797725287524265, 0.7291420798780182]),
        ("johnson_sb:3,0.9", [0.05611151464836819, 0.06455944075163013, 2.962448440133297, 13.06809126377328]),
        ("johnson_sb:1,0.1", [0.16254661810444515, 0.3345692812382512, 1.8305638559959223, 1.5912646010350686]),
        ("johnson_sb:5,20", [0.43786171186925044, 0.012299497659789821, 0.01859618841404562, -0.004291202184974759]),
    ] {
        let marginal = marginal(text);
        let found = [marginal.mean(), marginal.std(), marginal.skewness(), marginal.excess_kurtosis()];
        for (found, wanted) in found.into_iter().zip(wanted) {
            assert!((found - wanted).abs() < 2e-13 * (1.0 + wanted.abs()), "{text}: {found}, not {wanted}");
        }
    }
}

/// scipy 1.17.1: scipy.stats.johnsonsu and johnsonsb (γ, δ, loc = 0, scale = 1), cdf and pdf at x, ppf at 0.9; the
/// distribution functions agree with mpmath.
#[test]
fn distribution_function_density_and_quantile_are_those_of_scipy() {
    for (text, x, cdf, pdf, ninth) in [
        ("johnson_su:-1.1,1.5", 0.7, 0.45184545784551033, 0.4866636734892876, 2.344046702713573),
        ("johnson_su:2.5,1.2", -6.0, 0.31201889509752023, 0.06979502859539494, -1.1990638622010699),
        ("johnson_su:2.5,1.2", -0.5, 0.9727314424097837, 0.06745598636031062, -1.1990638622010699),
        ("johnson_sb:0.5,0.8", 0.3, 0.429424988442173, 1.4959365048228555, 0.7265005157758287),
        ("johnson_sb:-2,1.5", 0.95, 0.9921681468114083, 0.6793852495782923, 0.8991396108975244),
        ("johnson_sb:1,0.3", 0.02, 0.4334701929455357, 6.021151554635277, 0.7187976196522735),
    ] {
        let marginal = marginal(text);
        assert!((marginal.cdf(x) / cdf - 1.0).abs() < 1e-14, "{text}: {}", marginal.cdf(x));
        assert!((marginal.pdf(x) / pdf - 1.0).abs() < 1e-13, "{text}: {}", marginal.pdf(x));
        assert!((marginal.quantile(0.9) / ninth - 1.0).abs() < 1e-13, "{text}: {}", marginal.quantile(0.9));
    }
}

/// Excess of the test kurtoses over 1 + skewness².
const ABOVE: [f64; 13] = [0.01, 0.05, 0.2, 0.5, 1.0, 1.5, 1.8, 2.0, 2.2, 3.0, 6.0, 30.0, 300.0];

#[test]
fn every_shape_is_solved_to_nine_digits_in_its_region() {
    for skewness in [0.0, 1e-10, 1e-6, 1e-3, 0.1, 0.5, 1.0, 2.0, 4.0, 10.0] {
        let d = by_moments::lognormal_d(skewness);
        let on_the_line = d * (16.0 + d * (15.0 + d * (6.0 + d)));
        for above in ABOVE.into_iter().filter(|above| *above > 2e-3 * (1.0 + skewness * skewness)) {
            let excess = skewness * skewness - 2.0 + above;
            for sign in [-1.0, 1.0] {
                let marginal = Marginal::johnson_with_moments(5.0, 0.1, sign * skewness, excess).unwrap();
                let found = [marginal.mean() - 5.0, 10.0 * marginal.std() - 1.0, marginal.skewness() - sign * skewness];
                assert!(
                    found.iter().all(|error| error.abs() < 1e-9),
                    "{skewness} {excess}: {marginal} misses by {found:?}"
                );
                let error = (marginal.excess_kurtosis() - excess) / (1.0 + excess.abs());
                assert!(error.abs() < 1e-9, "{skewness} {excess}: {marginal} misses by {error:e}");
                let wanted = match excess - on_the_line {
                    _ if skewness < 1e-9 && excess.abs() < 1e-9 => "johnson_sn",
                    off if off.abs() < 1e-11 => "johnson_sl",
                    off if off < 0.0 => "johnson_sb",
                    _ => "johnson_su",
                };
                assert_eq!(marginal.name(), wanted, "{skewness} {excess}");
            }
        }
    }
}

#[test]
fn shapes_close_to_normal_and_to_lognormal_are_met() {
    for skewness in [1e-8, 1e-4, 0.02, 0.3, 1.0, 3.0] {
        let lognormal = marginal(&format!("johnson:{skewness},{}", 3.0 + 16.0 / 9.0 * skewness * skewness));
        assert!((lognormal.skewness() - skewness).abs() < 1e-9, "{lognormal}");
        let d = by_moments::lognormal_d(skewness);
        let on_the_line = d * (16.0 + d * (15.0 + d * (6.0 + d)));
        for off in [-1e-4, -1e-7, -1e-10, 0.0, 1e-10, 1e-7, 1e-4] {
            let excess = on_the_line * (1.0 + off);
            let marginal = Marginal::johnson_with_moments(0.0, 1.0, skewness, excess).unwrap();
            let errors = [
                marginal.mean(),
                marginal.std() - 1.0,
                marginal.skewness() - skewness,
                marginal.excess_kurtosis() - excess,
            ];
            assert!(
                errors.iter().all(|error| error.abs() < 1e-9 * (1.0 + excess)),
                "{skewness} {off}: {marginal} {errors:?}"
            );
        }
    }
    for excess in [-1e-3, -1e-6, -1e-8, 1e-8, 1e-6, 1e-3] {
        let marginal = Marginal::johnson_with_moments(0.0, 1.0, 0.0, excess).unwrap();
        assert!((marginal.excess_kurtosis() - excess).abs() < 1e-12 && marginal.skewness().abs() < 1e-12, "{marginal}");
        assert!((marginal.quantile(0.975) - 1.959963984540054).abs() < f64::max(1e-9, excess.abs()), "{marginal}");
    }
    assert_eq!(marginal("johnson:0,3,2,0.5").name(), "johnson_sn");
    assert_eq!(marginal("johnson:0,3,2,0.5").quantile(0.3), marginal("normal:2,0.5").quantile(0.3));
}

#[test]
fn on_the_lognormal_line_the_distribution_is_the_lognormal_one_or_its_mirror() {
    for sigma in [0.1, 0.5, 1.2] {
        let lognormal = Marginal::lognormal(0.3, sigma, -2.0).unwrap();
        let (mean, std) = (lognormal.mean(), lognormal.std());
        let (skewness, excess) = (lognormal.skewness(), lognormal.excess_kurtosis());
        let right = Marginal::johnson_with_moments(mean, std, skewness, excess).unwrap();
        let left = Marginal::johnson_with_moments(-mean, std, -skewness, excess).unwrap();
        assert_eq!((right.name(), left.name()), ("johnson_sl", "johnson_sl"));
        for p in [1e-6, 0.1, 0.5, 0.93] {
            let x = lognormal.quantile(p);
            assert!((right.quantile(p) - x).abs() < 1e-11 * (1.0 + x.abs()), "{right}");
            assert!((left.quantile(1.0 - p) + x).abs() < 1e-9, "{left}");
            assert!((right.cdf(x) - p).abs() < 1e-11 && (left.survival(-x) - p).abs() < 1e-11);
            assert!((right.pdf(x) / lognormal.pdf(x) - 1.0).abs() < 1e-10);
        }
        assert_eq!((right.cdf(-2.1), left.cdf(2.1)), (0.0, 1.0));
        assert_eq!((right.pdf(-2.1), left.pdf(2.1)), (0.0, 0.0));
        assert!((left.translate(-1.0) + right.translate(1.0)).abs() < 1e-12);
    }
}

#[test]
fn the_planted_parameters_are_found_again_from_the_moments() {
    // Each shape has exactly one distribution.
    for text in [
        "johnson_su:-1.1,1.5,3,2",
        "johnson_su:0.01,0.9,0,1",
        "johnson_su:40,9,-1,0.001",
        "johnson_sb:0.5,0.8,-1,3",
        "johnson_sb:-2,0.3,0,1",
        "johnson_sb:0.01,0.05,7,2",
        "johnson_sb:6,2.5,0,100",
    ] {
        let planted = marginal(text);
        let found = Marginal::johnson_with_moments(
            planted.mean(),
            planted.std(),
            planted.skewness(),
            planted.excess_kurtosis(),
        )
        .unwrap();
        assert_eq!(found.name(), planted.name(), "{text}");
        for p in [1e-4, 0.01, 0.3, 0.5, 0.8, 0.999] {
            let error = (found.quantile(p) - planted.quantile(p)) / planted.std();
            assert!(error.abs() < 1e-7, "{text}: {found} at {p}: {error:e}");
        }
    }
}

#[test]
fn shapes_that_no_distribution_has_are_refused_with_the_limit() {
    let error = "johnson:1.5,3.25".parse::<Marginal>().unwrap_err();
    assert!(matches!(error, DistributionError::Infeasible { least, .. } if least == 3.25), "{error}");
    assert_eq!(
        error.to_string(),
        "no marginal has a skewness of 1.5 and a kurtosis of 3.25: the kurtosis (3 for the normal marginal) must exceed 1 + \
         skewness² = 3.25"
    );
    assert!(matches!("johnson:0,1.0001".parse::<Marginal>(), Err(DistributionError::Moments { .. })));
    assert!(matches!("johnson:3,10.001".parse::<Marginal>(), Err(DistributionError::Moments { .. })));
    assert!(matches!(
        "johnson:NaN,4".parse::<Marginal>(),
        Err(DistributionError::Parameter { parameter: "skewness", .. })
    ));
    assert!(matches!(
        "johnson:0,4,0,-1".parse::<Marginal>(),
        Err(DistributionError::Parameter { parameter: "std", .. })
    ));
    assert!(matches!(
        "johnson_su:0,0".parse::<Marginal>(),
        Err(DistributionError::Parameter { parameter: "delta", .. })
    ));
    assert!(matches!(
        "johnson_sb:0,1,0,-1".parse::<Marginal>(),
        Err(DistributionError::Parameter { parameter: "lambda", .. })
    ));
    assert!(matches!(
        "johnson_sl:0,1,0,0".parse::<Marginal>(),
        Err(DistributionError::Parameter { parameter: "lambda", .. })
    ));
    assert!("johnson_sl:0,1,0,-1".parse::<Marginal>().is_ok());
}

#[test]
fn the_distribution_of_a_study_is_read_kept_and_drawn() {
    let plateau = marginal("johnson:-1.2,5.5");
    assert!((plateau.mean()).abs() < 1e-12 && (plateau.std() - 1.0).abs() < 1e-12);
    let heights = plateau.standardised(0.0, 0.4e-6).unwrap();
    assert!((heights.skewness() + 1.2).abs() < 1e-9 && (heights.excess_kurtosis() - 2.5).abs() < 1e-9);
    assert!((heights.std() / 0.4e-6 - 1.0).abs() < 1e-12);
}
