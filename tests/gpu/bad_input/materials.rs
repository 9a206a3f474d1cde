//! Materials whose number, numbers or textures do not fit.

use antumbra::scene::{Texture, TextureSlot, TextureWrap};
use glam::{Affine2, Vec2, Vec4};

use super::*;

/// The usual scene whose box has these materials, one for each half of its faces.
fn with(context: &RenderContext, materials: &[Arc<Material>]) -> Stage {
    let mut stage = empty_stage(context);
    stage
        .world
        .spawn(object(MeshData::plane(6.0), Transform::IDENTITY));
    let mut mesh = MeshData::cuboid(Vec3::splat(0.5));
    let half = mesh.submeshes[0].index_count / 2;
    mesh.submeshes = [0, half]
        .map(|first_index| antumbra::scene::Submesh {
            first_index,
            index_count: half,
        })
        .into();
    stage.world.spawn((
        SceneMesh(Arc::new(mesh)),
        SceneMaterials(materials.iter().cloned().collect()),
        (ShadowCaster, ShadowReceiver),
        Transform::from_xyz(0.0, 0.75, 0.0),
    ));
    let (light, at) = light();
    stage.spawn_light(light, at, Some(StencilVolume::default()));
    stage
}

#[test]
fn submeshes_without_a_material_are_not_drawn_and_cast_all_the_same() {
    let context = strict_context();
    let both = render(&mut with(&context, &[matte(), matte()]));
    let many = render(&mut with(&context, &[matte(), matte(), matte()]));
    assert!(same(&both, &many), "a material too many is ignored");
    // One and none: the camera looks into the box, whose whole surface blocks.
    for materials in [vec![matte()], vec![]] {
        let mut stage = with(&context, &materials);
        let rendered = render(&mut stage);
        assert!(!same(&both, &rendered), "half of the box is not there");
        let counted = assert_true(&mut stage, &rendered);
        assert!(counted.inner > 1000);
        assert!(rendered.visibility[0].contains(&0.0), "it casts");
    }
}

fn texture(rgba8: Vec<u8>) -> TextureSlot {
    TextureSlot {
        texture: Arc::new(Texture {
            name: "bad".to_owned(),
            width: 4,
            height: 4,
            rgba8,
            wrap: [TextureWrap::Repeat; 2],
            linear_magnify: true,
            linear_minify: true,
        }),
        uv_set: 0,
        uv_transform: Affine2::IDENTITY,
    }
}

/// The usual scene with a box of this material.
fn of(context: &RenderContext, material: Material) -> Rendered {
    let material = Arc::new(material);
    render(&mut with(context, &[material.clone(), material]))
}

#[test]
fn textures_of_the_wrong_size_are_ignored() {
    let context = strict_context();
    let plain = of(&context, Material::matte(Vec3::ONE));
    let textured = |slot: TextureSlot| {
        let mut material = Material::matte(Vec3::ONE);
        material.base_color_texture = Some(slot.clone());
        material.metallic_roughness_texture = Some(slot.clone());
        material.occlusion_texture = Some(slot.clone());
        material.normal_texture = Some(slot);
        of(&context, material)
    };
    for bytes in [0, 1, 63, 65, 4096] {
        assert!(
            same(&plain, &textured(texture(vec![10; bytes]))),
            "{bytes} bytes for 4×4 texels"
        );
    }
    for (width, height) in [(0, 4), (4, 0), (u32::MAX, u32::MAX)] {
        let mut slot = texture(vec![10; 64]);
        let mut image = (*slot.texture).clone();
        (image.width, image.height) = (width, height);
        slot.texture = Arc::new(image);
        assert!(same(&plain, &textured(slot)), "{width}×{height}");
    }
    assert!(
        !same(&plain, &textured(texture(vec![10; 64]))),
        "a whole texture shows"
    );
    let mut odd = texture(vec![10; 64]);
    odd.uv_set = 77;
    odd.uv_transform = Affine2::from_scale(Vec2::NAN);
    textured(odd); // finite, whatever it shows
}

#[test]
fn numbers_that_are_not_finite_do_not_reach_the_gpu() {
    let context = strict_context();
    let spoilers: [(&str, fn(&mut Material, f32)); 10] = [
        ("base colour", |m, x| m.base_color = Vec4::splat(x)),
        ("metallic", |m, x| m.metallic = x),
        ("roughness", |m, x| m.roughness = x),
        ("normal scale", |m, x| m.normal_scale = x),
        ("occlusion strength", |m, x| m.occlusion_strength = x),
        ("emissive", |m, x| m.emissive = Vec3::splat(x)),
        ("clearcoat", |m, x| m.clearcoat = x),
        ("clearcoat roughness", |m, x| {
            m.clearcoat = 1.0;
            m.clearcoat_roughness = x;
        }),
        ("alpha cutoff", |m, x| m.alpha_mode = AlphaMode::Mask(x)),
        ("blended", |m, x| {
            m.alpha_mode = AlphaMode::Blend;
            m.base_color.w = x;
        }),
    ];
    for (what, spoil) in spoilers {
        for x in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, -1.0] {
            let mut material = Material::matte(Vec3::ONE);
            // With a normal texture, so that its scale counts.
            material.normal_texture = Some(texture([128, 128, 255, 255].repeat(16)));
            spoil(&mut material, x);
            println!("{what} {x}");
            of(&context, material); // asserts that the radiance is finite
        }
    }
}
