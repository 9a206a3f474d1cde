//! Reader of the IES format, ANSI/IES LM-63 of 1986, 1991, 1995, 2002 and 2019.
//!
//! Sources: ANSI/IESNA LM-63-2002, "Standard File Format for the Electronic Transfer of Photometric Data"; the three
//! systems of angles are those of CIE 121, "The Photometry and Goniophotometry of Luminaires".

use super::error::{ProfileError, ProfileFault};
use super::measured::{Planes, tabulate};
use super::numbers::{MOST_ANGLES, Number, ascending, parse, values};
use super::table::{Frame, ProfileTable};

/// Reads the text of an IES file.
///
/// Keywords are skipped. So is the table of lamp tilts, because it describes how a lamp weakens in a luminaire that
/// is turned, not how its light is distributed.
pub(super) fn read(text: &str) -> Result<ProfileTable, ProfileError> {
    let last_line = text.lines().count().max(1);
    let tilt = text.lines().enumerate().find_map(|(index, line)| {
        let (key, value) = line.split_once('=')?;
        let is_tilt = key.trim().eq_ignore_ascii_case("TILT");
        is_tilt.then(|| (index, value.trim().eq_ignore_ascii_case("INCLUDE")))
    });
    let Some((tilt_line, has_table)) = tilt else {
        return Err(ProfileFault::NoTilt.at(last_line));
    };
    let mut numbers = Numbers::after(text, tilt_line, last_line);
    if has_table {
        numbers.next("the geometry of lamp and luminaire")?;
        let count = numbers.angle_count("the number of tilt angles", 0.0)?;
        for _ in 0..2 * count {
            numbers.next("the table of tilts")?;
        }
    }
    let is_2019 = text
        .lines()
        .next()
        .is_some_and(|line| line.contains("LM-63-2019"));
    let header = Header::read(&mut numbers, is_2019)?;
    let vertical = numbers.list("a vertical angle", header.vertical_count)?;
    let horizontal = numbers.list("a horizontal angle", header.horizontal_count)?;
    ascending("vertical angle", &vertical)?;
    ascending("horizontal angle", &horizontal)?;
    let mut candela = Vec::new();
    for _ in 0..vertical.len() * horizontal.len() {
        let (what, allowed) = ("an intensity", "at least 0");
        let value = numbers.next(what)?.within(what, 0.0..=f64::MAX, allowed)?;
        candela.push(value * header.factor);
    }
    if candela.iter().any(|value| !value.is_finite()) {
        let (what, allowed) = ("an intensity times the multiplier", "finite");
        let found = f64::INFINITY;
        return Err(ProfileFault::OutOfRange { what, found, allowed }.at(numbers.line));
    }
    let measured = Measured {
        vertical,
        horizontal,
        candela,
        line: numbers.line,
    };
    match header.photometry {
        Photometry::C => measured.type_c(),
        Photometry::A | Photometry::B => measured.type_a_or_b(header.photometry),
    }
}

/// The system of angles in which a file was measured.
#[derive(Clone, Copy, PartialEq)]
enum Photometry {
    /// Planes through the axis of aim.
    C,
    /// Planes through a horizontal axis.
    B,
    /// Planes through a vertical axis.
    A,
}

/// The numbers before the angles, as far as they matter here.
struct Header {
    factor: f64,
    vertical_count: usize,
    horizontal_count: usize,
    photometry: Photometry,
}

impl Header {
    fn read(numbers: &mut Numbers, is_2019: bool) -> Result<Self, ProfileError> {
        numbers.next("the number of lamps")?;
        numbers.next("the lumens of a lamp")?;
        let what = "the multiplier of candelas";
        let multiplier = numbers.next(what)?.within(what, 0.0..=f64::MAX, "at least 0")?;
        let vertical_count = numbers.angle_count("the number of vertical angles", 2.0)?;
        let horizontal_count = numbers.angle_count("the number of horizontal angles", 1.0)?;
        let what = "the type of photometry";
        let kind = numbers
            .next(what)?
            .count(what, 1.0, 3.0, "1 for C, 2 for B or 3 for A")?;
        let what = "the type of units";
        numbers
            .next(what)?
            .count(what, 1.0, 2.0, "1 for feet or 2 for metres")?;
        for what in ["the width", "the length", "the height"] {
            numbers.next(what)?;
        }
        let what = "the ballast factor";
        let ballast = numbers.next(what)?.within(what, 0.0..=f64::MAX, "at least 0")?;
        // A factor until 1991, then 1, and since 2019 a code that says how the file was made.
        let what = "the factor of ballast and lamp";
        let factor = numbers.next(what)?.within(what, 0.0..=f64::MAX, "at least 0")?;
        numbers.next("the watts")?;
        Ok(Self {
            factor: multiplier * ballast * if is_2019 { 1.0 } else { factor },
            vertical_count,
            horizontal_count,
            photometry: match kind {
                1 => Photometry::C,
                2 => Photometry::B,
                _ => Photometry::A,
            },
        })
    }
}

/// The angles and intensities of a file, horizontal angle after horizontal angle.
struct Measured {
    vertical: Vec<Number>,
    horizontal: Vec<Number>,
    candela: Vec<f64>,
    /// Line of the last number.
    line: usize,
}

impl Measured {
    /// Vertical angles count from the aim, and horizontal angles turn about it. Files leave out planes that are
    /// mirror images of others.
    fn type_c(self) -> Result<ProfileTable, ProfileError> {
        for angle in &self.vertical {
            angle.within("a vertical angle", 0.0..=180.0, "in 0..=180 degrees")?;
        }
        for angle in &self.horizontal {
            angle.within("a horizontal angle", 0.0..=360.0, "in 0..=360 degrees")?;
        }
        let mut planes = Planes::new(values(&self.horizontal));
        let [first, last] = self.horizontal_range();
        match (first, last) {
            (first, last) if first == last => {} // the same all around
            (0.0, 90.0) => {
                planes.reflect(90.0);
                planes.reflect(180.0);
            }
            (0.0, 180.0) => planes.reflect(180.0),
            (90.0, 270.0) => planes.reflect(90.0),
            (0.0, last) if last > 180.0 => {} // the whole circle; some files leave out its last plane
            _ => return Err(self.planes("0 to 0, 90, 180 or 360, or 90 to 270")),
        }
        planes.close();
        tabulate(
            Frame::ABOUT_AIM,
            &planes,
            &values(&self.vertical),
            &self.candela,
            self.line,
        )
    }

    /// One angle is a longitude about an axis across the aim, the other one a latitude. For type B the longitudes are
    /// the vertical angles and the axis is horizontal; for type A the longitudes are the horizontal angles and the
    /// axis is vertical. Files leave out one side of a luminaire that is its own mirror image.
    fn type_a_or_b(self, photometry: Photometry) -> Result<ProfileTable, ProfileError> {
        let is_b = photometry == Photometry::B;
        let (longitudes, latitudes) = if is_b {
            (&self.vertical, &self.horizontal)
        } else {
            (&self.horizontal, &self.vertical)
        };
        for angle in longitudes {
            angle.within("an angle about the axis", -180.0..=180.0, "in -180..=180 degrees")?;
        }
        for angle in latitudes {
            angle.within("an angle off the axis", -90.0..=90.0, "in -90..=90 degrees")?;
        }
        if self.horizontal.len() < 2 {
            return Err(self.planes("over a range, because only type C has turned shapes"));
        }
        let mut planes = Planes::new(values(longitudes));
        if longitudes[0].value == 0.0 {
            planes.reflect(0.0);
        }
        planes.sort();
        let mut latitude_planes = Planes::new(values(latitudes));
        if latitudes[0].value == 0.0 {
            latitude_planes.reflect(0.0);
        }
        latitude_planes.sort();
        // Polar angles ascend from the axis, at which the latitude is 90 degrees.
        let order: Vec<_> = latitude_planes.into_inner().into_iter().rev().collect();
        let polar: Vec<f64> = order.iter().map(|(latitude, _)| 90.0 - latitude).collect();
        let stride = self.vertical.len();
        let mut columns = Vec::with_capacity(longitudes.len() * order.len());
        for longitude in 0..longitudes.len() {
            columns.extend(order.iter().map(|&(_, latitude)| {
                if is_b {
                    self.candela[latitude * stride + longitude]
                } else {
                    self.candela[longitude * stride + latitude]
                }
            }));
        }
        let frame = if is_b { Frame::ABOUT_RIGHT } else { Frame::ABOUT_UP };
        tabulate(frame, &planes, &polar, &columns, self.line)
    }

    fn horizontal_range(&self) -> [f64; 2] {
        let value = |number: Option<&Number>| number.map_or(0.0, |number| number.value);
        [value(self.horizontal.first()), value(self.horizontal.last())]
    }

    fn planes(&self, allowed: &'static str) -> ProfileError {
        let [first, last] = self.horizontal_range();
        let line = self.horizontal.last().map_or(self.line, |number| number.line);
        ProfileFault::Planes { first, last, allowed }.at(line)
    }
}

/// The numbers of a text, separated by blanks, commas or line ends.
struct Numbers<'a> {
    words: Box<dyn Iterator<Item = (usize, &'a str)> + 'a>,
    /// Line of the number that was read last.
    line: usize,
    last_line: usize,
}

impl<'a> Numbers<'a> {
    /// The numbers after the line with this index.
    fn after(text: &'a str, index: usize, last_line: usize) -> Self {
        let words = text
            .lines()
            .enumerate()
            .skip(index + 1)
            .flat_map(|(index, line)| {
                line.split(|c: char| c.is_whitespace() || c == ',')
                    .filter(|word| !word.is_empty())
                    .map(move |word| (index + 1, word))
            });
        Self {
            words: Box::new(words),
            line: index + 1,
            last_line,
        }
    }

    fn next(&mut self, what: &'static str) -> Result<Number, ProfileError> {
        let Some((line, word)) = self.words.next() else {
            return Err(ProfileFault::Ends { expected: what }.at(self.last_line));
        };
        self.line = line;
        parse(what, word, line)
    }

    fn angle_count(&mut self, what: &'static str, least: f64) -> Result<usize, ProfileError> {
        let allowed = match least {
            0.0 => "a whole number from 0 to 7201",
            1.0 => "a whole number from 1 to 7201",
            _ => "a whole number from 2 to 7201",
        };
        self.next(what)?.count(what, least, MOST_ANGLES, allowed)
    }

    fn list(&mut self, what: &'static str, count: usize) -> Result<Vec<Number>, ProfileError> {
        (0..count).map(|_| self.next(what)).collect()
    }
}
