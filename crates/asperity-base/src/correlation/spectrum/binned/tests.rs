use super::*;
use crate::fourier::RealFft2;
use crate::map::Grid;
use crate::random;
use ndarray::Array2;

/// Maps of n × n points from periodic Gaussian maps of twice the side with the spectrum `psd_m4` on the lattice.
fn gaussian_map(n: usize, index: u64, psd_m4: &(impl Fn(f64, f64) -> f64 + Sync)) -> HeightMap {
    let side = 2 * n;
    let fft = RealFft2::new(side, side);
    let white = random::standard_normal(&mut random::stream(31, "binned spectrum", index), side * side);
    let (mut spectrum, mut work) = (fft.spectrum(), fft.workspace());
    fft.forward(&white, &mut spectrum, &mut work);
    let q_min = TAU / side as f64;
    for (place, value) in spectrum.iter_mut().enumerate() {
        let (kx, ky) = (place / side, place % side);
        *value *= psd_m4(kx as f64 * q_min, signed_index(ky, side) * q_min).sqrt();
    }
    let mut heights = vec![0.0; side * side];
    fft.inverse(&mut spectrum, &mut heights, &mut work);
    let values = Array2::from_shape_fn((n, n), |(row, column)| heights[row * side + column]);
    HeightMap::new(Grid::new(n, n, 1.0, 1.0).unwrap(), values).unwrap()
}

/// Spectrum with H = 0.5 and a roll-off at 2π/24, `stretch` times as long along y as along x.
fn self_affine(stretch: f64) -> impl Fn(f64, f64) -> f64 + Sync {
    move |qx, qy| stretch * (1.0 + (qx * qx + (stretch * qy).powi(2)) * (24.0 / TAU).powi(2)).powf(-1.5)
}

/// Returns the fraction of the bins between two wavenumbers whose band contains the true mean over `maps` maps, and the
/// number of bins.
fn coverage(
    maps: u64,
    spectrum: impl Fn(u64) -> BinnedSpectrum + Sync,
    truth: &[f64],
    (from, to): (f64, f64),
) -> (f64, f64) {
    let counts: Vec<(f64, f64)> = blocks::map(0..maps as usize, |index| {
        let found = spectrum(index as u64);
        assert_eq!(found.psd.len(), truth.len());
        let (mut inside, mut tried) = (0.0, 0.0);
        for (bin, wanted) in truth.iter().enumerate() {
            if (from..=to).contains(&found.q_rad_per_m[bin]) {
                inside += f64::from(u8::from(found.psd_low[bin] <= *wanted && *wanted <= found.psd_high[bin]));
                tried += 1.0;
            }
        }
        (inside, tried)
    });
    let (inside, tried) = counts.iter().fold((0.0, 0.0), |sum, count| (sum.0 + count.0, sum.1 + count.1));
    (inside / tried, tried)
}

/// Returns the mean of a spectrum over the wavevectors of the rings of a map of n × n points.
fn ring_means(n: usize, psd_m4: &impl Fn(f64, f64) -> f64) -> Vec<f64> {
    let edges = edges(n / 2);
    let mut sums = vec![(0.0, 0.0); edges.len() - 1];
    for kx in 0..n {
        for ky in 0..n {
            let (kx, ky) = (signed_index(kx, n), signed_index(ky, n));
            if let Some(bin) = bin_of(&edges, kx.hypot(ky)) {
                let (sum, count) = &mut sums[bin];
                *sum += psd_m4(kx * TAU / n as f64, ky * TAU / n as f64);
                *count += 1.0;
            }
        }
    }
    sums.iter().map(|(sum, count)| sum / count).collect()
}

/// Returns the mean of the spectrum of profiles along x on a lattice of pitch 1 over the wavenumbers of the bins.
fn profile_means(n: usize, psd_m4: &impl Fn(f64, f64) -> f64) -> Vec<f64> {
    let edges = edges(n / 2);
    // ∫ P dqy/2π over the zone of the lattice, exact because the maps are made of 2n of its wavenumbers.
    let along = |qx: f64| {
        (0..2 * n).map(|ky| psd_m4(qx, signed_index(ky, 2 * n) * 0.5 * TAU / n as f64)).sum::<f64>() / (2 * n) as f64
    };
    let mut sums = vec![(0.0, 0.0); edges.len() - 1];
    for k in 1..=n / 2 {
        if let Some(bin) = bin_of(&edges, k as f64) {
            let times = if 2 * k == n { 1.0 } else { 2.0 };
            sums[bin].0 += times * along(k as f64 * TAU / n as f64);
            sums[bin].1 += times;
        }
    }
    sums.iter().map(|(sum, count)| sum / count).collect()
}

/// Coverage of the three spectra of maps with spectrum `psd_m4` between two wavenumbers in steps 2π/L, given their true
/// means over rings and over profiles along x and y; and the least number of bins.
fn coverages(
    (n, maps): (usize, u64),
    psd_m4: &(impl Fn(f64, f64) -> f64 + Sync),
    truths: [Vec<f64>; 3],
    prepared: impl Fn(u64, HeightMap) -> HeightMap + Sync,
    (from, to): (f64, f64),
) -> ([f64; 3], f64) {
    let map = |index| prepared(index, gaussian_map(n, index, psd_m4));
    let step = TAU / n as f64;
    let range = (from * step, to * step);
    let area = |index| binned_radial_spectrum(&map(index)).unwrap();
    let profiles = |axis| move |index| binned_profile_spectrum(&map(index), axis).unwrap();
    let found = [
        coverage(maps, area, &truths[0], range),
        coverage(maps, profiles(Axis::X), &truths[1], range),
        coverage(maps, profiles(Axis::Y), &truths[2], range),
    ];
    (found.map(|(fraction, _)| fraction), found.iter().map(|(_, tried)| *tried).fold(f64::INFINITY, f64::min))
}

/// Returns the means of the spectrum itself.
fn true_means(n: usize, psd_m4: &impl Fn(f64, f64) -> f64) -> [Vec<f64>; 3] {
    [ring_means(n, psd_m4), profile_means(n, psd_m4), profile_means(n, &|x, y| psd_m4(y, x))]
}

/// Returns the means of a spectrum that is even in and symmetric between qx and qy, at the resolution of Parzen's lag
/// window over half of n.
fn resolved_means(n: usize, psd_m4: &impl Fn(f64, f64) -> f64) -> [Vec<f64>; 3] {
    let (side, lags) = (2 * n, (n - 1) / 2 + 1);
    let lattice = Array2::from_shape_fn((side, side), |(ky, kx)| {
        psd_m4(signed_index(kx, side) * TAU / side as f64, signed_index(ky, side) * TAU / side as f64)
    });
    let cosine = |rows: usize, columns: usize, period: usize| {
        Array2::from_shape_fn((rows, columns), |(a, b)| (TAU * (a * b) as f64 / period as f64).cos())
    };
    let to_lags = cosine(lags, side, side);
    let covariance = to_lags.dot(&lattice).dot(&to_lags.t()) / (side * side) as f64;
    // Both signs of a lag.
    let weight = |lag: usize| if lag == 0 { 1.0 } else { 2.0 } * parzen(lag as f64 / lags as f64);
    let to_waves = cosine(n, lags, n);
    let windowed = Array2::from_shape_fn((lags, lags), |(y, x)| weight(y) * weight(x) * covariance[[y, x]]);
    let area = to_waves.dot(&windowed).dot(&to_waves.t());
    let along = to_waves.dot(&ndarray::Array1::from_shape_fn(lags, |lag| weight(lag) * covariance[[0, lag]]));
    let place = |q: f64| (q * n as f64 / TAU).round().rem_euclid(n as f64) as usize;
    let profile = profile_means(n, &|qx, _| along[place(qx)]);
    [ring_means(n, &|qx, qy| area[[place(qy), place(qx)]]), profile.clone(), profile]
}

#[test]
fn bands_cover_the_spectrum_of_an_isotropic_surface_in_95_percent_of_the_bins() {
    let (fractions, tried) =
        coverages((64, 200), &self_affine(1.0), true_means(64, &self_affine(1.0)), |_, map| map, (2.0, 33.0));
    println!("isotropic {fractions:?} of {tried}");
    // Binomial standard error of 0.95 from 3,600 bins: 0.0036. The window correlates neighbouring bins by less than a
    // tenth, the lowest bins are biased by the curvature within the resolution, and the χ² match is approximate: 0.015
    // in total.
    assert!(tried > 3500.0);
    assert!(fractions.iter().all(|fraction| (fraction - 0.95).abs() < 0.015), "{fractions:?} of {tried}");
}

#[test]
fn bands_have_nearly_nominal_coverage_on_a_directional_surface() {
    let (fractions, tried) =
        coverages((64, 200), &self_affine(4.0), true_means(64, &self_affine(4.0)), |_, map| map, (3.0, 33.0));
    println!("lay {fractions:?} of {tried}");
    // Four times as long along y: counting all coefficients of a ring or all profiles equally would give a far lower
    // coverage.
    assert!(fractions.iter().all(|fraction| (0.92..0.97).contains(fraction)), "{fractions:?} of {tried}");
}

#[test]
fn bands_cover_the_spectrum_of_maps_with_missing_points() {
    // A disc and one point of fifty are missing.
    let punched = |index, map: HeightMap| {
        let grid = map.grid();
        let holes = random::standard_normal(&mut random::stream(32, "holes", index), grid.points());
        let heights = Array2::from_shape_fn(grid.shape(), |(row, column)| {
            let disc = (row as f64 - 20.0).hypot(column as f64 - 40.0) < 6.0;
            if disc || holes[row * grid.nx() + column] > 2.054 { f64::NAN } else { map.heights_m()[[row, column]] }
        });
        HeightMap::new(grid, heights).unwrap()
    };
    // The estimate has a lower resolution than the periodogram, so its expectation is the smoothed spectrum.
    let psd = self_affine(1.0);
    let truths = resolved_means(64, &psd);
    let (fractions, tried) = coverages((64, 200), &psd, truths, punched, (4.0, 16.0));
    println!("missing {fractions:?} of {tried}");
    assert!(fractions.iter().all(|fraction| (0.9..0.98).contains(fraction)), "{fractions:?} of {tried}");
}

#[test]
fn kernels_are_the_covariances_of_windowed_white_noise() {
    // |Σ w² e^{−2πidj/n}/Σ w²|² term by term.
    let n = 40;
    let window = hann(n);
    let power: f64 = window.iter().map(|w| w * w).sum();
    for distance in 0..6 {
        let (re, im) = window.iter().enumerate().fold((0.0, 0.0), |(re, im), (i, w)| {
            let phase = TAU * (distance * i) as f64 / n as f64;
            (re + w * w * phase.cos(), im + w * w * phase.sin())
        });
        let wanted = (re * re + im * im) / (power * power);
        assert!((Kernel::hann().at(distance as isize) - wanted).abs() < 1e-12, "{distance}");
    }
    let total: f64 = (-2..=2).map(|d| Kernel::hann().at(d)).sum();
    assert!((total - 35.0 / 18.0).abs() < 1e-15);
    // Parzen's lag window has 3.709 n/M degrees of freedom per coefficient (Percival & Walden, table 269), 2/κ(0),
    // without the correction for the pairs missing at long lags.
    let (n, end) = (4000, 40);
    assert!((2.0 / Kernel::parzen(n, end).at(0) * end as f64 / n as f64 - 3.709).abs() < 0.02);
}

#[test]
fn sums_over_neighbours_are_the_double_sums_over_all_wavevectors() {
    for (nx, ny) in [(12, 9), (11, 14)] {
        let heights = random::standard_normal(&mut random::stream(33, "sums", 0), nx * ny);
        let weights = power(nx, ny, |row, out| out.copy_from_slice(&heights[row * nx..(row + 1) * nx]));
        let kernels = [Kernel::hann(), Kernel::hann()];
        let spectrum = Coefficients { nx, ny, weights: &weights, own: kernels.clone(), estimate: kernels };
        let magnitude = |kx: f64, ky: f64| kx.hypot(ky);
        let edges = edges(nx.min(ny) / 2);
        let found = spectrum.sums(edges.len() - 1, magnitude, |q| bin_of(&edges, q));
        // All wavevectors with their density; distances on the periodic lattice.
        let all: Vec<(isize, isize, Option<usize>, f64)> = (0..nx as isize)
            .flat_map(|kx| (0..ny as isize).map(move |ky| (kx, ky)))
            .map(|(kx, ky)| {
                let q = signed_index(kx as usize, nx).hypot(signed_index(ky as usize, ny));
                (kx, ky, bin_of(&edges, q), weights[spectrum.index(kx, ky)])
            })
            .collect();
        let distance = |a: isize, b: isize, n: usize| {
            let d = (a - b).rem_euclid(n as isize);
            Kernel::hann().at(d.min(n as isize - d))
        };
        for (bin, sums) in found.iter().enumerate() {
            let (mut count, mut weight, mut own, mut flat) = (0.0, 0.0, 0.0, 0.0);
            for a in all.iter().filter(|a| a.2 == Some(bin)) {
                count += 1.0;
                weight += a.3;
                for b in all.iter().filter(|b| b.2 == Some(bin)) {
                    let kappa = distance(a.0, b.0, nx) * distance(a.1, b.1, ny);
                    own += a.3 * b.3 * kappa / (1.0 + kappa);
                    flat += kappa;
                }
            }
            assert_eq!(sums.count, count);
            for (fast, slow) in [(sums.weight, weight), (sums.own, own), (sums.estimate, own), (sums.flat, flat)] {
                assert!((fast - slow).abs() < 1e-9 * slow.abs(), "{nx} × {ny}, {bin}: {fast} {slow}");
            }
        }
    }
}

#[test]
fn a_single_coefficient_has_two_degrees_of_freedom_and_bins_are_means() {
    let map = gaussian_map(32, 0, &self_affine(1.0));
    let fine = profile_spectrum(&map, Axis::X).unwrap();
    let found = binned_profile_spectrum(&map, Axis::X).unwrap();
    // Up to the sixth wavenumber, where a sixth of an octave is one, bins contain one each.
    for k in 1..=6 {
        assert_eq!(found.coefficients[k - 1], 2);
        assert!((found.psd[k - 1] / fine.psd_m3[k] - 1.0).abs() < 1e-12);
        assert!((found.q_rad_per_m[k - 1] / fine.q_rad_per_m[k] - 1.0).abs() < 1e-12);
        assert!(found.degrees_of_freedom[k - 1] >= 2.0);
    }
    let total: usize = found.coefficients.iter().sum();
    assert_eq!(total, 31, "all wavenumbers but zero, both signs, Nyquist's once");
    let power = |q: &[f64]| q.iter().sum::<f64>();
    let weighted: Vec<f64> = found.psd.iter().zip(&found.coefficients).map(|(psd, n)| psd * *n as f64).collect();
    let both_signs = 2.0 * power(&fine.psd_m3[1..16]) + fine.psd_m3[16];
    assert!((power(&weighted) / both_signs - 1.0).abs() < 1e-12);
    // Identical profiles are redundant: 2 degrees of freedom where 32 independent ones have 64.
    let waves = HeightMap::from_function(map.grid(), |x, _| (1.3 * x).sin() + (0.4 * x * x).cos()).unwrap();
    let equal = binned_profile_spectrum(&waves, Axis::X).unwrap();
    assert!((equal.degrees_of_freedom[2] - 2.0).abs() < 1e-9, "{:?}", equal.degrees_of_freedom);
    assert!(
        (equal.psd_high[2] / equal.psd_low[2] - 3.6889 / 0.025_318).abs() < 0.1,
        "χ²₂ at 97.5 % over that at 2.5 %"
    );
}
