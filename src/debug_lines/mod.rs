//! Lines in world space that show what the systems of a frame computed, for debug views.
//!
//! The playground draws them over its picture, and with the feature `bevy-gizmos` a Bevy game draws them as gizmos. They
//! are collected from the world after the frame's systems have run, and only when they are asked for.
//!
//! | subject | shows |
//! | --- | --- |
//! | [`DebugSubject::Sets`] | boxes of the objects, coloured by the smallest set that holds them |
//! | [`DebugSubject::Silhouettes`] | silhouette edges of the casters |
//! | [`DebugSubject::Reach`] | place, extent and range of the light |
//! | [`DebugSubject::Hulls`] | the convex hulls outside which no caster matters |
//! | [`DebugSubject::Region`] | the part of the view that the light can change: its scissor between its depth bounds |
//! | [`DebugSubject::Cells`] | cells and portals |
//!
//! Techniques have lines of their own, such as the faces of maps:
//! [`Techniques::debug_lines`](crate::techniques::Techniques::debug_lines) collects them.
//!
//! | file | subject |
//! | --- | --- |
//! | `lines` | the buffer of lines, and shapes made of lines |
//! | `objects` | sets, silhouettes |
//! | `lights` | reach, hulls, region |
//! | `cells` | cells and portals |

pub(crate) mod cells;
pub(crate) mod lights;
pub(crate) mod lines;
pub(crate) mod objects;

pub use lines::{DebugLine, DebugLines, MOST_DEBUG_LINES};

use bevy_ecs::prelude::*;

use crate::sets::FrameLights;

/// A subject of debug lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
pub enum DebugSubject {
    /// Boxes of the objects, coloured by the sets of a light.
    Sets,
    /// Silhouette edges of the casters of a light, for techniques that use them.
    Silhouettes,
    /// Place, extent and range of a light.
    Reach,
    /// Convex hulls of a light with the view frustum and with its receivers.
    Hulls,
    /// The part of the view that a light can change.
    Region,
    /// Cells and portals of the world.
    Cells,
}

impl DebugSubject {
    /// All subjects.
    pub const ALL: [Self; 6] = [
        Self::Sets,
        Self::Silhouettes,
        Self::Reach,
        Self::Hulls,
        Self::Region,
        Self::Cells,
    ];

    /// Returns a name for users.
    pub fn label(self) -> &'static str {
        match self {
            Self::Sets => "Sets",
            Self::Silhouettes => "Silhouettes",
            Self::Reach => "Reach",
            Self::Hulls => "Hulls",
            Self::Region => "Region",
            Self::Cells => "Cells",
        }
    }

    /// Returns a sentence for users that says what the lines mean.
    pub fn help(self) -> &'static str {
        match self {
            Self::Sets => {
                "Boxes of all objects, coloured by the sets of the light: red casts (S), yellow is lit (I), blue is in \
                 its reach (L), white is seen (V), dark grey is in the frustum but hidden (F)."
            }
            Self::Silhouettes => {
                "The silhouette edges of the casters of the light, for techniques that use them."
            }
            Self::Reach => "Range, cone and extent of the light.",
            Self::Hulls => {
                "The convex hulls outside which no caster matters: of the light and the view in green, of the light and \
                 its receivers in olive."
            }
            Self::Region => {
                "The part of the view outside which the light changes no pixel: the scissor rectangle between the \
                 nearest and the farthest depth."
            }
            Self::Cells => "Cells in grey, open portals in green, closed portals in red.",
        }
    }
}

/// Adds the lines of a subject in the last frame of a world. `light` is an index into [`FrameLights`]; without a light, or
/// with an index that no light has, subjects of lights add nothing, and objects are coloured by the sets of the view.
pub fn draw_debug_lines(subject: DebugSubject, world: &World, light: Option<usize>, out: &mut DebugLines) {
    let lights = world.get_resource::<FrameLights>();
    let light = light.and_then(|index| lights?.lights.get(index));
    match (subject, light) {
        (DebugSubject::Sets, light) => objects::sets(world, light, out),
        (DebugSubject::Cells, _) => cells::cells(world, out),
        (DebugSubject::Silhouettes, Some(light)) => objects::silhouettes(world, light, out),
        (DebugSubject::Reach, Some(light)) => lights::reach(light, out),
        (DebugSubject::Hulls, Some(light)) => lights::hulls(world, light, out),
        (DebugSubject::Region, Some(light)) => lights::region(world, light, out),
        (_, None) => {}
    }
}
