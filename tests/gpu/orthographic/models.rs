//! Shadow volumes of models, from outside and inside of shadows, with lights in the picture and outside of it.

use antumbra::prelude::*;
use antumbra::reference::HardError;
use antumbra::techniques::stencil_volume::{Counting, StencilVolumes};
use bevy_transform::prelude::Transform;
use glam::{UVec2, Vec3};

use crate::harness::cases::{Case, PLACEMENTS, Placement};
use crate::harness::radiance::{judge_radiance, show_lights_alone};
use crate::harness::{ModelStage, file_name, judge, strict_context};

const SIZE: UVec2 = UVec2::new(160, 90);

/// Share of wrong pixels outside of the edge band; as in `reference_match`.
const ALLOWED: f64 = 0.001;

const MODELS: [&str; 3] = ["many_cubes.glb", "interior.glb", "fox.glb"];

/// The same light from an orthographic view with the same axis: wide, or a part of the picture; its near plane before,
/// within or behind the model.
fn orthographic(model: &ModelStage, case: &Case, placement: Placement) -> Case {
    let radius = model.bounds.half_size().length();
    let (height, near) = match placement {
        Placement::Outside | Placement::LightBehind => (2.0, -3.0),
        Placement::InsideShadow => (0.8, 0.0),
        Placement::LightInFrustum => (3.5, 0.5),
        Placement::Touching => (1.0, 0.3),
    };
    let camera = Camera::orthographic(
        height * radius,
        near * radius,
        12.0 * radius,
        SIZE.x as f32 / SIZE.y as f32,
    );
    Case {
        camera,
        ..case.clone()
    }
}

/// What was judged of several pictures.
#[derive(Default)]
struct Judged {
    /// Pixels outside of the edge band.
    inner: usize,
    /// Pixels whose radiance was judged.
    lit: usize,
    /// Pixels in shadow.
    dark: usize,
    /// Volumes by depth-fail, and by depth-pass.
    volumes: [usize; 2],
}

impl Judged {
    /// Renders a case and compares it with the ray caster, with volumes counted either way.
    fn add(&mut self, model: &mut ModelStage, case: &Case) -> [(Counting, HardError); 2] {
        [Counting::Auto, Counting::DepthFail].map(|counting| {
            let technique = StencilVolume {
                counting,
                ..StencilVolume::default()
            };
            model.set(case, technique);
            let rendered = model.stage.render().expect("the frame renders");
            let error = judge(&model.stage, &model.scene, 0, &rendered.visibility[0]);
            self.inner += error.inner;
            let shown = judge_radiance(&model.stage, &model.scene, &rendered.radiance);
            self.lit += shown.inner;
            assert!(
                shown.share().unwrap_or(0.0) <= ALLOWED,
                "radiance, {counting:?}: {shown:?}"
            );
            self.dark += rendered.visibility[0].iter().filter(|v| **v < 0.5).count();
            let volumes = model.stage.world.resource::<StencilVolumes>();
            for volume in volumes.lights.iter().flat_map(|light| &light.casters) {
                assert!(volume.extrusion > 0.0, "all volumes end");
                self.volumes[usize::from(volume.depth_pass)] += 1;
            }
            (counting, error)
        })
    }
}

#[test]
#[ignore = "needs all models: ANTUMBRA_MODELS"]
fn stencil_volumes_equal_the_ray_caster() {
    let context = strict_context();
    let mut failures = Vec::new();
    for name in MODELS {
        let path = crate::harness::model(name);
        let mut model = ModelStage::new(&path, &context, SIZE).expect("triangles");
        show_lights_alone(&mut model.stage);
        let mut judged = Judged::default();
        for (at, (label, case)) in model.cases().into_iter().enumerate() {
            let case = orthographic(&model, &case, PLACEMENTS[at / 3]);
            for (counting, error) in judged.add(&mut model, &case) {
                if error.share().unwrap_or(0.0) > ALLOWED {
                    failures.push(format!("{name} {label} {counting:?}: {error:?}"));
                }
            }
        }
        let Judged {
            inner,
            lit,
            dark,
            volumes: [by_fail, by_pass],
        } = judged;
        println!(
            "{:<20} {inner} judged, {dark} dark, {by_fail} volumes by depth-fail, {by_pass} by depth-pass",
            file_name(&path)
        );
        assert!(
            inner > 60_000 && lit > 30_000 && dark > 10_000,
            "{name}: too little was judged"
        );
        assert!(by_fail > 0);
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// The judge tells an orthographic picture from a perspective one.
#[test]
#[ignore = "needs all models: ANTUMBRA_MODELS"]
fn the_judge_sees_the_projection() {
    let context = strict_context();
    let mut model = ModelStage::new(&crate::harness::model(MODELS[0]), &context, SIZE).expect("triangles");
    let (_, case) = model.cases().swap_remove(0);
    model.set(&case, StencilVolume::default());
    let perspective = model.stage.render().expect("the frame renders");
    let case = orthographic(&model, &case, Placement::Outside);
    model.set(&case, StencilVolume::default());
    model.stage.render().expect("the frame renders");
    let error = judge(&model.stage, &model.scene, 0, &perspective.visibility[0]);
    assert!(error.share().unwrap_or(0.0) > 10.0 * ALLOWED, "{error:?}");
}

/// Lights along the lines of sight, from before and from behind, and across them: volumes that never leave the picture.
#[test]
#[ignore = "needs all models: ANTUMBRA_MODELS"]
fn lights_along_the_view_cast_as_others() {
    let context = strict_context();
    let mut model = ModelStage::new(&crate::harness::model(MODELS[0]), &context, SIZE).expect("triangles");
    let (_, case) = model.cases().swap_remove(2);
    let case = orthographic(&model, &case, Placement::Outside);
    let view = case.view;
    show_lights_alone(&mut model.stage);
    let mut judged = Judged::default();
    for towards in [view.forward(), view.back(), view.right(), view.up()] {
        let place = Transform::from_translation(view.translation)
            .looking_to(*towards, if towards.y.abs() > 0.9 { Vec3::X } else { Vec3::Y });
        let case = Case {
            place,
            ..case.clone()
        };
        for (counting, error) in judged.add(&mut model, &case) {
            println!("{towards:?} {counting:?}: {error:?}");
            assert!(error.share().unwrap_or(0.0) <= ALLOWED, "{towards:?}: {error:?}");
        }
    }
    let Judged { inner, dark, .. } = judged;
    assert!(inner > 10_000 && dark > 2_000, "{inner} {dark}");
}
