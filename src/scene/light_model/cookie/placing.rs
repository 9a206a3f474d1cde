//! From a point before a light to the place of its cookie that the light shines through.
//!
//! Twin of `shaders/common/light_texture.wgsl`.

use glam::{DMat2, DVec2, DVec3, Vec3};

use super::component::Cookie;
use super::cube;
use super::image::CookieImage;
use super::levels::Level;
use crate::scene::{LightKind, TextureWrap};

/// Where the picture of a cookie lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Projection {
    /// On the plane one metre before the light.
    Plane,
    /// Around the light, by longitude and latitude.
    Around,
    /// On a plane across parallel light.
    Parallel,
    /// On a cube around the light.
    Cube,
}

impl Projection {
    /// The projection of a picture before a kind of light. A cube before a directional light is no cookie, and lies as
    /// a flat picture would.
    pub fn of(kind: LightKind, image: &CookieImage) -> Self {
        match kind {
            LightKind::Directional => Self::Parallel,
            _ if image.is_cube() => Self::Cube,
            LightKind::Spot { .. } | LightKind::Rect { .. } => Self::Plane,
            LightKind::Point | LightKind::Sphere { .. } => Self::Around,
        }
    }

    /// Coordinates on the surface on which a flat picture lies, metres or radians. `point` is in light space: x to the
    /// right, y upwards, z the depth before the light. A cube is not flat; for it the coordinates are longitude and
    /// latitude.
    pub fn coordinates(self, point: DVec3) -> DVec2 {
        match self {
            // Behind the plane there is no light; the bound keeps the numbers finite.
            Self::Plane => point.truncate() / point.z.max(1e-6 * point.length()).max(1e-20),
            Self::Around | Self::Cube => {
                DVec2::new(point.x.atan2(point.z), point.y.atan2(point.x.hypot(point.z)))
            }
            Self::Parallel => point.truncate(),
        }
    }
}

/// The affine map from coordinates on the surface of the picture to texture coordinates, whose origin is the upper
/// left corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CookiePlacing {
    /// Linear part.
    pub matrix: DMat2,
    /// Texture coordinates of the surface's origin.
    pub origin: DVec2,
}

impl CookiePlacing {
    /// The placing of a cookie.
    pub fn of(cookie: &Cookie) -> Self {
        let (sin, cos) = f64::from(cookie.turn).sin_cos();
        let aspect = f64::from(cookie.image.height()) / f64::from(cookie.image.width());
        let width = f64::from(cookie.size);
        let (to_u, to_v) = (width.recip(), -(width * aspect).recip());
        // The picture turns counterclockwise, so its axes are those of the surface turned by the same angle. Texture
        // coordinate v points down.
        let matrix = DMat2::from_cols(
            DVec2::new(cos * to_u, -sin * to_v),
            DVec2::new(sin * to_u, cos * to_v),
        );
        Self {
            matrix,
            origin: DVec2::splat(0.5) - matrix * cookie.offset.as_dvec2(),
        }
    }

    /// Texture coordinates of a place on the surface of the picture.
    pub fn uv(&self, coordinates: DVec2) -> DVec2 {
        self.matrix * coordinates + self.origin
    }
}

impl Cookie {
    /// The factor by which the cookie multiplies the colour of a light of this kind at a point, without mip-mapping.
    /// `point` is in light space: x to the right, y upwards, z the depth before the light.
    pub fn factor(&self, kind: LightKind, point: DVec3) -> Vec3 {
        let picture = match Projection::of(kind, &self.image) {
            Projection::Cube => cube::sample(
                self.image.faces(),
                cube::light_from_cube(self).transpose() * point,
            ),
            flat => {
                let uv = CookiePlacing::of(self).uv(flat.coordinates(point));
                sample(self.image.first(), uv, self.wrap)
            }
        };
        Vec3::ONE.lerp(picture, self.density)
    }
}

/// Samples one level of a picture with linear interpolation between the centres of texels.
fn sample(level: &Level, uv: DVec2, wrap: [TextureWrap; 2]) -> Vec3 {
    let [columns, rows] =
        [(uv.x, level.width, wrap[0]), (uv.y, level.height, wrap[1])].map(|(at, count, wrap)| {
            let at = at * f64::from(count) - 0.5;
            let low = at.floor();
            let texels = [low, low + 1.0].map(|texel| wrapped(texel, count, wrap));
            (texels, (at - low) as f32)
        });
    let texel = |row: usize, column: usize| level.texels[row * level.width as usize + column];
    let [upper, lower] = rows
        .0
        .map(|row| texel(row, columns.0[0]).lerp(texel(row, columns.0[1]), columns.1));
    upper.lerp(lower, rows.1)
}

/// The texel at an index that may lie beyond the border.
fn wrapped(texel: f64, count: u32, wrap: TextureWrap) -> usize {
    let count = f64::from(count);
    let inside = match wrap {
        TextureWrap::Repeat => texel.rem_euclid(count),
        TextureWrap::Clamp => texel,
        TextureWrap::Mirror => {
            let twice = texel.rem_euclid(2.0 * count);
            twice.min(2.0 * count - 1.0 - twice)
        }
    };
    inside.clamp(0.0, count - 1.0) as usize
}

#[cfg(test)]
mod tests {
    use std::f32::consts::FRAC_PI_2;

    use glam::Vec2;

    use super::super::image::CookieImage;
    use super::*;

    const SPOT: LightKind = LightKind::Spot {
        inner_angle: 0.5,
        outer_angle: 0.9,
    };

    /// Red, green above; blue, white below.
    fn four_texels() -> Cookie {
        let texels = vec![Vec3::X, Vec3::Y, Vec3::Z, Vec3::ONE];
        let image = CookieImage::from_linear("four", 2, 2, texels).expect("a picture");
        Cookie {
            wrap: [TextureWrap::Clamp; 2],
            ..Cookie::new(image)
        }
    }

    #[test]
    fn it_is_upright_seen_from_the_light() {
        let cookie = four_texels();
        let at = |x: f64, y: f64, depth: f64| cookie.factor(SPOT, DVec3::new(x, y, 1.0) * depth);
        assert_eq!(at(-0.6, 0.6, 1.0), Vec3::X);
        assert_eq!(at(0.6, 0.6, 7.0), Vec3::Y);
        assert_eq!(at(-0.6, -0.6, 1.0), Vec3::Z);
        assert_eq!(at(0.6, -0.6, 0.1), Vec3::ONE);
        assert!((at(0.0, 0.0, 1.0) - Vec3::splat(0.5)).abs().max_element() < 1e-6);
    }

    #[test]
    fn it_turns_moves_and_grows() {
        let at = |cookie: &Cookie, x: f64, y: f64| cookie.factor(SPOT, DVec3::new(x, y, 1.0));
        let turned = Cookie {
            turn: FRAC_PI_2,
            ..four_texels()
        };
        // The upper left corner goes down the left side.
        assert_eq!(at(&turned, -0.6, -0.6), Vec3::X);
        assert_eq!(at(&turned, -0.6, 0.6), Vec3::Y);
        let moved = Cookie {
            offset: Vec2::new(10.0, -5.0),
            ..four_texels()
        };
        assert_eq!(at(&moved, 9.4, -4.4), Vec3::X);
        let large = Cookie {
            size: 200.0,
            ..four_texels()
        };
        assert_eq!(at(&large, -60.0, 60.0), Vec3::X);
        let thin = Cookie {
            density: 0.25,
            ..four_texels()
        };
        assert_eq!(at(&thin, -0.6, 0.6), Vec3::new(1.0, 0.75, 0.75));
    }

    #[test]
    fn it_goes_around_points_and_along_parallel_light() {
        let around = Cookie {
            wrap: [TextureWrap::Clamp; 2],
            ..Cookie::around(four_texels().image)
        };
        // Two texels around: their centres are a quarter turn left and right of the aim.
        let at = |x: f64, y: f64, z: f64| around.factor(LightKind::Point, DVec3::new(x, y, z));
        let upper = |color: Vec3| color.dot(Vec3::new(1.0, 1.0, 0.0)) > color.dot(Vec3::Z) + 0.5;
        assert!(upper(at(-1.0, 3.0, 0.0)) && !upper(at(-1.0, -3.0, 0.0)));
        assert_eq!(at(-1.0, 0.0, 0.0), at(-5.0, 0.0, 0.0));
        assert!(at(-1.0, 0.0, 0.0).x > 0.49 && at(-1.0, 0.0, 0.0).y < 1e-6);
        let parallel = four_texels();
        let lower_left = DVec3::new(-0.6, -0.6, 300.0);
        assert_eq!(parallel.factor(LightKind::Directional, lower_left), Vec3::Z);
    }

    #[test]
    fn it_continues_beyond_its_borders() {
        let texels = vec![Vec3::X, Vec3::Y, Vec3::Z];
        let image = CookieImage::from_linear("three", 3, 1, texels).expect("a picture");
        let row = |wrap| {
            let cookie = Cookie {
                wrap: [wrap; 2],
                size: 3.0,
                ..Cookie::new(image.clone())
            };
            [-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0].map(|x| {
                let color = cookie.factor(LightKind::Directional, DVec3::new(x, 0.0, 1.0));
                ["r", "g", "b"][color.max_position()]
            })
        };
        assert_eq!(row(TextureWrap::Repeat).concat(), "gbrgbrg");
        assert_eq!(row(TextureWrap::Clamp).concat(), "rrrgbbb");
        assert_eq!(row(TextureWrap::Mirror).concat(), "grrgbbg");
    }

    #[test]
    fn one_texel_colours_everything() {
        let image = CookieImage::from_linear("one", 1, 1, vec![Vec3::new(0.2, 0.4, 2.0)]).expect("a picture");
        for kind in [SPOT, LightKind::Point, LightKind::Directional] {
            for point in [DVec3::ZERO, DVec3::NEG_Z, DVec3::new(3.0, 1e9, -2.0)] {
                let factor = Cookie::new(image.clone()).factor(kind, point);
                assert!((factor - Vec3::new(0.2, 0.4, 2.0)).abs().max_element() < 1e-6);
            }
        }
    }
}
