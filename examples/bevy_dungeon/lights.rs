//! Torches on the walls, a wisp that wanders, and who throws their shadows.

use std::f32::consts::TAU;

use antumbra::bevy_adapter::prelude::*;
use bevy::prelude::*;

use crate::rooms::{ROOM, rooms};

/// Who throws a light's shadows.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Technique {
    /// Stencil shadow volumes: exact, hard.
    Volumes,
    /// Penumbra wedges: soft, by the flame's size.
    Wedges,
    /// Omnidirectional shadow maps.
    Maps,
    /// Bevy's shadow maps.
    Bevy,
    /// Nobody.
    None,
}

impl Technique {
    /// All of them.
    #[cfg(feature = "bevy-window")]
    pub const ALL: [Self; 5] = [Self::Volumes, Self::Wedges, Self::Maps, Self::Bevy, Self::None];

    /// Gives it to a light.
    pub fn give(self, light: &mut EntityCommands, point: &mut PointLight) {
        light.remove::<(StencilVolume, PenumbraWedge, OmniMap)>();
        point.shadow_maps_enabled = self == Self::Bevy;
        point.radius = if self == Self::Wedges { 0.08 } else { 0.0 };
        match self {
            Self::Volumes => light.insert(StencilVolume::default()),
            Self::Wedges => light.insert(PenumbraWedge::default()),
            Self::Maps => light.insert(OmniMap::default()),
            Self::Bevy | Self::None => light,
        };
        light.insert(self);
    }
}

/// A flame, whose brightness goes up and down.
#[derive(Component)]
pub struct Flame {
    /// Lumens.
    pub mean: f32,
    phase: f32,
}

/// A light that wanders through the rooms.
#[derive(Component)]
pub struct Wisp;

/// Two torches a room, and the wisp.
pub fn hang(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
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
    let mut hang = |place: Vec3, color: Color, mean: f32, phase: f32, look: &Handle<StandardMaterial>| {
        let mut point = PointLight {
            color,
            intensity: mean,
            range: 1.2 * ROOM,
            ..default()
        };
        // It shines out of its own flame, which must not stand in its way.
        let flame = (
            Mesh3d(flame_mesh.clone()),
            MeshMaterial3d(look.clone()),
            bevy::light::NotShadowCaster,
        );
        let mut light = commands.spawn((Transform::from_translation(place), Flame { mean, phase }, flame));
        Technique::Volumes.give(&mut light, &mut point);
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

/// Leads the wisp around the inner pillars.
pub fn wander(time: Res<Time>, mut wisps: Query<&mut Transform, With<Wisp>>) {
    let turn = 0.15 * TAU * time.elapsed_secs();
    for mut place in &mut wisps {
        place.translation = Vec3::new(3.0 * turn.cos(), 1.5 + 0.3 * (2.0 * turn).sin(), 3.0 * turn.sin());
    }
}
