//! The limit on the memory of all textures, and what each light asked for and got in this frame.

use bevy_ecs::prelude::*;

use super::share_out::{RankedWant, Scratch, TextureGrant, TextureWant, share_out, total_bytes};
use crate::sets::FrameLights;

/// The limit on the memory of the textures that lights have of their own, whatever their techniques, and what each light
/// gets in this frame. In Bevy each camera has its own, with the limit of `AntumbraSettings::texture_memory`.
///
/// ```
/// use antumbra::prelude::*;
/// use antumbra::techniques::{Storage, TextureMemory, TextureMemorySystems, TextureWant};
/// use bevy_ecs::prelude::*;
/// # type MyShadow = StencilVolume;
///
/// fn ask(mut memory: ResMut<TextureMemory>, lights: Res<FrameLights>) {
///     for (index, light) in lights.lights.iter().enumerate() {
///         if light.is_shadowed_by::<MyShadow>() {
///             let want = TextureWant {
///                 bytes_per_square: 8, // two textures of 4 bytes a texel
///                 resolution: 512,
///                 least: 64,
///                 storage: Storage::OwnElseNothing,
///             };
///             memory.ask(index, "my_shadow", want);
///         }
///     }
/// }
///
/// fn build(memory: Res<TextureMemory>) {
///     if let Some(grant) = memory.grant(0, "my_shadow") {
///         println!("The first light has {} texels along a side.", grant.resolution);
///     }
/// }
///
/// let mut schedule = antumbra::schedule::standalone_schedule();
/// schedule.add_systems((
///     ask.in_set(TextureMemorySystems::Ask),
///     build.in_set(TextureMemorySystems::Build),
/// ));
/// ```
#[derive(Resource, Clone, Debug)]
pub struct TextureMemory {
    /// Limit on the memory of all textures that lights have of their own, bytes. Beyond it, the lights with the most bytes
    /// for each pixel that they reach lose resolution first; then the least visible lose their textures. Higher values keep shadows sharp with many lights. Default: 256 MiB.
    pub limit: u64,
    bytes: u64,
    shortages: Vec<TextureShortage>,
    /// Wants of this frame; sorted by light and asker once they are shared.
    asked: Vec<Asked>,
    /// Whether `asked` is shared out, so that the next want begins another frame.
    is_shared: bool,
    wants: Vec<RankedWant>,
    grants: Vec<Option<TextureGrant>>,
    scratch: Scratch,
}

impl Default for TextureMemory {
    fn default() -> Self {
        Self {
            limit: 256 << 20,
            bytes: 0,
            shortages: Vec::new(),
            asked: Vec::new(),
            is_shared: false,
            wants: Vec::new(),
            grants: Vec::new(),
            scratch: Scratch::default(),
        }
    }
}

/// A want and who has it.
#[derive(Clone, Copy, Debug)]
struct Asked {
    light: usize,
    asker: &'static str,
    want: TextureWant,
}

/// A light that got less memory than it asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TextureShortage {
    /// Entity of the light.
    pub entity: Entity,
    /// The name with which [`TextureMemory::ask`] was called: that of the technique.
    pub asker: &'static str,
    /// What the light got instead.
    pub shortage: Shortage,
}

/// What a light got instead of the textures that it asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Shortage {
    /// The textures are coarser.
    #[error("memory for textures is short: resolution {wanted} became {given}")]
    Coarser {
        /// Resolution that was asked for, texels.
        wanted: u32,
        /// Resolution that the textures have, texels.
        given: u32,
    },
    /// The light has no textures of its own. It shares textures in turn, and they are drawn every frame.
    #[error(
        "memory for textures is short: the light's are not kept, and drawn every frame at resolution {given}"
    )]
    Shared {
        /// Resolution that the textures have, texels.
        given: u32,
    },
    /// The light gets nothing.
    #[error("memory for textures is short: the light gets none")]
    Nothing,
}

impl Shortage {
    fn between(wanted: u32, is_own_wanted: bool, grant: Option<TextureGrant>) -> Option<Self> {
        let Some(TextureGrant { resolution, is_own }) = grant else {
            return Some(Self::Nothing);
        };
        if is_own_wanted && !is_own {
            return Some(Self::Shared { given: resolution });
        }
        (resolution < wanted).then_some(Self::Coarser {
            wanted,
            given: resolution,
        })
    }
}

impl TextureMemory {
    /// Asks for textures of a light of this frame, given by its index in [`FrameLights`]. `asker` is the name of the
    /// technique ([`Technique::NAME`](crate::techniques::Technique::NAME)), or of whatever else needs textures for a light.
    /// It may ask once for each light. Call it in the set [`TextureMemorySystems::Ask`](super::TextureMemorySystems::Ask),
    /// every frame, for lights out of view too if their textures are to be kept.
    pub fn ask(&mut self, light: usize, asker: &'static str, want: TextureWant) {
        if std::mem::take(&mut self.is_shared) {
            self.asked.clear();
        }
        self.asked.push(Asked { light, asker, want });
    }

    /// Returns what a light gets in this frame. `None` if it did not ask or gets nothing. Call it in the set
    /// [`TextureMemorySystems::Build`](super::TextureMemorySystems::Build) or later.
    pub fn grant(&self, light: usize, asker: &str) -> Option<TextureGrant> {
        if !self.is_shared {
            return None;
        }
        let at = self
            .asked
            .binary_search_by_key(&(light, asker), |asked| (asked.light, asked.asker))
            .ok()?;
        self.grants.get(at).copied().flatten()
    }

    /// Returns the memory of the textures that lights have of their own in this frame, bytes.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Returns the lights that got less than they asked for in this frame, in the order of their entities.
    pub fn shortages(&self) -> &[TextureShortage] {
        &self.shortages
    }

    /// Shares the memory among all who asked since the last call.
    pub(super) fn share(&mut self, lights: &FrameLights) {
        if std::mem::replace(&mut self.is_shared, true) {
            self.asked.clear(); // nobody asked in this frame
        }
        // Techniques ask in any order, and the result must not depend on it.
        self.asked
            .sort_unstable_by_key(|asked| (asked.light, asked.asker));
        self.wants.clear();
        self.wants.extend(self.asked.iter().map(|asked| {
            let light = lights.lights.get(asked.light);
            let area = light
                .and_then(|light| light.region.scissor)
                .map_or(0, |scissor| scissor.area());
            RankedWant {
                want: asked.want,
                // Visibility goes in steps, so that small moves of the view do not replace textures.
                visibility: area.checked_ilog2().map_or(0, |log| log + 1),
            }
        }));
        share_out(&self.wants, self.limit, &mut self.grants, &mut self.scratch);
        self.bytes = total_bytes(&self.wants, &self.grants);
        self.shortages.clear();
        for (asked, grant) in self.asked.iter().zip(&self.grants) {
            let is_own_wanted = asked.want.storage != super::Storage::Shared;
            let shortage = Shortage::between(asked.want.resolution, is_own_wanted, *grant);
            if let (Some(shortage), Some(light)) = (shortage, lights.lights.get(asked.light)) {
                self.shortages.push(TextureShortage {
                    entity: light.entity,
                    asker: asked.asker,
                    shortage,
                });
            }
        }
    }
}
