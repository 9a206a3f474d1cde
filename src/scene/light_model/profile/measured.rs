//! The planes of a file, their symmetries, and the table that is made from them.

use super::error::{ProfileError, ProfileFault};
use super::table::{Frame, ProfileTable};

/// The planes of a file, before symmetries are unfolded.
#[derive(Debug)]
pub(super) struct Planes {
    /// Angle of each plane, degrees, and the index of its column.
    angles: Vec<(f64, usize)>,
}

impl Planes {
    /// The planes at these angles. The plane at the index `i` has the column `i`.
    pub fn new(angles: impl IntoIterator<Item = f64>) -> Self {
        let angles = angles
            .into_iter()
            .enumerate()
            .map(|(index, angle)| (angle, index));
        Self {
            angles: angles.collect(),
        }
    }

    /// The number of planes.
    pub fn count(&self) -> usize {
        self.angles.len()
    }

    /// The angle of each plane and the index of its column.
    pub fn into_inner(self) -> Vec<(f64, usize)> {
        self.angles
    }

    /// Adds the mirror image of each plane about the plane at `axis` degrees.
    pub fn reflect(&mut self, axis: f64) {
        let mirrored: Vec<_> = self
            .angles
            .iter()
            .map(|&(angle, column)| (2.0 * axis - angle, column))
            .collect();
        self.angles.extend(mirrored);
    }

    /// Brings the planes into the circle from 0 to 360 degrees, and repeats the first one a turn later, so that the
    /// last interval closes the circle.
    pub fn close(&mut self) {
        for (angle, _) in &mut self.angles {
            *angle = angle.rem_euclid(360.0);
        }
        self.sort();
        if let [(angle, column), _, ..] = self.angles[..] {
            self.angles.push((angle + 360.0, column));
        }
    }

    /// Sorts the planes. Of planes at one angle the first that was added stays.
    pub fn sort(&mut self) {
        const SAME: f64 = 1e-6;
        self.angles.sort_by(|a, b| a.0.total_cmp(&b.0));
        self.angles.dedup_by(|b, a| b.0 - a.0 < SAME);
    }
}

/// Makes the table of measured planes.
///
/// `columns` holds one intensity for each polar angle, plane after plane. `line` is the line that is named if all
/// intensities are 0.
pub(super) fn tabulate(
    frame: Frame,
    planes: &Planes,
    polar: &[f64],
    columns: &[f64],
    line: usize,
) -> Result<ProfileTable, ProfileError> {
    let brightest = columns.iter().copied().fold(0.0, f64::max);
    if !(brightest > 0.0) {
        return Err(ProfileFault::Dark.at(line));
    }
    let values = planes
        .angles
        .iter()
        .flat_map(|&(_, column)| &columns[column * polar.len()..][..polar.len()])
        .map(|candela| (candela / brightest) as f32)
        .collect();
    let azimuth = planes.angles.iter().map(|&(angle, _)| angle).collect();
    Ok(ProfileTable::new(
        frame,
        azimuth,
        polar.to_vec(),
        values,
        brightest,
    ))
}
