//! Pictures that are cubes around a light.
//!
//! The faces of a cube are in the order of cube maps on the GPU, with the light at the centre: to the right, to the left,
//! upwards, downwards, ahead, behind. Each face is seen from the light as its picture shows it. The four faces around the
//! light have local +Y above; the upper and the lower one join the face ahead.

#[cfg(any(feature = "render", feature = "gltf"))]
use std::path::Path;
use std::sync::Arc;

use glam::{DMat3, DVec3, Vec3};

use super::component::Cookie;
use super::image::{CookieImage, CookieImageError, Faces};
use super::levels::Level;

/// Number of the faces of a cube, with the place of each in a picture that holds all of them.
struct Layout {
    /// Width and height of the picture, faces.
    size: [u32; 2],
    /// Column and row of each face.
    at: [[u32; 2]; 6],
    /// Whether the last face, behind the light, stands on its head.
    turns_last: bool,
}

/// The arrangements of faces in one picture. They differ in their proportions. Those of Bevy's
/// `CubemapLayout` are the same.
const LAYOUTS: [Layout; 4] = [
    Layout {
        size: [4, 3],
        at: [[2, 1], [0, 1], [1, 0], [1, 2], [1, 1], [3, 1]],
        turns_last: false,
    },
    Layout {
        size: [3, 4],
        at: [[2, 1], [0, 1], [1, 0], [1, 2], [1, 1], [1, 3]],
        turns_last: true,
    },
    Layout {
        size: [6, 1],
        at: [[0, 0], [1, 0], [2, 0], [3, 0], [4, 0], [5, 0]],
        turns_last: false,
    },
    Layout {
        size: [1, 6],
        at: [[0, 0], [0, 1], [0, 2], [0, 3], [0, 4], [0, 5]],
        turns_last: false,
    },
];

impl CookieImage {
    /// Makes a cube of six square pictures of one size: those to the right (local +X), to the left (−X), upwards (+Y),
    /// downwards (−Y), ahead (−Z, the aim) and behind the light (+Z). Each is seen from the light as it is. The upper
    /// and the lower picture join the one ahead, at its upper and its lower edge.
    ///
    /// # Errors
    /// [`CookieImageError::Face`] names the first picture that does not fit.
    pub fn cube(name: &str, faces: [Arc<Self>; 6]) -> Result<Arc<Self>, CookieImageError> {
        let side = faces[0].width();
        let fits = |face: &Self| !face.is_cube() && face.width() == side && face.height() == side;
        if let Some(face) = faces.iter().find(|face| !fits(face)) {
            return Err(CookieImageError::Face {
                name: face.name().to_owned(),
                width: face.width(),
                height: face.height(),
                side,
            });
        }
        let levels = faces.map(|face| face.first().clone());
        Ok(Arc::new(Self {
            name: name.to_owned(),
            faces: Faces::Cube(Box::new(levels)),
        }))
    }

    /// Cuts a flat picture into the faces of a cube. Its proportions tell the arrangement:
    ///
    /// | proportions | faces, by local axes |
    /// | --- | --- |
    /// | 4 : 3 | a cross: a row of −X, −Z, +X, +Z, with +Y above −Z and −Y below it |
    /// | 3 : 4 | a cross: a row of −X, −Z, +X, with +Y above −Z, and −Y and +Z below it; +Z stands on its head |
    /// | 6 : 1, 1 : 6 | a row or a column of +X, −X, +Y, −Y, −Z, +Z |
    ///
    /// The light aims along −Z, which is the middle of a cross. These are the arrangements of Bevy's
    /// `CubemapLayout`.
    ///
    /// # Errors
    /// [`CookieImageError::Cube`] if the picture has none of these proportions, or is a cube already.
    pub fn cube_from(picture: &Self) -> Result<Arc<Self>, CookieImageError> {
        let (width, height) = (picture.width(), picture.height());
        let fits = |layout: &&Layout| {
            let [columns, rows] = layout.size;
            width % columns == 0 && height % rows == 0 && width / columns == height / rows
        };
        let layout = LAYOUTS.iter().find(fits).filter(|_| !picture.is_cube());
        let Some(layout) = layout else {
            return Err(CookieImageError::Cube {
                name: picture.name().to_owned(),
                width,
                height,
            });
        };
        let side = width / layout.size[0];
        let mut levels = layout.at.map(|at| cut(picture.first(), at, side));
        if layout.turns_last {
            levels[5].texels.reverse();
        }
        Ok(Arc::new(Self {
            name: picture.name().to_owned(),
            faces: Faces::Cube(Box::new(levels)),
        }))
    }

    /// Reads a picture file that holds the faces of a cube, as [`CookieImage::cube_from`] takes them and
    /// [`CookieImage::load`] reads them.
    ///
    /// # Errors
    /// [`CookieImageError`] names the file.
    #[cfg(any(feature = "render", feature = "gltf"))]
    pub fn load_cube(path: &Path) -> Result<Arc<Self>, CookieImageError> {
        let picture = Self::load(path)?;
        Self::cube_from(&picture)
    }
}

/// One face of a picture, by its column and row.
fn cut(picture: &Level, [column, row]: [u32; 2], side: u32) -> Level {
    let width = picture.width as usize;
    let rows = picture.texels.chunks_exact(width);
    let first = (column * side) as usize;
    let rows = rows.skip((row * side) as usize).take(side as usize);
    Level {
        width: side,
        height: side,
        texels: rows
            .flat_map(|row| &row[first..first + side as usize])
            .copied()
            .collect(),
    }
}

/// The turn of a cube about its light: from the directions of the picture to those of light space, whose x points to the
/// right, y upwards and z along the aim. The turn of the cookie comes first, then its offset: first upwards, then to the
/// right.
pub fn light_from_cube(cookie: &Cookie) -> DMat3 {
    let (sin, cos) = f64::from(cookie.turn).sin_cos();
    let turn = DMat3::from_cols(DVec3::new(cos, sin, 0.0), DVec3::new(-sin, cos, 0.0), DVec3::Z);
    let (sin, cos) = f64::from(cookie.offset.y).sin_cos();
    let upwards = DMat3::from_cols(DVec3::X, DVec3::new(0.0, cos, -sin), DVec3::new(0.0, sin, cos));
    let (sin, cos) = f64::from(cookie.offset.x).sin_cos();
    let to_the_right = DMat3::from_cols(DVec3::new(cos, 0.0, -sin), DVec3::Y, DVec3::new(sin, 0.0, cos));
    to_the_right * upwards * turn
}

/// The face of a cube that a direction meets, and the place on it: 0 to 1 from its upper left corner. Face 4 for the zero
/// vector.
/// Source: WebGPU, "Texture cube face selection" (that of all graphics interfaces).
pub fn face_of(direction: DVec3) -> (usize, [f64; 2]) {
    let DVec3 { x, y, z } = direction;
    let [ax, ay, az] = direction.abs().to_array();
    let (face, across, down, along) = if az >= ax && az >= ay {
        if z >= 0.0 { (4, x, -y, az) } else { (5, -x, -y, az) }
    } else if ay >= ax {
        if y >= 0.0 { (2, x, z, ay) } else { (3, x, -z, ay) }
    } else if x >= 0.0 {
        (0, -z, -y, ax)
    } else {
        (1, z, -y, ax)
    };
    let along = along.max(1e-30);
    (face, [across, down].map(|at| 0.5 + 0.5 * at / along))
}

/// Samples a cube in a direction, linearly between the centres of texels. Across the edge of a face the border texel
/// counts, where the GPU blends with the neighbouring face: the two differ in the outer half texel of each face.
pub fn sample(faces: &[Level], direction: DVec3) -> Vec3 {
    let (face, [u, v]) = face_of(direction);
    let Some(level) = faces.get(face) else {
        return Vec3::ONE;
    };
    let side = f64::from(level.width);
    let along = |at: f64| {
        let at = (at * side - 0.5).clamp(0.0, side - 1.0);
        let low = at.floor();
        let high = (low + 1.0).min(side - 1.0);
        (low as usize, high as usize, (at - low) as f32)
    };
    let ((left, right, x), (upper, lower, y)) = (along(u), along(v));
    let texel = |row: usize, column: usize| level.texels[row * level.width as usize + column];
    let above = texel(upper, left).lerp(texel(upper, right), x);
    let below = texel(lower, left).lerp(texel(lower, right), x);
    above.lerp(below, y)
}

#[cfg(test)]
mod tests {
    use std::f32::consts::FRAC_PI_2;

    use glam::Vec2;

    use super::*;
    use crate::scene::LightKind;

    /// Directions of the faces' centres, in light space.
    const CENTERS: [DVec3; 6] = [
        DVec3::X,
        DVec3::NEG_X,
        DVec3::Y,
        DVec3::NEG_Y,
        DVec3::Z,
        DVec3::NEG_Z,
    ];

    fn of_face(face: usize) -> Vec3 {
        Vec3::splat(face as f32 + 1.0)
    }

    fn faces(side: u32, texel: impl Fn(usize, u32, u32) -> Vec3) -> [Arc<CookieImage>; 6] {
        std::array::from_fn(|face| {
            let texels = (0..side * side).map(|at| texel(face, at % side, at / side));
            CookieImage::from_linear("face", side, side, texels.collect()).expect("a picture")
        })
    }

    fn image() -> Arc<CookieImage> {
        CookieImage::cube("cube", faces(2, |face, _, _| of_face(face))).expect("a cube")
    }

    #[test]
    fn each_face_is_on_its_side() {
        let cookie = Cookie::new(image());
        for (face, center) in CENTERS.into_iter().enumerate() {
            for kind in [LightKind::Point, LightKind::Sphere { radius: 1.0 }] {
                assert_eq!(cookie.factor(kind, center * 7.0), of_face(face), "{center}");
            }
        }
        assert!(cookie.factor(LightKind::Point, DVec3::ZERO).is_finite());
    }

    #[test]
    fn faces_join_at_their_edges() {
        // The texels on both sides of an edge have one colour: a smooth function of direction.
        let colour = |direction: DVec3| (direction.normalize() * 0.5 + 0.5).as_vec3();
        let side = 64;
        let texel = |face: usize, x: u32, y: u32| {
            let [u, v] = [x, y].map(|at| (f64::from(at) + 0.5) / f64::from(side) * 2.0 - 1.0);
            let direction = match face {
                0 => DVec3::new(1.0, -v, -u),
                1 => DVec3::new(-1.0, -v, u),
                2 => DVec3::new(u, 1.0, v),
                3 => DVec3::new(u, -1.0, -v),
                4 => DVec3::new(u, -v, 1.0),
                _ => DVec3::new(-u, -v, -1.0),
            };
            colour(direction)
        };
        let cookie = Cookie::new(CookieImage::cube("smooth", faces(side, texel)).expect("a cube"));
        for i in 0..2000 {
            let angle = f64::from(i) * 2.399_963_229_728_653;
            let y = 1.0 - (f64::from(i) + 0.5) / 1000.0;
            let around = (1.0 - y * y).sqrt();
            let direction = DVec3::new(angle.cos() * around, y, angle.sin() * around);
            let got = cookie.factor(LightKind::Point, direction);
            let error = (got - colour(direction)).abs().max_element();
            assert!(error < 0.02, "{direction}: {got}");
        }
    }

    #[test]
    fn a_cube_turns_about_the_aim_and_moves_up_and_to_the_right() {
        let at = |cookie: &Cookie, direction: DVec3| cookie.factor(LightKind::Point, direction);
        let turned = Cookie {
            turn: FRAC_PI_2,
            ..Cookie::new(image())
        };
        let shows = |cookie: &Cookie, direction: DVec3, face: usize| {
            let apart = at(cookie, direction) - of_face(face);
            apart.abs().max_element() < 1e-4
        };
        // Counterclockwise: what was to the right is above.
        assert!(shows(&turned, DVec3::Y, 0) && shows(&turned, DVec3::Z, 4));
        let moved = |offset| Cookie {
            offset,
            ..Cookie::new(image())
        };
        assert!(shows(&moved(Vec2::new(FRAC_PI_2, 0.0)), DVec3::X, 4));
        assert!(shows(&moved(Vec2::new(0.0, FRAC_PI_2)), DVec3::Y, 4));
    }

    #[test]
    fn pictures_are_cut_by_their_proportions() {
        let rows: [(&[&str], u32); 4] = [
            (&[" 2  ", "1405", " 3  "], 4),
            (&[" 2 ", "140", " 3 ", " 5 "], 3),
            (&["012345"], 6),
            (&["0", "1", "2", "3", "4", "5"], 1),
        ];
        for (rows, width) in rows {
            // Each face has two texels along a side, darker in its upper left one.
            let mut texels = Vec::new();
            for (row, half) in rows.iter().flat_map(|row| [(row, 0), (row, 1)]) {
                for letter in row.chars() {
                    let value = letter.to_digit(10).map_or(9.0, |digit| digit as f32 + 1.0);
                    texels.extend([
                        Vec3::splat(if half == 0 { value - 0.5 } else { value }),
                        Vec3::splat(value),
                    ]);
                }
            }
            let picture =
                CookieImage::from_linear("p", 2 * width, 2 * rows.len() as u32, texels).expect("a picture");
            let cube = CookieImage::cube_from(&picture).expect("a cube");
            assert!(cube.is_cube() && cube.width() == 2);
            for (face, level) in cube.faces().iter().enumerate() {
                let value = face as f32 + 1.0;
                let mut expected = [value - 0.5, value, value, value];
                if width == 3 && face == 5 {
                    expected.reverse(); // it stands on its head
                }
                let got: Vec<f32> = level.texels.iter().map(|texel| texel.x).collect();
                assert_eq!(got, expected, "{width} columns, face {face}");
            }
        }
    }

    #[test]
    fn pictures_that_are_no_cube_are_named() {
        let flat = |width, height| {
            let texels = vec![Vec3::ONE; (width * height) as usize];
            CookieImage::from_linear("flat", width, height, texels).expect("a picture")
        };
        for (width, height) in [(4, 4), (5, 3), (7, 1), (8, 3)] {
            let error = CookieImage::cube_from(&flat(width, height))
                .expect_err("no cube")
                .to_string();
            assert!(error.contains("flat") && error.contains("cross"), "{error}");
        }
        assert!(CookieImage::cube_from(&image()).is_err(), "a cube is no cross");
        let mut six = faces(2, |_, _, _| Vec3::ONE);
        six[3] = flat(3, 3);
        let error = CookieImage::cube("cube", six)
            .expect_err("another size")
            .to_string();
        assert!(error.contains("flat: 3×3") && error.contains("2×2"), "{error}");
    }
}
