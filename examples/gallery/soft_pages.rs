//! Soft shadows side by side: a cylinder and a complex caster under hard, sphere, square and wide lights. A whole
//! light, a split light and 1024 rays are compared, with maps of the error.
//!
//! After figures 8 to 11 of Assarsson et al. 2003. Writes PNGs and `soft.html`.

use std::fmt::Write as _;
use std::path::Path;
use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::reference::{
    LightSource, RayScene, VisibilityImage, compare_soft, difference_image, primary_hits, soft_visibility,
};
use antumbra::scene::gltf_import::{load_gltf, spawn_scene};
use antumbra::techniques::penumbra_wedge::WedgeSilhouette;
use antumbra::techniques::{OcclusionTexture, Settings, SliceCombination, SliceFilter};
use bevy_ecs::prelude::Bundle;
use bevy_transform::prelude::{GlobalTransform, Transform};
use glam::{UVec2, Vec3};

use super::panels;
use super::support::picture::write_png;
use super::support::stage::{Stage, one_line};
use super::support::stats::print_new_reports;

/// File name of the page.
pub const FILE: &str = "soft.html";

/// A caster on a ground.
pub(super) struct Scene {
    pub(super) name: &'static str,
    caption: &'static str,
    eye: Vec3,
    target: Vec3,
    pub(super) light: Vec3,
    kind: Caster,
}

enum Caster {
    Cylinder,
    Model(&'static str, Transform),
    Comb,
}

pub(super) fn scenes() -> Vec<Scene> {
    let eye = Vec3::new(2.2, 2.4, 4.4);
    vec![
        Scene {
            name: "cylinder",
            caption: "A cylinder, as in figure 10.",
            eye,
            target: Vec3::new(-0.3, 0.5, 0.0),
            light: Vec3::new(1.9, 4.2, 1.2),
            kind: Caster::Cylinder,
        },
        Scene {
            name: "deer",
            caption: "A more complex caster, as in figure 11.",
            eye,
            target: Vec3::new(-0.3, 0.6, 0.0),
            light: Vec3::new(1.9, 4.2, 1.2),
            kind: Caster::Model("deer.glb", Transform::from_scale(Vec3::splat(0.2))),
        },
        Scene {
            name: "comb",
            caption: "Bars behind one another, as in figures 8 and 9: the silhouette from the centre is not that from \
                      the rest of the light, and what overlaps is counted twice.",
            eye,
            target: Vec3::new(-0.4, 0.4, 0.0),
            light: Vec3::new(1.9, 4.2, 1.2),
            kind: Caster::Comb,
        },
    ]
}

pub(super) const SQUARE: LightKind = LightKind::Rect {
    width: 0.9,
    height: 0.9,
};

pub(super) const WIDE: LightKind = LightKind::Rect {
    width: 2.4,
    height: 0.3,
};

/// Renders and judges everything, and writes the page.
///
/// # Errors
/// One line that names the file and the element.
pub fn write(context: &RenderContext, assets: &Path, size: UVec2, out: &Path) -> Result<(), String> {
    std::fs::create_dir_all(out).map_err(|error| format!("{}: {error}", out.display()))?;
    let mut page = "<!doctype html><meta charset=utf-8><title>antumbra: soft shadows</title>\
         <style>body{background:#14161c;color:#ddd;font:15px sans-serif}figure{display:inline-block;margin:4px}</style>"
        .to_owned();
    for scene in scenes() {
        let _ = write!(page, "<h2>{}</h2><p>{}</p>", scene.name, scene.caption);
        let mut stage = stage(context, assets, size, &scene)?;
        let rays = RayScene::from_world(&mut stage.world);
        let shapes = [
            ("hard", LightKind::Point),
            ("sphere", LightKind::Sphere { radius: 0.5 }),
            ("square", SQUARE),
            ("wide", WIDE),
        ];
        for (name, kind) in shapes {
            set_light(&mut stage, kind, scene.light, PenumbraWedge::default());
            let rendered = stage.render().map_err(|error| one_line(&error))?;
            figure(
                &mut page,
                out,
                size,
                &format!("{}-{name}", scene.name),
                &rendered.picture,
                name,
            )?;
        }
        page += "<br>";
        let mut truth = None;
        let silhouettes = [
            (
                "center",
                "1×1, silhouette from the centre",
                1,
                WedgeSilhouette::Center,
            ),
            ("split1", "1×1", 1, WedgeSilhouette::Receiver),
            ("split2", "2×2", 2, WedgeSilhouette::Receiver),
            ("split3", "3×3", 3, WedgeSilhouette::Receiver),
        ];
        let wedges = silhouettes.map(|(stem, title, parts, silhouette)| {
            let wedge = PenumbraWedge {
                split: [parts; 2],
                silhouette,
                ..Default::default()
            };
            (stem, title, Settings::of(wedge))
        });
        for (stem, title, shadow) in wedges.into_iter().chain(slices()) {
            set_light(&mut stage, SQUARE, scene.light, ());
            let light = stage.lights[0];
            stage.shadow(light, &shadow);
            let rendered = stage.render().map_err(|error| one_line(&error))?;
            let got = VisibilityImage::new(size, rendered.visibility[0].clone())
                .map_err(|error| one_line(&error))?;
            if truth.is_none() {
                truth = Some(rays_of(&stage, &rays)?);
            }
            let Some(truth) = &truth else { continue };
            let error = compare_soft(truth, &got).map_err(|error| one_line(&error))?;
            let error = error.ok_or("no pixel counts")?;
            let title = format!(
                "{title}: RMSE {:.4}, penumbra {:.4}",
                error.rmse, error.rmse_penumbra
            );
            println!("{:<10} {title}", scene.name);
            let stem = format!("{}-{stem}", scene.name);
            figure(
                &mut page,
                out,
                size,
                &stem,
                &panels::visibility(&got, truth),
                &title,
            )?;
            let map = difference_image(truth, &got).map_err(|error| one_line(&error))?;
            figure(
                &mut page,
                out,
                size,
                &format!("{stem}-error"),
                &map.rgba8,
                "its error",
            )?;
        }
        if let Some(truth) = &truth {
            let stem = format!("{}-truth", scene.name);
            figure(
                &mut page,
                out,
                size,
                &stem,
                &panels::visibility(truth, truth),
                "1024 rays",
            )?;
        }
    }
    let file = out.join(FILE);
    std::fs::write(&file, page).map_err(|error| format!("{}: {error}", file.display()))?;
    println!("{}", file.display());
    Ok(())
}

/// Occlusion textures: filters and combinations side by side.
fn slices() -> Vec<(&'static str, &'static str, Settings)> {
    let slices = OcclusionTexture {
        slices: 16,
        ..Default::default()
    };
    let filtered = |filter| OcclusionTexture { filter, ..slices };
    let combined = |combine| OcclusionTexture { combine, ..slices };
    let all = [
        ("slices", "16 slices", slices),
        ("slices4", "4 slices", OcclusionTexture { slices: 4, ..slices }),
        (
            "slices-mipmaps",
            "16 slices, mipmaps",
            filtered(SliceFilter::Mipmaps),
        ),
        (
            "slices-sums",
            "16 slices, summed areas",
            filtered(SliceFilter::SummedAreas),
        ),
        (
            "slices-max",
            "16 slices, the darkest alone",
            combined(SliceCombination::Maximum),
        ),
        ("slices-sum", "16 slices, added", combined(SliceCombination::Sum)),
    ];
    all.into_iter()
        .map(|(stem, title, shadow)| (stem, title, Settings::of(shadow)))
        .collect()
}

fn figure(
    page: &mut String,
    out: &Path,
    size: UVec2,
    stem: &str,
    rgba8: &[u8],
    caption: &str,
) -> Result<(), String> {
    write_png(&out.join(format!("{stem}.png")), size, rgba8)?;
    let _ = write!(
        page,
        "<figure><img src=\"{stem}.png\" width={} height={}><figcaption>{caption}</figcaption></figure>",
        size.x, size.y
    );
    Ok(())
}

pub(super) fn stage(
    context: &RenderContext,
    assets: &Path,
    size: UVec2,
    scene: &Scene,
) -> Result<Stage, String> {
    let camera = Camera {
        vertical_fov: 0.75,
        near: 0.05,
        aspect: size.x as f32 / size.y as f32,
        ..Camera::default()
    };
    let view = Transform::from_translation(scene.eye).looking_at(scene.target, Vec3::Y);
    let mut stage = Stage::empty(size, camera, view);
    let added = stage.add_renderer(context.clone(), RenderSettings::default());
    added.map_err(|error| one_line(&error))?;
    let mut put = |mesh: MeshData, place: Transform| {
        stage.world.spawn((
            SceneMesh(Arc::new(mesh)),
            SceneMaterials([Arc::new(Material::matte(Vec3::splat(0.75)))].into()),
            (ShadowCaster, ShadowReceiver),
            place,
        ));
    };
    put(MeshData::plane(12.0), Transform::IDENTITY);
    match scene.kind {
        Caster::Cylinder => put(cylinder(0.45, 1.3, 48), Transform::from_xyz(0.0, 0.01, 0.0)),
        Caster::Comb => {
            for i in 0..7 {
                let x = 0.22 * (i as f32 - 3.0);
                let bar = || MeshData::cuboid(Vec3::new(0.05, 0.6, 0.05));
                put(bar(), Transform::from_xyz(x, 0.75, 0.0));
                put(bar(), Transform::from_xyz(x + 0.08, 0.75, -0.5));
            }
        }
        Caster::Model(name, place) => {
            let loaded = load_gltf(assets.join("models").join(name)).map_err(|error| one_line(&error))?;
            let spawned = spawn_scene(&mut stage.world, &loaded, None).map_err(|error| one_line(&error))?;
            stage.world.entity_mut(spawned.root).insert(place);
        }
    }
    stage.schedule.run(&mut stage.world);
    print_new_reports("soft scenes", &mut stage);
    Ok(stage)
}

pub(super) fn set_light(stage: &mut Stage, kind: LightKind, from: Vec3, shadow: impl Bundle) {
    for light in std::mem::take(&mut stage.lights) {
        stage.world.despawn(light);
    }
    let light = Light {
        kind,
        color: Vec3::ONE,
        intensity: 70.0,
        range: f32::INFINITY,
    };
    let place = Transform::from_translation(from).looking_at(Vec3::new(0.0, 0.4, 0.0), Vec3::Y);
    stage.spawn_light(light, place, Some(shadow));
}

fn rays_of(stage: &Stage, rays: &RayScene) -> Result<VisibilityImage, String> {
    let world = &stage.world;
    let (Some(camera), Some(view)) = (
        world.get::<Camera>(stage.camera),
        world.get::<GlobalTransform>(stage.camera),
    ) else {
        return Err("the stage has no camera".to_owned());
    };
    let size = world.resource::<ViewportSize>().0;
    let hits = primary_hits(rays, camera, view, size).map_err(|error| one_line(&error))?;
    let source = LightSource::of_entity(world, stage.lights[0]).map_err(|error| one_line(&error))?;
    Ok(soft_visibility(rays, &hits, &source, 1024, 7))
}

/// Builds a closed cylinder that stands at the origin.
fn cylinder(radius: f32, height: f32, sides: u32) -> MeshData {
    let mut positions = vec![Vec3::ZERO, Vec3::Y * height];
    for i in 0..sides {
        let (sin, cos) = (i as f32 / sides as f32 * std::f32::consts::TAU).sin_cos();
        let at = Vec3::new(cos * radius, 0.0, sin * radius);
        positions.extend([at, at + Vec3::Y * height]);
    }
    let mut indices = Vec::new();
    for i in 0..sides {
        let (a, b) = (2 + 2 * i, 2 + 2 * ((i + 1) % sides));
        indices.extend([a, a + 1, b, b, a + 1, b + 1, 0, a, b, 1, b + 1, a + 1]);
    }
    MeshData::from_triangles("cylinder", positions, indices)
}
