//! Images of an FRT file.

use crate::{Input, Result, Sample, Shape, refuse_if, warn_if};

/// Size in bytes of the description of the current image, before the first image of block 0x007d.
const IMAGES_HEADER_BYTES: usize = 8;
/// Size in bytes of the header of an image in block 0x007d.
const IMAGE_HEADER_BYTES: usize = 16;
/// Lower bits of the type of a topography.
pub(super) const TOPOGRAPHY: u32 = 0x0004;
/// Content of an image by the lower bits of its type.
const KINDS: [(u32, &str); 4] =
    [(TOPOGRAPHY, "Topography"), (0x0080, "Thickness"), (0x0800, "Sample thickness"), (0x1000, "AFM")];
/// Bits of a type that define the content.
const KIND_MASK: u32 = 0xffdf;
/// Flags of a type.
const FLAGS: [(u32, &str); 3] = [(0x1_0000, "extended"), (0x2_0000, "computed"), (0x20, "filtered")];

/// Image and the place of its numbers.
#[derive(Clone, Copy)]
pub(super) struct Image<'a> {
    kind: u32,
    pub(super) shape: Shape,
    pub(super) sample: Sample,
    pub(super) numbers: Input<'a>,
}

impl<'a> Image<'a> {
    /// Reads the size of an image from the start of `size` and checks that `numbers` hold as many points.
    pub(super) fn new(kind: u32, size: Input, numbers: Input<'a>) -> Result<Self> {
        let [x, y, bits] = ["points along x", "points along y", "bits per point"];
        let shape = size.shape((y, 4, size.u32(y, 4)?), (x, 0, size.u32(x, 0)?))?;
        let sample = match size.u32(bits, 8)? {
            16 => Sample::U16,
            32 => Sample::I32,
            found => return Err(size.wrong(bits, 8, found, "16 or 32")),
        };
        let image = Self { kind, shape, sample, numbers };
        numbers.take("the numbers of an image", 0, image.bytes())?;
        Ok(image)
    }

    /// Returns the size of the numbers in bytes.
    pub(super) fn bytes(&self) -> usize {
        self.shape.0 * self.shape.1 * self.sample.size()
    }

    /// Returns whether the image is a topography.
    pub(super) fn is_topography(&self) -> bool {
        self.kind & KIND_MASK == TOPOGRAPHY
    }

    /// Returns the name of the image; `None` if its values are not lengths.
    pub(super) fn name(&self) -> Option<String> {
        let (_, kind) = KINDS.into_iter().find(|(kind, _)| self.kind & KIND_MASK == *kind)?;
        let sensor = match self.kind >> 28 & 3 {
            0 => "top sensor".to_owned(),
            1 => "bottom sensor".to_owned(),
            other => format!("sensor {}", other + 1),
        };
        let buffer = (self.kind >> 24 & 0xf) + 1;
        let flags = FLAGS.iter().filter(|(flag, _)| self.kind & flag != 0);
        Some(flags.fold(format!("{kind} ({sensor}) {buffer}"), |name, (_, flag)| name + ", " + flag))
    }
}

/// Maximum number of images of a file. Sensors have at most sixteen buffers.
const MAX_IMAGES: usize = 1 << 12;

/// Returns all images of block 0x007d.
pub(super) fn images<'a>(block: Input<'a>, warnings: &mut Vec<String>) -> Result<Vec<Image<'a>>> {
    let mut images = Vec::new();
    let mut offset = IMAGES_HEADER_BYTES;
    while offset + IMAGE_HEADER_BYTES < block.len() {
        let kind = block.u32("type of an image", offset)?;
        let image = Image::new(kind, block.from(offset + 4), block.from(offset + IMAGE_HEADER_BYTES))?;
        offset += IMAGE_HEADER_BYTES + image.bytes();
        images.push(image);
        refuse_if!(images.len() > MAX_IMAGES, block.too_large("the number of images", 0, images.len(), MAX_IMAGES));
    }
    warn_if!(warnings, offset < block.len(), "{} bytes after the last image were left out", block.len() - offset);
    Ok(images)
}
