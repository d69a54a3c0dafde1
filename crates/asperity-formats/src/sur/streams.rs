//! Numbers from zlib streams one after the other.

use flate2::read::ZlibDecoder;

use crate::archive::{CHUNK_BYTES, RESERVED_NUMBERS, damage, fill};
use crate::large;
use crate::sample::{ByteOrder, Sample};

/// Numbers that grow stream by stream; a number may go on in the next.
pub(super) struct Unpacked {
    sample: Sample,
    order: ByteOrder,
    chunk: Vec<u8>,
    /// Bytes at the start of the chunk that do not fill a number yet.
    kept: usize,
    pub(super) values: Vec<f64>,
}

impl Unpacked {
    /// No numbers yet, of `count` that are to come.
    pub(super) fn new(sample: Sample, order: ByteOrder, count: usize) -> Self {
        let values = large::with_capacity(count.min(RESERVED_NUMBERS));
        Self { sample, order, chunk: vec![0; CHUNK_BYTES], kept: 0, values }
    }

    /// Adds the numbers of a stream that should unpack to `size` bytes.
    ///
    /// # Errors
    /// What is wrong with the stream, in words.
    pub(super) fn add(&mut self, stream: &[u8], size: u64) -> Result<(), String> {
        let mut source = ZlibDecoder::new(stream);
        let mut left = size;
        while left > 0 {
            let room = (self.chunk.len() - self.kept).min(usize::try_from(left).unwrap_or(usize::MAX));
            let place = &mut self.chunk[self.kept..self.kept + room];
            let filled = fill(&mut source, place).map_err(|error| damage(&error))?;
            left -= filled as u64;
            if filled < room {
                return Err(format!("it unpacks to {} bytes, not to the stated {size}", size - left));
            }
            let end = self.kept + filled;
            let whole = end - end % self.sample.size();
            self.sample.decode(self.order, &self.chunk[..whole], &mut self.values);
            self.chunk.copy_within(whole..end, 0);
            self.kept = end - whole;
        }
        // Reading on to the end compares the checksum.
        match fill(&mut source, &mut [0]) {
            Ok(0) => Ok(()),
            Ok(_) => Err(format!("it unpacks to more than the stated {size} bytes")),
            Err(error) => Err(damage(&error)),
        }
    }
}
