//! Reader of the EULUMDAT format (`.ldt`).
//!
//! Source: Stockmar 1990, "EULUMDAT - ein Leuchtendatenformat für den europäischen Beleuchtungsplaner".

use super::error::{ProfileError, ProfileFault};
use super::measured::{Planes, tabulate};
use super::numbers::{MOST_ANGLES, Number, ascending, parse, values};
use super::table::{Frame, ProfileTable};

/// Reads the text of a EULUMDAT file. Each value stands in a line of its own.
pub(super) fn read(text: &str) -> Result<ProfileTable, ProfileError> {
    let mut lines = Lines::new(text);
    lines.skip(2, "the symmetry")?;
    let what = "the symmetry";
    let symmetry = lines
        .number(what)?
        .count(what, 0.0, 4.0, "a whole number from 0 to 4")?;
    let what = "the number of C-planes";
    let plane_count = lines.angle_count(what, 1.0, "a whole number from 1 to 7201")?;
    let plane_line = lines.line;
    lines.skip(1, "the number of angles in a plane")?;
    let what = "the number of angles in a plane";
    let polar_count = lines.angle_count(what, 2.0, "a whole number from 2 to 7201")?;
    lines.skip(17, "the conversion factor")?;
    let what = "the conversion factor";
    let conversion = lines.number(what)?.within(what, 0.0..=1e30, "at least 0")?;
    lines.skip(1, "the number of sets of lamps")?;
    let what = "the number of sets of lamps";
    let sets = lines
        .number(what)?
        .count(what, 0.0, 20.0, "a whole number from 0 to 20")?;
    let flux = read_lamps(&mut lines, sets)?;
    lines.skip(10, "a C angle")?;
    let plane_angles = lines.list("a C angle", plane_count)?;
    let polar = lines.list("an angle in a plane", polar_count)?;
    for angle in &plane_angles {
        angle.within("a C angle", 0.0..=360.0, "in 0..=360 degrees")?;
    }
    for angle in &polar {
        angle.within("an angle in a plane", 0.0..=180.0, "in 0..=180 degrees")?;
    }
    ascending("C angle", &plane_angles)?;
    ascending("angle in a plane", &polar)?;
    let planes = measured_planes(symmetry, &values(&plane_angles), plane_line)?;
    let measured = planes.count();
    let planes = unfold(planes, symmetry);
    // Intensities are candela for each 1000 lumens of the lamps.
    let factor = conversion * flux / 1000.0;
    let mut candela = Vec::new();
    for _ in 0..measured * polar_count {
        let (what, allowed) = ("an intensity", "in 0..=1e30");
        candela.push(lines.number(what)?.within(what, 0.0..=1e30, allowed)? * factor);
    }
    tabulate(Frame::ABOUT_AIM, &planes, &values(&polar), &candela, lines.line)
}

/// Reads the sets of lamps and returns the flux of the first one, lumens. A negative number of lamps means that the
/// file was measured with its own lamps, and says nothing about the sign of their flux.
fn read_lamps(lines: &mut Lines, sets: usize) -> Result<f64, ProfileError> {
    let mut flux = 1000.0;
    for set in 0..sets {
        lines.skip(2, "the flux of the lamps")?;
        let what = "the flux of the lamps";
        let value = lines.number(what)?.within(what, -1e30..=1e30, "finite")?.abs();
        if set == 0 && value > 0.0 {
            flux = value;
        }
        lines.skip(3, "the next set of lamps")?;
    }
    Ok(flux)
}

/// The planes whose intensities the file lists. The rest of the circle follows from the symmetry.
fn measured_planes(symmetry: usize, angles: &[f64], line: usize) -> Result<Planes, ProfileError> {
    let planes = angles.len();
    let refuse = |needed| {
        Err(ProfileFault::Symmetry {
            planes,
            symmetry,
            needed,
        }
        .at(line))
    };
    match symmetry {
        1 => Ok(Planes::new([0.0])),
        2 if planes.is_multiple_of(2) => Ok(Planes::new(angles[..=planes / 2].iter().copied())),
        3 if planes.is_multiple_of(4) => {
            let from = 3 * planes / 4;
            Ok(Planes::new(
                (from..=from + planes / 2).map(|plane| angles[plane % planes]),
            ))
        }
        4 if planes.is_multiple_of(4) => Ok(Planes::new(angles[..=planes / 4].iter().copied())),
        2 => refuse("an even number"),
        3 | 4 => refuse("a multiple of 4"),
        _ => Ok(Planes::new(angles.iter().copied())),
    }
}

/// Adds the planes that a file leaves out, and closes the circle.
fn unfold(mut planes: Planes, symmetry: usize) -> Planes {
    if matches!(symmetry, 3 | 4) {
        planes.reflect(90.0);
    }
    if matches!(symmetry, 2 | 4) {
        planes.reflect(180.0);
    }
    planes.close();
    planes
}

/// The lines of a text.
struct Lines<'a> {
    lines: std::str::Lines<'a>,
    /// Number of the line that was read last.
    line: usize,
}

impl<'a> Lines<'a> {
    fn new(text: &'a str) -> Self {
        Self {
            lines: text.lines(),
            line: 0,
        }
    }

    fn next(&mut self, expected: &'static str) -> Result<&'a str, ProfileError> {
        let Some(line) = self.lines.next() else {
            return Err(ProfileFault::Ends { expected }.at(self.line.max(1)));
        };
        self.line += 1;
        Ok(line)
    }

    fn skip(&mut self, count: usize, before: &'static str) -> Result<(), ProfileError> {
        for _ in 0..count {
            self.next(before)?;
        }
        Ok(())
    }

    fn number(&mut self, what: &'static str) -> Result<Number, ProfileError> {
        let text = self.next(what)?;
        parse(what, text, self.line)
    }

    fn angle_count(
        &mut self,
        what: &'static str,
        least: f64,
        allowed: &'static str,
    ) -> Result<usize, ProfileError> {
        self.number(what)?.count(what, least, MOST_ANGLES, allowed)
    }

    fn list(&mut self, what: &'static str, count: usize) -> Result<Vec<Number>, ProfileError> {
        (0..count).map(|_| self.number(what)).collect()
    }
}
