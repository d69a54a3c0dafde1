//! Errors of the library as Python exceptions, by kind.

use std::error::Error;
use std::fmt::Display;
use std::io;

use asperity::study::{FailureKind, StoreError, StudyError, StudyFileError};
use asperity_formats::{FormatError, chain, refusal};
use pyo3::exceptions::{PyFileNotFoundError, PyKeyboardInterrupt, PyOSError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;

/// Exceptions that the Python package defines.
mod defined {
    pyo3::import_exception!(asperity.errors, FormatError);
    pyo3::import_exception!(asperity.errors, NotConvergedError);
    pyo3::import_exception!(asperity.errors, ResourceError);
}

pub(crate) use defined::{NotConvergedError, ResourceError};

/// Conversion of errors of the library.
pub(crate) trait Raise<T> {
    /// Returns the value, or the exception of the kind of the error.
    fn raise(self) -> PyResult<T>;
}

impl<T, E: Error + 'static> Raise<T> for Result<T, E> {
    fn raise(self) -> PyResult<T> {
        self.map_err(|error| exception(&error))
    }
}

/// Returns the exception of a wrong argument.
pub(crate) fn value_error(message: impl Display) -> PyErr {
    PyValueError::new_err(message.to_string())
}

/// Returns the exception of a damaged file.
pub(crate) fn format_error(message: impl Display) -> PyErr {
    defined::FormatError::new_err(message.to_string())
}

/// Returns the exception of an error.
pub(crate) fn exception(error: &(dyn Error + 'static)) -> PyErr {
    with_message(error, chain(error))
}

/// Returns the exception of the kind of an error: a wrong argument unless the error says otherwise.
pub(crate) fn with_message(error: &(dyn Error + 'static), message: String) -> PyErr {
    if let Some(error) = error.downcast_ref::<FormatError>() {
        return match error.cause() {
            FormatError::NotFound { .. } => PyFileNotFoundError::new_err(message),
            FormatError::Io { .. } => PyOSError::new_err(message),
            FormatError::UnknownUnit { .. } => value_error(message),
            error if error.asks_for_option() => value_error(message),
            _ => format_error(message),
        };
    }
    if let Some(StudyError::Scan(error)) = error.downcast_ref() {
        return with_message(error, message);
    }
    if let Some(StudyError::OneOf { error, .. } | StudyError::Counterface(error)) = error.downcast_ref() {
        return with_message(&**error, message);
    }
    if let Some(StudyFileError { in_data: true, .. }) = error.downcast_ref() {
        return format_error(message);
    }
    if let Some(StudyError::Blocks(error)) = error.downcast_ref() {
        return with_message(error, message);
    }
    if let Some(StoreError::Io { source, .. } | StoreError::Input { source, .. }) = error.downcast_ref() {
        return PyOSError::new_err((source.raw_os_error(), message));
    }
    match FailureKind::of(error) {
        FailureKind::Configuration | FailureKind::Input => value_error(message),
        FailureKind::NotConverged => NotConvergedError::new_err(message),
        FailureKind::Cancelled => PyKeyboardInterrupt::new_err(message),
        FailureKind::Runtime => PyRuntimeError::new_err(message),
    }
}

/// Returns the exception of a file that the operating system refused.
pub(crate) fn refused(path: impl Display, error: &io::Error) -> PyErr {
    PyOSError::new_err((error.raw_os_error(), format!("{path}: {}", refusal(error))))
}

/// Issues a warning at the line of the user.
pub(crate) fn warn(py: Python<'_>, message: &str) -> PyResult<()> {
    py.import("asperity.errors")?.call_method1("warn", (message,)).map(drop)
}
