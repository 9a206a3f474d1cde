//! Lights and casters that meet, and other degenerate input: never NaN, never an error of the device.

use antumbra::insides::records::WedgeCaster;
use antumbra::prelude::*;
use antumbra::techniques::PenumbraWedges;
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::{UVec2, Vec3};

use super::scenes::{Lit, ground, largest_difference, light, lit, rect, rendered, spawn, sphere, with};
use crate::harness::strict_context;

/// Renders a light in every form; the picture has nothing but visibilities.
fn shines(context: &RenderContext, name: &str, kind: LightKind, from: Vec3, mesh: MeshData) -> f32 {
    let mut stage = ground(context, Vec3::new(2.5, 3.0, 4.5), Vec3::ZERO);
    spawn(&mut stage, mesh, Transform::from_xyz(0.0, 1.0, 0.0));
    light(
        &mut stage,
        &Lit {
            kind,
            from,
            to: Vec3::new(0.01, 0.0, 0.02),
            wedge: PenumbraWedge::default(),
        },
    );
    let got = rendered(&mut stage, 0);
    let bad = got.values().iter().filter(|v| !(0.0..=1.0).contains(*v)).count();
    assert_eq!(bad, 0, "{name} {kind:?}");
    let radiance = stage.render().expect("a frame").radiance;
    assert!(radiance.iter().all(|value| value.is_finite()), "{name} {kind:?}");
    got.values().iter().sum::<f32>() / got.values().len() as f32
}

#[test]
fn lights_and_casters_may_meet() {
    let context = strict_context();
    let cube = || MeshData::cuboid(Vec3::splat(0.5));
    for kind in [rect(0.6, 0.4), sphere(0.3), rect(0.6, 0.0)] {
        let inside = shines(&context, "inside", kind, Vec3::new(0.0, 1.0, 0.0), cube());
        assert!(inside < 0.3, "all but dark: {inside}");
        shines(&context, "touching", kind, Vec3::new(0.0, 1.5, 0.0), cube());
        shines(
            &context,
            "crossing",
            kind,
            Vec3::new(0.1, 1.6, 0.2),
            MeshData::cuboid(Vec3::new(0.05, 1.0, 0.05)),
        );
        shines(&context, "on an edge", kind, Vec3::new(0.5, 1.5, 0.0), cube());
        shines(&context, "on a vertex", kind, Vec3::new(0.5, 1.5, 0.5), cube());
    }
    for kind in [rect(40.0, 40.0), sphere(20.0), rect(1e6, 1e6), sphere(1e6)] {
        shines(&context, "huge", kind, Vec3::new(0.0, 30.0, 0.0), cube());
    }
    let edge_on = shines(
        &context,
        "edge-on",
        rect(0.6, 0.4),
        Vec3::new(6.0, 0.0, 0.0),
        cube(),
    );
    // Half of it is below the ground's horizon, and sides of the cube turn away from it.
    assert!((0.2..0.5).contains(&edge_on), "{edge_on}");
}

#[test]
fn degenerate_and_many_edges_do_no_harm() {
    let context = strict_context();
    let sliver = MeshData::from_triangles(
        "sliver",
        vec![
            Vec3::ZERO,
            Vec3::X,
            Vec3::X * 2.0,
            Vec3::ZERO,
            Vec3::splat(1e-30),
            Vec3::splat(0.3),
            Vec3::ZERO,
            Vec3::ZERO,
            Vec3::Y,
        ],
        (0..9).collect(),
    );
    shines(
        &context,
        "slivers",
        rect(0.6, 0.4),
        Vec3::new(0.5, 4.0, 0.3),
        sliver,
    );
    let leaves = leaves();
    for kind in [rect(0.6, 0.4), sphere(0.3)] {
        shines(&context, "leaves", kind, Vec3::new(0.5, 4.0, 0.3), leaves.clone());
    }
}

/// In the first frame after one without a view, no caster is left: what was drawn before is not drawn again.
#[test]
fn casters_that_go_while_nothing_is_seen_are_forgotten() {
    let mut stage = ground(&strict_context(), Vec3::new(2.5, 3.0, 4.5), Vec3::ZERO);
    let cube = spawn(
        &mut stage,
        MeshData::cuboid(Vec3::splat(0.5)),
        Transform::from_xyz(0.0, 1.0, 0.0),
    );
    light(
        &mut stage,
        &Lit {
            kind: rect(0.6, 0.4),
            from: Vec3::new(0.5, 4.0, 0.3),
            to: Vec3::ZERO,
            wedge: PenumbraWedge::default(),
        },
    );
    let darkest = |stage: &mut _| rendered(stage, 0).values().iter().copied().fold(1.0, f32::min);
    assert!(darkest(&mut stage) < 0.1);
    let size = std::mem::replace(
        &mut *stage.world.resource_mut::<ViewportSize>(),
        ViewportSize(UVec2::ZERO),
    );
    stage.schedule.run(&mut stage.world);
    stage.world.despawn(cube);
    let mut casters = stage.world.query_filtered::<Entity, With<ShadowCaster>>();
    let ground: Vec<_> = casters.iter(&stage.world).collect();
    for entity in ground {
        stage.world.entity_mut(entity).remove::<ShadowCaster>();
    }
    stage.world.insert_resource(size);
    assert!(darkest(&mut stage) > 0.99);
}

/// Thousands of triangles apart from one another.
fn leaves() -> MeshData {
    let mut positions = Vec::new();
    for i in 0..2000 {
        let t = i as f32;
        let at = Vec3::new((t * 0.37).sin(), 0.4 * (t * 0.11).cos(), (t * 0.73).sin()) * 0.8;
        positions.extend([
            at,
            at + Vec3::new(0.05, 0.01, 0.0),
            at + Vec3::new(0.0, 0.02, 0.05),
        ]);
    }
    let indices = (0..positions.len() as u32).collect();
    MeshData::from_triangles("leaves", positions, indices)
}

/// A device whose bindings hold no more than `bytes`.
fn small_context(bytes: u64) -> RenderContext {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
    let options = wgpu::RequestAdapterOptions::default();
    let adapter = pollster::block_on(instance.request_adapter(&options)).expect("a GPU adapter is needed");
    let wanted = wgpu::Features::DEPTH32FLOAT_STENCIL8 | wgpu::Features::FLOAT32_BLENDABLE;
    let device = adapter.request_device(&wgpu::DeviceDescriptor {
        required_features: wanted & adapter.features(),
        required_limits: wgpu::Limits {
            max_storage_buffer_binding_size: bytes,
            ..Default::default()
        },
        ..Default::default()
    });
    let (device, queue) = pollster::block_on(device).expect("a device");
    device.on_uncaptured_error(std::sync::Arc::new(|error| panic!("wgpu error: {error}")));
    let mut context = RenderContext::from_device(device, queue, "small".to_owned());
    context.anisotropy = 1;
    context
}

#[test]
fn casters_beyond_a_binding_are_refused() {
    const BYTES: u64 = 2 << 20;
    let mut stage = ground(&small_context(BYTES), Vec3::new(2.5, 3.0, 4.5), Vec3::ZERO);
    let count = BYTES as usize / size_of::<WedgeCaster>() / 64 + 1;
    for i in 0..count {
        let place = Transform::from_xyz((i % 32) as f32 * 0.1 - 1.6, 0.5, (i / 32) as f32 * 0.1 - 0.8);
        spawn(&mut stage, MeshData::cuboid(Vec3::splat(0.02)), place);
    }
    let split = PenumbraWedge {
        split: [8; 2],
        ..Default::default()
    };
    light(&mut stage, &lit(rect(0.5, 0.5), split));
    let error = stage.render().expect_err("more than a binding holds").to_string();
    assert!(error.contains("casters of all wedges"), "{error}");
    // Fewer parts are fewer casters.
    with(&mut stage, PenumbraWedge::default());
}

#[test]
fn wedges_beyond_a_binding_are_drawn_from_several() {
    const BYTES: u64 = 2 << 20;
    let pictures = [strict_context(), small_context(BYTES)].map(|context| {
        let mut stage = ground(&context, Vec3::new(2.5, 3.0, 4.5), Vec3::ZERO);
        spawn(&mut stage, leaves(), Transform::from_xyz(0.0, 1.0, 0.0));
        light(
            &mut stage,
            &Lit {
                kind: rect(0.6, 0.4),
                from: Vec3::new(0.5, 4.0, 0.3),
                to: Vec3::ZERO,
                wedge: PenumbraWedge {
                    split: [2, 1],
                    ..Default::default()
                },
            },
        );
        let picture = rendered(&mut stage, 0);
        let wedges = stage.world.resource::<PenumbraWedges>();
        let bytes = size_of_val(&wedges.wedges[..]) as u64;
        assert!(bytes > BYTES, "{bytes} fit");
        picture
    });
    assert!(pictures[0].values().iter().any(|visible| *visible < 0.5));
    assert_eq!(largest_difference(&pictures[0], &pictures[1]), 0.0);
}
