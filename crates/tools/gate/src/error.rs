// SPDX-License-Identifier: MIT OR Apache-2.0
//! Why the gate cannot come to a verdict.

use std::path::PathBuf;
use terrafill_results::RunError;

/// Why the gate cannot come to a verdict. None of it is ever a pass.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GateError {
    /// What was given cannot be compared.
    #[error("{0}")]
    BadInput(String),
    /// A table that people write has a wrong row.
    #[error("{path}, row {row}: {message}")]
    Row {
        /// Which file.
        path: PathBuf,
        /// From 1, the header counted.
        row: usize,
        /// Found and allowed.
        message: String,
    },
    /// A file or a folder cannot be read or written.
    #[error("{path}: {source}")]
    Io {
        /// Which.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A run folder.
    #[error(transparent)]
    Run(#[from] RunError),
    /// A program that was started did not end well.
    #[error("{what}: {message}")]
    Program {
        /// Which program, doing what.
        what: String,
        /// Its status and what it said last.
        message: String,
    },
    /// The machine failed, and nothing that is compared: a build of the base, a full disk.
    #[error("{what}: {message}")]
    Infrastructure {
        /// What was being done.
        what: String,
        /// What came of it.
        message: String,
    },
    /// Both sides cannot be brought to do the same work.
    #[error("inconclusive: {0}")]
    Inconclusive(String),
    /// A program found no device.
    #[error("no usable device: {0}")]
    NoDevice(String),
    /// Nothing was there to be compared.
    #[error("nothing measured: {0}")]
    NothingMeasured(String),
}

impl GateError {
    /// The exit code of a command that ends with it.
    #[must_use]
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Inconclusive(_) => 3,
            Self::NothingMeasured(_) => 4,
            Self::NoDevice(_) => 5,
            Self::Infrastructure { .. } => 6,
            Self::Io { source, .. } | Self::Run(RunError::Io { source, .. })
                if is_of_machine(source) =>
            {
                6
            }
            _ => 2,
        }
    }

    /// The same failure of a program as one of the machine: a base that does not build says nothing of what is
    /// compared with it.
    #[must_use]
    pub fn of_machine(self) -> Self {
        match self {
            Self::Program { what, message } => Self::Infrastructure { what, message },
            other => other,
        }
    }

    pub(crate) fn io(path: impl Into<PathBuf>) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.into();
        move |source| Self::Io { path, source }
    }
}

/// Whether a machine has no room or no memory left.
fn is_of_machine(error: &std::io::Error) -> bool {
    use std::io::ErrorKind::{
        FileTooLarge, OutOfMemory, QuotaExceeded, ReadOnlyFilesystem, StorageFull, WriteZero,
    };
    let of_machine = [
        FileTooLarge,
        OutOfMemory,
        QuotaExceeded,
        ReadOnlyFilesystem,
        StorageFull,
        WriteZero,
    ];
    of_machine.contains(&error.kind())
}

/// Whether a program says that it ended for such a reason: each ends its message with the number that the system
/// gives, also one that was built long ago.
pub(crate) fn says_machine_failed(line: &str) -> bool {
    let number = line
        .rsplit_once("(os error ")
        .and_then(|(_, rest)| rest.split_once(')'));
    let number = number.and_then(|(number, _)| number.parse().ok());
    number.is_some_and(|number| is_of_machine(&std::io::Error::from_raw_os_error(number)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{Error, ErrorKind};

    #[test]
    fn a_full_disk_and_a_base_that_does_not_build_are_of_the_machine_and_a_missing_file_is_not() {
        let io = |kind: ErrorKind| GateError::io("a")(Error::from(kind)).exit_code();
        assert_eq!(
            [io(ErrorKind::StorageFull), io(ErrorKind::FileTooLarge)],
            [6, 6]
        );
        assert_eq!(
            [io(ErrorKind::NotFound), io(ErrorKind::PermissionDenied)],
            [2, 2]
        );
        let program = || GateError::Program {
            what: "cargo build".to_owned(),
            message: "exit status: 101".to_owned(),
        };
        assert_eq!(
            [program().exit_code(), program().of_machine().exit_code()],
            [2, 6]
        );
        assert_eq!(
            GateError::BadInput("revision".to_owned())
                .of_machine()
                .exit_code(),
            2
        );
        assert!(says_machine_failed(
            "error: out/x.csv: No space left on device (os error 28)"
        ));
        assert!(!says_machine_failed(
            "error: x: No such file or directory (os error 2)"
        ));
        assert!(!says_machine_failed("28 pixels differ"));
    }
}
