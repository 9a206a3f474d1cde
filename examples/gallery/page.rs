//! What a page is made of, and the stage that it stands on.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::scene::apply_animation;
use antumbra::scene::gltf_import::{load_gltf, spawn_scene};
use antumbra::techniques::{Row, Settings, Techniques};
use bevy_ecs::name::Name;
use bevy_transform::prelude::Transform;
use glam::{UVec2, Vec3};

use super::support::shot::ShotCamera;
use super::support::stage::{Stage, framing_camera, one_line};

/// One scene with its shots.
#[derive(Clone)]
pub struct Page {
    /// For `--only`, file names and links.
    pub name: &'static str,
    /// Heading.
    pub title: &'static str,
    /// What there is to see, for the reader of the page.
    pub about: &'static str,
    /// Files that the scene is made of.
    pub models: Vec<PlacedModel>,
    /// Objects made in code.
    pub objects: Vec<PlacedMesh>,
    /// Its lights; none: those of the models.
    pub lights: Vec<NamedLight>,
    /// Factor on the intensity of the models' own directional lights.
    pub sun_gain: f32,
    /// Lets light through surfaces that are blended, such as window panes.
    pub clear_panes: bool,
    /// Linear RGB where nothing is.
    pub background: Vec3,
    /// Linear RGB radiance from everywhere.
    pub ambient: Vec3,
    /// What shadows the lights: each by the first of these that fits it.
    pub techniques: Vec<Settings>,
    /// Views.
    pub shots: Vec<PageShot>,
}

/// A glTF file somewhere in a scene.
#[derive(Clone)]
pub struct PlacedModel {
    /// The file.
    pub file: PathBuf,
    /// Where its scene stands.
    pub transform: Transform,
    /// Clip, by a part of its name, and seconds.
    pub pose: Option<(&'static str, f32)>,
}

/// A mesh made in code.
#[derive(Clone)]
pub struct PlacedMesh {
    /// Its triangles.
    pub mesh: Arc<MeshData>,
    /// Its surface.
    pub material: Material,
    /// Its place.
    pub transform: Transform,
}

/// A light and what the page calls it.
#[derive(Clone)]
pub struct NamedLight {
    /// For the tables.
    pub name: &'static str,
    /// The light.
    pub light: Light,
    /// Its place.
    pub transform: Transform,
}

/// A view of a page.
#[derive(Clone)]
pub struct PageShot {
    /// For file names and headings.
    pub name: &'static str,
    /// What to look at.
    pub caption: &'static str,
    /// The view; none: one that frames the scene.
    pub camera: Option<ShotCamera>,
    /// Name of the light whose panels are shown.
    pub light: &'static str,
    /// Factor on radiance.
    pub exposure: f32,
}

/// A page's world, with every light shadowed.
pub struct PageStage {
    /// The world.
    pub stage: Stage,
    /// Names of the stage's lights.
    pub light_names: Vec<String>,
    /// Triangles of the scene.
    pub triangle_count: usize,
}

/// The repository's `assets`, else that of the current folder.
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

/// A camera at `eye` that looks to `target`.
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
    /// An empty page.
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
            techniques: Techniques::default()
                .rows()
                .iter()
                .take(1)
                .map(Row::defaults)
                .collect(),
            shots: Vec::new(),
        }
    }

    /// Names of the techniques, for the tables.
    pub fn technique_names(&self) -> String {
        let names = self
            .techniques
            .iter()
            .map(|settings| settings.row().name().replace('_', " "));
        names.collect::<Vec<_>>().join(", ")
    }

    /// The technique that fits a light.
    fn technique_of(&self, light: &Light) -> Option<&Settings> {
        self.techniques
            .iter()
            .find(|settings| settings.check(light).is_ok())
    }

    /// Builds the page's world.
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
            stage.spawn_shadowed(
                named.light.clone(),
                named.transform,
                self.technique_of(&named.light),
            );
            light_names.push(named.name.to_owned());
        }
        stage.schedule.run(&mut stage.world);
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
            let light = world.get::<Light>(entity).cloned();
            if let Some(settings) = light.and_then(|light| self.technique_of(&light)) {
                stage.shadow(entity, settings);
            }
            let world = &mut stage.world;
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
    /// Points the camera.
    ///
    /// # Errors
    /// What is wrong with the camera.
    pub fn look(&mut self, shot: &PageShot, size: UVec2) -> Result<(), String> {
        let parts = match &shot.camera {
            Some(camera) => (camera.camera(size), camera.transform()?),
            None => framing_camera(self.stage.scene_bounds(), size.x as f32 / size.y as f32),
        };
        let camera = self.stage.camera;
        self.stage.world.entity_mut(camera).insert(parts);
        Ok(())
    }

    /// Index of a light.
    ///
    /// # Errors
    /// The names that there are.
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
