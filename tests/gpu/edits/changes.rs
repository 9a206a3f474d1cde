//! What may happen to a scene between two frames.

use antumbra::prelude::*;
use antumbra::scene::{BlurredGround, IgnoresScale, MorphWeights, SurfaceWeights, TextureSlot};
use antumbra::sets::OcclusionSettings;
use bevy_transform::prelude::Transform;
use fastrand::Rng;
use glam::{Affine2, Quat, UVec2, Vec2, Vec3};

use super::spec::{Lamp, SHAPES, Shape, Spec, TEXTURES, Thing, extra};
use super::world::{Blink, Step};

/// A source of changes.
pub struct Changes {
    pub random: Rng,
    next_id: u32,
}

/// Index of the large ground in [`SHAPES`].
const GROUND: usize = 6;

/// Settings without occluders that are chosen by their size: the choice is made anew only when objects come or go.
pub fn usual() -> OcclusionSettings {
    OcclusionSettings {
        auto: None,
        ..Default::default()
    }
}

impl Changes {
    pub fn new(seed: u64) -> Self {
        Self {
            random: Rng::with_seed(seed),
            next_id: 0,
        }
    }

    pub(super) fn id(&mut self) -> u32 {
        self.next_id += 1;
        self.next_id
    }

    pub(super) fn one_in(&mut self, count: u32) -> bool {
        self.random.u32(0..count) == 0
    }

    pub(super) fn of<T: Clone>(&mut self, all: &[T]) -> T {
        all[self.random.usize(0..all.len())].clone()
    }

    pub(super) fn maybe<T>(&mut self, value: T) -> Option<T> {
        self.random.bool().then_some(value)
    }

    /// A scene to begin with.
    pub fn first(&mut self) -> Step {
        let mut spec = Spec {
            things: vec![Thing::new(self.id(), GROUND)],
            lamps: Vec::new(),
            pivots: [Transform::IDENTITY, Transform::from_xyz(0.5, 0.3, -0.5)],
            camera: Some(Camera::default()),
            eye: Transform::from_xyz(1.5, 3.5, 6.0).looking_at(Vec3::new(0.0, 0.4, 0.0), Vec3::Y),
            ignores_scale: None,
            size: UVec2::new(48, 27),
            culling: FaceCulling::default(),
            culled: CulledCasters::default(),
            occlusion: usual(),
            ambient: Vec3::splat(0.05),
            scissor: true,
            depth_bounds: true,
            cells: [None; 2],
            portal: None,
        };
        for _ in 0..self.random.u32(2..=5) {
            self.add_thing(&mut spec);
        }
        for _ in 0..self.random.u32(1..=3) {
            self.add_lamp(&mut spec);
        }
        Step {
            spec,
            in_place: true,
            blinks: Vec::new(),
            draws: true,
        }
    }

    /// The step after another.
    pub fn next(&mut self, last: &Step) -> Step {
        let mut step = last.clone();
        step.blinks.clear();
        step.in_place = self.random.bool();
        step.draws = !self.one_in(4);
        for _ in 0..self.random.u32(1..=4) {
            self.change(&mut step);
        }
        step
    }

    fn change(&mut self, step: &mut Step) {
        let spec = &mut step.spec;
        match self.random.u32(0..30) {
            0 => self.add_thing(spec),
            1 if spec.things.len() > 2 => {
                spec.things.swap_remove(self.random.usize(0..spec.things.len()));
            }
            2 => self.add_lamp(spec),
            3 if spec.lamps.len() > 1 => {
                spec.lamps.swap_remove(self.random.usize(0..spec.lamps.len()));
            }
            4 => {
                // Another entity takes its place.
                let at = self.random.usize(0..spec.things.len());
                spec.things[at].id = self.id();
            }
            5 => {
                let ids = spec.things.iter().map(|thing| thing.id);
                let ids: Vec<u32> = ids.chain(spec.lamps.iter().map(|lamp| lamp.id)).collect();
                step.blinks.push(Blink {
                    id: self.of(&ids),
                    part: self.random.u8(0..12),
                });
            }
            6..=9 => self.change_view(spec),
            10 => {
                let at = self.random.usize(0..2);
                spec.pivots[at] = self.place();
            }
            11..=19 => {
                let at = self.random.usize(0..spec.lamps.len());
                self.change_lamp(&mut spec.lamps[at]);
            }
            20 => self.change_cells(spec),
            _ => {
                let at = self.random.usize(0..spec.things.len());
                self.change_thing(&mut spec.things[at]);
            }
        }
    }

    fn add_thing(&mut self, spec: &mut Spec) {
        if spec.things.len() >= 8 {
            return;
        }
        let shape = self.random.usize(0..SHAPES.len());
        let mut thing = Thing::new(self.id(), shape);
        thing.place = self.place();
        spec.things.push(thing);
    }

    fn add_lamp(&mut self, spec: &mut Spec) {
        if spec.lamps.len() >= 4 {
            return;
        }
        let mut lamp = Lamp::new(self.id());
        lamp.place = self.lamp_place();
        self.change_kind(&mut lamp);
        self.change_technique(&mut lamp);
        spec.lamps.push(lamp);
    }

    fn turn(&mut self) -> Quat {
        let turns = [
            Quat::IDENTITY,
            Quat::from_rotation_y(0.7),
            Quat::from_rotation_x(1.2),
            Quat::from_euler(glam::EulerRot::XYZ, 0.3, 1.1, -0.4),
        ];
        self.of(&turns)
    }

    fn place(&mut self) -> Transform {
        let scale = match self.random.u32(0..10) {
            0 => Vec3::ZERO,
            1 => Vec3::new(1.0, 0.0, 1.0),
            2 => Vec3::new(-1.0, 1.0, 1.0),
            3 => Vec3::new(1.0, 2.0, 0.5),
            4 => Vec3::splat(1.5),
            _ => Vec3::ONE,
        };
        let x = self.of(&[-2.0, -1.0, 0.0, 0.5, 1.5, 40.0]);
        let y = self.of(&[0.0, 0.5, 0.9, 1.6]);
        let z = self.of(&[-2.0, -0.5, 0.0, 1.0, 2.0]);
        Transform {
            translation: Vec3::new(x, y, z),
            rotation: self.turn(),
            scale,
        }
    }

    pub(super) fn lamp_place(&mut self) -> Transform {
        let x = self.of(&[-1.5, -0.3, 0.4, 2.0, 60.0]);
        let y = self.of(&[0.9, 2.2, 3.1, 4.5]);
        let z = self.of(&[-1.5, 0.2, 1.4]);
        let target = self.of(&[Vec3::ZERO, Vec3::new(1.0, 0.0, -1.0), Vec3::new(0.0, 9.0, 0.1)]);
        let mut place = Transform::from_xyz(x, y, z).looking_at(target, Vec3::Z);
        if self.one_in(12) {
            place.scale = self.of(&[Vec3::ZERO, Vec3::new(-1.0, 1.0, 1.0)]);
        }
        place
    }

    fn change_thing(&mut self, thing: &mut Thing) {
        match self.random.u32(0..18) {
            0..=3 => thing.place = self.place(),
            4 => thing.place.translation.x += 0.1,
            5 => {
                thing.shape = if self.one_in(5) {
                    None
                } else {
                    Some(Shape {
                        at: self.random.usize(0..SHAPES.len()),
                        grown: 1.0,
                    })
                };
            }
            6 => {
                let grown = self.of(&[0.6, 1.2, 1.5]);
                if let Some(shape) = &mut thing.shape {
                    shape.grown = grown;
                }
            }
            7..=9 => self.change_material(thing),
            10 => thing.caster = self.maybe(ShadowCaster),
            11 => thing.receiver = self.maybe(ShadowReceiver),
            12 => {
                thing.layers = self
                    .of(&[None, Some(1), Some(2), Some(3), Some(0)])
                    .map(SelectionLayers)
            }
            13 => thing.occluder = self.of(&[None, Some(0), Some(1), Some(2)]),
            14 => {
                let weight = self.of(&[0.0, 0.5, 1.0]);
                thing.morph = self.maybe(MorphWeights(vec![weight]));
            }
            15 => {
                thing.skin = self.of(&[None, Some(0), Some(1)]);
            }
            16 => match self.random.u32(0..3) {
                0 => thing.blurred = self.maybe(BlurredGround::default()),
                1 => thing.extra = self.maybe(extra()),
                _ => {
                    let diffuse = self.of(&[0.0, 0.5]);
                    thing.weights = self.maybe(SurfaceWeights {
                        diffuse,
                        ..Default::default()
                    });
                }
            },
            _ => match self.random.bool() {
                true => thing.parent = self.of(&[None, Some(0), Some(1)]),
                false => thing.cells = self.of(&[None, Some(vec![]), Some(vec![0]), Some(vec![0, 1])]),
            },
        }
    }

    fn change_material(&mut self, thing: &mut Thing) {
        if self.one_in(10) {
            thing.materials.truncate(1);
            return;
        }
        if thing.materials.len() < 2 {
            thing.materials = vec![Material::matte(Vec3::splat(0.7)); 2];
        }
        let at = self.random.usize(0..thing.materials.len());
        let material = &mut thing.materials[at];
        match self.random.u32(0..7) {
            0 => material.alpha_mode = self.of(&[AlphaMode::Opaque, AlphaMode::Mask(0.5), AlphaMode::Blend]),
            1 => {
                material.alpha_mode = AlphaMode::Blend;
                material.base_color.w = 0.5;
            }
            2 => material.base_color.w = self.of(&[0.0, 0.4, 0.6, 1.0]),
            3 => material.double_sided = !material.double_sided,
            4 => material.unlit = !material.unlit,
            5 => material.base_color.x = self.of(&[0.2, 0.9]),
            _ => {
                let texture = self.of(&[Some(0), Some(1), None]);
                material.base_color_texture = texture.map(|at: usize| TextureSlot {
                    texture: TEXTURES[at].clone(),
                    uv_set: 0,
                    uv_transform: Affine2::IDENTITY,
                });
            }
        }
    }

    fn change_view(&mut self, spec: &mut Spec) {
        match self.random.u32(0..20) {
            0..=4 => {
                let eyes = [
                    Vec3::new(1.5, 3.5, 6.0),
                    Vec3::new(-4.0, 1.0, 1.0),
                    Vec3::new(0.1, 7.0, 0.0),
                    Vec3::new(0.4, 0.6, 0.2),
                    Vec3::new(1.6, 3.5, 6.0),
                ];
                let target = self.of(&[Vec3::new(0.0, 0.4, 0.0), Vec3::new(0.5, 0.0, -3.0)]);
                spec.eye = Transform::from_translation(self.of(&eyes)).looking_at(target, Vec3::Y);
            }
            5 => spec.eye.rotation *= Quat::from_rotation_y(self.of(&[0.2, 3.0])),
            6 => spec.eye.scale = self.of(&[Vec3::ONE, Vec3::new(-1.0, 1.0, 1.0), Vec3::splat(2.0)]),
            7 => {
                spec.camera = self.of(&[
                    Some(Camera::default()),
                    None,
                    Some(Camera::orthographic(6.0, 0.1, 20.0, 16.0 / 9.0)),
                ]);
            }
            8..=10 => {
                let (fov, near) = (self.of(&[0.4, 0.785, 1.6]), self.of(&[0.1, 0.5, 2.0]));
                let shift = self.of(&[Vec2::ZERO, Vec2::new(0.3, 0.1)]);
                if let Some(camera) = &mut spec.camera {
                    camera.vertical_fov = fov;
                    camera.near = near;
                    camera.shift = shift;
                }
            }
            11 => spec.ignores_scale = self.maybe(IgnoresScale),
            12 | 13 => spec.size = self.of(&[UVec2::new(48, 27), UVec2::new(32, 32), UVec2::ZERO]),
            14 => spec.culling = self.of(&[FaceCulling::SingleSided, FaceCulling::None]),
            15 => spec.culled = self.of(&[CulledCasters::LeaveOut, CulledCasters::Cast]),
            16 => spec.ambient = Vec3::splat(self.of(&[0.0, 0.05, 0.3])),
            17 => spec.scissor = !spec.scissor,
            18 => spec.depth_bounds = !spec.depth_bounds,
            _ => {
                spec.occlusion = self.of(&[
                    usual(),
                    OcclusionSettings::NONE,
                    OcclusionSettings {
                        of_shadows: false,
                        camera_texels: 64,
                        ..usual()
                    },
                ]);
            }
        }
    }

    fn change_cells(&mut self, spec: &mut Spec) {
        let places = [
            Transform::from_xyz(-1.5, 1.0, 0.0),
            Transform::from_xyz(1.5, 1.0, 0.0),
        ];
        match self.random.usize(0..4) {
            at @ 0..=1 => {
                let half = self.of(&[Vec3::splat(1.5), Vec3::new(1.5, 1.5, 3.0)]);
                let layers = self.of(&[1, 2]);
                spec.cells[at] = self.maybe((half, places[at], layers));
            }
            2 => {
                let place = Transform::from_xyz(0.0, self.of(&[0.8, 1.4]), 0.0)
                    .with_rotation(Quat::from_rotation_y(std::f32::consts::FRAC_PI_2));
                spec.portal = Some((place, self.random.bool()));
            }
            _ => spec.portal = None,
        }
    }
}
