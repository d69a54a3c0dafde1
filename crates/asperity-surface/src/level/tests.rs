use super::*;
use asperity_base::map::Grid;
use asperity_base::random;

fn noise(grid: Grid, index: u64) -> Array2<f64> {
    let values = random::standard_normal(&mut random::stream(9, "level", index), grid.points());
    Array2::from_shape_vec(grid.shape(), values).unwrap()
}

#[test]
fn a_quadratic_is_removed_at_any_pitch_and_offset() {
    for pitch_m in [1e-9, 1.0, 400.0] {
        let grid = Grid::new(31, 17, pitch_m, 2.0 * pitch_m).unwrap();
        let map = HeightMap::from_function(grid, |x, y| {
            let (x, y) = (x / pitch_m, y / pitch_m);
            pitch_m * (3e3 + 0.3 * x - 0.7 * y + 0.02 * x * x - 0.01 * x * y + 0.005 * y * y)
        });
        let levelled = remove_form(&map.unwrap(), Level::Quadratic).unwrap();
        assert!(levelled.map.present_m().all(|z| z == 0.0), "{:?}", levelled.map.present_m().fold(0.0, f64::max));
    }
}

#[test]
fn the_residual_is_orthogonal_to_the_form_on_the_present_points() {
    let grid = Grid::new(40, 30, 1e-6, 1e-6).unwrap();
    let mut heights = noise(grid, 0);
    // Half of the map is missing, so the polynomials are far from orthogonal.
    heights.indexed_iter_mut().filter(|((row, column), _)| row + column > 35).for_each(|(_, z)| *z = f64::NAN);
    let map = HeightMap::new(grid, heights).unwrap();
    for (level, degree) in [
        (Level::Mean, 0),
        (Level::Plane, 1),
        (Level::Quadratic, 2),
        (Level::Polynomial(4), 4),
        (Level::Polynomial(8), 8),
    ] {
        let levelled = remove_form(&map, level).unwrap();
        assert_eq!(levelled.map.missing_points(), map.missing_points());
        for (a, b) in (0..=degree).flat_map(|sum| (0..=sum).map(move |b| (sum - b, b))) {
            let left = levelled.map.heights_m().indexed_iter().filter(|(_, z)| !z.is_nan());
            let product: f64 =
                left.map(|((row, column), z)| z * (column as f64 / 40.0).powi(a) * (row as f64 / 30.0).powi(b)).sum();
            assert!(product.abs() < 1e-9, "{level}: {product:e}");
        }
        // Form and residual add up to the map.
        let again = &levelled.form_m + levelled.map.heights_m();
        assert!(again.iter().zip(map.heights_m()).all(|(a, b)| b.is_nan() || (a - b).abs() < 1e-12));
    }
}

#[test]
fn a_polynomial_of_degree_twelve_is_removed_by_its_own_degree() {
    let grid = Grid::new(50, 40, 1e-6, 1e-6).unwrap();
    let map = HeightMap::from_function(grid, |x, y| {
        let (u, v) = (x / 25e-6 - 1.0, y / 20e-6 - 1.0);
        1e-6 * (u.powi(12) - 3.0 * u.powi(7) * v.powi(5) + v.powi(11) * u + v)
    })
    .unwrap();
    let rest = |degree| {
        remove_form(&map, Level::Polynomial(degree)).unwrap().map.present_m().fold(0.0, |m: f64, z| m.max(z.abs()))
    };
    assert!(rest(12) < 1e-19, "{:e}", rest(12));
    assert!(rest(11) > 1e-10);
}

#[test]
fn levelling_twice_changes_nothing_and_none_removes_nothing() {
    let grid = Grid::new(20, 20, 1.0, 1.0).unwrap();
    let map = HeightMap::new(grid, noise(grid, 1)).unwrap();
    for level in [Level::Plane, Level::Polynomial(5)] {
        let once = remove_form(&map, level).unwrap().map;
        let twice = remove_form(&once, level).unwrap().map;
        assert!(once.heights_m().iter().zip(twice.heights_m()).all(|(a, b)| (a - b).abs() < 1e-14));
    }
    assert_eq!(remove_form(&map, Level::None).unwrap().map, map);
}

#[test]
fn points_on_a_line_do_not_determine_a_plane() {
    let grid = Grid::new(10, 10, 1.0, 1.0).unwrap();
    let diagonal = Array2::from_shape_fn((10, 10), |(row, column)| if row == column { 1.0 } else { f64::NAN });
    let map = HeightMap::new(grid, diagonal).unwrap();
    for level in [Level::Plane, Level::Polynomial(3), Level::Sphere, Level::Cylinder] {
        let error = remove_form(&map, level).unwrap_err();
        assert_eq!(error, LevelError::Undetermined { level, present: 10 });
    }
    assert!(remove_form(&map, Level::Mean).is_ok());
    let row = Array2::from_shape_fn((10, 10), |(row, _)| if row == 3 { 1.0 } else { f64::NAN });
    assert!(remove_form(&HeightMap::new(grid, row).unwrap(), Level::Plane).is_err());
}

/// Returns the sphere of centre (x₀, y₀) and radius R with its top at the height `top`; R < 0 is a dish.
fn sphere(x0: f64, y0: f64, top: f64, radius: f64) -> impl Fn(f64, f64) -> f64 {
    move |x, y| top - radius + radius.signum() * (radius * radius - (x - x0).powi(2) - (y - y0).powi(2)).sqrt()
}

#[test]
fn a_sphere_is_removed_and_its_radius_returned() {
    let grid = Grid::new(60, 45, 2e-6, 3e-6).unwrap();
    // A cap, a dish, a sphere whose top is beyond the map, nearly a hemisphere, and nearly a plane.
    for (x0, y0, radius) in
        [(60e-6, 70e-6, 1e-3), (50e-6, 60e-6, -0.5e-3), (300e-6, -200e-6, 2e-3), (60e-6, 67e-6, 95e-6), (0.0, 0.0, 0.3)]
    {
        let map = HeightMap::from_function(grid, sphere(x0, y0, 5e-6, radius)).unwrap();
        let levelled = remove_form(&map, Level::Sphere).unwrap();
        let found = levelled.radius_m.unwrap();
        let depth = map.present_m().fold(f64::NEG_INFINITY, f64::max) - map.present_m().fold(f64::INFINITY, f64::min);
        // The error of the radius is the rounding of the heights, of some 5 µm, over the depth of the sphere in the map.
        assert!((found / radius - 1.0).abs() < 1e-13 * 1e-4 / depth + 1e-9, "{found} is not {radius}");
        let rest = levelled.map.present_m().fold(0.0, |m: f64, z| m.max(z.abs()));
        // The heights of the function above are accurate to the rounding of the radius.
        assert!(rest < 1e-10 * depth + f64::EPSILON * radius.abs(), "{rest:e} of {depth:e}");
    }
}

#[test]
fn a_rough_sphere_with_holes_keeps_its_roughness() {
    let grid = Grid::new(80, 80, 1e-6, 1e-6).unwrap();
    let cap = sphere(35e-6, 45e-6, 0.0, 400e-6);
    let mut heights = noise(grid, 2) * 10e-9;
    for ((row, column), z) in heights.indexed_iter_mut() {
        *z += cap((column as f64 + 0.5) * 1e-6, (row as f64 + 0.5) * 1e-6);
    }
    heights.iter_mut().step_by(7).for_each(|z| *z = f64::NAN);
    let levelled = remove_form(&HeightMap::new(grid, heights).unwrap(), Level::Sphere).unwrap();
    let (n, sum) = levelled.map.present_m().fold((0.0, 0.0), |(n, sum), z| (n + 1.0, sum + z * z));
    // 5,485 residuals: the standard error of their rms is 1/√(2n) = 1 %.
    assert!(((sum / n).sqrt() / 10e-9 - 1.0).abs() < 0.03);
    // A cap of 40 µm radius is 2 µm deep; 10 nm at 5,485 points give the curvature an error of about 1e-4.
    assert!((levelled.radius_m.unwrap() / 400e-6 - 1.0).abs() < 1e-3);
}

#[test]
fn a_tilted_cylinder_of_any_axis_is_removed_and_its_radius_returned() {
    let grid = Grid::new(50, 60, 2e-6, 2e-6).unwrap();
    for (angle, tilt, radius) in [(0.3, 0.0, 1e-3), (1.6, 0.1, -0.4e-3), (2.9, -0.05, 300e-6), (0.0, 0.2, 2e-3)] {
        // Points at the distance R from the axis through (a, b, c) along the unit vector t, by bisection.
        let (sin, cos) = f64::sin_cos(angle);
        let length = 1.0_f64.hypot(tilt);
        let t = [cos / length, sin / length, tilt / length];
        let centre = [60e-6, 50e-6, -radius];
        let height = |x: f64, y: f64| {
            let distance = |z: f64| {
                let d = [x - centre[0], y - centre[1], z - centre[2]];
                let along: f64 = d.iter().zip(&t).map(|(d, t)| d * t).sum();
                (d.iter().map(|d| d * d).sum::<f64>() - along * along).sqrt()
            };
            // The axis passes at this height, where the distance is least; the outer side is at most R beyond.
            let axis = centre[2] + tilt * ((x - centre[0]) * cos + (y - centre[1]) * sin);
            let (mut low, mut high) = (axis, axis + 2.0 * radius);
            for _ in 0..200 {
                let middle = 0.5 * (low + high);
                if distance(middle) < radius.abs() { low = middle } else { high = middle }
            }
            low
        };
        let map = HeightMap::from_function(grid, height).unwrap();
        let levelled = remove_form(&map, Level::Cylinder).unwrap();
        assert!((levelled.radius_m.unwrap() / radius - 1.0).abs() < 1e-6, "{:?} is not {radius}", levelled.radius_m);
        let rest = levelled.map.present_m().fold(0.0, |m: f64, z| m.max(z.abs()));
        assert!(rest < 1e-14, "{rest:e}");
    }
}

#[test]
fn forms_are_named_as_in_study_files() {
    for level in Level::PLAIN.into_iter().chain([Level::Polynomial(0), Level::Polynomial(12)]) {
        assert_eq!(level.to_string().parse(), Ok(level));
        assert_eq!(serde_json::to_string(&level).unwrap(), format!("\"{level}\""));
    }
    for wrong in ["cubic", "polynomial", "polynomial:13", "polynomial:-1", "polynomial:2.5"] {
        assert!(wrong.parse::<Level>().is_err(), "{wrong}");
    }
}

#[test]
fn a_form_is_dominant_if_its_rms_height_exceeds_that_of_the_rest() {
    let grid = Grid::new(64, 48, 1e-6, 1e-6).unwrap();
    let (rough, n) = (noise(grid, 7), 64.0_f64);
    let with = |slope: f64, bend: f64| {
        let heights = Array2::from_shape_fn(grid.shape(), |(row, column)| {
            let x = column as f64 - 31.5;
            rough[[row, column]] + slope * x + bend * (x * x - (n * n - 1.0) / 12.0)
        });
        dominant_form(&HeightMap::new(grid, heights).unwrap())
    };
    assert_eq!(with(0.0, 0.0), None);
    // A slope s over n points has the rms height s √((n² − 1)/12), a parabola b x² has b √((n² − 1)(n² − 4)/180).
    let (of_slope, of_bend) = (((n * n - 1.0) / 12.0).sqrt(), ((n * n - 1.0) * (n * n - 4.0) / 180.0).sqrt());
    assert_eq!(with(0.8 / of_slope, 0.0), None);
    assert_eq!(with(0.0, 0.8 / of_bend), None);
    for (slope, bend, level) in
        [(3.0, 0.0, Level::Plane), (3.0, 0.8, Level::Plane), (0.0, 3.0, Level::Quadratic), (3.0, 3.0, Level::Quadratic)]
    {
        let found = with(slope / of_slope, bend / of_bend).unwrap();
        assert_eq!(found.level, level);
        let wanted = slope.hypot(if level == Level::Plane { 0.0 } else { bend });
        // Noise of variance 1 on 3072 points changes tilt and curvature by a few per cent.
        assert!((found.form_rms_m / wanted - 1.0).abs() < 0.05, "{found:?}, wanted {wanted}");
        let rest = if level == Level::Plane { 1.0_f64.hypot(bend) } else { 1.0 };
        assert!((found.roughness_rms_m / rest - 1.0).abs() < 0.05, "{found:?}, wanted {rest}");
    }
}
