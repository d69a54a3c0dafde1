use asperity_formats::{Format, FormatError, Scan};

use crate::check::{assert_error, assert_refused, assert_scan, bytes, patched};
use crate::fixture::{Fixture, read_bytes, read_channel};
use crate::fixtures::{deflated as deflated_bytes, zlib};
use crate::{NAN, assert_heights, assert_metadata};
use hdf5::{Hdf5, Message, attribute, contiguous, dataspace, datatype, fill_value};

mod damaged;
pub(crate) mod hdf5;

/// The largest number, by which Mx marks points without data.
const NO_DATA: f64 = f64::MAX;

/// How the numbers of a map are stored.
#[derive(Clone)]
enum Store {
    Contiguous,
    /// In chunks of this shape with a pipeline message, each as its offsets, filter mask and bytes.
    Chunked([u32; 2], Vec<u8>, Vec<([u64; 2], u32, Vec<u8>)>),
    /// By another layout message, from the numbers.
    Layout(fn(&mut Hdf5, &[u8]) -> Vec<u8>),
    /// By a layout message that is not read.
    Message(Vec<u8>),
}

/// A dataset of a map.
#[derive(Clone)]
pub(crate) struct Map {
    kind: &'static str,
    datatype: Vec<u8>,
    pub(crate) shape: [u64; 2],
    numbers: Vec<u8>,
    store: Store,
    fill: Vec<u8>,
    unit: Option<&'static str>,
    no_data: Option<(Vec<u8>, Vec<u8>)>,
    /// Category, base unit and parameters of the converters along x, y and z.
    converters: [Option<(&'static str, &'static str, [f64; 4])>; 3],
    /// Attributes that are numbers.
    factors: Vec<(&'static str, f64)>,
}

impl Default for Map {
    /// Two rows of three heights in nm, 1.5 µm apart along x and 2 µm along y, one without data.
    fn default() -> Self {
        let numbers = [100.0, -200.0, NO_DATA, 400.0, 500.5, 600.0];
        Self {
            kind: "Surface",
            datatype: datatype::float(8, false),
            shape: [2, 3],
            numbers: numbers.iter().flat_map(|z: &f64| z.to_le_bytes()).collect(),
            store: Store::Contiguous,
            fill: vec![],
            unit: Some("NanoMeters"),
            no_data: Some((datatype::float(8, false), NO_DATA.to_le_bytes().to_vec())),
            converters: [
                Some(("LateralCat", "Pixels", [0.0, 1.5e-6, 0.0, 0.0])),
                Some(("LateralCat", "Pixels", [0.0, 2e-6, 0.0, 0.0])),
                Some(("HeightCat", "NanoMeters", [0.0, 6.3e-7, 0.5, 1.0])),
            ],
            factors: vec![],
        }
    }
}

impl Map {
    /// The same map with integers of four bytes in fringes.
    fn fringes(numbers: [i32; 6]) -> Self {
        Self {
            datatype: datatype::integer(4, false),
            numbers: numbers.iter().flat_map(|z| z.to_le_bytes()).collect(),
            unit: Some("Fringes"),
            no_data: Some((datatype::integer(4, false), i32::MAX.to_le_bytes().to_vec())),
            converters: [None, None, Some(("HeightCat", "Fringes", [0.0, 6e-7, 0.5, 0.75]))],
            ..Self::default()
        }
    }

    fn append(&self, file: &mut Hdf5) -> u64 {
        let text = datatype::long_text();
        let sequence = datatype::sequence(&datatype::float(8, false));
        let converter = datatype::compound(&[
            ("Category", 16, text.clone()),
            ("BaseUnit", 16, text.clone()),
            ("Parameters", 16, sequence),
        ]);
        let mut attributes = Vec::new();
        if let Some(unit) = self.unit {
            attributes.push(attribute("Unit", &text, &file.keep(unit.as_bytes()).of(unit.len())));
        }
        if let Some((datatype, value)) = &self.no_data {
            attributes.push(attribute("No Data", datatype, value));
        }
        for (name, converting) in ["X Converter", "Y Converter", "Z Converter"].into_iter().zip(self.converters) {
            let Some((category, unit, parameters)) = converting else { continue };
            let parameters: Vec<u8> = parameters.iter().flat_map(|one| one.to_le_bytes()).collect();
            let value = bytes![
                file.keep(category.as_bytes()).of(category.len()),
                file.keep(unit.as_bytes()).of(unit.len()),
                file.keep(&parameters).of(4),
            ];
            attributes.push(attribute(name, &converter, &value));
        }
        for (name, factor) in &self.factors {
            attributes.push(attribute(name, &datatype::float(8, false), &factor.to_le_bytes()));
        }
        let messages = [self.stored(file), attributes].concat();
        file.object(&messages)
    }

    /// The messages on the numbers.
    pub(crate) fn stored(&self, file: &mut Hdf5) -> Vec<Message> {
        let mut messages = vec![
            (hdf5::DATASPACE, dataspace(&self.shape)),
            (hdf5::DATATYPE, self.datatype.clone()),
            fill_value(&self.fill),
        ];
        messages.extend(self.layout(file));
        messages
    }

    fn layout(&self, file: &mut Hdf5) -> Vec<Message> {
        match &self.store {
            Store::Contiguous => {
                let address = file.append(&self.numbers);
                vec![contiguous(address, self.numbers.len() as u64)]
            }
            Store::Chunked(shape, filters, chunks) => {
                let mut children = Vec::new();
                for (offset, mask, bytes) in chunks {
                    let address = file.append(bytes);
                    // Bytes of the chunk, filter mask, offsets, offset within the element.
                    children.push((bytes![bytes.len() as u32, mask, offset, [0_u8; 8]], address));
                }
                // The key after the last chunk is beyond it.
                let end = self.shape[0].next_multiple_of(u64::from(shape[0]));
                let end = bytes![[0_u8; 8], end, [0_u8; 16]];
                // Two chunks in each node, and a node above these if there are several.
                let nodes: Vec<(Vec<u8>, u64)> =
                    children.chunks(2).map(|pair| (pair[0].0.clone(), file.tree(1, 0, pair, &end))).collect();
                let tree = match nodes.as_slice() {
                    [(_, only)] => *only,
                    nodes => file.tree(1, u8::from(!nodes.is_empty()), nodes, &end),
                };
                // The element is the last of the dimensions.
                let element = self.datatype[4..8].to_vec();
                let layout = bytes![[3_u8, 2, 3], tree, shape, element];
                let pipeline = (!filters.is_empty()).then(|| (hdf5::FILTERS, filters.clone()));
                [(hdf5::LAYOUT, layout)].into_iter().chain(pipeline).collect()
            }
            Store::Layout(layout) => vec![(hdf5::LAYOUT, layout(file, &self.numbers))],
            Store::Message(layout) => vec![(hdf5::LAYOUT, layout.clone())],
        }
    }
}

/// A file of maps under `/Data`, with the table of links when it is to lead to one of them.
fn file(maps: &[Map], main: Option<usize>, attributes: &[Message]) -> Vec<u8> {
    let mut file = Hdf5::new();
    let objects: Vec<u64> = maps.iter().map(|map| map.append(&mut file)).collect();
    let names: Vec<String> = (0..maps.len()).map(|place| format!("{{{}}}", 9 - place)).collect();
    let mut kinds: Vec<&str> = maps.iter().map(|map| map.kind).collect();
    kinds.dedup();
    let groups: Vec<(&str, u64)> = kinds
        .into_iter()
        .map(|kind| {
            let members = maps.iter().zip(&names).zip(&objects).filter(|((map, _), _)| map.kind == kind);
            let members: Vec<(&str, u64)> = members.map(|((_, name), object)| (name.as_str(), *object)).collect();
            (kind, file.group(&members, &[]))
        })
        .collect();
    let data = file.group(&groups, &[]);
    let described = file.group(&[], attributes);
    let described = file.group(&[("{A}", described)], &[]);
    let mut links = vec![("Attributes", described), ("Data", data)];
    if let Some(main) = main {
        let path = format!("/Data/{}/{}", maps[main].kind, names[main]);
        links.push(("MetaData", table(&mut file, &path)));
    }
    let root = file.group(&links, &[]);
    let is_chunked = maps.iter().any(|map| matches!(map.store, Store::Chunked(..)));
    file.finish(u8::from(is_chunked), root)
}

/// The table of links (source, link, destination) as texts in a global heap.
fn table(file: &mut Hdf5, path: &str) -> u64 {
    let texts = [
        "Root",
        "Measurement",
        "{M}",
        "Attributes",
        "{A}",
        "Surface",
        "{S}",
        "Path",
        path,
        "/Attributes/{A}",
        "Layout",
        "1",
    ];
    let cells = texts.map(|text| file.keep(text.as_bytes()).of(text.len()));
    let rows = [[0, 10, 11], [0, 1, 2], [2, 3, 4], [2, 5, 6], [4, 7, 9], [6, 7, 8]];
    let content: Vec<u8> = rows.iter().flatten().flat_map(|cell| cells[*cell].clone()).collect();
    let text = datatype::long_text;
    let row = datatype::compound(&[("Source", 16, text()), ("Link", 16, text()), ("Destination", 16, text())]);
    let address = file.append(&content);
    file.object(&[
        (hdf5::DATASPACE, dataspace(&[rows.len() as u64])),
        (hdf5::DATATYPE, row),
        fill_value(&[]),
        contiguous(address, content.len() as u64),
    ])
}

pub(crate) fn one(map: Map) -> Vec<u8> {
    file(&[map], Some(0), &[])
}

fn read(map: Map) -> Scan {
    read_bytes(&one(map)).unwrap()
}

/// A pipeline message of version 1 (IV.A.2.l): version, number, reserved; each filter with one value and without a name.
fn pipeline(filters: &[(u16, u32)]) -> Vec<u8> {
    let each = |&(filter, value): &(u16, u32)| {
        // Filter, length of the name, flags, number of values; an odd number of values is padded.
        bytes![filter, [0_u8; 2], [0_u8; 2], 1_u16, value, [0_u8; 4]]
    };
    bytes![[1_u8, filters.len() as u8], [0_u8; 6], filters.iter().flat_map(each).collect::<Vec<u8>>()]
}

/// Three rows of four integers in chunks of two by three; only three of the four chunks were written.
pub(crate) fn chunked() -> Map {
    let chunk = |numbers: [i16; 6]| numbers.iter().flat_map(|z| z.to_be_bytes()).collect::<Vec<u8>>();
    // The first goes through shuffle and deflate: high bytes first, then low ones.
    let first = chunk([1, 2, 3, 5, 6, 7]);
    let shuffled: Vec<u8> = first.iter().step_by(2).chain(first.iter().skip(1).step_by(2)).copied().collect();
    let chunks = vec![
        ([0, 0], 0, zlib(&shuffled)),
        // Elements beyond the edge are stored without meaning. The mask skips both filters.
        ([0, 3], 0b11, chunk([4, -1, -1, 8, -1, -1])),
        ([2, 0], 0b11, chunk([9, -2, 11, -1, -1, -1])),
    ];
    Map {
        datatype: datatype::integer(2, true),
        shape: [3, 4],
        store: Store::Chunked([2, 3], pipeline(&[(2, 2), (1, 6)]), chunks),
        fill: 77_i16.to_be_bytes().to_vec(),
        no_data: Some((datatype::integer(2, true), 11_i16.to_be_bytes().to_vec())),
        ..Map::default()
    }
}

/// Six heights of every type and byte order.
fn of_every_type() -> Vec<Map> {
    let heights = [1, -2, 3, 4, -5, 6_i8];
    [
        (datatype::float(4, false), heights.map(f32::from).map(f32::to_le_bytes).concat()),
        (datatype::float(4, true), heights.map(f32::from).map(f32::to_be_bytes).concat()),
        (datatype::float(8, true), heights.map(f64::from).map(f64::to_be_bytes).concat()),
        (datatype::integer(2, false), heights.map(i16::from).map(i16::to_le_bytes).concat()),
        (datatype::integer(8, true), heights.map(i64::from).map(i64::to_be_bytes).concat()),
    ]
    .map(|(datatype, numbers)| Map { datatype, numbers, ..Map::default() })
    .into()
}

/// The usual heights in one chunk with its Fletcher-32 checksum, from bytes of which the sixth is changed afterwards.
fn summed(change: u8) -> Map {
    let numbers = Map::default().numbers;
    // Sums over big-endian words modulo 65535.
    let (mut first, mut second) = (0_u64, 0_u64);
    for word in numbers.chunks(2) {
        first = (first + u64::from(u16::from_be_bytes([word[0], word[1]]))) % 65535;
        second = (second + first) % 65535;
    }
    let mut bytes = bytes![numbers, (second << 16 | first).to_le_bytes()[..4]];
    bytes[5] ^= change;
    Map { store: Store::Chunked([2, 3], pipeline(&[(3, 0)]), vec![([0, 0], 0, bytes)]), ..Map::default() }
}

/// Heights in nm, k² modulo 257 for the point k in row order, in one compressed chunk. Long streams have codes of their own.
fn deflated(shape: [u64; 2]) -> Map {
    let numbers: Vec<u8> =
        (0..shape[0] * shape[1]).flat_map(|k| i16::try_from(k * k % 257).unwrap().to_le_bytes()).collect();
    let chunk = ([0, 0], 0, deflated_bytes(&numbers));
    Map {
        datatype: datatype::integer(2, false),
        shape,
        store: Store::Chunked(shape.map(|size| size as u32), pipeline(&[(1, 9)]), vec![chunk]),
        no_data: None,
        ..Map::default()
    }
}

/// The usual heights in a compact layout and in that of a single chunk.
fn of_other_layouts() -> [Map; 2] {
    let compact = |_: &mut Hdf5, numbers: &[u8]| bytes![[3_u8, 0], numbers.len() as u16, numbers];
    // Version 4: class, flags, rank, width of sizes, sizes, index 1, address; no filters.
    let single = |file: &mut Hdf5, numbers: &[u8]| {
        let address = file.append(numbers);
        bytes![[4_u8, 2, 0, 3, 1], [2_u8, 3, 8], [1_u8], address]
    };
    [compact as fn(&mut Hdf5, &[u8]) -> Vec<u8>, single]
        .map(|layout| Map { store: Store::Layout(layout), ..Map::default() })
}

/// Filters, indices of chunks and a version of the layout that are not read, and their names.
fn not_read() -> Vec<(Map, &'static str)> {
    let filter = |number| Store::Chunked([2, 3], pipeline(&[(number, 0)]), vec![]);
    // Version 4: class, flags, rank, width of sizes, sizes, index, bits of a page, address.
    let index = |kind| Store::Message(bytes![[4_u8, 2, 0, 3, 1], [2_u8, 3, 8], [kind, 10_u8], 104_u64]);
    [
        (filter(4), "filter 4 (szip)"),
        (filter(5), "filter 5 (n-bit)"),
        (filter(6), "filter 6 (scale-offset)"),
        (filter(307), "filter 307"),
        (index(2), "chunks under no index"),
        (index(3), "chunks under a fixed array"),
        (index(4), "chunks under an extensible array"),
        (index(5), "chunks under a version 2 B-tree"),
        (index(6), "chunks under an unknown index"),
        (Store::Message(vec![5, 1]), "layout, version"),
    ]
    .map(|(store, name)| (Map { store, ..Map::default() }, name))
    .into()
}

/// Maps stored in every way.
pub(crate) fn stored_in_every_way() -> Vec<Map> {
    let empty = Map { store: Store::Chunked([2, 2], vec![], vec![]), ..Map::default() };
    let usual = [Map::default(), empty, summed(0), summed(1), deflated([2, 3]), deflated([32, 24])];
    [usual.into(), of_every_type(), of_other_layouts().into(), not_read().into_iter().map(|(map, _)| map).collect()]
        .concat()
}

pub(crate) fn fixtures() -> Vec<Fixture> {
    // The end of the last structure, the group at the root, is its message: header, two addresses.
    vec![
        Fixture::whole("DATX of float64 in nm", file(&[Map::default()], Some(0), &system())),
        Fixture::whole("DATX of int32 in fringes", file(&[Map::fringes([1, 2, 3, 4, 5, i32::MAX])], None, &[])),
        Fixture::whole("DATX in chunks", one(chunked())),
    ]
}

/// Returns attributes of Mx on the instrument.
fn system() -> Vec<Message> {
    let stamp =
        datatype::compound(&[("Seconds", 4, datatype::integer(4, false)), ("Zone", 4, datatype::integer(4, false))]);
    vec![
        attribute("Data Context.Data Attributes.System Serial Number", &datatype::text(8), b"87266\0\0\0"),
        attribute("Data Context.Lateral Resolution:Value", &datatype::float(8, false), &4e-6_f64.to_le_bytes()),
        attribute("Data Context.Data Attributes.Camera Width", &datatype::integer(4, false), &1000_i32.to_le_bytes()),
        attribute("Data Context.Data Attributes.Time Stamp", &stamp, &bytes![1_500_000_000_i32, -60_i32]),
    ]
}

/// Asserts heights in nanometre.
#[track_caller]
fn assert_nm<const N: usize>(scan: &Scan, heights_nm: [f64; N]) {
    assert_heights(scan, &heights_nm.map(|z| z * 1e-9));
}

const HEIGHTS_NM: [f64; 6] = [100.0, -200.0, NAN, 400.0, 500.5, 600.0];

#[test]
fn heights_in_nanometre_lie_in_rows_from_the_top() {
    let heights = HEIGHTS_NM.map(|z| z * 1e-9);
    // The x converter counts along columns and the y converter along rows.
    let bytes = file(&[Map::default()], Some(0), &system());
    let scan = assert_scan(&bytes, Format::Datx, (2, 3), (1.5e-6, 2e-6), &heights);
    assert_eq!((scan.channels.as_slice(), scan.warnings.len()), (&["Surface".to_owned()][..], 0));
    let wanted = [
        ("Unit", "NanoMeters"),
        ("No Data", "1.7976931348623157e308"),
        ("X Converter", "Category LateralCat, BaseUnit Pixels, Parameters 0 1.5e-6 0 0"),
        ("Data Context.Data Attributes.System Serial Number", "87266"),
        ("Data Context.Data Attributes.Camera Width", "1000"),
        ("Data Context.Data Attributes.Time Stamp", "Seconds 1500000000, Zone -60"),
    ];
    assert_metadata(&scan, &wanted);
}

#[test]
fn units_of_length_are_spelt_as_in_mx() {
    for (unit, height_m) in [("Meters", 100.0), ("MilliMeters", 0.1), ("MicroMeters", 1e-4), ("nm", 1e-7)] {
        assert_eq!(read(Map { unit: Some(unit), ..Map::default() }).heights_m[[0, 0]], height_m, "{unit}");
    }
    let counts = one(Map { unit: Some("Counts"), ..Map::default() });
    assert_refused([(&counts, "Unit ("), (&counts, "`Counts`; wanted Fringes or a unit of length")]);
    // The unit of the converter applies if the dataset states none.
    assert_eq!(read(Map { unit: None, ..Map::default() }).heights_m[[0, 0]], 100e-9);
    let [x, y, _] = Map::default().converters;
    let converters = [x, y, Some(("HeightCat", "MicroMeters", [0.0; 4]))];
    let scan = read(Map { converters, ..Map::default() });
    assert_eq!(scan.heights_m[[0, 0]], 100e-9);
    assert!(scan.warnings[0].contains("NanoMeters was used"), "{:?}", scan.warnings);
}

#[test]
fn fringes_are_heights_by_wavelength_scale_and_obliquity() {
    // n · 600 nm · 0.5 · 0.75, from the parameters of the converter.
    let height = 600.0 * 0.5 * 0.75;
    let scan = read(Map::fringes([1, -2, 3, 4, 5, i32::MAX]));
    assert_nm(&scan, [1.0, -2.0, 3.0, 4.0, 5.0, NAN].map(|fringes| fringes * height));
    // The same from attributes, which go before the parameters.
    let factors = vec![("Wavelength", 5e-7), ("Interferometric Scale Factor", 0.25), ("Obliquity Factor", 2.0)];
    let [x, y, _] = Map::default().converters;
    for (z, warnings) in [(None, 0), (Some(("HeightCat", "Fringes", [0.0, 6e-7, 0.25, 2.0])), 1)] {
        let map = Map { factors: factors.clone(), converters: [x, y, z], ..Map::fringes([8, 0, 0, 0, 0, 0]) };
        let scan = read(map);
        assert!((scan.heights_m[[0, 0]] / 2e-6 - 1.0).abs() < 1e-15);
        assert_eq!(scan.warnings.len(), warnings);
        assert!(scan.warnings.iter().all(|one| one.starts_with("the Wavelength is 0.0000005, but")));
    }
    let unknown = Map { converters: [None, None, None], ..Map::fringes([1; 6]) };
    let zero = Map { factors: vec![("Wavelength", 0.0)], ..unknown.clone() };
    assert_refused([
        (one(unknown), "Wavelength is missing"),
        (one(zero), "is `0`; wanted a finite number other than 0"),
    ]);
}

#[test]
fn numbers_at_or_beyond_the_mark_have_no_data() {
    // A mark below zero is no limit.
    for (mark, numbers, missing) in [
        (Some(1000_i32), [999, 1000, 1001, -999, -1000, i32::MIN], [false, true, true, false, true, true]),
        (Some(-3), [1, -3, 3, 4, -4, 6], [false, true, false, false, false, false]),
        (None, [1, 2, 3, 4, 5, 6], [false; 6]),
    ] {
        let no_data = mark.map(|mark| (datatype::integer(4, false), mark.to_le_bytes().to_vec()));
        let scan = read(Map { no_data, ..Map::fringes(numbers) });
        assert!(scan.heights_m.iter().map(|z| z.is_nan()).eq(missing), "{mark:?}");
    }
}

#[test]
fn a_map_of_uncalibrated_pixels_takes_the_lateral_resolution_or_has_no_pitch() {
    let zero = Some(("LateralCat", "Pixels", [0.0; 4]));
    let map = Map { converters: [zero, zero, Map::default().converters[2]], ..Map::default() };
    let scan = read_bytes(&file(std::slice::from_ref(&map), Some(0), &system())).unwrap();
    assert_eq!(scan.pitch_m, Some((4e-6, 4e-6)));
    let scan = read(map);
    assert_eq!(scan.pitch_m, None);
    assert!(scan.warnings[0].contains("no lateral resolution"), "{:?}", scan.warnings);
}

#[test]
fn maps_of_heights_are_channels_and_the_measured_surface_is_the_first() {
    let first = |z: f64| z.to_le_bytes().iter().chain(&[0; 40]).copied().collect::<Vec<u8>>();
    let [x, y, _] = Map::default().converters;
    let intensity = Map {
        kind: "Intensity",
        unit: Some("Counts"),
        converters: [x, y, Some(("IntensityCat", "Counts", [0.0; 4]))],
        ..Map::default()
    };
    let maps = [
        Map { kind: "Bottom Surface", numbers: first(1.0), ..Map::default() },
        intensity.clone(),
        // Members are called {9}, {8}, …, so the table leads to the second of the two in the file's order.
        Map { numbers: first(2.0), ..Map::default() },
        Map { numbers: first(3.0), ..Map::default() },
    ];
    let bytes = file(&maps, Some(2), &[]);
    let scan = read_bytes(&bytes).unwrap();
    assert_eq!(scan.channels, ["Surface", "Surface 2", "Bottom Surface"]);
    assert_eq!((scan.heights_m[[0, 0]], scan.channel), (2e-9, 0));
    for (name, height_m) in [("Surface 2", 3e-9), ("Bottom Surface", 1e-9)] {
        assert_eq!(read_channel(&bytes, name).unwrap().heights_m[[0, 0]], height_m);
    }
    assert_error(read_channel(&bytes, "Intensity"), "no height map `Intensity`");
    assert_refused([(one(intensity), "DATX: the file holds no map of heights; wanted a surface under /Data")]);
    // Without the table the first surface is read.
    let other = Map { kind: "Bottom Surface", unit: Some("Meters"), ..Map::default() };
    let scan = read_bytes(&file(&[other, Map::default()], None, &[])).unwrap();
    assert_eq!(scan.channels, ["Surface", "Bottom Surface"]);
    assert_eq!(scan.heights_m[[0, 0]], 100e-9);
}

#[test]
fn numbers_in_every_type_layout_and_packing_are_read() {
    for map in of_every_type() {
        assert_nm(&read(map), [1.0, -2.0, 3.0, 4.0, -5.0, 6.0]);
    }
    for map in of_other_layouts() {
        assert_nm(&read(map), HEIGHTS_NM);
    }
    let scan = read(chunked());
    assert_eq!(scan.heights_m.dim(), (3, 4));
    // The last chunk was never written and holds the fill value; 11 and beyond is without data.
    assert_nm(&scan, [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, -2.0, NAN, NAN]);
    // Without a fill value there is zero where nothing was written.
    assert_nm(&read(Map { store: Store::Chunked([2, 2], vec![], vec![]), ..Map::default() }), [0.0; 6]);
    for shape in [[2, 3], [32, 24]] {
        let wanted: Vec<f64> = (0..shape[0] * shape[1]).map(|k| (k * k % 257) as f64 * 1e-9).collect();
        assert_heights(&read(deflated(shape)), &wanted);
    }
    assert_nm(&read(summed(0)), HEIGHTS_NM);
    assert_refused([(one(summed(1)), "the Fletcher-32 checksum does not fit")]);
}

#[test]
fn layouts_and_filters_that_are_not_read_are_named() {
    for (map, name) in not_read() {
        let message = read_bytes(&one(map)).unwrap_err().to_string();
        assert!(message.contains(name), "{message}");
        assert_eq!(message.contains("h5repack -l CONTI OLD NEW"), name.starts_with("chunks"), "{message}");
    }
    let bytes = one(Map::default());
    assert_refused([
        (patched(&bytes, 13, 4_u8), "DATX: the size of offsets (byte 13) is 4; wanted 8 bytes"),
        (patched(&bytes, 8, 9_u8), "DATX: superblock, version (byte 8) is `9`; wanted 0, 1, 2, 3"),
    ]);
}

#[test]
fn hdf5_files_of_other_programs_are_not_claimed() {
    let mut other = Hdf5::new();
    let root = other.group(&[("Results", 104)], &[]);
    assert_eq!(Format::detect(&other.finish(0, root)), Some(Format::NetCdf));
    assert_eq!(Format::detect(&one(Map::default())), Some(Format::Datx));
    // A root that cannot be read counts as damaged.
    assert_eq!(Format::detect(b"\x89HDF\r\n\x1a\n"), Some(Format::Datx));
}
