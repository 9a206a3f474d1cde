//! What changes from frame to frame under a slowly moving light, beside what changes in truth.

use antumbra::prelude::*;
use antumbra::reference::VisibilityImage;
use antumbra::techniques::penumbra_wedge::WedgeSilhouette;
use bevy_transform::prelude::Transform;
use glam::Vec3;

use super::scenes::{EYE, ground, light, lit, rect, rendered, spawn, truth};
use crate::harness::strict_context;

/// By how much more than truth a pixel may change.
pub const ALLOWED: f32 = 0.06;

/// Changes at every pixel from frame to frame.
#[derive(Default)]
pub struct Changes {
    last: Option<(VisibilityImage, VisibilityImage)>,
    excesses: Vec<f32>,
    moved: f32,
}

/// What they come to.
#[derive(Debug)]
#[allow(dead_code, reason = "printed")]
pub struct Flicker {
    /// By how much more the wedges change at a pixel, at most.
    pub excess: f32,
    /// The same of one pixel in ten thousand.
    pub rare: f32,
    /// Pixels where it is more than [`ALLOWED`], of all frames.
    pub jumps: usize,
    /// Of how many.
    pub pixels: usize,
}

impl Changes {
    /// Another frame.
    pub fn add(&mut self, got: VisibilityImage, truth: VisibilityImage) {
        if let Some((last_got, last_truth)) = &self.last {
            for i in 0..truth.values().len() {
                let change = (truth.values()[i] - last_truth.values()[i]).abs();
                if change.is_nan() {
                    continue;
                }
                self.moved = self.moved.max(change);
                self.excesses
                    .push((got.values()[i] - last_got.values()[i]).abs() - change);
            }
        }
        self.last = Some((got, truth));
    }

    /// Of all frames.
    pub fn flicker(mut self) -> Flicker {
        assert!(self.moved > 0.02, "the light moves");
        self.excesses.sort_by(f32::total_cmp);
        let excesses = &self.excesses;
        let last = excesses.len() - 1;
        Flicker {
            excess: excesses[last],
            rare: excesses[last - excesses.len() / 10_000],
            jumps: excesses.iter().filter(|excess| **excess > ALLOWED).count(),
            pixels: excesses.len(),
        }
    }
}

/// Moves a light by a centimetre a frame.
fn flicker(casters: &[(MeshData, Vec3)], wedge: PenumbraWedge, frames: u32) -> Flicker {
    let context = strict_context();
    let mut stage = ground(&context, EYE, Vec3::ZERO);
    for (mesh, place) in casters {
        spawn(&mut stage, mesh.clone(), Transform::from_translation(*place));
    }
    light(&mut stage, &lit(rect(0.5, 0.5), wedge));
    let entity = stage.lights[0];
    stage
        .world
        .insert_resource(ViewportSize(glam::UVec2::new(80, 45)));
    let mut changes = Changes::default();
    for frame in 0..frames {
        let from = Vec3::new(0.6 + 0.01 * frame as f32, 4.5, 0.8);
        let place = Transform::from_translation(from).looking_at(Vec3::ZERO, Vec3::Y);
        stage.world.entity_mut(entity).insert(place);
        let got = rendered(&mut stage, 0);
        let truth = truth(&mut stage, 0, 256);
        changes.add(got, truth);
    }
    let flicker = changes.flicker();
    println!(
        "{} casters, split {:?}: {flicker:.3?}",
        casters.len(),
        wedge.split
    );
    flicker
}

fn balls(radius: f32, subdivisions: u32) -> [(MeshData, Vec3); 3] {
    let ball = |x, y, z| (MeshData::icosphere(radius, subdivisions), Vec3::new(x, y, z));
    [ball(0.0, 1.6, 0.0), ball(0.35, 1.0, 0.2), ball(-0.3, 0.7, -0.1)]
}

#[test]
fn a_slowly_moving_light_does_not_flicker() {
    let alone = [(MeshData::icosphere(0.5, 3), Vec3::new(0.0, 1.2, 0.0))];
    // Balls that hide the same of the light, and coarse ones that cut one another: millimetres from a facet, the facet is
    // all of the light.
    for casters in [&alone[..], &balls(0.35, 3), &balls(0.4, 2)] {
        for split in [[1; 2], [2; 2]] {
            let wedge = PenumbraWedge {
                split,
                ..Default::default()
            };
            let flicker = flicker(casters, wedge, 25);
            assert!(flicker.excess <= ALLOWED, "{flicker:?}");
        }
    }
}

#[test]
fn the_silhouette_from_the_centre_jumps_over_facets() {
    let wedge = PenumbraWedge {
        silhouette: WedgeSilhouette::Center,
        ..Default::default()
    };
    let flicker = flicker(&balls(0.4, 2), wedge, 60);
    assert!(flicker.excess > 2.0 * ALLOWED, "{flicker:?}");
}
