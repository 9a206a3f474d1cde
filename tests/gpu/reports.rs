//! What a device cannot draw stands in `Reports`, once.

use std::sync::Arc;

use crate::harness::support::stage::Stage;
use crate::harness::{own_context, strict_context};
use antumbra::prelude::*;
use antumbra::render::{HostView, RenderError, create_target};
use antumbra::reports::{Report, Reports};
use antumbra::scene::{Texture, TextureSlot};
use antumbra::techniques::VisibilityBuffer;
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::{Affine2, UVec2, Vec3};

const SIZE: UVec2 = UVec2::new(64, 32);

fn stage(context: RenderContext) -> Stage {
    let view = Transform::from_xyz(0.0, 3.0, 6.0).looking_at(Vec3::ZERO, Vec3::Y);
    let camera = Camera {
        aspect: 2.0,
        ..Default::default()
    };
    let mut stage = Stage::empty(SIZE, camera, view);
    stage
        .add_renderer(context, RenderSettings::default())
        .expect("shaders compose");
    let place = Transform::from_xyz(1.0, 3.0, 1.0);
    let shadow = Some(StencilVolume::default());
    stage.spawn_light(Light::point(Vec3::ONE, 20.0, 20.0), place, shadow);
    object(&mut stage, MeshData::cuboid(Vec3::splat(0.5)));
    stage
}

fn object(stage: &mut Stage, mesh: MeshData) -> Entity {
    let object = (
        SceneMesh(Arc::new(mesh)),
        SceneMaterials([Arc::new(Material::matte(Vec3::ONE))].into()),
        (ShadowCaster, ShadowReceiver),
        Transform::default(),
    );
    stage.world.spawn(object).id()
}

fn frame(stage: &mut Stage) -> Vec<Report> {
    stage.schedule.run(&mut stage.world);
    let mut reports = stage.world.resource_mut::<Reports>();
    reports.drain_new().cloned().collect()
}

/// The fault is new once.
fn expect(stage: &mut Stage, topic: &str, entity: Option<Entity>, text: &[&str]) {
    let new = frame(stage);
    let [report] = &new[..] else {
        panic!("{text:?}: {new:#?}");
    };
    assert_eq!((report.topic, report.entity), (topic, entity), "{report:?}");
    for text in text {
        assert!(report.message.contains(text), "{text:?}: {}", report.message);
    }
    for _ in 0..5 {
        assert!(frame(stage).is_empty(), "{text:?} is said once");
    }
    assert_eq!(stage.world.resource::<Reports>().iter().count(), 1);
}

fn expect_nothing(stage: &mut Stage) {
    let new = frame(stage);
    assert!(new.is_empty(), "{new:#?}");
    assert_eq!(stage.world.resource::<Reports>().iter().count(), 0);
}

#[test]
fn a_view_outside_of_its_host_is_reported_of_its_camera() {
    let mut stage = stage(strict_context());
    expect_nothing(&mut stage);
    let camera = stage.world.get::<Camera>(stage.camera).unwrap();
    let inside = HostView {
        target_size: SIZE,
        viewport_origin: UVec2::ZERO,
        clip_from_view: camera.clip_from_view(),
    };
    let outside = HostView {
        viewport_origin: UVec2::X,
        ..inside
    };
    let host = |stage: &mut Stage, view| {
        let mut renderer = stage.world.resource_mut::<Renderer>();
        renderer.set_host(Some(view)).unwrap();
    };
    host(&mut stage, outside);
    let camera = Some(stage.camera);
    let text = ["No shadows are drawn", "64", "Keep the viewport inside"];
    expect(&mut stage, "renderer", camera, &text);
    host(&mut stage, inside);
    expect_nothing(&mut stage);
}

#[test]
fn a_lost_device_is_reported_of_nobody() {
    let mut stage = stage(own_context(RequestedFeatures::default()));
    expect_nothing(&mut stage);
    stage.world.resource::<Renderer>().context().set_lost();
    let text = ["GPU device was lost", "Make a new `RenderContext`"];
    expect(&mut stage, "renderer", None, &text);
    let context = own_context(RequestedFeatures::default());
    stage
        .add_renderer(context, RenderSettings::default())
        .expect("shaders compose");
    expect_nothing(&mut stage);
}

/// A device that allows storage of 256 KiB in a binding.
fn small_device() -> RenderContext {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
    let adapter = pollster::block_on(instance.request_adapter(&wgpu::RequestAdapterOptions::default()))
        .expect("a GPU adapter is needed");
    let limits = wgpu::Limits {
        max_storage_buffer_binding_size: 256 << 10,
        ..Default::default()
    };
    let descriptor = wgpu::DeviceDescriptor {
        required_limits: limits,
        ..Default::default()
    };
    let (device, queue) =
        pollster::block_on(adapter.request_device(&descriptor)).expect("less than the adapter has");
    device.on_uncaptured_error(Arc::new(|error| panic!("wgpu error: {error}")));
    let mut context = RenderContext::from_device(device, queue, "small".to_owned());
    context.anisotropy = 1;
    context
}

#[test]
fn a_mesh_beyond_the_device_is_reported_of_its_object() {
    let mut stage = stage(small_device());
    expect_nothing(&mut stage);
    let mut mesh = MeshData::icosphere(0.5, 6);
    let bytes = mesh.positions.len() * 12;
    assert!(bytes > 256 << 10);
    mesh.name = "statue".to_owned();
    let object = object(&mut stage, mesh);
    stage.world.entity_mut(object).remove::<ShadowCaster>();
    let bytes = format!("{bytes} bytes");
    let text = ["`statue` is not drawn", &bytes, "262144 bytes", "Split the mesh"];
    expect(&mut stage, "mesh", Some(object), &text);
    stage.world.despawn(object);
    expect_nothing(&mut stage);
}

/// The small device allows 8192 texels along a side of a texture.
#[test]
fn textures_beyond_the_device_are_reported_with_both_sizes() {
    let mut stage = stage(small_device());
    expect_nothing(&mut stage);
    let texture = Texture {
        name: "wall".to_owned(),
        width: 16_384,
        height: 3,
        rgba8: vec![255; 4 * 16_384 * 3],
        wrap: Default::default(),
        linear_magnify: true,
        linear_minify: true,
    };
    let slot = TextureSlot {
        texture: Arc::new(texture),
        uv_set: 0,
        uv_transform: Affine2::IDENTITY,
    };
    // A texture that is read in two ways is reported once.
    let material = Material {
        base_color_texture: Some(slot.clone()),
        occlusion_texture: Some(slot),
        ..Material::matte(Vec3::ONE)
    };
    let object = object(&mut stage, MeshData::cuboid(Vec3::splat(0.5)));
    let materials = SceneMaterials([Arc::new(material)].into());
    stage.world.entity_mut(object).insert(materials);
    let text = ["`wall`", "16384 × 3", "8192 × 1"];
    expect(&mut stage, "texture", None, &text);
    stage.world.despawn(object);
    expect_nothing(&mut stage);

    let texels = vec![Vec3::ONE; 2 * 9000];
    let image = CookieImage::from_linear("window", 9000, 2, texels).expect("a picture");
    let light = (
        Light::point(Vec3::ONE, 20.0, 20.0),
        Cookie::around(image),
        Transform::from_xyz(-1.0, 3.0, 1.0),
    );
    let light = stage.world.spawn(light).id();
    let text = ["`window`", "9000 × 2", "4500 × 1"];
    expect(&mut stage, "texture", None, &text);
    stage.world.despawn(light);
    stage.schedule.run(&mut stage.world); // the frame that frees it
    expect_nothing(&mut stage);
}

#[test]
fn more_objects_than_the_device_can_bind_are_reported_and_lost_no_longer_than_needed() {
    let mut stage = stage(small_device());
    expect_nothing(&mut stage);
    let mesh = Arc::new(MeshData::cuboid(Vec3::splat(0.01)));
    let objects: Vec<Entity> = (0..2100)
        .map(|index| {
            let place = Transform::from_xyz(0.02 * index as f32, -5.0, 0.0);
            stage
                .world
                .spawn((SceneMesh(mesh.clone()), ShadowReceiver, place))
                .id()
        })
        .collect();
    let text = ["the list of all objects", "262144"];
    let camera = Some(stage.camera);
    expect(&mut stage, "renderer", camera, &text);
    for object in objects {
        stage.world.despawn(object);
    }
    expect_nothing(&mut stage);
}

#[test]
fn a_world_without_a_picture_says_what_is_missing() {
    let mut stage = stage(strict_context());
    expect_nothing(&mut stage);
    stage.world.insert_resource(ViewportSize(UVec2::new(64, 0)));
    expect(
        &mut stage,
        "renderer",
        None,
        &["Nothing is drawn", "`ViewportSize` is 64 × 0"],
    );
    stage.world.insert_resource(ViewportSize(SIZE));
    expect_nothing(&mut stage);
    let camera = stage.camera;
    let set_aspect = |stage: &mut Stage, aspect| {
        stage.world.get_mut::<Camera>(camera).expect("a camera").aspect = aspect;
    };
    set_aspect(&mut stage, f32::NAN);
    expect(
        &mut stage,
        "renderer",
        None,
        &["Nothing is drawn", "no `Camera` that can be used"],
    );
    set_aspect(&mut stage, 2.0);
    expect_nothing(&mut stage);
}

/// Draws the prepared frame into a picture of its own.
fn draw_picture(stage: &Stage, format: wgpu::TextureFormat) {
    let renderer = stage.world.resource::<Renderer>();
    let context = renderer.context();
    let picture = create_target(context, "picture", SIZE, format).expect("a texture");
    let picture = picture.create_view(&Default::default());
    let mut encoder = context.device.create_command_encoder(&Default::default());
    let outputs = FrameOutputs {
        picture: Some(&picture),
        visibility: &[],
    };
    renderer.record(&mut encoder, &outputs);
    context.queue.submit([encoder.finish()]);
}

#[test]
fn a_picture_of_a_format_that_was_not_prepared_is_reported() {
    let mut stage = stage(strict_context());
    expect_nothing(&mut stage);
    let format = wgpu::TextureFormat::Rgb10a2Unorm;
    draw_picture(&stage, format);
    expect(
        &mut stage,
        "renderer",
        None,
        &["Rgb10a2Unorm", "`Renderer::prepare_output`"],
    );
    stage.world.resource_mut::<Renderer>().prepare_output(format);
    expect_nothing(&mut stage);
}

#[test]
fn a_picture_that_is_written_ends_the_report_of_one_that_was_not() {
    let mut stage = stage(strict_context());
    let written = wgpu::TextureFormat::Rgba8Unorm;
    stage.world.resource_mut::<Renderer>().prepare_output(written);
    expect_nothing(&mut stage);
    draw_picture(&stage, wgpu::TextureFormat::Rgb10a2Unorm);
    expect(&mut stage, "renderer", None, &["Rgb10a2Unorm"]);
    draw_picture(&stage, written);
    expect_nothing(&mut stage);
    assert_eq!(stage.world.resource::<Renderer>().unprepared_output(), None);
}

/// An output whose pipeline fails is prepared between two frames.
#[test]
fn a_failure_between_frames_is_that_of_the_next_one() {
    let mut stage = stage(strict_context());
    expect_nothing(&mut stage);
    let fail = |stage: &mut Stage| {
        let error = RenderError::Shader {
            name: "passes/mine.wgsl".to_owned(),
            reason: "no such name".to_owned(),
        };
        stage.world.resource_mut::<Renderer>().fail(error);
    };
    let lights = |stage: &Stage| stage.world.resource::<Renderer>().frame().lights.len();
    fail(&mut stage);
    assert!(stage.world.resource::<Renderer>().failure().is_some());
    assert_eq!(lights(&stage), 1, "the frame before is untouched");
    let new = frame(&mut stage);
    assert_eq!(new.len(), 1, "{new:#?}");
    assert!(
        new[0].message.contains("passes/mine.wgsl: no such name"),
        "{new:#?}"
    );
    assert_eq!(lights(&stage), 0);
    let failure = stage.world.resource_mut::<Renderer>().take_failure();
    assert!(matches!(failure, Some(RenderError::Shader { .. })), "{failure:?}");
    expect_nothing(&mut stage);
    assert_eq!(lights(&stage), 1);

    fail(&mut stage);
    assert!(stage.world.resource_mut::<Renderer>().take_failure().is_some());
    expect_nothing(&mut stage);
}

/// A timer whose pass did not run is never written, and waiting for it may hang a device.
#[test]
fn a_picture_that_is_not_written_is_not_timed() {
    let mut stage = stage(own_context(RequestedFeatures {
        timestamps: true,
        ..Default::default()
    }));
    let format = wgpu::TextureFormat::Rgb10a2Unorm;
    let mut is_timed = || {
        stage.run();
        draw_picture(&stage, format);
        let mut renderer = stage.world.resource_mut::<Renderer>();
        let times = renderer.timings().read(renderer.context()).expect("times");
        assert!(!times.is_empty(), "the device has timers");
        renderer.prepare_output(format);
        times.iter().any(|time| time.label == "tonemap")
    };
    assert!(!is_timed(), "nothing was prepared");
    assert!(is_timed());
}

#[test]
fn wedges_on_a_device_that_blends_no_floats_say_that_they_err_more() {
    let mut stage = stage(own_context(RequestedFeatures::BASELINE));
    expect_nothing(&mut stage);
    let place = Transform::from_xyz(0.0, 3.0, 0.5).looking_at(Vec3::ZERO, Vec3::Z);
    let rect = LightKind::Rect {
        width: 0.5,
        height: 0.5,
    };
    let light = Light {
        kind: rect,
        ..Light::point(Vec3::ONE, 20.0, 20.0)
    };
    let light = stage.spawn_light(light, place, Some(PenumbraWedge::default()));
    let text = ["does not blend", "FLOAT32_BLENDABLE"];
    expect(&mut stage, "penumbra_wedge", None, &text);
    let meant = PenumbraWedge {
        buffer: VisibilityBuffer::Split8,
        ..Default::default()
    };
    stage.world.entity_mut(light).insert(meant);
    expect_nothing(&mut stage);
}
