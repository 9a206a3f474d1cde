//! Brute force over sampled points and rays: what must be in the sets.

use antumbra::geometry::Aabb;
use antumbra::scene::{Light, LightDistance, LightKind, ShadowOrigin, ShadowSoftness};
use antumbra::sets::{
    DepthBounds, FrameLight, FrameLights, FrustumSet, Objects, View, VisibleSet, shadow_depth_range,
};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::GlobalTransform;
use glam::{DVec2, DVec3, DVec4};

use super::{Id, Random, Scene, SceneLight, SceneModel, Thing, VIEWPORT};

/// The camera, by vectors.
pub struct Eye {
    pub position: DVec3,
    pub forward: DVec3,
    right: DVec3,
    up: DVec3,
    half: (f64, f64),
    shift: DVec2,
    near: f64,
    /// Depth of the far plane of an orthographic view.
    far: Option<f64>,
}

impl Eye {
    pub fn new(scene: &Scene) -> Self {
        let affine = scene.world_from_camera.affine();
        let orthographic = scene.camera.orthographic;
        let up = match orthographic {
            None => (f64::from(scene.camera.vertical_fov) * 0.5).tan(),
            Some(orthographic) => f64::from(orthographic.height) * 0.5,
        };
        Self {
            position: affine.translation.as_dvec3(),
            right: affine.matrix3.x_axis.as_dvec3(),
            up: affine.matrix3.y_axis.as_dvec3(),
            forward: -affine.matrix3.z_axis.as_dvec3(),
            half: (up * f64::from(scene.camera.aspect), up),
            shift: scene.camera.shift.as_dvec2(),
            near: f64::from(scene.camera.near),
            far: orthographic.map(|orthographic| f64::from(orthographic.far)),
        }
    }

    /// The ray through a point of the picture, −1..=1.
    pub fn ray(&self, x: f64, y: f64) -> DVec3 {
        self.forward + self.across(x, y)
    }

    fn across(&self, x: f64, y: f64) -> DVec3 {
        let (x, y) = (x - self.shift.x, y - self.shift.y);
        self.right * (x * self.half.0) + self.up * (y * self.half.1)
    }

    /// The point at a view depth that a point of the picture, −1..=1, shows.
    pub fn point_at(&self, x: f64, y: f64, depth: f64) -> DVec3 {
        match self.far {
            None => self.position + self.ray(x, y) * depth,
            Some(_) => self.position + self.across(x, y) + self.forward * depth,
        }
    }

    /// The view depths between which `share` runs from 0 to 1: the box of an orthographic view, or 8 metres.
    pub fn depth_at(&self, share: f64) -> f64 {
        match self.far {
            None => share * 8.0,
            Some(far) => self.near + (far - self.near) * share,
        }
    }

    /// Pixel and view depth of a point that the picture shows.
    fn project(&self, point: DVec3) -> Option<Seen> {
        let to = point - self.position;
        let depth = to.dot(self.forward);
        if depth < self.near || self.far.is_some_and(|far| depth > far) {
            return None;
        }
        let (w, reversed) = match self.far {
            None => (depth, self.near / depth),
            Some(far) => (1.0, (far - depth) / (far - self.near)),
        };
        let x = to.dot(self.right) / w / self.half.0 + self.shift.x;
        let y = to.dot(self.up) / w / self.half.1 + self.shift.y;
        let size = VIEWPORT.as_dvec2();
        (x.abs() <= 1.0 && y.abs() <= 1.0).then(|| Seen {
            x: (((x * 0.5 + 0.5) * size.x) as u32).min(VIEWPORT.x - 1),
            y: (((0.5 - y * 0.5) * size.y) as u32).min(VIEWPORT.y - 1),
            depth,
            reversed: reversed as f32,
        })
    }
}

#[derive(Clone, Copy)]
struct Seen {
    x: u32,
    y: u32,
    depth: f64,
    reversed: f32,
}

impl Seen {
    fn is_within(&self, bounds: Option<DepthBounds>) -> bool {
        bounds.is_some_and(|bounds| {
            let depth = self.depth as f32;
            (bounds.depth_min..=bounds.depth_max).contains(&self.reversed)
                && bounds.near <= depth
                && depth <= bounds.far
        })
    }
}

/// A random point of the light, homogeneous, if it lights `point` from there.
fn lit_from(
    light: &Light,
    world_from_light: &GlobalTransform,
    model: &SceneModel,
    point: DVec3,
    random: &mut Random,
) -> Option<DVec4> {
    let affine = world_from_light.affine();
    let center = affine.translation.as_dvec3();
    let shine = -affine.matrix3.z_axis.as_dvec3().normalize();
    let from = match light.kind {
        LightKind::Directional => {
            let falls = match model.origin {
                Some(ShadowOrigin::Direction(falls)) => falls.as_dvec3(),
                _ => shine,
            };
            return Some((-falls.normalize()).extend(0.0));
        }
        LightKind::Sphere { radius } => center + random.direction() * f64::from(radius) * random.unit(),
        LightKind::Rect { width, height } => {
            let u = f64::from(width) * random.range(-0.5, 0.5);
            let v = f64::from(height) * random.range(-0.5, 0.5);
            center + affine.matrix3.x_axis.as_dvec3() * u + affine.matrix3.y_axis.as_dvec3() * v
        }
        LightKind::Point | LightKind::Spot { .. } => center,
    };
    let to = point - from;
    let in_shape = match light.kind {
        LightKind::Spot { outer_angle, .. } => to.dot(shine) >= to.length() * f64::from(outer_angle).cos(),
        LightKind::Rect { .. } => to.dot(shine) >= 0.0,
        _ => true,
    };
    let axis = |axis: glam::Vec3A| axis.as_dvec3().normalize().dot(point - center);
    let local = DVec3::new(
        axis(affine.matrix3.x_axis),
        axis(affine.matrix3.y_axis),
        -axis(affine.matrix3.z_axis),
    );
    let (local, doors) = (local.as_vec3(), model.shape.is_some());
    let opens = model.shape.is_none_or(|shape| shape.factor(local) > 0.0);
    let arrives = |distance: LightDistance| distance.factor(LightDistance::depth_of(local, doors)) > 0.0;
    let is_lit = opens && model.distance.is_none_or(arrives);
    let mut from = from;
    if let Some(ShadowSoftness(softness)) = model.softness {
        let softness = f64::from(softness);
        from = center
            + match light.kind {
                LightKind::Rect { .. } => DVec3::ZERO, // its middle is on it, whatever its size
                _ => random.direction() * softness * random.unit(),
            };
    }
    if let Some(ShadowOrigin::Position(origin)) = model.origin {
        from += origin.as_dvec3() - center;
    }
    (in_shape && is_lit && to.length() <= f64::from(light.range)).then(|| from.extend(1.0))
}

/// Whether the segment from `point` to the light passes through the box.
fn crosses(aabb: &Aabb, point: DVec3, light: DVec4) -> bool {
    let along = light.truncate() - point * light.w;
    let mut range = (0.0f64, if light.w == 0.0 { f64::INFINITY } else { 1.0 });
    for axis in 0..3 {
        let low = f64::from(aabb.min[axis]) - point[axis];
        let high = f64::from(aabb.max[axis]) - point[axis];
        if along[axis] == 0.0 {
            if low > 0.0 || high < 0.0 {
                return false;
            }
        } else {
            let (a, b) = (low / along[axis], high / along[axis]);
            range = (range.0.max(a.min(b)), range.1.min(a.max(b)));
        }
    }
    range.0 <= range.1
}

/// The corners of a box and some points inside.
fn samples(aabb: &Aabb, count: usize, random: &mut Random) -> Vec<DVec3> {
    let (min, max) = (aabb.min.as_dvec3(), aabb.max.as_dvec3());
    let mut points: Vec<_> = aabb.corners().map(|corner| corner.as_dvec3()).into();
    points.extend((0..count).map(|_| {
        let inside = DVec3::new(random.unit(), random.unit(), random.unit());
        min + (max - min) * inside
    }));
    points
}

/// All that is missing from the sets of a frame, in words.
#[derive(Default)]
pub struct Verdict {
    pub wrong: Vec<String>,
    /// Visible lit points that were looked at.
    pub looked: usize,
    /// Segments found blocked by a caster that casts for the light.
    pub blocked: usize,
}

struct Judge<'a> {
    scene: &'a Scene,
    world: &'a World,
    /// Dense index of each thing.
    indices: Vec<usize>,
    eye: Eye,
    random: Random,
    verdict: Verdict,
}

/// Looks at points of every thing, from the camera and from every light.
pub fn judge(scene: &Scene, world: &World, seed: u64) -> Verdict {
    let objects = world.resource::<Objects>();
    let mut indices = vec![usize::MAX; scene.things.len()];
    for (index, &entity) in objects.entities.iter().enumerate() {
        indices[world.get::<Id>(entity).unwrap().0] = index;
    }
    let mut judge = Judge {
        scene,
        world,
        indices,
        eye: Eye::new(scene),
        random: Random::new(seed ^ 0x5eed),
        verdict: Verdict::default(),
    };
    for i in 0..scene.things.len() {
        judge.look_at(i);
    }
    judge.verdict
}

impl Judge<'_> {
    fn look_at(&mut self, i: usize) {
        let thing = self.scene.things[i];
        let index = self.indices[i];
        let frame = self.world.resource::<FrameLights>();
        for point in samples(&thing.aabb, 24, &mut self.random) {
            let seen = self.eye.project(point);
            let in_f = self.world.resource::<FrustumSet>().set.contains(index);
            let in_v = self.world.resource::<VisibleSet>().set.contains(index);
            if seen.is_some() && !(in_f && in_v) {
                self.verdict
                    .wrong
                    .push(format!("object {i} not in F or V, {point} is in view"));
            }
            for light in &frame.lights {
                let same = |given: &SceneLight| {
                    let same = given.1 == light.world_from_light && given.2 == light.selection;
                    same && given.0.kind == light.light.kind
                };
                let at = self.scene.lights.iter().position(same).unwrap();
                self.look_at_lit(i, &thing, point, seen, light, at);
            }
        }
    }

    fn look_at_lit(
        &mut self,
        i: usize,
        thing: &Thing,
        point: DVec3,
        seen: Option<Seen>,
        light: &FrameLight,
        at: usize,
    ) {
        let (component, world_from_light, selection) = &self.scene.lights[at];
        let model = self.scene.model(at);
        let Some(from) = lit_from(component, world_from_light, &model, point, &mut self.random) else {
            return;
        };
        let kind = component.kind;
        let wrong = &mut self.verdict.wrong;
        if !light.sets.l.contains(self.indices[i]) {
            wrong.push(format!("object {i} not in L of {kind:?}"));
        }
        let Some(seen) = seen else { return };
        if !thing.drawn || thing.layers & selection.affects == 0 {
            return;
        }
        self.verdict.looked += 1;
        if !light.sets.i.contains(self.indices[i]) {
            wrong.push(format!("object {i} not in I of {kind:?}"));
            return;
        }
        if !light
            .region
            .scissor
            .is_some_and(|scissor| scissor.contains(seen.x, seen.y))
        {
            wrong.push(format!(
                "pixel {},{} not in {:?} of {component:?}",
                seen.x, seen.y, light.region.scissor
            ));
        }
        if !seen.is_within(light.region.depth_bounds) {
            wrong.push(format!(
                "depth {} not in {:?} of {component:?}",
                seen.depth, light.region.depth_bounds
            ));
        }
        if !thing.receiver || thing.layers & selection.shows_on == 0 {
            return;
        }
        for (c, caster) in self.scene.things.iter().enumerate() {
            let casts = caster.caster && caster.layers & selection.casts_for != 0;
            if !casts || !crosses(&caster.aabb, point, from) {
                continue;
            }
            self.verdict.blocked += 1;
            if !light.sets.s.contains(self.indices[c]) {
                wrong.push(format!("caster {c} not in S of {kind:?}, it blocks {point}"));
            }
            let view = self.world.resource::<View>().data.as_ref().unwrap();
            let range = shadow_depth_range(view, &caster.aabb, &light.emitter);
            if !seen.is_within(range) {
                wrong.push(format!(
                    "depth {} not in {range:?}, shadow of {c} from {kind:?}",
                    seen.depth
                ));
            }
        }
    }
}
