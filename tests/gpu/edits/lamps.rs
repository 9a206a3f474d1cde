//! What may happen to a light between two frames.

use antumbra::prelude::*;
use antumbra::scene::{
    BarnMap, LightDistance, LightShape, LightWeights, ShadowOrigin, ShadowSoftness, ShadowTint,
};
use antumbra::techniques::maps::{Cascades, MapFilter, MapFormat, MapResolution, MapSurface};
use antumbra::techniques::occlusion_texture::{SliceCombination, SliceFilter};
use antumbra::techniques::penumbra_wedge::{Overlap, VisibilityBuffer, WedgeSilhouette};
use antumbra::techniques::perspective_map::{MapFocus, PerspectiveFaces, PerspectiveProjection};
use antumbra::techniques::stencil_volume::{Counting, Extent};
use glam::Vec3;

use super::changes::Changes;
use super::spec::{IMAGES, Lamp};

impl Changes {
    pub(super) fn change_kind(&mut self, lamp: &mut Lamp) {
        let kind = self.of(&[
            LightKind::Point,
            LightKind::Spot {
                inner_angle: 0.3,
                outer_angle: 0.7,
            },
            LightKind::Directional,
            LightKind::Rect {
                width: 0.8,
                height: 0.4,
            },
            LightKind::Sphere { radius: 0.3 },
        ]);
        if let Some(light) = &mut lamp.light {
            light.kind = kind;
            light.intensity = if kind == LightKind::Directional { 2.0 } else { 20.0 };
        }
    }

    pub(super) fn change_technique(&mut self, lamp: &mut Lamp) {
        if !self.one_in(6) {
            lamp.without_technique();
        }
        let resolution = self.of(&[
            MapResolution::Fixed(64),
            MapResolution::Fixed(32),
            MapResolution::Fixed(128),
        ]);
        let filter = self.of(&[
            MapFilter::Bilinear,
            MapFilter::Brute4x4,
            MapFilter::Soft4 { softness: 0.02 },
            MapFilter::Jittered {
                softness: 0.03,
                adaptive: true,
            },
        ]);
        let surface = self.of(&[MapSurface::Nearest, MapSurface::Second, MapSurface::Midpoint]);
        let cached = !self.one_in(4);
        let near = self.of(&[None, Some(0.3)]);
        let cascades = Cascades {
            count: self.of(&[1, 2, 3]),
            distance: self.of(&[f32::INFINITY, 8.0]),
            ..Default::default()
        };
        match self.random.u32(0..9) {
            0 => {}
            1 | 2 => {
                lamp.stencil = Some(StencilVolume {
                    counting: self.of(&[Counting::Auto, Counting::DepthFail]),
                    extent: self.of(&[Extent::Finite, Extent::Infinite]),
                });
            }
            3 => {
                lamp.wedge = Some(PenumbraWedge {
                    split: self.of(&[[1, 1], [2, 1]]),
                    silhouette: self.of(&[WedgeSilhouette::Receiver, WedgeSilhouette::Center]),
                    overlap: self.of(&[Overlap::Sampled, Overlap::Additive, Overlap::Paper]),
                    buffer: self.of(&[
                        VisibilityBuffer::Float,
                        VisibilityBuffer::Half,
                        VisibilityBuffer::Split8,
                    ]),
                    ..Default::default()
                });
            }
            4 => {
                lamp.map = Some(ShadowMap {
                    resolution,
                    filter,
                    surface,
                    cached,
                    near,
                    cascades,
                    ..Default::default()
                });
            }
            5 => {
                lamp.omni = Some(OmniMap {
                    resolution,
                    filter,
                    surface,
                    cached,
                    near,
                    format: self.of(&[MapFormat::Depth, MapFormat::R32Float, MapFormat::Rgba8FourBytes]),
                    ..Default::default()
                });
            }
            6 => {
                lamp.perspective = Some(PerspectiveMap {
                    resolution,
                    filter,
                    cached,
                    near,
                    projection: self.of(&[PerspectiveProjection::Inverse, PerspectiveProjection::SlideBack]),
                    faces: PerspectiveFaces::Cube, // one picture is exchanged for several only when that pays
                    focus: self.of(&[MapFocus::Receivers, MapFocus::All]),
                    ..Default::default()
                });
            }
            7 => {
                lamp.smoothie = Some(Smoothie {
                    resolution,
                    cached,
                    near,
                    cascades,
                    ..Default::default()
                });
            }
            _ => {
                lamp.slices = Some(OcclusionTexture {
                    slices: self.of(&[4, 8]),
                    resolution: self.of(&[32, 64]),
                    filter: self.of(&[
                        SliceFilter::NBuffers,
                        SliceFilter::Mipmaps,
                        SliceFilter::SummedAreas,
                    ]),
                    combine: self.of(&[SliceCombination::Overlap, SliceCombination::Product]),
                    close_leaks: self.of(&[0, u32::MAX, 2]),
                    ..Default::default()
                });
            }
        }
    }

    pub(super) fn change_lamp(&mut self, lamp: &mut Lamp) {
        match self.random.u32(0..22) {
            0..=3 => lamp.place = self.lamp_place(),
            4 => lamp.place.translation.y += 0.2,
            5 | 6 => self.change_kind(lamp),
            7..=9 => self.change_technique(lamp),
            10 => {
                let intensity = self.of(&[0.0, 20.0, f32::INFINITY, 7.0]);
                if let Some(light) = &mut lamp.light {
                    light.intensity = intensity;
                }
            }
            11 => {
                let range = self.of(&[1.5, 6.0, 20.0, f32::INFINITY]);
                if let Some(light) = &mut lamp.light {
                    light.range = range;
                }
            }
            12 => {
                lamp.light = match lamp.light {
                    Some(_) => None,
                    None => Some(Light::point(Vec3::ONE, 20.0, 20.0)),
                }
            }
            13 => {
                lamp.selection = Some(LightSelection {
                    affects: self.of(&[1, 2, u32::MAX]),
                    casts_for: self.of(&[1, 2, u32::MAX]),
                    shows_on: self.of(&[1, 2, u32::MAX]),
                });
            }
            14 => lamp.parent = self.of(&[None, Some(0), Some(1)]),
            15 => {
                let round = self.of(&[0.0, 0.5, 1.0]);
                lamp.shape = self.maybe(LightShape {
                    width: 0.8,
                    height: 0.6,
                    width_edge: 0.2,
                    height_edge: 0.2,
                    round,
                });
            }
            16 => {
                let (near, far) = (self.of(&[0.0, 1.0]), self.of(&[3.0, 50.0]));
                lamp.distance = self.maybe(LightDistance {
                    near,
                    far,
                    ..Default::default()
                });
            }
            17 => {
                let darkness = self.of(&[0.0, 0.5, 1.0]);
                lamp.tint = self.maybe(ShadowTint {
                    darkness,
                    ..Default::default()
                });
                let diffuse = self.of(&[0.0, 0.5, 1.0]);
                lamp.weights = self.maybe(LightWeights {
                    diffuse,
                    ..Default::default()
                });
            }
            18 => {
                lamp.origin = self.of(&[
                    None,
                    Some(ShadowOrigin::Position(Vec3::new(0.7, 3.0, 0.5))),
                    Some(ShadowOrigin::Direction(Vec3::new(0.3, -1.0, 0.2))),
                ]);
            }
            19 => lamp.softness = self.of(&[None, Some(0.0), Some(0.2)]).map(ShadowSoftness),
            20 => {
                let image = self.of(&*IMAGES);
                lamp.cookie = self.maybe(Cookie::new(image));
            }
            _ => {
                lamp.profile = self.of(&[None, Some(0), Some(1)]);
                lamp.barn_map = self.maybe(BarnMap { resolution: 32 });
            }
        }
    }
}
