use asperity_formats::{Format, Scan, write_sur};

use crate::check::{
    assert_error, assert_no_warning, assert_one_warning, assert_pitch, assert_refused, assert_scan, assert_warns, warns,
};
use crate::fixture::{Fixture, read_bytes};
use crate::{NAN, assert_heights, assert_metadata};

/// Columns, rows from the smallest y on, and the pitch of the maps below.
const SIZE: (usize, usize) = (4, 3);
const PITCH: (f64, f64) = (0.5, 0.25);

/// The height of a point, another one for each.
fn height((row, column): (usize, usize)) -> f64 {
    (4 * row + column) as f64 / 8.0
}

/// Returns the position of a point: row 0 has the smallest y.
fn position((row, column): (usize, usize)) -> (f64, f64) {
    (10.0 + PITCH.0 * column as f64, -1.5 + PITCH.1 * row as f64)
}

fn by_rows() -> Vec<(usize, usize)> {
    (0..SIZE.1).flat_map(|row| (0..SIZE.0).map(move |column| (row, column))).collect()
}

fn by_columns() -> Vec<(usize, usize)> {
    (0..SIZE.0).flat_map(|column| (0..SIZE.1).map(move |row| (row, column))).collect()
}

fn list(points: &[(usize, usize)], separator: &str) -> String {
    let line = |&point: &(usize, usize)| {
        let (x, y) = position(point);
        format!("{x}{separator}{y}{separator}{}\n", height(point))
    };
    points.iter().map(line).collect()
}

fn read(text: &str) -> Scan {
    assert_eq!(Format::detect(text.as_bytes()), Some(Format::Xyz), "{text}");
    read_bytes(text.as_bytes()).unwrap_or_else(|error| panic!("{error}: {text}"))
}

fn heights() -> Vec<f64> {
    by_rows().into_iter().map(height).collect()
}

/// A Zygo file: a header of 13 lines and `#`, the points, `#` (Zygo, OMP-0347, appendix B).
fn zygo(resolution: &str) -> String {
    let mut text = String::from("Zygo XYZ Data File - Format 1\n");
    // Program, version, date; origin and size of intensities, buckets, range; origin and size of phases.
    text += "1 8 3 5 \"Tue Dec 01 14:30:59 2016\"\n0 0 0 0 0 0\n100 50 3 2\n";
    // Comment, serial number, part number.
    text += "\"hob ground\"\n\"S-17\"\n\"gear 7\"\n";
    // Source, scale factor, wavelength, aperture, obliquity, magnification, camera resolution, time.
    text += &format!("0 0.5 6.328e-07 0 1 0 {resolution} 1480602659\n");
    // System; acquisition; processing; system error; refractive index.
    text += "3 2 0 0 0 0 0 \"\"\n0 0 1 33 0 0 0.1 60.4 2 50\n0 1 100 0 0 0 0 0 0 0\n0 \"\"\n1 5 0\n#\n";
    text += "100 50 0.25\n101 50 -0.5\n102 50 No Data\n100 51 1.5\n101 51 2\n102 51 No Data\n#\n";
    text
}

pub(crate) fn fixtures() -> Vec<Fixture> {
    vec![
        Fixture::open_ended("XYZ", list(&by_rows(), " ").into_bytes()),
        Fixture::open_ended("XYZ with units", format!("X [mm];Y [mm];Z [um]\n{}", list(&by_columns(), ";")).into()),
        Fixture::open_ended("XYZ of Zygo", zygo("1e-05").into_bytes()),
    ]
}

#[test]
fn points_are_put_in_their_places_in_any_order() {
    let (rows, columns) = (by_rows(), by_columns());
    let reversed = |points: &[(usize, usize)]| points.iter().rev().copied().collect::<Vec<_>>();
    let serpentine: Vec<_> = rows
        .chunks(SIZE.0)
        .enumerate()
        .flat_map(|(row, line)| if row % 2 == 0 { line.to_vec() } else { reversed(line) })
        .collect();
    let mirrored: Vec<_> = rows.chunks(SIZE.0).flat_map(reversed).collect();
    for points in [&rows, &columns, &reversed(&rows), &reversed(&columns), &serpentine, &mirrored] {
        assert_scan(list(points, " ").as_bytes(), Format::Xyz, (3, 4), PITCH, &heights());
    }
}

#[test]
fn shuffled_points_are_put_in_their_places() {
    // 17 × 11 points, in steps of 0.5 and 0.25; 7 and 97 are coprime to their number, so multiples visit each once.
    let (columns, rows) = (17, 11);
    for (factor, jitter, left_out) in [(7, 0.0, 0), (97, 0.0, 0), (97, 0.01, 0), (101, 0.0, 30), (101, 0.02, 30)] {
        let points = (0..columns * rows - left_out).map(|n| (n * factor + 5) % (columns * rows));
        let noise = |place: usize, along: f64| jitter * ((place as f64 * along).fract() - 0.5);
        let line = |place: usize| {
            let (x, y) = (0.5 * (place % columns) as f64, 0.25 * (place / columns) as f64);
            format!("{:.6} {:.6} {}\n", x + noise(place, 0.618_034), y + noise(place, 0.754_878), place as f64 / 64.0)
        };
        let scan = read(&points.map(line).collect::<String>());
        assert_eq!(scan.heights_m.dim(), (rows, columns), "{factor} {jitter} {left_out}");
        let (dx_m, dy_m) = scan.pitch_m.unwrap();
        assert!((dx_m / 0.5 - 1.0).abs() < 1e-2 && (dy_m / 0.25 - 1.0).abs() < 1e-2, "{dx_m} {dy_m}");
        let is_missing = |z: &f64| z.is_nan();
        assert_eq!(scan.heights_m.iter().filter(|z| is_missing(z)).count(), left_out);
        let in_place =
            |((row, column), z): ((usize, usize), &f64)| z.is_nan() || *z == (row * columns + column) as f64 / 64.0;
        assert!(scan.heights_m.indexed_iter().all(in_place), "{factor} {jitter} {left_out}");
    }
    // Quantised heights in three columns are no points: places repeat.
    let map: String = (0..60).map(|n| format!("{} {} {}\n", n * 7 % 5, n * 3 % 4, n * 11 % 6)).collect();
    assert_eq!(Format::detect(map.as_bytes()), Some(Format::Text));
}

#[test]
fn an_index_of_the_rows_is_no_coordinate() {
    let map: Vec<(usize, usize)> = (0..5).flat_map(|row| (0..6).map(move |column| (row, column))).collect();
    let line = |(index, &(row, column)): (usize, &(usize, usize))| {
        format!("{index},{}e-6,{}e-6,{}e-7\n", 2 * column, 3 * row, 10 * row + column)
    };
    let indexed: String = map.iter().enumerate().map(line).collect();
    for head in ["", ",x,y,z\n", "index,x,y,z\n", "\"\",\"x\",\"y\",\"z\"\n", "x,y,z\n", ",X,Y,Height\n"] {
        let scan = read(&format!("{head}{indexed}"));
        assert_eq!(scan.heights_m.dim(), (5, 6), "{head}");
        let (dx_m, dy_m) = scan.pitch_m.unwrap();
        assert!((dx_m / 2e-6 - 1.0).abs() < 1e-12 && (dy_m / 3e-6 - 1.0).abs() < 1e-12, "{dx_m} {dy_m}");
        assert!(scan.heights_m.indexed_iter().all(|((y, x), z)| (z * 1e7 - (10 * y + x) as f64).abs() < 1e-9));
    }
    // Few rows, rows that were dropped, tabs, and x and y in another order.
    let few = "0 0 0 0\n1 0 1 .1\n2 1 0 1\n3 1 1 1.1\n4 2 0 2\n5 2 1 2.1\n";
    assert_scan(few.as_bytes(), Format::Xyz, (2, 3), (1.0, 1.0), &[0.0, 1.0, 2.0, 0.1, 1.1, 2.1]);
    let dropped = few.replace("2 1 0 1\n", "").replace(' ', "\t");
    let text = format!("\tx\ty\tz\n{dropped}");
    assert_scan(text.as_bytes(), Format::Xyz, (2, 3), (1.0, 1.0), &[0.0, NAN, 2.0, 0.1, 1.1, 2.1]);
    assert_scan(format!("y x z\n{few}").as_bytes(), Format::Xyz, (3, 2), (1.0, 1.0), &[0.0, 0.1, 1.0, 1.1, 2.0, 2.1]);
}

#[test]
fn columns_with_numbers_as_names_and_further_columns_are_points() {
    let of = |line: &dyn Fn(usize, usize, usize) -> String| (0..12).map(|n| line(n, n % 4, n / 4)).collect::<String>();
    let heights: Vec<f64> = (0..12).map(|n| f64::from(n) / 8.0).collect();
    // As pandas writes an array: an index, and numbers as names of columns.
    let pandas = of(&|n, x, y| format!("{n},{x}.0,{y}.5,{}\n", n as f64 / 8.0));
    for head in [",0,1,2\n", ",0,1,2\r\n"] {
        assert_scan(format!("{head}{pandas}").as_bytes(), Format::Xyz, (3, 4), (1.0, 1.0), &heights);
    }
    // Names with an intensity behind them, with a name of the index, without one, and without the index.
    let five = of(&|n, x, y| format!("{n},{x},{y},{},255\n", n as f64 / 8.0));
    for head in ["index,x,y,z,intensity\n", ",x,y,z,intensity\n", "x,y,z,intensity\n"] {
        let scan = assert_scan(format!("{head}{five}").as_bytes(), Format::Xyz, (3, 4), (1.0, 1.0), &heights);
        assert_warns(&scan, "a point has 5 values; those beside x, y and z were left out");
    }
    // A map with numbered rows and columns stays one, and so do five columns without names.
    let map = of(&|n, x, y| format!("{n},{},{},{}\n", (x * 7 + y) % 5, (y * 11 + n) % 7, n * n % 11));
    assert_eq!(Format::detect(format!(",0,1,2\n{map}").as_bytes()), Some(Format::Text));
    assert_eq!(read_bytes(format!(",0,1,2\n{map}").as_bytes()).unwrap().heights_m.dim(), (12, 3));
    assert_eq!(Format::detect(five.as_bytes()), Some(Format::Text));
}

#[test]
fn flaws_of_shuffled_points_are_named_with_their_lines() {
    let line = |n: usize| (n * 7 + 5) % 60;
    let points: Vec<String> = (0..60).map(|n| format!("{} {} 0.5", line(n) % 10, line(n) / 10)).collect();
    let with = |place: usize, point: &str| {
        let mut points = points.clone();
        points.insert(place, point.into());
        format!("# points\n{}\n", points.join("\n"))
    };
    // After a comment, the point of index 30 is on line 32.
    for (point, message) in [
        (points[3].as_str(), "XYZ: the point (line 32) is `in the place of another`"),
        ("nan 3 0.5", "XYZ: x (line 32) is `not finite`; wanted a number"),
        ("4 inf 0.5", "XYZ: y (line 32) is `not finite`; wanted a number"),
    ] {
        assert_refused([(with(30, point), message)]);
        assert_refused([(format!("x y z\n{}", with(30, point)), &*message.replace("32", "33"))]);
    }
}

#[test]
fn units_that_are_no_lengths_are_refused_by_name() {
    let points = list(&by_rows(), " ");
    for header in
        ["# x (µ), y (µ), z (µ)\n", "x/µ y/µ z/µ\n", "# unit: µ\n", "# unit: um\n# z unit: u\n", "# z unit: V\n"]
    {
        let unit = if header.contains('V') {
            "V"
        } else if header.contains(": u\n") {
            "u"
        } else {
            "µ"
        };
        let message = format!("XYZ: coordinates in `{unit}`; wanted a unit of length for each of x, y and z");
        assert_refused([(format!("{header}{points}"), message)]);
    }
    for (header, unit) in [("[km]\n", 1e3), ("# unit: fm\n", 1e-15)] {
        let scan = read(&format!("{header}{points}"));
        assert!((scan.pitch_m.unwrap().0 / (0.5 * unit) - 1.0).abs() < 1e-15, "{scan:?}");
    }
}

#[test]
fn shuffled_lists_may_lack_the_corners_of_a_disc_or_a_band() {
    let of = |is_kept: fn(i32, i32) -> bool| -> String {
        let places = (0..1681).map(|n| (n * 7 + 3) % 1681).map(|place| (place % 41 - 20, place / 41 - 20));
        places.filter(|(x, y)| is_kept(*x, *y)).map(|(x, y)| format!("{x}e-6 {y}e-6 {}e-8\n", x + 3 * y)).collect()
    };
    for (is_kept, dim) in
        [((|x, y| x * x + y * y <= 400) as fn(i32, i32) -> bool, (41, 41)), (|x, _| !(3..9).contains(&x), (41, 41))]
    {
        let scan = read(&of(is_kept));
        assert_eq!(scan.heights_m.dim(), dim);
        assert!((scan.pitch_m.unwrap().0 / 1e-6 - 1.0).abs() < 1e-9);
    }
    // Steps of 2.5 printed as whole numbers.
    let rounded: String = (0..81)
        .map(|n| {
            format!("{} {} 0.5\n", [0, 2, 5, 8, 10, 12, 15, 18, 20][n % 9], [0, 2, 5, 8, 10, 12, 15, 18, 20][n / 9])
        })
        .collect();
    assert_eq!(read(&rounded).heights_m.dim(), (9, 9));
}

#[test]
fn lines_may_lie_closer_than_the_points_on_them() {
    // Pixels of 5 µm × 1 µm in lines along x: a new line starts a fifth of a step further.
    for (columns, rows) in [(4, 3), (2, 9), (7, 5), (3, 40)] {
        let line = |row: usize| (0..columns).map(move |column| (row, column));
        let there =
            |row: usize| if row.is_multiple_of(2) { line(row).collect() } else { line(row).rev().collect::<Vec<_>>() };
        let one_way: Vec<_> = (0..rows).flat_map(line).collect();
        let serpentine: Vec<_> = (0..rows).flat_map(there).collect();
        for points in [one_way, serpentine] {
            let text: String = points
                .iter()
                .map(|&(row, column)| format!("{}e-6 {}e-6 {}e-7\n", 5 * column, row, 10 * row + column))
                .collect();
            let scan = read(&text);
            assert_eq!(scan.heights_m.dim(), (rows, columns));
            let (dx_m, dy_m) = scan.pitch_m.unwrap();
            assert!((dx_m / 5e-6 - 1.0).abs() < 1e-12 && (dy_m / 1e-6 - 1.0).abs() < 1e-12, "{dx_m} {dy_m}");
            assert!(scan.heights_m.indexed_iter().all(|((y, x), z)| (z * 1e7 - (10 * y + x) as f64).abs() < 1e-9));
        }
    }
}

#[test]
fn separators_comments_and_a_line_of_names_are_understood() {
    let points = by_rows();
    for text in [
        list(&points, "\t"),
        list(&points, ","),
        list(&points, ", "),
        list(&points, ";"),
        list(&points, ";").replace('.', ","),
        list(&points, "\t").replace('.', ","),
        format!("# measured 2016\n{}", list(&points, " ")),
        format!("X Y Z\n\n{}", list(&points, " ")),
        format!("x,y,z\n{}", list(&points, ",")),
        list(&points, "   ").replace('\n', "\r\n"),
    ] {
        assert_scan(text.as_bytes(), Format::Xyz, (3, 4), PITCH, &heights());
    }
}

#[test]
fn units_stand_in_the_header() {
    let points = list(&by_rows(), " ");
    for (header, pitch_m, z) in [
        ("[um]\n", (0.5e-6, 0.25e-6), 1e-6),
        ("mm\n", (0.5e-3, 0.25e-3), 1e-3),
        ("X [mm] Y [mm] Z [um]\n", (0.5e-3, 0.25e-3), 1e-6),
        ("# X (mm), Y (mm), Z (nm)\n", (0.5e-3, 0.25e-3), 1e-9),
        ("X Y Z\n[mm] [um] [nm]\n", (0.5e-3, 0.25e-6), 1e-9),
        ("x/um y/um z/nm\n", (0.5e-6, 0.25e-6), 1e-9),
        ("# lateral [um], height [nm]\n", (0.5e-6, 0.25e-6), 1e-9),
        ("# unit: um\n", (0.5e-6, 0.25e-6), 1e-6),
        ("# unit: um\n# z unit: nm\n", (0.5e-6, 0.25e-6), 1e-9),
        ("xy unit = mm\nz unit = um\n", (0.5e-3, 0.25e-3), 1e-6),
    ] {
        let scan = read(&format!("{header}{points}"));
        assert_pitch(&scan, pitch_m);
        assert_heights(&scan, &heights().iter().map(|height| height * z).collect::<Vec<_>>());
        assert!(!warns(&scan, "no unit"), "{header}: {:?}", scan.warnings);
    }
    // English words are no units.
    assert_eq!(read(&format!("# measured in 2016\n# in air\n{points}")).pitch_m, Some(PITCH));
}

#[test]
fn wide_spacing_without_a_unit_gives_a_warning() {
    let points = list(&by_rows(), " ");
    let scan = read(&points);
    assert_warns(&scan, "no unit is stated");
    let metre = by_rows().into_iter().map(|point| {
        let (x, y) = position(point);
        format!("{:e} {:e} {:e}\n", x * 1e-6, y * 1e-6, height(point) * 1e-6)
    });
    let scan = read(&metre.collect::<String>());
    assert!(!warns(&scan, "no unit"), "{:?}", scan.warnings);
}

#[test]
fn missing_points_and_heights_are_nan() {
    let text = list(&by_rows(), " ");
    let mut lines: Vec<&str> = text.lines().collect();
    lines[2] = "11 -1.5 nan";
    lines[3] = "11.5 -1.5 BAD";
    lines[4] = "10 -1.25 1.#QNAN";
    lines[7] = "11.5 -1.25 No Data";
    lines.remove(6);
    let mut wanted = heights();
    for missing in [2, 3, 4, 6, 7] {
        wanted[missing] = NAN;
    }
    assert_heights(&read(&lines.join("\n")), &wanted);
    // A whole column and a whole row.
    let some: Vec<_> = by_rows().into_iter().filter(|&(row, column)| row != 1 && column != 2).collect();
    let scan = read(&list(&some, " "));
    assert_eq!(scan.heights_m.dim(), (2, 4), "with two rows left their distance is the pitch");
    assert_eq!(scan.missing_points(), 2);
    assert_eq!(scan.pitch_m, Some((0.5, 0.5)));
}

#[test]
fn coordinates_may_jitter_by_a_tenth_of_a_step() {
    // Deterministic noise of ±1 steps of 1/10.
    let noise = |index: usize| ((index * 7919 % 2001) as f64 / 1000.0 - 1.0) / 10.0;
    let mut text = String::new();
    for row in 0..20 {
        for column in 0..30 {
            let (x, y) = (column as f64 + noise(30 * row + column), row as f64 + noise(31 * row + 5 * column + 1));
            text += &format!("{x} {y} {}\n", height((row, column)));
        }
    }
    let scan = read(&text);
    assert_eq!(scan.heights_m.dim(), (20, 30));
    let wanted: Vec<f64> = (0..20).flat_map(|row| (0..30).map(move |column| height((row, column)))).collect();
    assert_heights(&scan, &wanted);
    let (dx_m, dy_m) = scan.pitch_m.unwrap();
    assert!((dx_m - 1.0).abs() < 0.01 && (dy_m - 1.0).abs() < 0.01, "{dx_m} {dy_m}");
}

#[test]
fn coarse_digits_give_the_true_pitch() {
    // A pitch of 1/300 with three digits: 0.003, 0.007, 0.010, 0.013.
    let mut text = String::new();
    for row in 0..31 {
        for column in 0..31 {
            text += &format!(
                "{:.3} {:.3} {}\n",
                f64::from(column) / 300.0,
                f64::from(row) / 300.0,
                1e-6 * f64::from(row * column)
            );
        }
    }
    let scan = read(&text);
    assert_eq!(scan.heights_m.dim(), (31, 31));
    assert_eq!(scan.missing_points(), 0);
    let (dx_m, dy_m) = scan.pitch_m.unwrap();
    assert!((dx_m * 300.0 - 1.0).abs() < 1e-12 && (dy_m * 300.0 - 1.0).abs() < 1e-12, "{dx_m} {dy_m}");
}

#[test]
fn a_zygo_file_has_heights_in_micrometre_and_pixels_from_the_top() {
    let heights = [0.25e-6, -0.5e-6, NAN, 1.5e-6, 2e-6, NAN];
    let scan = assert_scan(zygo("1e-05").as_bytes(), Format::Xyz, (2, 3), (1e-5, 1e-5), &heights);
    assert_no_warning(&scan);
    let wanted = [("comment", "hob ground"), ("part serial number", "S-17"), ("part number", "gear 7")];
    assert_metadata(&scan, &wanted);
    let scan = read(&zygo("0"));
    assert_eq!(scan.pitch_m, None);
    assert_one_warning(&scan, "not calibrated");
    let cut = zygo("1e-05").replace("\n#\n", "\n");
    assert_refused([(cut, "the line `#` after the header is missing")]);
}

#[test]
fn columns_are_those_of_their_names_and_a_fourth_is_left_out() {
    let grid = |point: &dyn Fn(i32, i32, f64) -> String| -> String {
        (0..20).map(|k| point(k % 5, k / 5, f64::from(k * k % 7)) + "\n").collect()
    };
    let heights = read_bytes(grid(&|x, y, z| format!("{x} {y} {z}")).as_bytes()).unwrap().heights_m;
    for text in [
        format!("y [um],x [um],z [nm]\n{}", grid(&|x, y, z| format!("{y},{x},{z}"))),
        format!("z [nm];x [um];y [um]\n{}", grid(&|x, y, z| format!("{z};{x};{y}"))),
        format!("x/um y/um z/nm intensity\n{}", grid(&|x, y, z| format!("{x} {y} {z} 255"))),
        format!("x (um), y (um), intensity (a.u.), z (nm)\n{}", grid(&|x, y, z| format!("{x},{y},255,{z}"))),
        // Other lines may name them too.
        format!("# sorted by z, y, x\n# z [nm] x [um] y [um]\n{}", grid(&|x, y, z| format!("{z} {x} {y}"))),
        format!("z (nm) x y (um)\n{}", grid(&|x, y, z| format!("{z} {x} {y}"))),
    ] {
        let scan = read_bytes(text.as_bytes()).unwrap();
        assert_eq!((scan.format, scan.pitch_m), (Some(Format::Xyz), Some((1e-6, 1e-6))), "{text}");
        assert!(scan.heights_m.iter().zip(&heights).all(|(a, b)| (a - 1e-9 * b).abs() < 1e-22), "{text}");
        assert_eq!(scan.warnings.len(), usize::from(text.contains("intensity")));
    }
    let doubtful = format!("x (mm), y (mm), z\n{}", grid(&|x, y, z| format!("{x},{y},{z}")));
    assert_refused([(doubtful, "some of the columns x, y and z have a unit of length")]);
    // Without names the fourth column is left out too.
    let scan = read_bytes(grid(&|x, y, z| format!("{x} {y} {z} {}", 7 - x)).as_bytes()).unwrap();
    assert_eq!(scan.heights_m, heights);
    assert!(scan.warnings[0].contains("a point has 4 values"), "{:?}", scan.warnings);
}

#[test]
fn maps_of_three_columns_stay_maps() {
    let ramp: String = (0..100).map(|i| format!("{} {} {}\n", i, 2 * i, 3 * i)).collect();
    let noise: String = (0..100_usize).map(|i| format!("{} {} {}\n", i * 7919 % 13, i * 104729 % 17, i)).collect();
    let flat: String = (0..20).map(|_| "0 0 0\n").collect();
    let alternating: String = (0..500).map(|i| format!("{} 0 {i}\n", i % 2)).collect();
    for text in [&ramp, &noise, &flat, &alternating, "1 2 3\n4 5 6\n7 8 9\n", "0 0 0\n0 1 0\n0 0 0\n"] {
        assert_eq!(Format::detect(text.as_bytes()), Some(Format::Text), "{text}");
        assert_eq!(read_bytes(text.as_bytes()).unwrap().heights_m.ncols(), 3);
    }
    // A pixel size distinguishes a map from points.
    let text = format!("# pixel size: 1 um\n{}", list(&by_rows(), " "));
    assert_eq!(Format::detect(text.as_bytes()), Some(Format::Text));
}

#[test]
fn points_beside_the_grid_or_on_one_another_name_their_line() {
    let text = format!("# points\n\n{}", list(&by_rows(), " "));
    // The seventh point, on line 9.
    for (to, message) in [
        ("11.2 -1.25 ", "XYZ: x (line 9) is `0.40 steps off the grid`"),
        ("10.5 -1.25 ", "XYZ: the point (line 9) is `in the place of another`"),
        ("inf -1.25 ", "XYZ: x (line 9) is `not finite`"),
    ] {
        assert_refused([(text.replace("11 -1.25 ", to), message)]);
    }
}

#[test]
fn lines_that_are_not_points_are_named() {
    let mut text: String = (0..900).map(|point| format!("{} {} 0.5\n", point % 30, point / 30)).collect();
    text.insert_str(0, "# points\n");
    // The point (17, 25) is on line 2 + 25 · 30 + 17, after the lines that show a list of points.
    for (to, message) in [
        ("\n17 25 0.5 7\n", "XYZ: the number of values (line 769) is `4`; wanted 3: x, y and z"),
        ("\n17 one 0.5\n", "XYZ: value 2 (line 769) is `one`; wanted a number"),
    ] {
        assert_refused([(text.replace("\n17 25 0.5\n", to), message)]);
    }
}

#[test]
fn points_that_span_a_giant_grid_are_refused() {
    let mut text = list(&by_rows(), " ");
    text += "1000000000 -1 0\n";
    assert_error(read_bytes(text.as_bytes()), "XYZ: the points would fill less than 1 of 4 places of a grid of");
}

#[test]
fn a_map_has_one_orientation_as_xyz_sur_and_matrix() {
    // Neither symmetric nor square; positions grow from line to line, as ISO 25178-72 and the SUR format count them.
    let heights = ndarray::Array2::from_shape_fn((5, 7), |(row, column)| 1e-7 * (3 * row * row + column) as f64);
    let map = Scan::new(heights, Some((2e-6, 3e-6)));
    let sur = read_bytes(&write_sur(&map).unwrap()).unwrap();
    let matrix = read_bytes(&asperity_formats::to_bytes(&map, "map.txt".as_ref()).unwrap()).unwrap();
    let points: String = sur
        .heights_m
        .indexed_iter()
        .map(|((row, column), z)| format!("{}e-6 {}e-6 {z:e}\n", 2 * column, 3 * row))
        .collect();
    let xyz = read(&points);
    assert_eq!(crate::bits(&xyz), crate::bits(&sur));
    assert_eq!(xyz.heights_m.dim(), (5, 7));
    assert!(matrix.heights_m.iter().zip(&xyz.heights_m).all(|(a, b)| (a - b).abs() < 1e-13));
}

/// 20 × 20 points of a square grid of step 1, each moved.
fn moved(moved: impl Fn(f64, f64) -> (f64, f64)) -> String {
    let point = |place: u32| {
        let (x, y) = moved(f64::from(place % 20), f64::from(place / 20));
        format!("{x:.4} {y:.4} {:.4}\n", 1.0 + f64::from(place).sin())
    };
    (0..400).map(point).collect()
}

#[test]
fn points_on_no_grid_are_refused() {
    let turned = moved(|x, y| (0.866 * x - 0.5 * y, 0.5 * x + 0.866 * y));
    // Moved by up to 0.3 steps, by the fractions of multiples of irrational numbers.
    let jitter = |x: f64, y: f64, factor: f64| 0.6 * ((x + 20.0 * y) * factor).fract() - 0.3;
    let jittered = moved(|x, y| (x + jitter(x, y, 0.618_034), y + jitter(x, y, 0.754_878)));
    // Anywhere, in any order, with heights of a hundredth of the range.
    let anywhere: String = (0..400)
        .map(f64::from)
        .map(|n| format!("{} {} {}\n", (n * 0.754_878).fract(), (n * 0.569_84).fract(), 0.01 * (n * 0.3).sin()))
        .collect();
    for points in [&turned, &jittered, &anywhere] {
        for header in ["# x [um] y [um] z [um]\n", "x;y;z\n", "X (mm), Y (mm), Z (um)\n"] {
            let error = read_bytes(format!("{header}{points}").as_bytes()).unwrap_err().to_string();
            let is_told = |words| error.starts_with(&format!("XYZ: the {words}"));
            assert!(
                is_told("three columns are points x, y, z that lie on no regular grid")
                    || is_told("points have no grid")
            );
            assert!(error.contains("interpolate the heights onto one"), "{error}");
        }
        // A pixel size marks a map.
        let text = format!("# pixel size: 1 um\n# unit: um\n{points}");
        assert_eq!(read_bytes(text.as_bytes()).unwrap().heights_m.dim(), (400, 3));
    }
}

#[test]
fn three_columns_in_a_file_named_xyz_are_points() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        asperity_formats::read(&path)
    };
    let map = "1 2 3\n4 5 6\n7 9 9\n";
    assert_error(
        write("map.xyz", map),
        "map.xyz: XYZ: the three columns are points x, y, z that lie on no regular grid",
    );
    let sized = "# pixel size: 1 um\n# unit: um\n1 2 3\n4 5 6\n";
    for (name, text) in [("map.txt", map), ("map.xyz", "1 2\n3 4\n"), ("map.xyz", sized)] {
        assert_eq!(write(name, text).unwrap().format, Some(Format::Text), "{name}: {text}");
    }
    // Too few points to detect steps.
    assert_eq!(write("grid.xyz", "0 0 .1\n1 0 .2\n0 1 .3\n1 1 .4\n").unwrap().heights_m.dim(), (2, 2));
}
