//! Reading of numbers from the text of a profile. Each number knows its line.

use super::error::{ProfileError, ProfileFault};

/// The largest number of angles along one axis.
pub(super) const MOST_ANGLES: f64 = 7201.0;

/// A number and the line in which it stands.
#[derive(Clone, Copy, Debug)]
pub(super) struct Number {
    pub value: f64,
    pub line: usize,
}

impl Number {
    /// Checks that the number is a whole number between `least` and `most`.
    pub fn count(
        self,
        what: &'static str,
        least: f64,
        most: f64,
        allowed: &'static str,
    ) -> Result<usize, ProfileError> {
        let is_count = self.value.fract() == 0.0 && (least..=most).contains(&self.value);
        if is_count {
            Ok(self.value as usize)
        } else {
            Err(self.out_of_range(what, allowed))
        }
    }

    /// Checks that the number is in a range.
    pub fn within(
        self,
        what: &'static str,
        range: std::ops::RangeInclusive<f64>,
        allowed: &'static str,
    ) -> Result<f64, ProfileError> {
        if range.contains(&self.value) {
            Ok(self.value)
        } else {
            Err(self.out_of_range(what, allowed))
        }
    }

    fn out_of_range(self, what: &'static str, allowed: &'static str) -> ProfileError {
        let found = self.value;
        ProfileFault::OutOfRange { what, found, allowed }.at(self.line)
    }
}

/// Parses one number. A decimal comma counts as a point.
pub(super) fn parse(what: &'static str, text: &str, line: usize) -> Result<Number, ProfileError> {
    let text = text.trim();
    let parsed = if text.contains(',') {
        text.replacen(',', ".", 1).parse::<f64>()
    } else {
        text.parse::<f64>()
    };
    match parsed {
        Ok(value) if value.is_finite() => Ok(Number { value, line }),
        _ => {
            let found = text.chars().take(40).collect();
            Err(ProfileFault::NotANumber { what, found }.at(line))
        }
    }
}

/// Checks that angles ascend.
pub(super) fn ascending(what: &'static str, angles: &[Number]) -> Result<(), ProfileError> {
    for pair in angles.windows(2) {
        let [previous, found] = [pair[0].value, pair[1].value];
        if found <= previous {
            return Err(ProfileFault::NotAscending {
                what,
                previous,
                found,
            }
            .at(pair[1].line));
        }
    }
    Ok(())
}

/// The values of some numbers.
pub(super) fn values(numbers: &[Number]) -> Vec<f64> {
    numbers.iter().map(|number| number.value).collect()
}
