//! The formats and how they are told apart.

/// Bytes that are looked at to tell text from binary data.
const TEXT_PROBE: usize = 4096;

/// A file format for measured surfaces.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Format {
    /// X3P, ISO 25178-72: a zip archive of an XML description and binary heights.
    X3p,
    /// Digital Surf SUR: a header of 512 bytes and integer heights.
    Sur,
    /// NumPy array file.
    Npy,
    /// Matrix of numbers as text.
    Text,
}

impl Format {
    /// The name for the user.
    pub fn name(self) -> &'static str {
        match self {
            Self::X3p => "X3P",
            Self::Sur => "SUR",
            Self::Npy => "NPY",
            Self::Text => "text",
        }
    }

    /// Whether files of this format state how far apart their points are.
    pub fn stores_pitch(self) -> bool {
        matches!(self, Self::X3p | Self::Sur)
    }

    /// The format of a file's content, by its first bytes; `None` for binary content of no known format.
    ///
    /// Every zip archive counts as X3P and everything without control characters as text: whether they hold heights is
    /// found out by reading them.
    pub fn detect(bytes: &[u8]) -> Option<Self> {
        if bytes.starts_with(b"PK\x03\x04") {
            Some(Self::X3p)
        } else if bytes.starts_with(crate::sur::SIGNATURE) || bytes.starts_with(crate::sur::SIGNATURE_COMPRESSED) {
            Some(Self::Sur)
        } else if bytes.starts_with(crate::npy::MAGIC) {
            Some(Self::Npy)
        } else {
            let probe = &bytes[..bytes.len().min(TEXT_PROBE)];
            let is_text = |&byte: &u8| byte >= 0x20 && byte != 0x7f || matches!(byte, b'\t' | b'\n' | b'\r' | 0x0c);
            (!probe.is_empty() && probe.iter().all(is_text)).then_some(Self::Text)
        }
    }

    /// The format that is usually stored under an extension (without its dot, in any case).
    pub fn from_extension(extension: &str) -> Option<Self> {
        match extension.to_ascii_lowercase().as_str() {
            "x3p" => Some(Self::X3p),
            "sur" => Some(Self::Sur),
            "npy" => Some(Self::Npy),
            "txt" | "dat" | "csv" => Some(Self::Text),
            _ => None,
        }
    }
}
