//! What can be wrong with the file of a profile.

/// What is wrong with the text of a profile, and where.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("line {line}: {fault}")]
pub struct ProfileError {
    /// Number of the line, counted from 1.
    pub line: usize,
    /// What is wrong there.
    pub fault: ProfileFault,
}

/// What is wrong in a line of a profile's file.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ProfileFault {
    /// The file ends before a value that must follow.
    #[error("the file ends before {expected}")]
    Ends {
        /// The value that is missing.
        expected: &'static str,
    },
    /// An IES file has no line that begins with `TILT=`, after which its numbers follow.
    #[error("no line begins with TILT=, so this is no IES file")]
    NoTilt,
    /// Something that must be a number is not a finite number.
    #[error("{what} is {found:?}, a number is needed")]
    NotANumber {
        /// The value that is read.
        what: &'static str,
        /// The text that was found.
        found: String,
    },
    /// A number is outside of its range.
    #[error("{what} is {found}, it must be {allowed}")]
    OutOfRange {
        /// The value that is read.
        what: &'static str,
        /// The number that was found.
        found: f64,
        /// The numbers that are allowed.
        allowed: &'static str,
    },
    /// An angle is not greater than the angle before it.
    #[error("{what} {found}° follows {previous}°, the angles must ascend")]
    NotAscending {
        /// The angles that are read.
        what: &'static str,
        /// The angle before it.
        previous: f64,
        /// The angle that was found.
        found: f64,
    },
    /// The range of the horizontal angles is none of those that the format knows.
    #[error("the horizontal angles go from {first}° to {last}°, they must go {allowed}")]
    Planes {
        /// The first horizontal angle.
        first: f64,
        /// The last horizontal angle.
        last: f64,
        /// The ranges that are allowed.
        allowed: &'static str,
    },
    /// The number of planes does not fit the symmetry of the file.
    #[error("{planes} C-planes cannot have the symmetry {symmetry}, {needed} are needed")]
    Symmetry {
        /// The number of planes of the whole circle.
        planes: usize,
        /// The symmetry indicator of the file.
        symmetry: usize,
        /// The numbers of planes that are allowed.
        needed: &'static str,
    },
    /// No intensity is greater than 0.
    #[error("no intensity is greater than 0, so the light would be dark")]
    Dark,
}

impl ProfileFault {
    /// The error of this fault in a line.
    pub(super) fn at(self, line: usize) -> ProfileError {
        ProfileError { line, fault: self }
    }
}
