//! The cookie and the profile of a shot's light.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::scene::{CookieError, CookieImage, TextureWrap};
use glam::Vec3;
use serde::Deserialize;

/// A cookie as the file has it.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ShotCookie {
    /// Path of the picture, relative to the shot file.
    pub path: PathBuf,
    /// Whether the picture holds the six faces of a cube around the light. Its proportions tell their arrangement.
    #[serde(default)]
    pub cube: bool,
    /// Strength, 0 to 1.
    #[serde(default = "whole")]
    pub density: f32,
    /// Width: metres on the plane one metre before the light, metres for a directional light, radians around a point
    /// or sphere. Default: 2, and once around a point or sphere.
    pub size: Option<f32>,
    /// Offset to the right and upwards, seen from the light, in the units of `size`.
    #[serde(default)]
    pub offset: [f32; 2],
    /// Counterclockwise turn, seen from the light, degrees.
    #[serde(default)]
    pub turn_deg: f32,
    /// How the picture continues beyond its borders.
    #[serde(default)]
    pub wrap: ShotWrap,
}

fn whole() -> f32 {
    1.0
}

/// How a cookie continues beyond its borders.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ShotWrap {
    /// The picture repeats.
    #[default]
    Repeat,
    /// The picture repeats, mirrored every other time.
    Mirror,
    /// The texels of the border extend outward.
    Clamp,
}

impl ShotCookie {
    /// The component with a picture.
    fn with(&self, image: Arc<CookieImage>, kind: LightKind) -> Cookie {
        let wrap = match self.wrap {
            ShotWrap::Repeat => TextureWrap::Repeat,
            ShotWrap::Mirror => TextureWrap::Mirror,
            ShotWrap::Clamp => TextureWrap::Clamp,
        };
        let cookie = match kind {
            LightKind::Point | LightKind::Sphere { .. } => Cookie::around(image),
            _ => Cookie::new(image),
        };
        Cookie {
            density: self.density,
            size: self.size.unwrap_or(cookie.size),
            offset: self.offset.into(),
            turn: self.turn_deg.to_radians(),
            wrap: [wrap; 2],
            ..cookie
        }
    }

    /// Reads the picture and returns the component.
    ///
    /// # Errors
    /// Names the file and says what is wrong with it.
    pub fn load(&self, kind: LightKind) -> Result<Cookie, String> {
        let load = if self.cube {
            CookieImage::load_cube
        } else {
            CookieImage::load
        };
        let image = load(&self.path).map_err(|error| format!("cookie.path: {error}"))?;
        Ok(self.with(image, kind))
    }

    /// Checks the numbers for a kind of light. The picture is not read.
    ///
    /// # Errors
    /// Names the first number that cannot be used.
    pub fn check(&self, kind: LightKind) -> Result<(), String> {
        if self.cube && kind == LightKind::Directional {
            return Err(format!("cookie.cube: {}", CookieError::Cube));
        }
        let any = CookieImage::from_linear("", 1, 1, vec![Vec3::ONE]).map_err(|error| error.to_string())?;
        let checked = self.with(any, kind).check();
        checked.map_err(|error| format!("cookie: {error}"))
    }
}

/// Reads a profile.
///
/// # Errors
/// Names the file and the line.
pub fn load_profile(path: &Path) -> Result<LightProfile, String> {
    LightProfile::load(path).map_err(|error| format!("profile: {error}"))
}

/// Checks that a light of this kind can have a profile.
///
/// # Errors
/// The light has only one direction.
pub fn check_profile(kind: LightKind) -> Result<(), String> {
    if kind == LightKind::Directional {
        return Err("profile: does not fit a directional light, whose light has one direction".to_owned());
    }
    Ok(())
}
