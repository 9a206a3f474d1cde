//! Torches on the walls, a wandering wisp, and the techniques of their shadows.

use std::f32::consts::TAU;

use antumbra::techniques::{Row, Techniques};
use bevy::prelude::*;

use crate::rooms::{ROOM, rooms};

/// The technique that makes a light's shadows.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Technique {
    /// A technique of antumbra.
    Ours(Row),
    /// Bevy's shadow maps.
    Bevy,
    /// No shadows.
    None,
}

/// Radius of flames, metres.
#[derive(Resource, Clone, Copy, PartialEq)]
pub struct FlameRadius(pub f32);

impl Default for FlameRadius {
    fn default() -> Self {
        Self(0.08)
    }
}

impl Technique {
    /// Returns all choices: first our techniques that fit a point light, in the order of their list, then the others.
    pub fn all() -> Vec<Self> {
        let point = antumbra::scene::Light::point(Vec3::ONE, 1.0, ROOM);
        let techniques = Techniques::default();
        let fitting = techniques
            .rows()
            .iter()
            .filter(|row| row.defaults().check(&point).is_ok());
        let ours = fitting.copied().map(Self::Ours);
        ours.chain([Self::Bevy, Self::None]).collect()
    }

    /// Returns the name for the text on the screen.
    #[cfg(feature = "bevy-window")]
    pub fn name(self) -> &'static str {
        match self {
            Self::Ours(row) => row.name(),
            Self::Bevy => "Bevy's maps",
            Self::None => "none",
        }
    }

    /// Whether lights of the technique have an extent. Objects can be hidden from a light only if the light is a point, so
    /// techniques that use this get a point.
    pub fn has_flame(self) -> bool {
        matches!(self, Self::Ours(row) if !row.needs().light_occlusion)
    }

    /// Gives the technique to a light and removes the light's other techniques.
    pub fn give(self, light: &mut EntityCommands, point: &mut PointLight, radius: FlameRadius) {
        point.shadow_maps_enabled = self == Self::Bevy;
        point.radius = if self.has_flame() { radius.0 } else { 0.0 };
        light.insert(self);
        light.queue(move |mut light: EntityWorldMut| {
            Techniques::default().take(&mut light);
            if let Self::Ours(row) = self {
                row.defaults().insert(&mut light);
            }
        });
    }
}

/// A flame whose brightness flickers.
#[derive(Component)]
pub struct Flame {
    /// Mean luminous power, lumens.
    pub mean: f32,
    phase: f32,
}

/// Marks the light that wanders through the rooms.
#[derive(Component)]
pub struct Wisp;

/// Spawns two torches in each room, and the wisp.
pub fn hang(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    radius: Res<FlameRadius>,
) {
    let flame_mesh = meshes.add(Sphere::new(0.05));
    let mut glow = |color: LinearRgba| {
        materials.add(StandardMaterial {
            emissive: color * 20.0,
            ..default()
        })
    };
    let (fire, cold) = (
        glow(LinearRgba::rgb(1.0, 0.5, 0.15)),
        glow(LinearRgba::rgb(0.3, 0.8, 1.0)),
    );
    let first = Technique::all().first().copied().unwrap_or(Technique::None);
    let mut hang = |place: Vec3, color: Color, mean: f32, phase: f32, look: &Handle<StandardMaterial>| {
        let mut point = PointLight {
            color,
            intensity: mean,
            range: 1.2 * ROOM,
            ..default()
        };
        // The light is inside its own flame, so the flame must not cast a shadow.
        let flame = (
            Mesh3d(flame_mesh.clone()),
            MeshMaterial3d(look.clone()),
            bevy::light::NotShadowCaster,
        );
        let mut light = commands.spawn((Transform::from_translation(place), Flame { mean, phase }, flame));
        first.give(&mut light, &mut point, *radius);
        light.insert(point).id()
    };
    for (index, middle) in rooms().enumerate() {
        for (side, z) in [-1.0, 1.0].into_iter().enumerate() {
            let x = if (index + side) % 2 == 0 { 1.6 } else { -1.6 };
            let place = middle + Vec3::new(x, 1.9, z * (0.5 * ROOM - 0.5));
            let phase = (2 * index + side) as f32 * 1.7;
            hang(place, Color::srgb(1.0, 0.62, 0.3), 400_000.0, phase, &fire);
        }
    }
    let wisp = hang(Vec3::Y * 1.5, Color::srgb(0.5, 0.85, 1.0), 300_000.0, 0.0, &cold);
    commands.entity(wisp).insert(Wisp);
}

/// Makes flames flicker.
pub fn flicker(time: Res<Time>, mut flames: Query<(&Flame, &mut PointLight)>) {
    let now = time.elapsed_secs();
    for (flame, mut light) in &mut flames {
        let wave = |speed: f32| (speed * now + flame.phase).sin();
        light.intensity = flame.mean * (1.0 + 0.12 * wave(9.0) * wave(2.3) + 0.06 * wave(23.0));
    }
}

/// Moves the wisp around the inner pillars.
pub fn wander(time: Res<Time>, mut wisps: Query<&mut Transform, With<Wisp>>) {
    let turn = 0.15 * TAU * time.elapsed_secs();
    for mut place in &mut wisps {
        place.translation = Vec3::new(3.0 * turn.cos(), 1.5 + 0.3 * (2.0 * turn).sin(), 3.0 * turn.sin());
    }
}
