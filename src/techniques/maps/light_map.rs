//! The map of one light: what it asked for, what it got, and its faces.

use bevy_ecs::prelude::Entity;
use fixedbitset::FixedBitSet;
use glam::{DVec3, DVec4};

use super::face_state::FaceState;
use super::members::Scene;
use super::request::{MapRequest, MapShape};
use super::settings::MapResolution;
use crate::sets::FrameLight;

/// The map of one light.
#[derive(Clone, Debug)]
pub struct LightMap {
    /// Index into [`FrameLights`](crate::sets::FrameLights).
    pub light: usize,
    /// The light.
    pub entity: Entity,
    /// What it asked for.
    pub request: MapRequest,
    /// Texels along a side.
    pub resolution: u32,
    /// The map is kept.
    pub cached: bool,
    /// A shadow can be seen: the map is looked up in this frame.
    pub active: bool,
    /// Distance to which squared distances are scaled, metres. Source: GPU Gems ch. 12, §12.2.5.
    pub reach: f64,
    /// Its faces; no more than the request's.
    pub faces: Vec<FaceState>,
    /// Casters of all faces.
    pub(super) casters: FixedBitSet,
    /// Scissor's area, pixels.
    pub(super) visibility: u64,
    /// Of [`MapResolution::Auto`], before the limits.
    wanted: u32,
    /// Frames for which a change has waited.
    pub(super) waited: u64,
    /// Frame up to which all changes are taken in; `None`: not all are.
    pub(super) settled_at: Option<u64>,
    /// What the faces were made for.
    pub(super) key: Option<FaceKey>,
}

/// What faces depend on, beside the casters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FaceKey {
    /// The light.
    pub point_world: DVec4,
    /// Where it shines to.
    pub direction: DVec3,
    /// Metres.
    pub reach: f64,
    /// Generation of the view, for cascades.
    pub view: u64,
    /// What was asked for.
    pub request: MapRequest,
    /// Texels.
    pub resolution: u32,
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
            faces: Vec::new(),
            casters: FixedBitSet::new(),
            visibility: 0,
            wanted: 0,
            waited: 0,
            settled_at: None,
            key: None,
        }
    }

    pub(super) fn begin(&mut self, index: usize, light: &FrameLight, request: MapRequest) {
        self.light = index;
        if self.request != request {
            if self.request.face_count() != request.face_count() || self.request.shape != request.shape {
                self.forget();
            }
            self.request = request;
        }
        self.active = light.scissor.is_some() && !light.s.is_clear();
        self.visibility = light.scissor.map_or(0, |scissor| scissor.area());
        if let (MapResolution::Auto { least, most }, Some(scissor)) = (request.resolution, light.scissor) {
            let longest = f64::from(scissor.width.max(scissor.height));
            let ideal = match request.shape {
                MapShape::Spot => longest,
                MapShape::Cube => 0.5 * longest, // a face shows a quarter of the way round
                MapShape::Cascades => f64::from(most),
            };
            // Wide enough apart that a light at rest in a moving view keeps its map.
            let current = f64::from(self.resolution);
            if !(0.4 * current..=1.1 * current).contains(&ideal) || self.wanted == 0 {
                self.wanted = (ideal.ceil() as u32).next_power_of_two();
            }
            self.wanted = self.wanted.clamp(least, most);
        }
    }

    pub(super) fn wanted_resolution(&self) -> u32 {
        match self.request.resolution {
            MapResolution::Fixed(resolution) => resolution,
            MapResolution::Auto { least, .. } => self.wanted.max(least),
        }
    }

    /// Textures of the map: still casters, those with moving ones over them, and what is made of these.
    pub fn texture_count(&self) -> u64 {
        1 + u64::from(self.has_moving()) + u64::from(self.request.has_final())
    }

    /// Casters of all faces, by dense object index.
    pub fn casters(&self) -> &FixedBitSet {
        &self.casters
    }

    /// Whether something moves in any face.
    pub fn has_moving(&self) -> bool {
        self.cached && self.faces.iter().any(|face| !face.moving.is_clear())
    }

    /// Its faces show nothing any more.
    pub(super) fn forget(&mut self) {
        self.faces.clear();
        self.settled_at = None;
        self.key = None;
    }

    pub(super) fn face_key(&self, light: &FrameLight, scene: &Scene, reach: f64) -> FaceKey {
        let cascades = self.request.shape == MapShape::Cascades;
        FaceKey {
            point_world: light.point_world,
            direction: light.direction.as_dvec3(),
            reach,
            view: if cascades { scene.view_generation } else { 0 },
            request: self.request,
            resolution: self.resolution,
        }
    }
}
