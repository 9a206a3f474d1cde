//! The map of one light: what the light asked for, what it got, and the map's faces.

use bevy_ecs::prelude::Entity;
use fixedbitset::FixedBitSet;
use glam::{DVec3, DVec4};

use super::cascades::DepthRange;
use super::face_state::FaceState;
use super::frame_scene::Scene;
use super::needed_resolution::needed_resolution;
use super::request::{LightRequest, MapFaces, MapRequest, MapShape};
use super::settings::MapResolution;
use crate::sets::{FrameLight, ViewData};

/// The map of one light.
#[derive(Clone, Debug)]
pub struct LightMap {
    /// Index into [`FrameLights`](crate::sets::FrameLights).
    pub light: usize,
    /// Entity of the light.
    pub entity: Entity,
    /// What the light asked for.
    pub request: MapRequest,
    /// Texels along a side.
    pub resolution: u32,
    /// Whether the map is kept.
    pub cached: bool,
    /// Whether the map is looked up in this frame, because a shadow is visible.
    pub active: bool,
    /// Distance to which squared distances are scaled, metres. Source: GPU Gems ch. 12, §12.2.5.
    pub reach: f64,
    /// Distance of the near plane from a light at a position, metres.
    pub near: f64,
    /// Error of the casters' depths, metres, because some reach far away.
    pub rounding: f64,
    /// View depths that cascades share out; other maps ignore them.
    pub(super) range: DepthRange,
    /// Faces of the map, at most as many as the request has.
    pub faces: Vec<FaceState>,
    /// Casters of all faces, by dense object index.
    pub(super) casters: FixedBitSet,
    /// Area of the light's scissor, pixels.
    pub(super) visibility: u64,
    /// Resolution of [`MapResolution::Auto`] before the limits, texels.
    wanted: u32,
    /// Resolution at which a texel is as large as a pixel, texels; 0 while it is unknown.
    pub(super) needed: f64,
    /// Number of frames for which a change has waited.
    pub(super) waited: u64,
    /// Frame up to which all changes are taken over; `None` if some are not.
    pub(super) settled_at: Option<u64>,
    /// The key for which the faces were made.
    pub(super) key: Option<FaceKey>,
    /// The faces that the technique handed over in this frame; empty unless the shape is
    /// [`MapShape::Matrices`].
    pub(super) handed_over: MapFaces,
    /// Number of frames in which other faces were handed over than in the frame before.
    hand_overs: u64,
}

/// Everything on which faces depend, besides the casters, and besides what makes a light
/// [`moved`](FrameLight::moved): its kind, range and shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FaceKey {
    /// The light as a homogeneous point.
    pub point_world: DVec4,
    /// Direction in which the light shines.
    pub direction: DVec3,
    /// Reach of the map, metres.
    pub reach: f64,
    /// Distance within which surfaces do not block the light, metres.
    pub clearance: f64,
    /// Generation of the view, for cascades; number of changes of faces that were handed over.
    pub view: u64,
    /// What the light asked for.
    pub request: MapRequest,
    /// Texels along a side.
    pub resolution: u32,
}

/// Returns the name of the technique for which a light has a map; empty for a light without a technique, which has none.
pub(super) fn asker(light: &FrameLight) -> &'static str {
    light.technique.map_or("", |technique| technique.name)
}

impl LightMap {
    pub(super) fn new(light: &FrameLight, request: MapRequest) -> Self {
        Self {
            light: 0,
            entity: light.entity,
            request,
            resolution: 0,
            cached: false,
            active: false,
            reach: 1.0,
            near: 1e-5,
            rounding: 0.0,
            range: DepthRange::default(),
            faces: Vec::new(),
            casters: FixedBitSet::new(),
            visibility: 0,
            wanted: 0,
            needed: 0.0,
            waited: 0,
            settled_at: None,
            key: None,
            handed_over: MapFaces::new(),
            hand_overs: 0,
        }
    }

    pub(super) fn begin(&mut self, asked: LightRequest, light: &FrameLight, view: Option<&ViewData>) {
        let request = asked.request;
        self.light = asked.light;
        if self.handed_over != asked.faces {
            self.handed_over = asked.faces;
            self.hand_overs += 1;
        }
        if self.request != request {
            // A picture beside the depth shows the settings with which it was drawn.
            let redrawn = self.request.beside != request.beside;
            if redrawn
                || self.request.face_count() != request.face_count()
                || self.request.shape != request.shape
            {
                self.forget();
            }
            // The resolution of another technique's map would stay where this one needs half of it.
            let is_another = self.request.shape != request.shape
                || self.request.beside.is_some() != request.beside.is_some();
            if is_another {
                self.wanted = 0;
            }
            self.request = request;
        }
        self.active = light.region.scissor.is_some() && !light.sets.s.is_clear();
        self.visibility = light.region.scissor.map_or(0, |scissor| scissor.area());
        if let MapResolution::Auto { least, most } = request.resolution {
            self.follow_receivers(light, view, [least, most], asked.stretch);
        }
    }

    /// Brings the wanted resolution up to date with what the visible receivers need.
    fn follow_receivers(
        &mut self,
        light: &FrameLight,
        view: Option<&ViewData>,
        [least, most]: [u32; 2],
        stretch: f64,
    ) {
        let shape = self.request.shape;
        if let (Some(view), Some(scissor)) = (view, light.region.scissor)
            && self.active
            && (light.is_recomputed() || self.wanted == 0)
        {
            self.needed = match shape {
                MapShape::Cascades => f64::from(most),
                // The faces of a handed-over map show about what the view shows.
                MapShape::Matrices => stretch * f64::from(scissor.width.max(scissor.height)),
                MapShape::Spot | MapShape::Cube => {
                    needed_resolution(&self.request, light, view).unwrap_or(self.needed)
                }
            };
            // The limits are far enough apart that a light at rest in a moving view keeps its map.
            let current = f64::from(self.wanted);
            if !(0.4 * current..=1.1 * current).contains(&self.needed) {
                let needed = self.needed.ceil().min(f64::from(most)) as u32;
                self.wanted = needed.next_power_of_two();
            }
        }
        self.wanted = self.wanted.clamp(least, most);
    }

    pub(super) fn wanted_resolution(&self) -> u32 {
        match self.request.resolution {
            MapResolution::Fixed(resolution) => resolution,
            MapResolution::Auto { least, .. } => self.wanted.max(least),
        }
    }

    /// Returns the number of textures of the map, each of 4 bytes a texel: still casters, still and moving casters,
    /// the result of a conversion, the pictures beside the first two, and the technique's own pictures.
    pub fn texture_count(&self) -> u64 {
        let layers = 1 + u64::from(self.has_moving());
        let own = 2 * u64::from(self.request.pictures);
        layers * (1 + u64::from(self.request.beside.is_some())) + u64::from(self.request.has_final()) + own
    }

    /// Returns the memory of the map's textures as bytes for each squared resolution.
    pub fn bytes_per_square(&self) -> u64 {
        4 * u64::from(self.request.face_count()) * self.texture_count()
    }

    /// Returns the casters of all faces, by dense object index.
    pub fn casters(&self) -> &FixedBitSet {
        &self.casters
    }

    /// Whether something moves in any face.
    pub fn has_moving(&self) -> bool {
        self.cached && self.faces.iter().any(|face| !face.moving.is_clear())
    }

    /// Forgets the faces, so that they show nothing any more.
    pub(super) fn forget(&mut self) {
        self.faces.clear();
        self.settled_at = None;
        self.key = None;
    }

    pub(super) fn face_key(&self, light: &FrameLight, scene: &Scene, reach: f64) -> FaceKey {
        FaceKey {
            point_world: light.point_world,
            direction: light.direction.as_dvec3(),
            reach,
            clearance: light.clearance,
            view: match self.request.shape {
                MapShape::Spot | MapShape::Cube => 0,
                MapShape::Cascades => scene.view_generation,
                MapShape::Matrices => self.hand_overs,
            },
            request: self.request,
            resolution: self.resolution,
        }
    }
}
