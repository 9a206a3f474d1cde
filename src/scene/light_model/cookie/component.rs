//! The component that puts a picture before a light.

use std::sync::Arc;

use bevy_ecs::prelude::*;
#[cfg(feature = "bevy")]
use bevy_ecs::reflect::ReflectComponent;
use glam::Vec2;

use super::image::CookieImage;
use crate::scene::{LightKind, TextureWrap};

/// Puts a picture before a light, as a slide in a projector: it colours the light and shapes it.
///
/// The light is multiplied by `mix(1, picture, density)`, in linear RGB.
///
/// | light | the picture lies |
/// | --- | --- |
/// | spot, rectangle | across the aim, on the plane one metre before the light's centre |
/// | point, sphere | around the light, by longitude and latitude (equirectangular); one metre of the picture is one radian |
/// | directional | across the aim, through the light's own position, and does not widen |
/// | all but directional, with a cube ([`CookieImage::cube`]) | around the light, seen from it as the faces show it |
///
/// The picture's middle lies on the aim, local −Z, with its upper edge towards local +Y. Seen from the light it is as
/// its file shows it. It is mip-mapped, so patterns that are smaller than a pixel turn grey and do not flicker.
///
/// Each field may change at any frame, the picture too. Of the blended surfaces at a pixel only the nearest is lit
/// through the picture; farther ones are lit as without it.
///
/// Costs: one pass over the light's pixels, which a [`LightProfile`](crate::scene::LightProfile) shares.
///
/// Source: Pellacini and Vidimce 2004, "Cinematic Lighting", GPU Gems, chapter 10. There the picture replaces the
/// colour of the light; here it multiplies it, so intensity stays candela.
#[derive(Component, Clone, Debug)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(opaque, Component, Debug, Clone, PartialEq)
)]
pub struct Cookie {
    /// The picture.
    pub image: Arc<CookieImage>,
    /// Strength of the picture, 0..=1; default 1. At 0 the light is as without a cookie, at 1 it has the picture's
    /// colours.
    pub density: f32,
    /// Width of the picture, metres on the plane one metre before the light, or metres for a directional light, or
    /// radians around a point or sphere. Its height follows from its texels. Greater values make the picture larger. A
    /// cube ignores it. Must be in 1e-6..=1e9; default 2, and a whole turn for [`Cookie::around`].
    pub size: f32,
    /// Offset of the picture to the right and upwards, seen from the light, in the units of `size`, and in radians for
    /// a cube; default 0.
    pub offset: Vec2,
    /// Angle by which the picture is turned counterclockwise about its middle, seen from the light, radians;
    /// default 0.
    pub turn: f32,
    /// How the picture continues beyond its borders, along its width and its height; default repeating. A cube has no
    /// borders.
    pub wrap: [TextureWrap; 2],
}

/// Why a cookie cannot be used. The light shines as without a cookie.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CookieError {
    /// The density is NaN or outside of its range.
    #[error("density is {0}, it must be in 0..=1")]
    Density(f32),
    /// The size is NaN, zero, negative, or out of all proportion.
    #[error("size is {0}, it must be greater than 0, in 1e-6..=1e9")]
    Size(f32),
    /// The offset is not finite.
    #[error("offset is {0}, it must be finite")]
    Offset(Vec2),
    /// The turn is not finite.
    #[error("turn is {0}, it must be finite")]
    Turn(f32),
    /// A cube is before a directional light, all of whose light has one direction.
    #[error("a cube goes around a light, so it does not fit a directional light; use a flat picture")]
    Cube,
}

impl PartialEq for Cookie {
    /// Cookies are equal if their settings are, and they share one picture.
    fn eq(&self, other: &Self) -> bool {
        let settings = |cookie: &Self| {
            (
                cookie.density,
                cookie.size,
                cookie.offset,
                cookie.turn,
                cookie.wrap,
            )
        };
        Arc::ptr_eq(&self.image, &other.image) && settings(self) == settings(other)
    }
}

impl Cookie {
    /// A cookie two metres wide, one metre before the light.
    pub fn new(image: Arc<CookieImage>) -> Self {
        Self {
            image,
            density: 1.0,
            size: 2.0,
            offset: Vec2::ZERO,
            turn: 0.0,
            wrap: [TextureWrap::Repeat; 2],
        }
    }

    /// A cookie that goes once around a point or sphere. The picture should be twice as wide as high; it then covers
    /// all directions.
    pub fn around(image: Arc<CookieImage>) -> Self {
        Self {
            size: std::f32::consts::TAU,
            ..Self::new(image)
        }
    }

    /// Checks that all numbers are usable.
    ///
    /// # Errors
    /// [`CookieError`] for the first number that is out of its range.
    pub fn check(&self) -> Result<(), CookieError> {
        if !(0.0..=1.0).contains(&self.density) {
            return Err(CookieError::Density(self.density));
        }
        if !(1e-6..=1e9).contains(&self.size) {
            return Err(CookieError::Size(self.size));
        }
        if !self.offset.is_finite() {
            return Err(CookieError::Offset(self.offset));
        }
        if !self.turn.is_finite() {
            return Err(CookieError::Turn(self.turn));
        }
        Ok(())
    }

    /// Checks that all numbers are usable, and that the picture fits a kind of light.
    ///
    /// # Errors
    /// [`CookieError`] for the first number that is out of its range, or for a cube before a directional light.
    pub fn check_for(&self, kind: LightKind) -> Result<(), CookieError> {
        self.check()?;
        if self.image.is_cube() && kind == LightKind::Directional {
            return Err(CookieError::Cube);
        }
        Ok(())
    }
}
