use asperity_formats::{Format, Scan};

use crate::check::{assert_no_warning, assert_pitch, assert_refused, assert_warns, bytes, patched};
use crate::datx;
use crate::datx::hdf5::{self, Hdf5, Message, contiguous, dataspace, datatype, fill_value, new_attribute};
use crate::fixture::{Fixture, read_bytes, read_channel};
use crate::{NAN, assert_heights, assert_metadata};

/// An attribute of any of the types that tests use.
#[derive(Clone)]
enum Att {
    Text(&'static str),
    Short(i16),
    Int(i32),
    Float(f32),
    Double(f64),
}

impl Att {
    /// Type, number of elements, bytes.
    fn parts(&self) -> (u32, u64, Vec<u8>) {
        match self {
            Self::Text(text) => (2, text.len() as u64, text.as_bytes().to_vec()),
            Self::Short(value) => (3, 1, value.to_be_bytes().to_vec()),
            Self::Int(value) => (4, 1, value.to_be_bytes().to_vec()),
            Self::Float(value) => (5, 1, value.to_be_bytes().to_vec()),
            Self::Double(value) => (6, 1, value.to_be_bytes().to_vec()),
        }
    }
}

type Atts = Vec<(&'static str, Att)>;

/// A variable: name, places of its dimensions, attributes, type, all its bytes.
#[derive(Clone)]
struct Var(&'static str, Vec<usize>, Atts, u32, Vec<u8>);

/// File of a classic format. A dimension of length 0 is the record dimension.
#[derive(Clone)]
struct Classic {
    version: u8,
    records: Option<u64>,
    dimensions: Vec<(&'static str, u64)>,
    attributes: Atts,
    variables: Vec<Var>,
}

fn doubles(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_be_bytes()).collect()
}

fn shorts(values: &[i16]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_be_bytes()).collect()
}

fn unit(unit: &'static str) -> Atts {
    vec![("unit", Att::Text(unit))]
}

impl Default for Classic {
    /// Returns a file as written by SurfaceTopography: two points along x and three along y, 1.5 µm and 2 µm apart.
    fn default() -> Self {
        let side = |length| [unit("um"), vec![("length", Att::Double(length)), ("periodic", Att::Int(1))]].concat();
        Self {
            version: 2,
            records: Some(0),
            dimensions: vec![("x", 2), ("y", 3)],
            attributes: vec![("json", Att::Text("{\"instrument\": {}}"))],
            variables: vec![
                Var("x", vec![0], side(3.0), 6, doubles(&[0.0, 1.5])),
                Var("heights", vec![0, 1], unit("nm"), 6, doubles(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0])),
                Var("y", vec![1], side(6.0), 6, doubles(&[0.0, 2.0, 4.0])),
            ],
        }
    }
}

impl Classic {
    /// A count: 4 bytes, in version 5 8 bytes.
    fn count(&self, count: u64) -> Vec<u8> {
        if self.version == 5 { count.to_be_bytes().to_vec() } else { (count as u32).to_be_bytes().to_vec() }
    }

    fn name(&self, name: &str) -> Vec<u8> {
        bytes![self.count(name.len() as u64), padded(name.as_bytes())]
    }

    /// A list; one without entries is absent: tag and count are zero.
    fn list(&self, tag: u32, entries: &[Vec<u8>]) -> Vec<u8> {
        let tag = if entries.is_empty() { 0 } else { tag };
        bytes![tag.to_be_bytes(), self.count(entries.len() as u64), entries.concat()]
    }

    fn attributes(&self, attributes: &Atts) -> Vec<u8> {
        let entry = |(name, att): &(&str, Att)| {
            let (kind, count, bytes) = att.parts();
            bytes![self.name(name), kind.to_be_bytes(), self.count(count), padded(&bytes)]
        };
        self.list(0x0c, &attributes.iter().map(entry).collect::<Vec<_>>())
    }

    fn has_records(&self, variable: &Var) -> bool {
        variable.1.first().is_some_and(|&place| self.dimensions[place].1 == 0)
    }

    fn header(&self, begins: &[u64]) -> Vec<u8> {
        let dimension = |(name, length): &(&str, u64)| bytes![self.name(name), self.count(*length)];
        let variable = |(Var(name, places, attributes, kind, bytes), begin): (&Var, &u64)| {
            let places: Vec<u8> = places.iter().flat_map(|&place| self.count(place as u64)).collect();
            let rank = self.count((places.len() / self.count(0).len()) as u64);
            let begin =
                if self.version == 1 { (*begin as u32).to_be_bytes().to_vec() } else { begin.to_be_bytes().to_vec() };
            // Name, dimensions, attributes, type, size, place.
            let size = self.count(bytes.len() as u64);
            bytes![self.name(name), rank, places, self.attributes(attributes), kind.to_be_bytes(), size, begin]
        };
        bytes![
            [b'C', b'D', b'F', self.version],
            // A number of records with all bits set means unknown.
            self.count(self.records.unwrap_or(u64::MAX)),
            self.list(0x0a, &self.dimensions.iter().map(dimension).collect::<Vec<_>>()),
            self.attributes(&self.attributes),
            self.list(0x0b, &self.variables.iter().zip(begins).map(variable).collect::<Vec<_>>()),
        ]
    }

    /// The header, variables without records, and the records with a part of each of the others.
    fn bytes(&self) -> Vec<u8> {
        let mut begins = vec![0; self.variables.len()];
        let start = self.header(&begins).len();
        let mut data = Vec::new();
        let (in_records, others): (Vec<usize>, Vec<usize>) =
            (0..self.variables.len()).partition(|&place| self.has_records(&self.variables[place]));
        for place in others {
            begins[place] = (start + data.len()) as u64;
            data.extend(padded(&self.variables[place].4));
        }
        // Files of an unknown number of records have three.
        let records = self.records.unwrap_or(3) as usize;
        for record in 0..records {
            for &place in &in_records {
                if record == 0 {
                    begins[place] = (start + data.len()) as u64;
                }
                let bytes = &self.variables[place].4;
                let part = &bytes[record * bytes.len() / records..(record + 1) * bytes.len() / records];
                // A single variable in the records is not padded.
                data.extend(if in_records.len() == 1 { part.to_vec() } else { padded(part) });
            }
        }
        bytes![self.header(&begins), data]
    }

    fn read(&self) -> Scan {
        read_bytes(&self.bytes()).unwrap()
    }
}

/// A file as written by SurfaceTopography, of three rows of two heights in nm.
pub(crate) fn of_surface_topography() -> Vec<u8> {
    Classic::default().bytes()
}

/// A line scan as written by SurfaceTopography, with the positions `x` in µm along the dimension of this name.
fn line_scan(dimension: &'static str, x: &[f64]) -> Classic {
    let heights: Vec<f64> = (0..x.len()).map(|n| n as f64).collect();
    Classic {
        dimensions: vec![(dimension, x.len() as u64)],
        variables: vec![
            Var("x", vec![0], unit("um"), 6, doubles(x)),
            Var("heights", vec![0], unit("nm"), 6, doubles(&heights)),
        ],
        ..Classic::default()
    }
}

/// Bytes and zeros up to a multiple of four.
fn padded(bytes: &[u8]) -> Vec<u8> {
    let mut padded = bytes.to_vec();
    padded.resize(bytes.len().next_multiple_of(4), 0);
    padded
}

/// Integers z(y, x) of two rows that are packed, with a missing one.
fn packed() -> Classic {
    let attributes = vec![
        ("units", Att::Text("um")),
        ("scale_factor", Att::Double(0.5)),
        ("add_offset", Att::Float(10.0)),
        ("_FillValue", Att::Short(-999)),
        ("missing_value", Att::Short(-998)),
    ];
    Classic {
        version: 1,
        records: Some(0),
        dimensions: vec![("y", 2), ("x", 3)],
        attributes: vec![],
        variables: vec![Var("z", vec![0, 1], attributes, 3, shorts(&[0, 1, -999, 3, -998, 5]))],
    }
}

/// Three records of two integers, with another variable of bytes in the records.
fn in_records(version: u8, records: Option<u64>) -> Classic {
    Classic {
        version,
        records,
        dimensions: vec![("t", 0), ("x", 2)],
        attributes: vec![],
        variables: vec![
            Var("quality", vec![0], vec![], 1, vec![7, 8, 9]),
            Var("z", vec![0, 1], unit("mm"), 3, shorts(&[1, 2, 3, 4, 5, 6])),
        ],
    }
}

/// Appends numbers in double precision, and returns the messages on them.
fn contiguous_numbers(file: &mut Hdf5, shape: &[u64], values: &[f64]) -> Vec<Message> {
    let numbers: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    let address = file.append(&numbers);
    vec![
        (hdf5::DATASPACE, dataspace(shape)),
        (hdf5::DATATYPE, datatype::float(8, false)),
        fill_value(&[]),
        contiguous(address, numbers.len() as u64),
    ]
}

/// An attribute of text.
fn text(name: &str, value: &str) -> Vec<u8> {
    new_attribute(name, &datatype::text(value.len() as u32), 1, value.as_bytes())
}

/// Appends positions along x and y and heights(x, y) in nm with these messages, and returns the links to them.
fn variables(
    file: &mut Hdf5,
    x: &[f64],
    y: &[f64],
    heights: impl Fn(&mut Hdf5) -> Vec<Message>,
) -> [(&'static str, u64); 3] {
    let scale = |name| {
        [("CLASS", text("CLASS", "DIMENSION_SCALE")), ("NAME", text("NAME", name)), ("unit", text("unit", "um"))]
    };
    let in_header = scale("x").map(|(_, content)| (hdf5::ATTRIBUTE, content));
    let stored = contiguous_numbers(file, &[x.len() as u64], x);
    let x = file.new_object(&[stored, in_header.to_vec()].concat());
    let stored = contiguous_numbers(file, &[y.len() as u64], y);
    let in_heap = file.dense_attributes(&scale("y"));
    let y = file.new_object(&[stored, vec![in_heap]].concat());
    // Each dimension has a sequence of references to its scales.
    let scales = [x, y].map(|address: u64| file.keep(&address.to_le_bytes()).of(1)).concat();
    let list = new_attribute("DIMENSION_LIST", &datatype::sequence(&datatype::reference()), 2, &scales);
    let attributes = vec![(hdf5::ATTRIBUTE, list), (hdf5::ATTRIBUTE, text("unit", "nm"))];
    let stored = heights(file);
    let heights = file.new_object(&[stored, attributes].concat());
    [("x", x), ("y", y), ("heights", heights)]
}

/// A netCDF-4 file: heights of two by three, with links and some of the attributes in fractal heaps.
fn enhanced() -> Vec<u8> {
    let mut file = Hdf5::new();
    let heights = |file: &mut Hdf5| contiguous_numbers(file, &[2, 3], &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    let links = variables(&mut file, &[0.0, 1.5], &[0.0, 2.0, 4.0], heights);
    let links = file.dense_links(&links);
    let root = file.new_object(&[links, (hdf5::ATTRIBUTE, text("title", "a face"))]);
    file.finish_new(root)
}

/// A netCDF-4 file: heights of three by four in filtered chunks, with links in a symbol table, and another dimension.
fn in_chunks() -> Vec<u8> {
    let mut file = Hdf5::new();
    let heights = |file: &mut Hdf5| datx::chunked().stored(file);
    let links = variables(&mut file, &[0.0, 1.5, 3.0], &[0.0, 2.0, 4.0, 6.0], heights);
    // A dimension without positions.
    let name = "This is a netCDF dimension but not a netCDF variable         7";
    let attributes =
        [("CLASS", "DIMENSION_SCALE"), ("NAME", name)].map(|(name, value)| (hdf5::ATTRIBUTE, text(name, value)));
    let stored = contiguous_numbers(&mut file, &[1], &[0.0]);
    let time = file.new_object(&[stored, attributes.to_vec()].concat());
    let root = file.group(&[links.as_slice(), &[("time", time)]].concat(), &[]);
    file.finish(1, root)
}

pub(crate) fn fixtures() -> Vec<Fixture> {
    let enhanced = Fixture::whole("NetCDF-4", enhanced());
    vec![
        Fixture::whole("NetCDF of SurfaceTopography", Classic::default().bytes()),
        Fixture::whole("NetCDF of packed int16", packed().bytes()),
        Fixture::whole("NetCDF with records, version 5", in_records(5, Some(3)).bytes()),
        // The checksum of the root at the end is not needed.
        Fixture { needed: enhanced.needed - 4, ..enhanced },
        Fixture::whole("NetCDF-4 in chunks", in_chunks()),
    ]
}

/// Heights in nm.
fn assert_nm<const N: usize>(scan: &Scan, wanted: [f64; N]) {
    assert_heights(scan, &wanted.map(|z| z * 1e-9));
}

#[test]
fn a_file_of_surfacetopography_is_turned_to_rows_of_y() {
    for version in [1, 2, 5] {
        let scan = Classic { version, ..Classic::default() }.read();
        assert_eq!(scan.heights_m.dim(), (3, 2));
        // heights[x][y] = 1 2 3, 4 5 6 nm; the first y is at the top.
        assert_nm(&scan, [1.0, 4.0, 2.0, 5.0, 3.0, 6.0]);
        assert_pitch(&scan, (1.5e-6, 2e-6));
        assert_eq!(scan.channels, ["heights"]);
        assert_no_warning(&scan);
        assert_metadata(&scan, &[("json", "{\"instrument\": {}}"), ("heights:unit", "nm"), ("x:unit", "um")]);
        assert_metadata(&scan, &[("x:length", "3"), ("y:periodic", "1")]);
    }
    // Rows of x are not turned.
    let mut file = Classic { dimensions: vec![("y", 2), ("x", 3)], ..Classic::default() };
    file.variables[0].0 = "y";
    file.variables[2].0 = "x";
    let scan = file.read();
    assert_nm(&scan, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    assert_eq!(scan.heights_m.dim(), (2, 3));
    assert_pitch(&scan, (2e-6, 1.5e-6));
}

#[test]
fn marks_fill_values_and_the_mask_are_missing() {
    let mut file = Classic::default();
    file.variables.push(Var("mask", vec![0, 1], vec![], 1, vec![0, 0, 1, 0, 0, 0]));
    let scan = file.read();
    assert_nm(&scan, [1.0, 4.0, 2.0, 5.0, NAN, 6.0]);
    assert_eq!(scan.channels.len(), 1);
    // n · 0.5 + 10, in µm, with two marks.
    let scan = packed().read();
    assert_heights(&scan, &[10e-6, 10.5e-6, NAN, 11.5e-6, NAN, 12.5e-6]);
    assert_pitch(&scan, None);
    // −32767 fills variables of short integers unless another value is stated.
    let mut file = packed();
    file.variables[0].4 = shorts(&[0, -32767, 1, 1, 1, 1]);
    assert_eq!(file.read().missing_points(), 0);
    file.variables[0].2.retain(|(name, _)| *name != "_FillValue");
    assert!(file.read().heights_m[[0, 1]].is_nan());
    // 0x1.ep+122 fills variables of floats.
    let mut file = Classic::default();
    file.variables[1].4 = doubles(&[1.0, 9.969209968386869e36, 3.0, 4.0, 5.0, 6.0]);
    assert!(file.read().heights_m[[1, 0]].is_nan());
    // A mark of double precision marks numbers of single precision.
    let values: Vec<u8> = [1.0_f32, 1e20, 3.0, 4.0, 5.0, 6.0].iter().flat_map(|z| z.to_be_bytes()).collect();
    let attributes = vec![("units", Att::Text("nm")), ("missing_value", Att::Double(1e20))];
    let file = Classic { variables: vec![Var("z", vec![0, 1], attributes, 5, values)], ..Classic::default() };
    assert_eq!(file.read().missing_points(), 1);
}

#[test]
fn integers_of_every_type_are_read() {
    let last = |attributes: Atts, kind, bytes: &[u8]| {
        let variables = vec![Var("z", vec![0, 1], attributes, kind, bytes.repeat(6))];
        Classic { version: 5, variables, ..Classic::default() }.read().heights_m[[2, 1]]
    };
    // Type, number, bytes of one element.
    for (kind, value, bytes) in [
        (1, -2.0, &[0xfe][..]),
        (3, -2.0, &[0xff, 0xfe]),
        (4, -2.0, &[0xff, 0xff, 0xff, 0xfe]),
        (7, 254.0, &[0xfe]),
        (8, 65534.0, &[0xff, 0xfe]),
        (9, 4294967294.0, &[0xff, 0xff, 0xff, 0xfe]),
        (10, -2.0, &[0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xfe]),
        (11, 4294967296.0, &[0, 0, 0, 1, 0, 0, 0, 0]),
    ] {
        assert_eq!(last(unit("m"), kind, bytes), value, "type {kind}");
    }
    assert_eq!(last(vec![("unit", Att::Text("m")), ("_Unsigned", Att::Text("true"))], 1, &[0xfe]), 254.0);
}

#[test]
fn records_are_put_together() {
    let wanted = [1e-3, 2e-3, 3e-3, 4e-3, 5e-3, 6e-3];
    for version in [1, 2, 5] {
        // With a second variable each record is padded to four bytes; an unknown number of records is counted.
        for records in [Some(3), None] {
            let scan = in_records(version, records).read();
            assert_eq!(scan.heights_m.dim(), (3, 2));
            assert_heights(&scan, &wanted);
        }
        // A single variable is not padded: three integers of two bytes follow each other.
        let mut file = in_records(version, Some(2));
        file.dimensions[1].1 = 3;
        file.variables.remove(0);
        assert_heights(&file.read(), &wanted);
    }
    let file = Classic {
        records: Some(1),
        dimensions: vec![("time", 0), ("y", 2), ("x", 3)],
        variables: vec![Var("z", vec![0, 1, 2], unit("mm"), 3, shorts(&[1, 2, 3, 4, 5, 6]))],
        ..Classic::default()
    };
    assert_heights(&file.read(), &wanted);
}

#[test]
fn maps_in_a_unit_of_length_are_channels_and_heights_is_the_first() {
    let mut file = Classic::default();
    file.variables.insert(0, Var("error", vec![0, 1], unit("um"), 6, doubles(&[7.0; 6])));
    file.variables.insert(0, Var("current", vec![0, 1], unit("A/m"), 6, doubles(&[8.0; 6])));
    let bytes = file.bytes();
    let scan = read_bytes(&bytes).unwrap();
    assert_eq!((scan.channels.as_slice(), scan.channel), (&["heights".to_owned(), "error".to_owned()][..], 0));
    assert_eq!(read_channel(&bytes, "error").unwrap().heights_m[[0, 0]], 7e-6);
}

#[test]
fn units_of_heights_and_positions_replace_or_contradict_each_other() {
    let changed = |change: &dyn Fn(&mut Vec<Var>)| {
        let mut file = Classic::default();
        change(&mut file.variables);
        file.read()
    };
    // Heights without a unit are in that of the positions, or in metre.
    let scan = changed(&|variables| variables[1].2.clear());
    assert_eq!((scan.heights_m[[0, 0]], scan.warnings.len()), (1e-6, 0));
    let without = |variable: &mut Var| variable.2.retain(|(name, _)| *name != "unit");
    let scan = changed(&|variables| variables.iter_mut().for_each(without));
    assert_eq!((scan.heights_m[[0, 0]], scan.pitch_m), (1.0, Some((1.5, 2.0))));
    assert_warns(&scan, "no unit");
    let scan = changed(&|variables| variables[0].2 = unit("s"));
    assert_pitch(&scan, None);
    assert_warns(&scan, "the unit of x is `s`");
    // A side of 1.5 µm is the distance between the first and the last of two points.
    let scan = changed(&|variables| variables[0].2[1].1 = Att::Double(1.5));
    assert_pitch(&scan, (1.5e-6, 2e-6));
    assert_warns(&scan, "the length of x gives pixels of 0.75 um");
    // Positions that were never written leave the length of three points; falling and uneven ones are read.
    let at = |positions: [f64; 3]| changed(&|variables| variables[2].4 = doubles(&positions));
    assert_pitch(&at([9.969209968386869e36; 3]), (1.5e-6, 2e-6));
    assert_no_warning(&at([4.0, 2.0, 0.0]));
    assert_warns(&at([0.0, 1.0, 4.0]), "not evenly spaced");
    for positions in [[4.0, 2.0, 0.0], [0.0, 1.0, 4.0]] {
        assert_pitch(&at(positions), (1.5e-6, 2e-6));
    }
}

#[test]
fn netcdf_4_is_read_like_the_classic_formats() {
    let scan = read_bytes(&enhanced()).unwrap();
    assert_nm(&scan, [1.0, 4.0, 2.0, 5.0, 3.0, 6.0]);
    assert_pitch(&scan, (1.5e-6, 2e-6));
    let metadata: Vec<(&str, &str)> = scan.metadata.iter().map(|(name, text)| (name.as_str(), text.as_str())).collect();
    assert_eq!(metadata, [("heights:unit", "nm"), ("title", "a face"), ("x:unit", "um"), ("y:unit", "um")]);
    let scan = read_bytes(&in_chunks()).unwrap();
    assert_eq!(scan.heights_m.dim(), (4, 3));
    assert_pitch(&scan, (1.5e-6, 2e-6));
    // The last chunk was never written and holds the fill value.
    assert_nm(&scan, [1.0, 5.0, 9.0, 2.0, 6.0, -2.0, 3.0, 7.0, 11.0, 4.0, 8.0, 77.0]);
}

#[test]
fn numbers_of_hdf5_are_read_as_in_datx() {
    for map in datx::stored_in_every_way() {
        let mut file = Hdf5::new();
        let [x, y] = map.shape.map(|size| (0..size).map(|k| k as f64).collect::<Vec<_>>());
        let links = variables(&mut file, &x, &y, |file| map.stored(file));
        let root = file.new_object(&links.map(|(name, address)| (hdf5::LINK, hdf5::link(name, address))));
        match (read_bytes(&file.finish_new(root)), read_bytes(&datx::one(map))) {
            // A mark of missing points is an attribute in DATX.
            (Ok(found), Ok(wanted)) => {
                assert!(found.heights_m.t().iter().zip(&wanted.heights_m).all(|(z, w)| z == w || w.is_nan()));
            }
            (Err(found), Err(wanted)) => {
                // The same message at another place.
                let [found, wanted] = [found, wanted].map(|error| error.to_string().replace(char::is_numeric, ""));
                assert_eq!(found.strip_prefix("NetCDF"), wanted.strip_prefix("DATX"));
            }
            (found, wanted) => panic!("{found:?}, {wanted:?}"),
        }
    }
}

#[test]
fn other_versions_and_files_without_a_map_are_refused_with_their_content() {
    for (version, format) in
        [(1, Some(Format::NetCdf)), (2, Some(Format::NetCdf)), (5, Some(Format::NetCdf)), (3, None)]
    {
        assert_eq!(Format::detect(&bytes!["CDF", [version; 1], [0_u8; 40]]), format);
    }
    let with = |variable: Option<Var>| {
        let mut file = Classic::default();
        file.variables.splice(1..2, variable);
        file.bytes()
    };
    let sized = |side| Classic { dimensions: vec![("x", side), ("y", side)], ..Classic::default() }.bytes();
    let usual = Classic::default().bytes();
    assert_refused([
        (with(Some(Var("current", vec![0, 1], unit("A/m"), 6, doubles(&[8.0; 6])))), "holds `current` (A/m); wanted"),
        (
            line_scan("n", &[0.0, 1.5, 4.0]).bytes(),
            "NetCDF: the file holds a line scan whose positions are not evenly spaced",
        ),
        (with(None), "NetCDF: the file holds no map"),
        (in_records(2, Some(0)).bytes(), "NetCDF: rows (byte 0) is `0`; wanted 1 or more"),
        (sized(1 << 30), "the limit is"),
        (sized(1 << 14), "wanted 2147483648"),
        // One record more than there is.
        (patched(&in_records(2, Some(3)).bytes(), 4, 4_u32.to_be_bytes()), "stop after"),
        // The tag of the list of dimensions, and the number of its entries.
        (patched(&usual, 11, [0x0c_u8]), "NetCDF: dimensions (byte 8) is `tag 12`; wanted tag 10"),
        (patched(&usual, 12, 1_000_000_u32.to_be_bytes()), "is 1000000; the limit is"),
    ]);
}

#[test]
fn a_line_scan_is_a_scan_of_one_row() {
    for dimension in ["x", "n"] {
        let scan = line_scan(dimension, &[0.0, 1.5, 3.0]).read();
        assert_eq!(scan.heights_m.dim(), (1, 3));
        assert_nm(&scan, [0.0, 1.0, 2.0]);
        assert_pitch(&scan, (1.5e-6, 1.5e-6));
        assert_no_warning(&scan);
    }
}
