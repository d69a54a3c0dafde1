use super::*;
use crate::correlation::{
    CorrelationFamily, CorrelationModel, Covariance, Rotated, StationaryCovariance, fit_covariance,
};
use crate::fourier::RealFft2;
use crate::map::{Grid, HeightMap};
use crate::random;
use crate::surface::{RandomSurface, SpectralField};

fn draw(field: &SpectralField, index: u64) -> HeightMap {
    field.generate(&random::standard_normal(&mut random::stream(31, "measured", index), field.germ_len()))
}

fn estimate(map: &HeightMap) -> Autocorrelation {
    Autocorrelation::estimate(map).unwrap()
}

/// Wide ridges with a fine periodic structure across and short-range roughness: no family of the fits has this shape.
struct Mixture;

impl StationaryCovariance for Mixture {
    fn std_m(&self) -> f64 {
        2.0
    }

    fn correlation(&self, dx_m: f64, dy_m: f64) -> f64 {
        let wave = (-(dx_m / 30.0).powi(2) - (dy_m / 12.0).powi(2)).exp() * (std::f64::consts::TAU * dx_m / 16.0).cos();
        0.5 * wave + 0.5 * (-dx_m.hypot(dy_m) / 3.0).exp()
    }

    fn mirror_symmetric(&self) -> bool {
        true
    }
}

#[test]
fn look() {
    let grid = Grid::new(256, 256, 1.0, 1.0).unwrap();
    let se = Covariance::isotropic(CorrelationModel::SquaredExponential, 2.0, 6.0).unwrap();
    let ex = Covariance::isotropic(CorrelationModel::Exponential, 2.0, 6.0).unwrap();
    let sa = Covariance::isotropic(CorrelationModel::SelfAffine { hurst: 0.8 }, 2.0, 6.0).unwrap();
    let el = Covariance::new(CorrelationModel::SquaredExponential, 2.0, 16.0, 4.0).unwrap();
    let long = Covariance::new(CorrelationModel::SquaredExponential, 2.0, 200.0, 4.0).unwrap();
    let rot = Rotated::new(el, 0.6).unwrap();
    let white = Covariance::isotropic(CorrelationModel::Exponential, 2.0, 0.01).unwrap();
    let all: [(&str, &dyn StationaryCovariance); 8] = [
        ("se", &se), ("exp", &ex), ("sa", &sa), ("el", &el), ("rot", &rot), ("mix", &Mixture), ("white", &white), ("long", &long),
    ];
    for (name, covariance) in all {
        let field = SpectralField::free(covariance, grid).unwrap();
        for index in 0..2 {
            let estimate = estimate(&draw(&field, index));
            match MeasuredCovariance::new(&estimate) {
                Ok(measured) => {
                    let free = SpectralField::free(&measured, grid).unwrap();
                    println!("{name} std {:.3} {:?} free clip {:e} domain {:?}", measured.std_m(), measured.report(), free.clipped_variance(), free.germ_len());
                    for lag in [0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0] {
                        print!("  {:.4}/{:.4}", measured.correlation(lag, 0.0), covariance.correlation(lag, 0.0));
                    }
                    println!();
                }
                Err(e) => println!("{name} {e}"),
            }
        }
    }
}
