//! A light with a second technique is handed to the host once, with the visibility that both leave.

use antumbra::prelude::*;
use bevy_transform::prelude::Transform;
use glam::Vec3;

use super::comparison::{both, differing};
use super::scenes::{SIZE, alone};
use crate::harness::strict_context;
use crate::occlusion_interval::companions::{add, visibility, with_boxes};

#[test]
fn a_second_technique_darkens_in_a_host_what_it_darkens_in_a_frame_of_our_own() {
    let context = strict_context();
    let mut stage = with_boxes(0.4, 0.1);
    stage.world.insert_resource(ViewportSize(SIZE));
    let camera = *stage.world.get::<Camera>(stage.camera).expect("the camera");
    let [own_alone, hosted_alone] = both(&context, &mut stage, alone(&camera));
    let (wrong, _) = differing(&mut stage, &own_alone, &hosted_alone, 0.04);
    assert_eq!(wrong, 0, "without a second technique");
    let dark = |picture: &[f32]| picture.iter().filter(|value| **value < 0.5).count();
    for kind in ["stencil_volume", "shadow_map"] {
        if kind == "stencil_volume" {
            add(&mut stage, StencilVolume::default());
        } else {
            let light = stage.lights[0];
            stage.world.entity_mut(light).remove::<StencilVolume>();
            add(&mut stage, ShadowMap::default());
        }
        // `both` checks that the host adds each light of the stage once.
        let [own, hosted] = both(&context, &mut stage, alone(&camera));
        let (wrong, judged) = differing(&mut stage, &own, &hosted, 0.04);
        let more = dark(&hosted) as isize - dark(&hosted_alone) as isize;
        println!("{kind}: {wrong} of {judged} differ, {more} more are dark");
        assert!(
            judged > 5000 && wrong * 1000 <= judged,
            "{kind}: {wrong} of {judged}"
        );
        assert!(more > 100, "{kind}: {more}");
        let (wrong, _) = differing(&mut stage, &own, &hosted_alone, 0.04);
        assert!(wrong > 100, "{kind}: the comparison can fail: {wrong}");
    }
    // A surface that shows no shadows stays unshadowed: the host leaves the mask out there, or it is 1.
    let mut own = stage;
    own.world
        .resource_mut::<Renderer>()
        .set_host(None)
        .expect("shaders compose");
    let before = visibility(&mut own);
    own.world.spawn((
        SceneMesh(std::sync::Arc::new(MeshData::cuboid(Vec3::new(0.5, 0.02, 0.5)))),
        SceneMaterials([std::sync::Arc::new(Material::matte(Vec3::ONE))].into()),
        Transform::from_xyz(0.4, 0.1, 0.5),
    ));
    let after = visibility(&mut own);
    assert!(dark(&after) + 50 < dark(&before), "it covers shadows");
}
