//! Large scenes, and what the hierarchy over them must give: what tests of every single box give.

use antumbra::geometry::Aabb;
use antumbra::insides::WORD;
use antumbra::scene::{SceneMaterials, SelectionLayers, ShadowCaster, ShadowReceiver, WorldBounds};
use antumbra::sets::{FrameLight, FrameLights, FrustumSet, LightVolume, Objects, View};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::GlobalTransform;
use glam::DVec3;

use super::{Id, Random, Scene, Thing, random_scene, thing};

/// A scene of `count` boxes of very different sizes, some without any, and the lights of a random scene; far from the
/// origin as often as those.
pub fn large_scene(seed: u64, count: usize) -> Scene {
    let mut scene = random_scene(seed);
    let origin = scene.world_from_camera.translation().as_dvec3();
    let mut random = Random::new(seed ^ 0xfeed);
    scene.things = (0..count).map(|_| random_thing(&mut random, origin)).collect();
    scene
}

pub fn random_thing(random: &mut Random, origin: DVec3) -> Thing {
    let center = origin + random.vec(30.0);
    let half = random.range(0.0, 1.0).powi(8) * 20.0;
    let mut aabb = thing(center.as_vec3(), half as f32).aabb;
    if random.chance(0.02) {
        aabb = Aabb::EMPTY;
    }
    Thing {
        aabb,
        caster: random.chance(0.8),
        receiver: random.chance(0.8),
        drawn: random.chance(0.8),
        layers: 1 << random.below(2),
    }
}

/// F and the reach of every light, by asking all boxes, have the bits that the world has.
pub fn assert_flat_tests_agree(world: &World) {
    let objects = world.resource::<Objects>();
    let present = objects.present.as_slice();
    let view = world.resource::<View>().data.as_ref().unwrap();
    let f = world.resource::<FrustumSet>().set.as_slice();
    for word in 0..objects.boxes.words() {
        let flat = objects
            .boxes
            .touching_planes(word, present[word], &view.frustum.planes);
        assert_eq!(f[word], flat, "F, word {word}");
    }
    for light in &world.resource::<FrameLights>().lights {
        for (word, &present) in present.iter().enumerate() {
            let flat = match &light.volume {
                LightVolume::Infinite => present,
                LightVolume::Ball(ball) => objects.boxes.touching_sphere(word, present, ball),
                LightVolume::Cone(cone) | LightVolume::HalfBall(cone) => {
                    objects.boxes.touching_cone(word, present, cone)
                }
            };
            let reach = light.sets.reach.as_slice()[word];
            assert_eq!(reach, flat, "{:?}, word {word}", light.volume);
            assert!(light.sets.l.as_slice()[word] & !reach == 0);
            assert!(
                (light.sets.i.as_slice()[word] | light.sets.s.as_slice()[word])
                    & !light.sets.l.as_slice()[word]
                    == 0
            );
        }
        assert_shadow_set(world, light, f);
    }
}

/// S has the bits that both hulls leave, box by box.
pub fn assert_shadow_set(world: &World, light: &FrameLight, f: &[usize]) {
    let objects = world.resource::<Objects>();
    for (word, &l) in light.sets.l.as_slice().iter().enumerate() {
        let mut s = l & objects.casters.as_slice()[word];
        if light.region.scissor.is_none() || light.hulls.receivers.planes.planes.is_empty() {
            continue;
        }
        if light.hulls.inside_frustum {
            s &= f[word];
        } else {
            s = objects.boxes.touching_planes(word, s, &light.hulls.view.planes);
        }
        s = objects
            .boxes
            .touching_planes(word, s, &light.hulls.receivers.planes);
        for bit in 0..WORD {
            let layers = objects.layers.get(word * WORD + bit).copied().unwrap_or_default();
            if layers & light.selection.casts_for == 0 {
                s &= !(1 << bit);
            }
        }
        assert_eq!(
            light.sets.s.as_slice()[word],
            s,
            "S of {:?}, word {word}",
            light.volume
        );
    }
}

/// Boxes of clusters and blocks hold all that they must.
pub fn assert_clusters_hold(world: &World) {
    let objects = world.resource::<Objects>();
    let (words, blocks) = (&objects.clusters.words, &objects.clusters.blocks);
    let holds = |outer: Aabb, inner: Aabb| {
        inner.is_empty() || (outer.min.cmple(inner.min).all() && inner.max.cmple(outer.max).all())
    };
    for index in 0..objects.len() {
        let aabb = objects.boxes.get(index);
        assert!(holds(words.get(index / WORD), aabb), "object {index}");
        assert_eq!(objects.present.contains(index), !aabb.is_empty());
    }
    for word in 0..words.len() {
        assert!(holds(blocks.get(word / WORD), words.get(word)), "word {word}");
    }
}

pub fn spawn_thing(world: &mut World, id: usize, thing: &Thing) {
    let layers = SelectionLayers(thing.layers);
    let mut entity = world.spawn((Id(id), WorldBounds(thing.aabb), layers, GlobalTransform::IDENTITY));
    if thing.caster {
        entity.insert(ShadowCaster);
    }
    if thing.receiver {
        entity.insert(ShadowReceiver);
    }
    if thing.drawn {
        entity.insert(SceneMaterials(Default::default()));
    }
}
