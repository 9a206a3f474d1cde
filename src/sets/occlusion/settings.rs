//! What is left out because something stands before it.

use bevy_ecs::prelude::*;

/// Which sets occlusion shrinks, and how much work that may be. Each switch changes what a frame costs and never what it
/// shows.
///
/// All are on: with a software driver frames of all scenes measured became faster (`examples/visibility_table` prints the
/// time of the sets beside that of the frame), and a scene without occluders and cells pays nothing. A frame in which the
/// camera moves pays for the triangles of [`triangle_budget`](Self::triangle_budget), some 0.2 µs each on one core; where
/// draws are cheaper than that, lower it or leave `from_camera` off. Lights at rest pay nothing.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct OcclusionSettings {
    /// V leaves out what is occluded from the camera; else V = F.
    pub from_camera: bool,
    /// L of lights with a shadow technique leaves out what is occluded from the light; else all that it reaches.
    pub from_lights: bool,
    /// S leaves out casters whose shadow cannot reach what is lit in view; else it is all casters of L.
    pub of_shadows: bool,
    /// Which objects without an [`Occluder`](crate::scene::Occluder) hide others; `None`: none of them.
    pub auto: Option<AutoOccluders>,
    /// Width of the camera's depth buffer, texels, 16..=2048; its height follows from the picture's shape.
    pub camera_texels: u32,
    /// Width of each face of a light's depth buffer, texels, 16..=1024.
    pub light_texels: u32,
    /// Triangles that are rasterised for one viewpoint at most; the objects that cover most for each of their triangles
    /// come first.
    pub triangle_budget: usize,
}

/// What an object must be to hide others without being told to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AutoOccluders {
    /// Area of the largest face of its world bounds, square metres.
    pub min_area: f32,
    /// Triangles of its mesh.
    pub max_triangles: usize,
}

impl Default for AutoOccluders {
    fn default() -> Self {
        Self {
            min_area: 1.0,
            max_triangles: 4096,
        }
    }
}

impl Default for OcclusionSettings {
    fn default() -> Self {
        Self {
            from_camera: true,
            from_lights: true,
            of_shadows: true,
            auto: Some(AutoOccluders::default()),
            camera_texels: 256,
            light_texels: 96,
            triangle_budget: 1 << 15,
        }
    }
}

impl OcclusionSettings {
    /// Frustum and light volumes alone, as the first row of table 15-1 has them.
    pub const NONE: Self = Self {
        from_camera: false,
        from_lights: false,
        of_shadows: false,
        auto: None,
        camera_texels: 16,
        light_texels: 16,
        triangle_budget: 0,
    };
}
