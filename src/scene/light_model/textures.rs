//! The textures of one light: the usable ones of its cookie and its profile.

use super::cookie::Cookie;
use super::model::LightModelFault;
use super::profile::LightProfile;
use crate::scene::LightKind;

/// The textures that scale what one light gives. Those that are missing, change nothing or cannot be used are left
/// out.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightTextures {
    /// Picture before the light.
    pub cookie: Option<Cookie>,
    /// Intensity by direction.
    pub profile: Option<LightProfile>,
}

impl LightTextures {
    /// Gathers the usable textures of a light. Calls `fault` for each one that is not usable.
    pub fn of(
        cookie: Option<&Cookie>,
        profile: Option<&LightProfile>,
        kind: LightKind,
        mut fault: impl FnMut(LightModelFault),
    ) -> Self {
        let cookie = cookie.filter(|cookie| match cookie.check_for(kind) {
            Ok(()) => cookie.density > 0.0,
            Err(error) => {
                fault(LightModelFault::Cookie(error));
                false
            }
        });
        let profile = profile.filter(|_| {
            let has_directions = kind != LightKind::Directional;
            if !has_directions {
                fault(LightModelFault::Directional("LightProfile"));
            }
            has_directions
        });
        Self {
            cookie: cookie.cloned(),
            profile: profile.cloned(),
        }
    }

    /// Whether the light has neither.
    pub fn is_empty(&self) -> bool {
        self.cookie.is_none() && self.profile.is_none()
    }
}
