//! Settings of occlusion: which sets leave out hidden objects, and at what cost.

use bevy_ecs::prelude::*;

/// Settings of occlusion: which sets leave out hidden objects, and how much work that may take. They change
/// the cost of a frame and never its picture.
///
/// By default everything is on. With a software driver, frames of all measured scenes became faster
/// (`examples/visibility_table` prints the time of the sets beside that of the frame). A scene without
/// occluders and cells pays nothing, nor do lights at rest. A frame in which the camera moves pays for the
/// triangles of [`triangle_budget`](Self::triangle_budget), some 0.2 µs each on one core. Where drawing costs
/// less than that, lower the budget or switch off `from_camera`.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct OcclusionSettings {
    /// Whether V leaves out objects that are occluded from the camera; default `true`. If off, V = F: the CPU
    /// draws no depth buffer for the camera and follows no portals, and the GPU draws hidden objects.
    pub from_camera: bool,
    /// Whether L of lights with a shadow technique leaves out objects that are occluded from the light;
    /// default `true`. If off, L is everything that the light reaches: the CPU draws no depth buffers for
    /// lights and follows no portals, and lights draw objects that they cannot see.
    pub from_lights: bool,
    /// Whether S leaves out casters whose shadow cannot reach anything lit in view; default `true`. If off, S
    /// is all casters of L, and more shadows are drawn.
    pub of_shadows: bool,
    /// Which objects without an [`Occluder`](crate::scene::Occluder) hide others; default
    /// [`AutoOccluders::default`]. With `None` only objects with that component do.
    pub auto: Option<AutoOccluders>,
    /// Width of the camera's depth buffer, texels; 16 to 2048, default 256. Its height follows from the
    /// picture's shape. Higher values find more hidden objects behind small or narrow occluders; time and
    /// memory grow with the square of the value.
    pub camera_texels: u32,
    /// Width of each face of a light's depth buffer, texels; 16 to 1024, default 96. Higher values find more
    /// objects hidden from lights; time and memory grow with the square of the value, for each face of each
    /// light.
    pub light_texels: u32,
    /// Most triangles that are rasterised for one viewpoint; default 32768. Objects that cover most for each
    /// of their triangles come first. Higher values hide more objects and cost some 0.2 µs for each triangle;
    /// 0 rasterises nothing.
    pub triangle_budget: usize,
}

/// The conditions on which an object without an [`Occluder`](crate::scene::Occluder) hides others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AutoOccluders {
    /// Least area of the largest face of the object's world bounds, square metres; default 1. Lower values
    /// make more, smaller objects occluders, which compete for the triangle budget.
    pub min_area: f32,
    /// Most triangles that the object's mesh may have; default 4096. Higher values let more detailed objects
    /// hide others and cost more to rasterise.
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
    /// No occlusion: only the frustum and light volumes cull, as in the first row of table 15-1.
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
