//! Errors of commands, and their exit codes.

use std::error::Error;
use std::fmt;
use std::io;

use asperity::monitor::Cancelled;
use asperity::study::FailureKind;
pub(crate) use asperity_formats::chain;
use asperity_formats::refusal;

/// Error number of a failed device on Unix.
const EIO: i32 = 5;
/// Error numbers on Unix if the system or the program may open no further file: ENFILE, EMFILE.
const TOO_MANY_FILES: [i32; 2] = [23, 24];

/// Kind of an error; it determines the exit code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// An error while running, for example a file could not be written.
    Runtime,
    /// A flag, key, unit or value is wrong.
    Usage,
    /// Input data is missing, corrupt or unusable.
    Data,
    /// The computation did not converge, or too few samples are valid. The command has printed its answer all the same.
    NotConverged,
    /// Memory, disk or threads ran out.
    Resources,
    /// Stopped by the user.
    Cancelled,
}

impl Kind {
    /// Returns the exit code of the program.
    pub(crate) fn exit_code(self) -> u8 {
        match self {
            Self::Runtime => 1,
            Self::Usage => 2,
            Self::Data => 3,
            Self::NotConverged => 4,
            Self::Resources => 5,
            Self::Cancelled => 130,
        }
    }
}

/// Error of a command: its kind and one message for the user.
#[derive(Debug)]
pub(crate) struct Failure {
    kind: Kind,
    message: String,
}

impl Failure {
    pub(crate) fn new(kind: Kind, message: impl Into<String>) -> Self {
        Self { kind, message: message.into() }
    }

    /// Returns the error of a wrong flag, key or value.
    pub(crate) fn usage(cause: impl fmt::Display) -> Self {
        Self::new(Kind::Usage, cause.to_string())
    }

    /// Returns the error of unusable data in the file or object `what`.
    pub(crate) fn data(what: impl fmt::Display, cause: &dyn Error) -> Self {
        Self::new(Kind::Data, format!("{what}: {}", chain(cause)))
    }

    /// Returns the error of a failed read or write of `what`. A full disk and an unwritable place count as a lack of
    /// resources, a missing input as missing data.
    pub(crate) fn io(kind: Kind, what: impl fmt::Display, cause: &io::Error) -> Self {
        let kind = match cause.kind() {
            io::ErrorKind::StorageFull
            | io::ErrorKind::QuotaExceeded
            | io::ErrorKind::FileTooLarge
            | io::ErrorKind::OutOfMemory
            // No further thread.
            | io::ErrorKind::WouldBlock => Kind::Resources,
            io::ErrorKind::PermissionDenied
            | io::ErrorKind::ReadOnlyFilesystem
            | io::ErrorKind::NotADirectory
            | io::ErrorKind::AlreadyExists
                if kind == Kind::Runtime =>
            {
                Kind::Resources
            }
            _ if cause.raw_os_error().is_some_and(|code| TOO_MANY_FILES.contains(&code)) => Kind::Resources,
            // A disk that fails to write is a lack of one.
            _ if kind == Kind::Runtime && cause.raw_os_error() == Some(EIO) => Kind::Resources,
            _ => kind,
        };
        Self::new(kind, format!("{what}: {}", refusal(cause)))
    }

    /// Returns the end of a command by the user; `goes_on` states whether the same command goes on from finished blocks.
    pub(crate) fn cancelled(goes_on: bool) -> Self {
        let rest = if goes_on { "; the same command goes on from the finished blocks" } else { "" };
        Self::new(Kind::Cancelled, format!("cancelled{rest}"))
    }

    pub(crate) fn message(&self) -> &str {
        &self.message
    }

    pub(crate) fn kind(&self) -> Kind {
        self.kind
    }
}

impl From<FailureKind> for Kind {
    fn from(kind: FailureKind) -> Self {
        match kind {
            FailureKind::Configuration => Self::Usage,
            FailureKind::Input => Self::Data,
            FailureKind::NotConverged => Self::NotConverged,
            FailureKind::Cancelled => Self::Cancelled,
            FailureKind::Runtime => Self::Runtime,
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.kind {
            Kind::Cancelled => write!(f, "{}", self.message),
            _ => write!(f, "error: {}", self.message),
        }
    }
}

impl From<Cancelled> for Failure {
    fn from(_: Cancelled) -> Self {
        Self::cancelled(false)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_of_the_system_are_described_in_words() {
        for number in [2, 13, 28] {
            let failure = Failure::io(Kind::Data, "scan.x3p", &io::Error::from_raw_os_error(number));
            assert!(!failure.message().contains("os error"), "{failure}");
        }
        let gone = Failure::io(Kind::Data, "scan.x3p", &io::ErrorKind::NotFound.into());
        assert_eq!(gone.to_string(), "error: scan.x3p: no such file or folder");
        // An unwritable folder is a lack of resources; an unreadable input is missing data.
        for (kind, wanted) in [(Kind::Runtime, Kind::Resources), (Kind::Data, Kind::Data)] {
            assert_eq!(Failure::io(kind, "out", &io::ErrorKind::PermissionDenied.into()).kind(), wanted);
        }
    }
}
