//! Objects of a file: their parts and numbers.

use super::header::{COMMENT_BYTES, HEADER_BYTES, Header, OBJECT_TYPE, PRIVATE_BYTES, SIGNATURE_COMPRESSED, is_object};
use crate::archive::{beyond_reason, damaged, may_hold, unpack};
use crate::{Format, Input, Result, Sample, refuse_if};

/// Maximum number of streams of one object. Writers use one, or one per processor.
const MAX_STREAMS: u32 = 1 << 10;
/// Size in bytes of the number of streams, and of the sizes of one.
const COUNT_BYTES: usize = 4;
const SIZES_BYTES: usize = 8;

/// Returns the published name of an object type: `Ok` for surfaces, `Err` for other types.
pub(super) fn kind(code: i16) -> Result<&'static str, &'static str> {
    match code {
        0 => Ok("an object of unknown type"),
        1 => Ok("a profile"),
        2 => Ok("a surface"),
        5 => Ok("a series of surfaces"),
        8 => Ok("a multilayer surface"),
        11 => Ok("a surface with intensity"),
        13 => Ok("a surface with colours"),
        16 => Ok("a surface with colours and intensity"),
        3 => Err("a binary image"),
        4 => Err("a series of profiles"),
        6 => Err("a meridian disc"),
        7 => Err("a multilayer profile"),
        9 => Err("a parallel disc"),
        10 => Err("an intensity image"),
        12 => Err("a colour image"),
        14 | 15 => Err("force curves"),
        17 => Err("a contour"),
        18 => Err("a series of colour images"),
        20 => Err("a spectrum"),
        21 => Err("a hyperspectral map"),
        _ => Err("an object of a type that is not published"),
    }
}

/// Returns whether an object of a type is a surface with images of it in the following objects.
pub(super) fn is_followed_by_images(code: i16) -> bool {
    matches!(code, 11 | 13 | 16)
}

/// Object of a file.
pub(super) struct Object<'a> {
    pub(super) header: Header<'a>,
    pub(super) code: i16,
    pub(super) ny: usize,
    pub(super) nx: usize,
    sample: Sample,
    /// Offsets of the private zone and of the numbers from the start of the object.
    private_start: usize,
    data_start: usize,
    /// Number of zlib streams; `None` for plain numbers.
    streams: Option<usize>,
    /// Sizes of all streams in bytes, unpacked and packed.
    raw: u64,
    packed: u64,
    /// Size of the object in bytes.
    end: usize,
}

impl<'a> Object<'a> {
    /// Opens an object and checks that all of its bytes are present.
    fn open(header: Header<'a>) -> Result<Self> {
        let input = header.input;
        let sample = header.sample()?;
        let (ny, nx) = header.shape()?;
        let private_start = HEADER_BYTES + usize::from(input.u16(COMMENT_BYTES.0, COMMENT_BYTES.1)?);
        let data_start = private_start + usize::from(input.u16(PRIVATE_BYTES.0, PRIVATE_BYTES.1)?);
        let (code, streams, raw, packed, end) = (header.i16(OBJECT_TYPE)?, None, 0, 0, data_start);
        let object = Self { header, code, ny, nx, sample, private_start, data_start, streams, raw, packed, end };
        if input.bytes.starts_with(SIGNATURE_COMPRESSED) {
            return object.with_directory();
        }
        let data = input.take("the heights", data_start, nx * ny * sample.size())?;
        Ok(Self { end: data_start + data.len(), ..object })
    }

    /// Adds the directory of the streams.
    fn with_directory(self) -> Result<Self> {
        let input = self.header.input;
        let count = input.u32("number of streams", self.data_start)?;
        refuse_if!(count > MAX_STREAMS, input.wrong("number of streams", self.data_start, count, "1024 or less"));
        let streams = count as usize;
        let mut object = Self { streams: Some(streams), ..self };
        object.end = object.streams_start(streams);
        for number in 0..streams {
            let (raw, bytes) = object.stream(number, object.end)?;
            object.raw += raw;
            object.packed += bytes.len() as u64;
            object.end += bytes.len();
        }
        Ok(object)
    }

    /// Returns the offset of the first stream.
    fn streams_start(&self, streams: usize) -> usize {
        self.data_start + COUNT_BYTES + SIZES_BYTES * streams
    }

    /// Returns the unpacked size of a stream, and its packed bytes, which start at `start`.
    fn stream(&self, number: usize, start: usize) -> Result<(u64, &'a [u8])> {
        let input = self.header.input;
        let sizes = self.data_start + COUNT_BYTES + SIZES_BYTES * number;
        let raw = input.u32("size of a stream", sizes)?;
        let packed = input.u32("packed size of a stream", sizes + SIZES_BYTES / 2)?;
        let packed = usize::try_from(packed).unwrap_or(usize::MAX);
        Ok((raw.into(), input.take("the bytes of a stream", start, packed)?))
    }

    /// Returns the comment.
    pub(super) fn comment(&self) -> Result<String> {
        self.header.input.latin1("comment", HEADER_BYTES, self.private_start - HEADER_BYTES)
    }

    /// Returns the stored numbers.
    pub(super) fn numbers(&self) -> Result<Vec<f64>> {
        let count = self.nx * self.ny;
        let Some(streams) = self.streams else {
            return self.header.input.samples("the heights", self.data_start, count, self.sample);
        };
        let wanted = (count * self.sample.size()) as u64;
        if self.raw != wanted {
            let (first, wanted) = (self.data_start + COUNT_BYTES, format!("{wanted} bytes for {count} points"));
            return Err(self.header.input.wrong("size of all streams", first, self.raw, &wanted));
        }
        if !may_hold(self.packed, count as u64, self.sample) {
            return Err(beyond_reason(Format::Sur, "the heights", self.packed, wanted));
        }
        // A number may begin in one stream and end in the next.
        let (mut bytes, mut start) = (Vec::new(), self.streams_start(streams));
        for number in 0..streams {
            let (size, stream) = self.stream(number, start)?;
            start += stream.len();
            let name = format!("stream {}", number + 1);
            unpack(stream, size, &mut bytes).map_err(|reason| damaged(Format::Sur, &name, reason))?;
        }
        Ok(self.sample.decode_all(self.header.order, &bytes))
    }
}

/// Returns the objects of a file, and a warning if bytes remain after them.
///
/// `check` checks the first header before the rest of the object is read.
///
/// # Errors
/// The error of the first object. A later damaged object ends the list.
pub(super) fn objects<'a>(
    input: Input<'a>,
    check: impl Fn(&Header) -> Result<()>,
) -> Result<(Vec<Object<'a>>, Option<String>)> {
    let header = Header::open(input)?;
    check(&header)?;
    let first = Object::open(header)?;
    let mut end = first.end;
    let mut objects = vec![first];
    // `end` grows by at least a header and stays within the file.
    while is_object(&input.bytes[end..]) {
        match Header::open(input.from(end)).and_then(Object::open) {
            Ok(object) => {
                end += object.end;
                objects.push(object);
            }
            Err(error) => return Ok((objects, Some(format!("the bytes after the objects were left out: {error}")))),
        }
    }
    let left = input.len() - end;
    Ok((objects, (left > 0).then(|| format!("{left} bytes after the last object were left out"))))
}
