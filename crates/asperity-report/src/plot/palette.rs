//! Colours that remain distinct to colour-blind readers and in grey prints.

use crate::plot::canvas::{Colour, Dash, Pen, WHITE};

pub(crate) const BLUE: Colour = Colour(0, 114, 178);
pub(crate) const VERMILION: Colour = Colour(213, 94, 0);
pub(crate) const GREEN: Colour = Colour(0, 130, 95);
pub(crate) const PURPLE: Colour = Colour(170, 68, 140);
pub(crate) const SKY: Colour = Colour(86, 180, 233);
pub(crate) const ORANGE: Colour = Colour(230, 159, 0);
pub(crate) const PLUM: Colour = Colour(84, 24, 110);
pub(crate) const OLIVE: Colour = Colour(128, 128, 0);
pub(crate) const GREY: Colour = Colour(150, 150, 150);
pub(crate) const BLACK: Colour = Colour(20, 20, 20);

/// Returns the pen of curve number `index`; nine curves differ in colour and in dash (colours after Okabe & Ito).
pub(crate) fn pen(index: usize) -> Pen {
    const PENS: [(Colour, Dash); 9] = [
        (BLUE, Dash::Solid),
        (VERMILION, Dash::Dashed),
        (GREEN, Dash::Alternating),
        (PURPLE, Dash::Dotted),
        (ORANGE, Dash::Long),
        (SKY, Dash::Short),
        (BLACK, Dash::DoubleDotted),
        (OLIVE, Dash::LongShort),
        (PLUM, Dash::Sparse),
    ];
    let (colour, dash) = PENS[index % PENS.len()];
    Pen::new(colour, 1.8, dash)
}

/// Mixes a fraction of a colour with white, for areas under lines.
pub(crate) fn pale(colour: Colour, fraction: f64) -> Colour {
    let lighter = |c: u8| (fraction * f64::from(c) + (1.0 - fraction) * 255.0).round() as u8;
    Colour(lighter(colour.0), lighter(colour.1), lighter(colour.2))
}

/// Colour of missing heights. The scale below has the opposite hue at its lightness.
pub(crate) const MISSING: Colour = VERMILION;
/// Colour of pressures at the hardness.
pub(crate) const HARDNESS: Colour = VERMILION;
/// Colour of points without contact.
pub(crate) const NO_CONTACT: Colour = WHITE;

/// Returns the colour at `t` in [0, 1] of a sequential scale: violet, blue, green, yellow.
///
/// The scale is a path in Oklab (B. Ottosson, 2020) with linear lightness and linear hue at nearly constant chroma, so that equal
/// steps of the value look equal and grey prints keep the order. Chroma is reduced to stay within sRGB.
pub(crate) fn colour_scale(t: f64) -> Colour {
    let t = t.clamp(0.0, 1.0);
    let (lightness, hue) = (0.27 + 0.64 * t, (305.0 - 200.0 * t).to_radians());
    let mut chroma = 0.105 + 0.06 * t * t;
    let mut rgb = oklab_to_linear_rgb(lightness, chroma * hue.cos(), chroma * hue.sin());
    while rgb.iter().any(|c| !(0.0..=1.0).contains(c)) && chroma > 0.0 {
        chroma -= 0.001;
        rgb = oklab_to_linear_rgb(lightness, chroma * hue.cos(), chroma * hue.sin());
    }
    let [r, g, b] = rgb.map(|c| {
        let c = c.clamp(0.0, 1.0);
        let encoded = if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
        (255.0 * encoded).round() as u8
    });
    Colour(r, g, b)
}

/// Converts Oklab to linear sRGB.
fn oklab_to_linear_rgb(lightness: f64, a: f64, b: f64) -> [f64; 3] {
    let l = (lightness + 0.396_337_777_4 * a + 0.215_803_757_3 * b).powi(3);
    let m = (lightness - 0.105_561_345_8 * a - 0.063_854_172_8 * b).powi(3);
    let s = (lightness - 0.089_484_177_5 * a - 1.291_485_548_0 * b).powi(3);
    [
        4.076_741_662_1 * l - 3.307_711_591_3 * m + 0.230_969_929_2 * s,
        -1.268_438_004_6 * l + 2.609_757_401_1 * m - 0.341_319_396_5 * s,
        -0.004_196_086_3 * l - 0.703_418_614_7 * m + 1.707_614_701_0 * s,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// CIE lightness L* of an sRGB colour.
    fn cie_lightness(colour: Colour) -> f64 {
        let linear = |c: u8| {
            let c = f64::from(c) / 255.0;
            if c <= 0.040_45 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
        };
        let y = 0.2126 * linear(colour.0) + 0.7152 * linear(colour.1) + 0.0722 * linear(colour.2);
        if y > 0.008_856 { 116.0 * y.cbrt() - 16.0 } else { 903.3 * y }
    }

    #[test]
    fn the_lightness_of_the_colour_scale_increases_evenly() {
        let lightness: Vec<f64> = (0..=20).map(|i| cie_lightness(colour_scale(f64::from(i) / 20.0))).collect();
        let mean = (lightness[20] - lightness[0]) / 20.0;
        assert!(mean > 3.0, "the scale spans {:.0} of 100 units of lightness", 20.0 * mean);
        for pair in lightness.windows(2) {
            // Oklab's lightness differs from CIE's; steps within a factor of two are all visible and none dominates.
            let step = pair[1] - pair[0];
            assert!(step > 0.5 * mean && step < 2.0 * mean, "step {step:.2} against the mean {mean:.2}");
        }
    }

    #[test]
    fn nine_pens_differ_in_dash_as_well_as_colour() {
        let differ = |one: Pen, other: Pen| one.colour != other.colour && one.dash != other.dash;
        assert!((0..9).all(|index| (0..index).all(|other| differ(pen(index), pen(other)))));
    }
}
