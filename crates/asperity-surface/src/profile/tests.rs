use std::f64::consts::{FRAC_1_SQRT_2, PI, TAU};

use super::*;
use crate::{RandomSurface, SpectralField};
use asperity_base::correlation::{CorrelationModel, Covariance};
use asperity_base::random;

/// Returns the height of a wave of amplitude 2 µm and length 50 µm at a place of a profile.
fn sine(place: usize) -> f64 {
    2e-6 * (TAU * place as f64 / 100.0 + 0.3).sin()
}

fn of(heights_m: &[f64], preparation: &Preparation) -> ProfileStatistics {
    let prepared = Profile::new(heights_m, 5e-7).unwrap().prepare(preparation).unwrap();
    ProfileStatistics::new(prepared).unwrap()
}

fn assert_near(found: f64, wanted: f64, tolerance: f64) {
    assert!((found / wanted - 1.0).abs() < tolerance, "{found:e}, not {wanted:e}");
}

#[test]
fn the_parameters_of_a_sine_are_known() {
    let heights_m: Vec<f64> = (0..8000).map(sine).collect();
    let mean = Preparation { level: Level::Mean, ..Preparation::default() };
    let found = of(&heights_m, &mean);
    assert_near(found.ra_m, 2.0 / PI * 2e-6, 1e-3);
    assert_near(found.rq_m, FRAC_1_SQRT_2 * 2e-6, 1e-9);
    assert!(found.rsk.abs() < 1e-9);
    assert_near(found.rku, 1.5, 1e-9);
    let FeatureParameters { rp_m, rv_m, rz_m, rt_m, rsm_m, sections, .. } = found.features;
    for (found, wanted) in [(rp_m, 2e-6), (rv_m, 2e-6), (rz_m, 4e-6), (rt_m, 4e-6), (rsm_m.unwrap(), 5e-5)] {
        assert_near(found, wanted, 5e-4);
    }
    assert_eq!(sections, 1);
    // The profile has whole waves, its differences a few points less; a forward difference shortens slopes by sinc(π/100).
    let slope = FRAC_1_SQRT_2 * TAU * 2e-6 / 5e-5;
    assert_near(found.rdq_7point.unwrap(), slope, 1e-3);
    assert_near(found.rdq.unwrap(), slope * (PI / 100.0).sin() / (PI / 100.0), 1e-3);
    // cos(2πx/λ) = 1/e, linear between points.
    assert_near(found.correlation_length_m.unwrap(), (-1.0_f64).exp().acos() / TAU * 5e-5, 2e-3);
    // Parseval: the density over both signs of q is the variance.
    let spectrum = &found.spectrum;
    let power: f64 = spectrum.psd_m3[1..].iter().sum::<f64>() * 2.0 * spectrum.q_rad_per_m[1] / TAU;
    assert_near(power, 2e-12, 1e-9);
}

#[test]
fn parameters_are_those_of_a_table_by_hand() {
    // Two sections of four points; heights about the mean 1 are −1, 1, 0, 2 and −3, 3, 0, −2.
    let heights_m = [0.0, 2.0, 1.0, 3.0, -2.0, 4.0, 1.0, -1.0].map(|z| z * 1e-6);
    let profile = Profile::new(&heights_m, 1e-6).unwrap();
    let found = FeatureParameters::new(&profile, Some(4e-6));
    assert_eq!(found.sections, 2);
    for (found, wanted) in [(found.rp_m, 2.5), (found.rv_m, 2.0), (found.rz_m, 4.5), (found.rt_m, 6.0)] {
        assert_near(found, wanted * 1e-6, 1e-12);
    }
    let (interval, error) = found.rz_interval().unwrap();
    // 3 and 6: standard error 1.5, Student's 12.706 for one degree of freedom.
    assert_near(error, 1.5e-6, 1e-9);
    assert_near(interval.high, (4.5 + 12.706_204_7 * 1.5) * 1e-6, 1e-6);
    assert_eq!(interval.low, 0.0);
}

#[test]
fn elements_begin_with_the_first_point() {
    // Crossings at 0.6, 3.5 and 6.4 µm.
    let heights_m = [-3.0, 2.0, 3.0, 2.0, -2.0, -3.0, -2.0, 3.0].map(|z| z * 1e-9);
    for mirrored in [false, true] {
        let mut heights_m = heights_m;
        if mirrored {
            heights_m.reverse();
        }
        let found = FeatureParameters::new(&Profile::new(&heights_m, 1e-6).unwrap(), None);
        assert_near(found.rsm_m.unwrap(), 5.8e-6, 1e-9);
    }
}

#[test]
fn another_program_has_the_same_parameters() {
    // surfalize 0.19.2, `Profile` of heights in µm at 0.5 µm, five sections.
    let height = |place: usize| {
        let i = place as f64;
        (0.05 * i).sin() + 0.3 * (0.37 * i + 1.0).sin() + 0.1 * (2.1 * i).sin() + 0.4 * (0.011 * i).sin().powi(3)
    };
    let heights_m: Vec<f64> = (0..4000).map(|place| 1e-6 * height(place)).collect();
    let found = of(&heights_m, &Preparation { level: Level::Mean, ..Preparation::default() });
    let sections = FeatureParameters::new(&found.prepared.profile, Some(4e-4));
    assert_eq!(sections.sections, 5);
    for (found, wanted) in [
        (found.ra_m, 0.671_094_760_286_610_4e-6),
        (found.rq_m, 0.775_335_907_786_285_7e-6),
        (found.rsk, -0.005_417_608_733_086_956),
        (found.rku, 1.945_300_936_157_22),
        (sections.rp_m, 1.668_062_792_182_696_5e-6),
        (sections.rv_m, 1.727_294_075_933_313e-6),
        (sections.rz_m, 3.395_356_868_116_01e-6),
        (sections.rt_m, 3.522_729_128_673_805e-6),
        (found.rdq.unwrap(), 0.299_273_843_754_713_6),
    ] {
        assert_near(found, wanted, 1e-9);
    }
}

#[test]
fn small_hills_and_dales_belong_to_their_neighbours() {
    // Waves of 400 points; a ripple of 7 % of their height crosses the mean line many times beside each of their crossings.
    let wave = |place: usize| (TAU * (place as f64 + 0.5) / 400.0).sin();
    let with_ripple = |height: f64| {
        let ripple = |place: usize| if wave(place).abs() < 0.2 { height * (PI * place as f64).cos() } else { 0.0 };
        let heights_m: Vec<f64> = (0..4000).map(|place| 1e-6 * (wave(place) + ripple(place))).collect();
        FeatureParameters::new(&Profile::new(&heights_m, 1e-6).unwrap(), None).rsm_m.unwrap()
    };
    assert_near(with_ripple(0.07), 4e-4, 5e-3);
    // Higher ones are elements of their own.
    assert!(with_ripple(0.25) < 1e-4);
}

#[test]
fn filters_transmit_waves_as_iso_16610_21_states() {
    // Waves of 50 µm and 1 mm over 8 mm, on a slope; the L-filter at 250 µm transmits 1 − 2^{−(250/λ)²} of each.
    let long = |place: usize| 5e-6 * (TAU * place as f64 / 2000.0).sin();
    let heights_m: Vec<f64> = (0..16_000).map(|k| sine(k) + long(k) + 1e-3 * 5e-7 * k as f64).collect();
    let profile = Profile::new(&heights_m, 5e-7).unwrap();
    let rough = profile.prepare(&Preparation { l_filter_m: Some(2.5e-4), ..Preparation::default() }).unwrap();
    let passes = |length_m: f64| 1.0 - (-(2.5e-4 / length_m).powi(2)).exp2();
    for place in (4000..12_000).step_by(77) {
        let wanted = passes(5e-5) * sine(place) + passes(1e-3) * long(place);
        assert!((rough.profile.heights_m()[place] - wanted).abs() < 2e-8, "{place}");
    }
    assert_eq!((rough.section_m, rough.profile.pitch_m()), (Some(2.5e-4), 5e-7));
    let smooth = profile.prepare(&Preparation { s_filter_m: Some(5e-5), ..Preparation::default() }).unwrap();
    let form = 1e-3 * 5e-7;
    let heights = smooth.profile.heights_m();
    let difference = heights[8050] - heights[8000];
    let wanted = 0.5 * (sine(8050) - sine(8000)) + (-(5e-5_f64 / 1e-3).powi(2)).exp2() * (long(8050) - long(8000));
    assert!((difference - wanted).abs() < 1e-8 + 0.01 * form, "{difference:e} {wanted:e}");
}

#[test]
fn the_spectrum_of_a_profile_tells_the_covariance_of_an_isotropic_surface() {
    let grid = Grid::new(4096, 64, 1e-6, 1e-6).unwrap();
    for (model, tolerance) in [
        (CorrelationModel::SquaredExponential, 0.1),
        (CorrelationModel::Exponential, 0.2),
        (CorrelationModel::SelfAffine { hurst: 0.8 }, 0.3),
    ] {
        let covariance = Covariance::isotropic(model, 1e-6, 2e-5).unwrap();
        let field = SpectralField::periodic(&covariance, grid);
        let (mut lengths, mut shapes) = (0.0, 0.0);
        const PROFILES: u64 = 8;
        for index in 0..PROFILES {
            let xi = random::standard_normal(&mut random::stream(3, "profile", index), field.xi_len());
            let map = field.generate(&xi);
            let prepared = Profile::new(&map.values_m()[..4096], 1e-6).unwrap().prepare(&Preparation::default());
            let statistics = ProfileStatistics::new(prepared.unwrap()).unwrap();
            let family = asperity_base::correlation::CorrelationFamily::ALL
                .iter()
                .find(|family| family.name() == model.name())
                .unwrap();
            let found = statistics.isotropic_covariance(&[*family]).unwrap().best();
            assert_eq!(found.length_x_m(), found.length_y_m());
            lengths += found.length_x_m() / 2e-5 / PROFILES as f64;
            if let CorrelationModel::SelfAffine { hurst } = found.model() {
                shapes += hurst / PROFILES as f64;
            }
        }
        assert!((lengths - 1.0).abs() < tolerance, "{model:?}: {lengths}");
        assert!(shapes == 0.0 || (shapes - 0.8).abs() < 0.1, "{shapes}");
    }
}

#[test]
#[ignore = "a minute: 400 profiles"]
fn intervals_of_profiles_cover() {
    // Profiles of 100 correlation lengths; about the line, Rq of the surface is 1 µm.
    let grid = Grid::new(2000, 16, 1e-6, 1e-6).unwrap();
    let covariance = Covariance::isotropic(CorrelationModel::SquaredExponential, 1e-6, 2e-5).unwrap();
    let field = SpectralField::periodic(&covariance, Grid::new(4000, 256, 1e-6, 1e-6).unwrap());
    let truth = [
        ("Ra_m", (2.0 / PI).sqrt() * 1e-6),
        ("Rq_m", 1e-6),
        ("Rsk", 0.0),
        ("Rku", 3.0),
        // E z'² = 2σ²/ℓ², by differences a little less.
        ("Rdq", (2.0 * (1.0 - (-(1.0_f64 / 20.0).powi(2)).exp())).sqrt()),
        ("correlation_length_m", 2e-5),
    ];
    const PROFILES: u64 = 400;
    let (mut covered, mut defined) = ([0.0; 6], [0.0; 6]);
    let mut spacings = Vec::new();
    for index in 0..PROFILES {
        let xi = random::standard_normal(&mut random::stream(4, "profile", index), field.xi_len());
        let map = field.generate(&xi);
        let line = &map.values_m()[..grid.nx()];
        let prepared = Profile::new(line, 1e-6).unwrap().prepare(&Preparation::default()).unwrap();
        let statistics = ProfileStatistics::new(prepared).unwrap();
        spacings.push((statistics.features.rsm_m.unwrap(), statistics.features.rsm_interval().unwrap().0));
        for (place, ((name, wanted), (own, estimate))) in truth.iter().zip(statistics.estimates).enumerate() {
            assert_eq!(*name, own);
            let Some(Estimate { interval, .. }) = estimate else { continue };
            defined[place] += 1.0;
            covered[place] += f64::from(u8::from((interval.low..=interval.high).contains(wanted)));
        }
    }
    assert!(defined.iter().all(|count| *count >= 0.8 * PROFILES as f64), "{defined:?}");
    let covered = [0, 1, 2, 3, 4, 5].map(|place| covered[place] / defined[place]);
    // RSm with its thresholds has no closed form: the mean of all profiles, whose error is a twentieth of that of one, stands for it.
    let mean = spacings.iter().map(|(spacing, _)| spacing).sum::<f64>() / PROFILES as f64;
    let held = spacings.iter().filter(|(_, interval)| (interval.low..=interval.high).contains(&mean)).count();
    let of_spacings = held as f64 / PROFILES as f64;
    assert!((0.91..=0.985).contains(&of_spacings), "{of_spacings}");
    // Binomial standard deviation 1.1 %.
    assert!(covered.iter().all(|fraction| (0.91..=0.985).contains(fraction)), "{covered:?}");
}
