//! The light model of a shot's light: the keys that every kind of light may have.

use std::path::{Path, PathBuf};

use antumbra::prelude::*;
use antumbra::scene::gltf_import::{LoadedGltf, SpawnedScene, layer_of_name};
use antumbra::scene::{
    BarnMap, LightDistance, LightModel, LightModelFault, LightShape, LightWeights, ShadowOrigin,
    ShadowSoftness, ShadowTint,
};
use bevy_ecs::prelude::*;
use glam::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::{Map, Value};

use super::textures::{ShotCookie, check_profile, load_profile};

/// The light model of a light. Each key may be left out.
#[derive(Clone, Debug, Default, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ShotModel {
    /// Barn doors.
    pub shape: Option<LightShape>,
    /// The texture that holds the barn doors.
    pub barn_map: Option<BarnMap>,
    /// Depths between which the light shines.
    pub distance: Option<LightDistance>,
    /// Weights of ambient, diffuse and specular light.
    pub weights: Option<LightWeights>,
    /// Colour of the shadows, linear RGB.
    pub shadow_color: Option<[f32; 3]>,
    /// Share of the light that casters take away, 0 to 1.
    #[schemars(range(min = 0, max = 1))]
    pub shadow_darkness: Option<f32>,
    /// Place from which shadows are cast, metres.
    pub shadow_origin: Option<[f32; 3]>,
    /// Direction in which the shadows of a directional light fall.
    pub shadow_direction: Option<[f32; 3]>,
    /// Radius of the extent that shadows are cast with, metres.
    #[schemars(range(min = 0))]
    pub shadow_softness: Option<f32>,
    /// Picture before the light.
    pub cookie: Option<ShotCookie>,
    /// Path of an IES or EULUMDAT file, relative to the shot file.
    pub profile: Option<PathBuf>,
    /// Names of the nodes or layers that the light lights. Default: all.
    pub affects: Option<Vec<String>>,
    /// Names of the nodes or layers that block the light. Default: all.
    pub casts_for: Option<Vec<String>>,
    /// Names of the nodes or layers that show the light's shadows. Default: all.
    pub shows_on: Option<Vec<String>>,
}

/// The keys of a [`ShotModel`].
pub const KEYS: [&str; 14] = [
    "shape",
    "barn_map",
    "distance",
    "weights",
    "shadow_color",
    "shadow_darkness",
    "shadow_origin",
    "shadow_direction",
    "shadow_softness",
    "cookie",
    "profile",
    "affects",
    "casts_for",
    "shows_on",
];

impl ShotModel {
    /// Takes the keys of the light model out of a light's, and reads them.
    ///
    /// # Errors
    /// Names the key and says what is wrong with it.
    pub fn take(light: &mut Map<String, Value>) -> Result<Self, String> {
        let mut own = Map::new();
        for key in KEYS {
            own.extend(light.remove_entry(key));
        }
        serde_path_to_error::deserialize(Value::Object(own))
            .map_err(|error| format!("{}: {}", error.path(), error.inner()))
    }

    /// Checks that all numbers are usable for a light.
    ///
    /// # Errors
    /// Names the first number that is not.
    pub fn check(&self, light: &Light) -> Result<(), String> {
        let mut first = None;
        let (tint, origin, softness) = (
            self.tint(),
            self.origin(),
            self.shadow_softness.map(ShadowSoftness),
        );
        let parts = (
            self.shape.as_ref(),
            self.distance.as_ref(),
            self.weights.as_ref(),
            tint.as_ref(),
            origin.as_ref(),
            softness.as_ref(),
            self.barn_map.as_ref(),
        );
        LightModel::of(parts, light.kind, |fault| {
            first.get_or_insert(fault);
        });
        if self.barn_map.is_some() && self.shape.is_none() {
            return Err("barn_map: it needs `shape`, which it tabulates".to_owned());
        }
        if self.shadow_origin.is_some() && self.shadow_direction.is_some() {
            return Err(
                "shadow_direction: it is for directional lights, which have no `shadow_origin`".to_owned(),
            );
        }
        if let Some(cookie) = &self.cookie {
            cookie.check(light.kind)?;
        }
        if self.profile.is_some() {
            check_profile(light.kind)?;
        }
        first.map_or(Ok(()), |fault| match self.key_of(&fault) {
            Some(key) => Err(format!("{key}: {fault}")),
            None => Err(fault.to_string()),
        })
    }

    /// Returns the key of the file that a fault is about.
    fn key_of(&self, fault: &LightModelFault) -> Option<String> {
        let key = match fault {
            LightModelFault::Shape { name, .. } => return Some(format!("shape.{name}")),
            LightModelFault::Distance { name, .. } => return Some(format!("distance.{name}")),
            LightModelFault::Weight { name, .. } => return Some(format!("weights.{name}")),
            LightModelFault::Round(_) => "shape.round",
            LightModelFault::NearBeyondFar { .. } => "distance",
            LightModelFault::Directional("LightShape") => "shape",
            LightModelFault::Directional("LightDistance") => "distance",
            LightModelFault::ShadowColor(_) => "shadow_color",
            LightModelFault::Darkness(_) => "shadow_darkness",
            LightModelFault::Origin(_) | LightModelFault::OriginKind { .. }
                if self.shadow_origin.is_some() =>
            {
                "shadow_origin"
            }
            LightModelFault::Origin(_) | LightModelFault::OriginKind { .. } => "shadow_direction",
            LightModelFault::Softness(_) => "shadow_softness",
            LightModelFault::BarnMap(_) => "barn_map.resolution",
            _ => return None,
        };
        Some(key.to_owned())
    }

    /// Makes the paths relative to the current folder. The files are read here only to report errors with the shot
    /// file's name, and again when the light is spawned.
    ///
    /// # Errors
    /// Names the key and the file.
    pub fn find_files(&mut self, folder: &Path) -> Result<(), String> {
        if let Some(cookie) = &mut self.cookie {
            cookie.path = folder.join(&cookie.path);
            cookie.load(LightKind::Point)?;
        }
        if let Some(profile) = &mut self.profile {
            *profile = folder.join(&*profile);
            load_profile(profile)?;
        }
        Ok(())
    }

    fn tint(&self) -> Option<ShadowTint> {
        let mut tint = ShadowTint::default();
        if self.shadow_color.is_none() && self.shadow_darkness.is_none() {
            return None;
        }
        tint.color = self.shadow_color.map_or(tint.color, Vec3::from);
        tint.darkness = self.shadow_darkness.unwrap_or(tint.darkness);
        Some(tint)
    }

    fn origin(&self) -> Option<ShadowOrigin> {
        let position = self
            .shadow_origin
            .map(|point| ShadowOrigin::Position(point.into()));
        position.or(self
            .shadow_direction
            .map(|towards| ShadowOrigin::Direction(towards.into())))
    }

    /// Removes all components that [`ShotModel::insert`] may insert.
    pub fn remove(light: &mut EntityWorldMut) {
        light.remove::<(
            (LightSelection, Cookie, LightProfile),
            (LightShape, BarnMap, LightDistance, LightWeights),
            (ShadowTint, ShadowOrigin, ShadowSoftness),
        )>();
    }

    /// Inserts the components into a light of a scene.
    ///
    /// # Errors
    /// A name that neither a node nor a layer of the scene has, more names than layers, or a file that cannot be read.
    pub fn insert(
        &self,
        world: &mut World,
        light: Entity,
        (loaded, spawned): (&LoadedGltf, &SpawnedScene),
    ) -> Result<(), String> {
        let mut selection = LightSelection::default();
        for (key, names, mask) in [
            ("affects", &self.affects, &mut selection.affects),
            ("casts_for", &self.casts_for, &mut selection.casts_for),
            ("shows_on", &self.shows_on, &mut selection.shows_on),
        ] {
            let Some(names) = names else { continue };
            *mask = 0;
            for name in names {
                let bit = layer_of_name(world, loaded, &spawned.nodes, name)
                    .map_err(|error| format!("{key}: {error}"))?;
                *mask |=
                    bit.ok_or_else(|| format!("{key}: neither a node nor a layer has the name `{name}`"))?;
            }
        }
        let kind = world
            .get::<Light>(light)
            .map_or(LightKind::Point, |light| light.kind);
        let mut entity = world.entity_mut(light);
        if let Some(cookie) = &self.cookie {
            entity.insert(cookie.load(kind)?);
        }
        if let Some(profile) = &self.profile {
            entity.insert(load_profile(profile)?);
        }
        if selection != LightSelection::default() {
            entity.insert(selection);
        }
        put(&mut entity, self.shape);
        put(&mut entity, self.barn_map);
        put(&mut entity, self.distance);
        put(&mut entity, self.weights);
        put(&mut entity, self.tint());
        put(&mut entity, self.origin());
        put(&mut entity, self.shadow_softness.map(ShadowSoftness));
        Ok(())
    }
}

fn put(light: &mut EntityWorldMut, part: Option<impl Bundle>) {
    if let Some(part) = part {
        light.insert(part);
    }
}
