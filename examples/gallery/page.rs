//! The description of a page, and the stage that is built from it.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::scene::apply_animation;
use antumbra::scene::gltf_import::{load_gltf, spawn_scene};
use antumbra::techniques::Techniques;
use bevy_ecs::name::Name;
use bevy_transform::prelude::Transform;
use glam::{UVec2, Vec3};

use super::support::shot::ShotCamera;
use super::support::stage::{Stage, framing_camera, one_line};
use super::way::{Way, ways_of};

/// One scene with its shots.
#[derive(Clone)]
pub struct Page {
    /// Name for `--only`, file names and links.
    pub name: &'static str,
    /// Heading of the page.
    pub title: &'static str,
    /// Text that tells the reader what to look for.
    pub about: &'static str,
    /// glTF files of the scene.
    pub models: Vec<PlacedModel>,
    /// Objects of the scene that are made in code.
    pub objects: Vec<PlacedMesh>,
    /// Lights of the page. If empty, the models' own lights shine.
    pub lights: Vec<NamedLight>,
    /// Factor that multiplies the intensity of the models' own directional lights.
    pub sun_gain: f32,
    /// Whether blended surfaces, such as window panes, let light through.
    pub clear_panes: bool,
    /// Background, linear RGB radiance.
    pub background: Vec3,
    /// Ambient light, linear RGB radiance from everywhere.
    pub ambient: Vec3,
    /// Ways to shadow the lights, each of which is drawn and judged.
    pub ways: Vec<Way>,
    /// Views of the scene.
    pub shots: Vec<PageShot>,
}

/// A glTF file and its place in a scene.
#[derive(Clone)]
pub struct PlacedModel {
    /// Path of the file.
    pub file: PathBuf,
    /// Transform of the file's scene.
    pub transform: Transform,
    /// Part of a clip's name, and a time in seconds.
    pub pose: Option<(&'static str, f32)>,
}

/// A mesh that is made in code.
#[derive(Clone)]
pub struct PlacedMesh {
    /// Triangles of the mesh.
    pub mesh: Arc<MeshData>,
    /// Surface of the mesh.
    pub material: Material,
    /// Transform in the scene.
    pub transform: Transform,
}

/// A light and its name on the page.
#[derive(Clone)]
pub struct NamedLight {
    /// Name for the tables.
    pub name: &'static str,
    /// The light component.
    pub light: Light,
    /// Transform in the scene.
    pub transform: Transform,
}

/// A view of a page.
#[derive(Clone)]
pub struct PageShot {
    /// Name for file names and headings.
    pub name: &'static str,
    /// Text that tells the reader what to look for in this view.
    pub caption: &'static str,
    /// The camera; `None` takes one that frames the scene.
    pub camera: Option<ShotCamera>,
    /// Name of the light whose panels are shown.
    pub light: &'static str,
    /// Exposure, a factor that multiplies radiance.
    pub exposure: f32,
}

/// The stage of a page.
pub struct PageStage {
    /// World, schedule and renderer.
    pub stage: Stage,
    /// Names of the stage's lights.
    pub light_names: Vec<String>,
    /// Number of triangles of the scene.
    pub triangle_count: usize,
}

/// Returns the repository's `assets` folder, or else the one in the current folder.
pub fn assets_folder() -> Result<PathBuf, String> {
    let built_from = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets");
    let here = PathBuf::from("assets");
    [&built_from, &here]
        .into_iter()
        .find(|folder| folder.join("models").is_dir())
        .cloned()
        .ok_or_else(|| {
            format!(
                "{}: folder models is not there, nor in ./assets",
                built_from.display()
            )
        })
}

/// Returns a camera at `eye` that looks at `target`.
pub fn view(eye: [f32; 3], target: [f32; 3], vfov_deg: f32) -> Option<ShotCamera> {
    Some(ShotCamera {
        eye,
        target,
        up: [0.0, 1.0, 0.0],
        vfov_deg,
        near: 0.05,
        orthographic: None,
    })
}

impl Page {
    /// Returns an empty page.
    pub fn new(name: &'static str, title: &'static str, about: &'static str) -> Self {
        Self {
            name,
            title,
            about,
            models: Vec::new(),
            objects: Vec::new(),
            lights: Vec::new(),
            sun_gain: 1.0,
            clear_panes: false,
            background: Vec3::new(0.012, 0.014, 0.018),
            ambient: Vec3::splat(0.02),
            ways: ways_of(&Techniques::default()),
            shots: Vec::new(),
        }
    }

    /// Builds the page's stage. Its lights have no techniques yet.
    ///
    /// # Errors
    /// One line that names the file and the element.
    pub fn stage(&self, size: UVec2) -> Result<PageStage, String> {
        let mut stage = Stage::empty(size, Camera::default(), Transform::IDENTITY);
        stage.world.insert_resource(FaceCulling::None);
        let mut light_names = Vec::new();
        for model in &self.models {
            self.spawn_model(model, &mut stage, &mut light_names)?;
        }
        for object in &self.objects {
            stage.world.spawn((
                SceneMesh(Arc::clone(&object.mesh)),
                SceneMaterials([Arc::new(object.material.clone())].into()),
                (ShadowCaster, ShadowReceiver),
                object.transform,
            ));
        }
        for named in &self.lights {
            stage.spawn_light(named.light.clone(), named.transform, None::<()>);
            light_names.push(named.name.to_owned());
        }
        stage.run();
        let triangle_count = stage
            .world
            .query::<&SceneMesh>()
            .iter(&stage.world)
            .map(|mesh| mesh.0.triangle_count())
            .sum();
        Ok(PageStage {
            stage,
            light_names,
            triangle_count,
        })
    }

    fn spawn_model(
        &self,
        model: &PlacedModel,
        stage: &mut Stage,
        light_names: &mut Vec<String>,
    ) -> Result<(), String> {
        let loaded = load_gltf(&model.file).map_err(|error| one_line(&error))?;
        let world = &mut stage.world;
        let spawned = spawn_scene(world, &loaded, None).map_err(|error| one_line(&error))?;
        world.entity_mut(spawned.root).insert(model.transform);
        if let Some((part, seconds)) = model.pose {
            let clip = loaded
                .clips
                .iter()
                .find(|clip| clip.name.to_lowercase().contains(part))
                .ok_or_else(|| {
                    let names: Vec<&str> = loaded.clips.iter().map(|clip| clip.name.as_str()).collect();
                    format!(
                        "{}: no clip {part}, there are {}",
                        model.file.display(),
                        names.join(", ")
                    )
                })?;
            apply_animation(world, &spawned, clip, seconds);
        }
        for &camera in &spawned.cameras {
            world.entity_mut(camera).remove::<Camera>();
        }
        for &entity in &spawned.lights {
            let world = &mut stage.world;
            if !self.lights.is_empty() {
                world.entity_mut(entity).remove::<Light>();
                continue;
            }
            let mut light_entity = world.entity_mut(entity);
            let name = light_entity
                .get::<Name>()
                .map_or_else(String::new, |name| name.to_string());
            if let Some(mut light) = light_entity.get_mut::<Light>()
                && light.kind == LightKind::Directional
            {
                light.intensity *= self.sun_gain;
            }
            light_names.push(name);
            stage.lights.push(entity);
        }
        let world = &mut stage.world;
        if self.clear_panes {
            for &mesh in &spawned.meshes {
                let is_clear = world.get::<SceneMaterials>(mesh).is_some_and(|materials| {
                    materials
                        .0
                        .iter()
                        .all(|material| material.alpha_mode == AlphaMode::Blend)
                });
                if is_clear {
                    world.entity_mut(mesh).remove::<ShadowCaster>();
                }
            }
        }
        Ok(())
    }
}

impl PageStage {
    /// Points the camera at a shot's view.
    ///
    /// # Errors
    /// Says what is wrong with the camera.
    pub fn look(&mut self, shot: &PageShot, size: UVec2) -> Result<(), String> {
        let parts = match &shot.camera {
            Some(camera) => (camera.camera(size), camera.transform()?),
            None => framing_camera(self.stage.scene_bounds(), size.x as f32 / size.y as f32),
        };
        let camera = self.stage.camera;
        self.stage.world.entity_mut(camera).insert(parts);
        Ok(())
    }

    /// Returns the index of the light with a name.
    ///
    /// # Errors
    /// No light has the name. Lists the names of all lights.
    pub fn light(&self, page: &Page, name: &str) -> Result<usize, String> {
        self.light_names
            .iter()
            .position(|light| light == name)
            .ok_or_else(|| {
                format!(
                    "page {}: no light {name}, there are {}",
                    page.name,
                    self.light_names.join(", ")
                )
            })
    }
}
