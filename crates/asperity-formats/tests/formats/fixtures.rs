//! Small files, each assembled field by field from the description of its format.

use std::io::Write;

use md5::{Digest, Md5};

use crate::check::{Raw, bytes};
use crate::fixture::Content;

/// CRC-32 of the zip format (polynomial 0xEDB88320), bit by bit.
fn crc32(bytes: &[u8]) -> u32 {
    let mut crc = u32::MAX;
    for &byte in bytes {
        crc ^= u32::from(byte);
        for _ in 0..8 {
            crc = if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 };
        }
    }
    !crc
}

/// A zip archive that stores its files unpacked (PKWARE APPNOTE 4.3.7, 4.3.12, 4.3.16).
pub(crate) fn zip(files: &[(&str, &[u8])]) -> Vec<u8> {
    let (mut bytes, mut directory) = (Vec::new(), Vec::new());
    for (name, content) in files {
        let offset = bytes.len() as u32;
        // Version 2.0, no flags, stored, 1980-01-01 00:00.
        let mut common: Vec<u8> = vec![20, 0, 0, 0, 0, 0, 0, 0, 0x21, 0];
        common.extend(crc32(content).to_le_bytes());
        common.extend((content.len() as u32).to_le_bytes());
        common.extend((content.len() as u32).to_le_bytes());
        common.extend((name.len() as u16).to_le_bytes());
        common.extend([0, 0]);
        bytes.extend(b"PK\x03\x04");
        bytes.extend(&common);
        bytes.extend(name.as_bytes());
        bytes.extend(*content);
        directory.extend(b"PK\x01\x02\x14\x00");
        directory.extend(&common);
        // No comment, disk 0, no attributes.
        directory.extend([0; 10]);
        directory.extend(offset.to_le_bytes());
        directory.extend(name.as_bytes());
    }
    let start = bytes.len() as u32;
    bytes.extend(&directory);
    bytes.extend(b"PK\x05\x06\x00\x00\x00\x00");
    bytes.extend((files.len() as u16).to_le_bytes());
    bytes.extend((files.len() as u16).to_le_bytes());
    bytes.extend((directory.len() as u32).to_le_bytes());
    bytes.extend(start.to_le_bytes());
    bytes.extend([0, 0]);
    bytes
}

/// A gzip stream that stores its content unpacked (RFC 1952 around stored blocks of RFC 1951).
pub(crate) fn gzip(content: &[u8]) -> Vec<u8> {
    // Magic, deflate, no flags, no time, no extra flags, unknown system.
    let mut bytes = vec![0x1f, 0x8b, 8, 0, 0, 0, 0, 0, 0, 255];
    for block in content.chunks(0xffff) {
        bytes.push(0);
        bytes.extend((block.len() as u16).to_le_bytes());
        bytes.extend((!(block.len() as u16)).to_le_bytes());
        bytes.extend(block);
    }
    // An empty last block.
    bytes.extend([1, 0, 0, 0xff, 0xff]);
    bytes.extend(crc32(content).to_le_bytes());
    bytes.extend((content.len() as u32).to_le_bytes());
    bytes
}

/// A zlib stream that stores its content unpacked (RFC 1950 around a stored block of RFC 1951).
pub(crate) fn zlib(content: &[u8]) -> Vec<u8> {
    // Deflate with a window of 32 KiB; check bits that make the two bytes a multiple of 31.
    let mut bytes = vec![0x78, 0x01];
    // One last block.
    bytes.push(1);
    bytes.extend((content.len() as u16).to_le_bytes());
    bytes.extend((!(content.len() as u16)).to_le_bytes());
    bytes.extend(content);
    let (mut low, mut high) = (1_u32, 0_u32);
    for &byte in content {
        low = (low + u32::from(byte)) % 65521;
        high = (high + low) % 65521;
    }
    bytes.extend((high << 16 | low).to_be_bytes());
    bytes
}

/// A zlib stream that packs its content.
pub(crate) fn deflated(content: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
    encoder.write_all(content).unwrap();
    encoder.finish().unwrap()
}

pub(crate) fn md5(bytes: &[u8]) -> String {
    Md5::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Variable parts of an X3P file. The rest is as in the samples of openGPS.
pub(crate) struct X3p {
    pub(crate) feature: &'static str,
    pub(crate) x_axis_type: &'static str,
    pub(crate) z_axis: &'static str,
    pub(crate) size: (u64, u64, u64),
    pub(crate) data: Vec<u8>,
    pub(crate) valid: Option<Vec<u8>>,
    pub(crate) folder: &'static str,
}

impl Default for X3p {
    fn default() -> Self {
        Self {
            feature: "SUR",
            x_axis_type: "I",
            z_axis: "<AxisType>A</AxisType><DataType>D</DataType>",
            size: (2, 2, 1),
            data: [1e-6_f64, 2e-6, 3e-6, 4e-6].iter().flat_map(|z| z.to_le_bytes()).collect(),
            valid: None,
            folder: "",
        }
    }
}

impl X3p {
    pub(crate) fn main_xml(&self) -> String {
        let valid = self.valid.as_ref().map(|valid| {
            let md5 = md5(valid).to_uppercase();
            format!("<ValidPointsLink>bindata/valid.bin</ValidPointsLink><MD5ChecksumValidPoints>{md5}</MD5ChecksumValidPoints>")
        });
        format!(
            r#"<?xml version="1.0" encoding="UTF-8"?>
<p:ISO5436_2 xmlns:p="http://www.opengps.eu/2008/ISO5436_2">
  <Record1>
    <Revision>ISO5436 - 2000</Revision>
    <FeatureType>{}</FeatureType>
    <Axes>
      <CX><AxisType>{}</AxisType><DataType>D</DataType><Increment>2.5E-0006</Increment><Offset>1e-3</Offset></CX>
      <CY><AxisType>I</AxisType><DataType>D</DataType><Increment> 5e-6 </Increment><Offset/></CY>
      <CZ>{}</CZ>
    </Axes>
  </Record1>
  <Record2>
    <Date>2007-04-30T13:58:02.6+02:00</Date>
    <Instrument><Manufacturer>Meyer &amp; S&#246;hne</Manufacturer><Model>µSurf</Model></Instrument>
    <Comment><![CDATA[a < b]]></Comment>
  </Record2>
  <Record3>
    <MatrixDimension><SizeX>{}</SizeX><SizeY>{}</SizeY><SizeZ>{}</SizeZ></MatrixDimension>
    <DataLink>
      <PointDataLink>bindata/data.bin</PointDataLink>
      <MD5ChecksumPointData>{}</MD5ChecksumPointData>{}
    </DataLink>
  </Record3>
  <Record4><ChecksumFile>md5checksum.hex</ChecksumFile></Record4>
</p:ISO5436_2>
"#,
            self.feature,
            self.x_axis_type,
            self.z_axis,
            self.size.0,
            self.size.1,
            self.size.2,
            md5(&self.data).to_uppercase(),
            valid.unwrap_or_default(),
        )
    }

    /// The files of the archive, with any `main.xml` in place of its own.
    pub(crate) fn files(&self, main: &[u8]) -> Vec<(String, Vec<u8>)> {
        let name = |file: &str| format!("{}{file}", self.folder);
        let mut files = vec![(name("main.xml"), main.to_vec()), (name("bindata/data.bin"), self.data.clone())];
        files.extend(self.valid.clone().map(|valid| (name("bindata/valid.bin"), valid)));
        files.push((name("md5checksum.hex"), format!("{} *main.xml", md5(main)).into_bytes()));
        files
    }

    /// The archive, with any `main.xml` in place of its own.
    pub(crate) fn with_main(&self, main: &[u8]) -> Vec<u8> {
        Content::Zip(self.files(main)).bytes()
    }

    pub(crate) fn bytes(&self) -> Vec<u8> {
        self.with_main(self.main_xml().as_bytes())
    }
}

/// Variable parts of an object of a SUR file. The rest is as written by MountainsMap.
#[derive(Clone)]
pub(crate) struct Sur {
    pub(crate) signature: &'static [u8; 12],
    pub(crate) big_endian: bool,
    pub(crate) objects: i16,
    pub(crate) object_type: i16,
    pub(crate) name: &'static [u8],
    pub(crate) special_points: i16,
    pub(crate) bits: i16,
    pub(crate) z_range: (i32, i32),
    pub(crate) size: (i32, i32),
    pub(crate) spacing: [f32; 3],
    pub(crate) units: [&'static [u8]; 3],
    pub(crate) z_offset: f32,
    pub(crate) comment: &'static [u8],
    pub(crate) private: &'static [u8],
    pub(crate) data: Vec<u8>,
    /// Where the data of a compressed object are cut into streams.
    pub(crate) cuts: &'static [usize],
}

impl Default for Sur {
    fn default() -> Self {
        let heights: [i16; 6] = [100, 200, 98, -300, 400, 500];
        Self {
            signature: b"DIGITAL SURF",
            big_endian: false,
            objects: 1,
            object_type: 2,
            name: b"gear 7",
            special_points: 1,
            bits: 16,
            z_range: (100, 500),
            size: (3, 2),
            spacing: [0.5, 0.25, 2.0],
            units: [b"\xb5m", b"mm", b"nm"],
            z_offset: 1000.0,
            comment: b"hob ground, \xb5 = 0.1",
            private: b"\x00\x01\x02",
            data: heights.iter().flat_map(|z| z.to_le_bytes()).collect(),
            cuts: &[],
        }
    }
}

/// Numbers in either order of bytes, one after the other.
struct Numbers {
    bytes: Vec<u8>,
    big_endian: bool,
}

impl Numbers {
    fn put<T: Raw>(&mut self, numbers: &[T]) {
        for number in numbers {
            let mut number = bytes![number];
            if self.big_endian {
                number.reverse();
            }
            self.bytes.extend(number);
        }
    }

    fn zeros(&mut self, count: usize) {
        self.bytes.extend(vec![0; count]);
    }

    fn padded(&mut self, text: &[u8], width: usize) {
        self.bytes.extend(text);
        self.bytes.extend(vec![b' '; width - text.len()]);
    }
}

impl Sur {
    /// The compressed form of an object with the same heights.
    pub(crate) fn compressed(self, cuts: &'static [usize]) -> Self {
        Self { signature: b"DSCOMPRESSED", cuts, ..self }
    }

    /// The heights as the file holds them: as they are, or as a directory and streams.
    fn heights(&self) -> Vec<u8> {
        if self.signature == b"DIGITAL SURF" {
            return self.data.clone();
        }
        let mut directory = Numbers { bytes: Vec::new(), big_endian: self.big_endian };
        let mut streams = Vec::new();
        directory.put(&[self.cuts.len() as i32 + 1]);
        let mut start = 0;
        for end in self.cuts.iter().copied().chain([self.data.len()]) {
            let stream = zlib(&self.data[start..end]);
            directory.put(&[(end - start) as i32, stream.len() as i32]);
            streams.extend(stream);
            start = end;
        }
        [directory.bytes, streams].concat()
    }

    /// The fields of the header one after the other, in the order and with the widths of the published layout.
    pub(crate) fn bytes(&self) -> Vec<u8> {
        let heights = self.heights();
        let mut file = Numbers { bytes: self.signature.to_vec(), big_endian: self.big_endian };
        // Format (PC, or the other order), number of objects, version, type.
        file.put(&[if self.big_endian { 257 } else { 0_i16 }, self.objects, 1, self.object_type]);
        file.padded(self.name, 30);
        file.padded(b"A. Operator", 30);
        // Channels, acquisition type (stylus), range type.
        file.put(&[0_i16, 1, 0]);
        // Special points, absolute heights.
        file.put(&[self.special_points, 1]);
        // Gauge resolution, points of a spectrum.
        file.zeros(8);
        file.put(&[self.bits]);
        file.put(&[self.z_range.0, self.z_range.1, self.size.0, self.size.1, self.size.0.wrapping_mul(self.size.1)]);
        file.put(&self.spacing);
        for name in [b"X", b"Y", b"Z"] {
            file.padded(name, 16);
        }
        // Units of steps, then of lengths: the same here, so the ratios are 1.
        for unit in self.units.iter().chain(&self.units) {
            file.padded(unit, 16);
        }
        file.put(&[1_f32; 3]);
        // Imprint, inverted, levelled, 12 obsolete bytes.
        file.zeros(18);
        file.put(&[59_i16, 30, 14, 1, 12, 2016, 4]);
        file.put(&[12.5_f32]);
        // Size of compressed data and 6 obsolete bytes.
        file.put(&[if self.signature == b"DIGITAL SURF" { 0_i32 } else { heights.len() as i32 }]);
        file.zeros(6);
        file.put(&[self.comment.len() as i16, self.private.len() as i16]);
        file.padded(b"a program", 128);
        file.put(&[0.0, 0.0, self.z_offset]);
        // Temperature axis: spacing, offset, unit, name.
        file.zeros(34);
        assert_eq!(file.bytes.len(), 512);
        [&file.bytes, self.comment, self.private, &heights].concat()
    }
}

/// A NumPy file with any version and header text.
pub(crate) fn npy(version: u8, header: &str, data: &[u8]) -> Vec<u8> {
    let mut bytes = b"\x93NUMPY".to_vec();
    bytes.extend([version, 0]);
    match version {
        1 => bytes.extend((header.len() as u16).to_le_bytes()),
        _ => bytes.extend((header.len() as u32).to_le_bytes()),
    }
    bytes.extend(header.as_bytes());
    bytes.extend(data);
    bytes
}

pub(crate) const TEXT: &[u8] = b"# instrument: stylus\n1e-6, 2e-6, nan\n-1e-6, , inf % two missing\n";
