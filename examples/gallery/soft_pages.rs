//! Pages with soft shadows: a cylinder, a complex caster and a comb under lights with a size.
//!
//! After figures 8 to 11 of Assarsson et al. 2003.

use std::path::Path;

use antumbra::prelude::*;
use antumbra::techniques::penumbra_wedge::WedgeSilhouette;
use antumbra::techniques::{OcclusionTexture, Settings, SliceCombination, SliceFilter};
use bevy_transform::prelude::Transform;
use glam::Vec3;

use super::page::{NamedLight, Page, PageShot, PlacedMesh, PlacedModel, view};
use super::pages::{ground, mesh, model};
use super::way::Way;

/// Place of the lights of all pages.
pub const LIGHT: Vec3 = Vec3::new(1.9, 4.2, 1.2);

/// A square light.
pub const SQUARE: LightKind = LightKind::Rect {
    width: 0.9,
    height: 0.9,
};

/// A light that is much wider than high.
pub const WIDE: LightKind = LightKind::Rect {
    width: 2.4,
    height: 0.3,
};

/// Returns all pages with soft shadows.
pub fn all(models: &Path) -> Vec<Page> {
    let mut pages = casters(models);
    let deer = pages[1].clone();
    pages.push(Page {
        lights: vec![light("sphere", LightKind::Sphere { radius: 0.5 })],
        shots: shots(
            "sphere",
            "A sphere is round from everywhere, so its penumbrae are as wide on all sides.",
        ),
        name: "soft-sphere",
        title: "A deer under a sphere",
        about: "The same deer under a light that is a sphere of one metre.",
        ..deer
    });
    let cylinder = pages[0].clone();
    pages.push(Page {
        lights: vec![light("wide", WIDE)],
        shots: shots(
            "wide",
            "Edges along the light are sharp, edges across it are soft.",
        ),
        name: "soft-wide",
        title: "A cylinder under a long light",
        about: "A light of 2.4 m × 0.3 m: a penumbra’s width depends on the direction of the edge.",
        ..cylinder
    });
    pages
}

/// Returns the pages under a square light, whose silhouettes and parts are compared as well.
pub fn casters(models: &Path) -> Vec<Page> {
    let page = |name, title, about, caption| Page {
        objects: vec![ground(12.0)],
        lights: vec![light("square", SQUARE)],
        shots: shots("square", caption),
        background: Vec3::ZERO,
        ..Page::new(name, title, about)
    };
    let mut cylinder = page(
        "soft-cylinder",
        "A cylinder under a square light",
        "A light with a size has penumbrae: sharp at the contact, wider with the distance (figure 10 of the wedges’ paper). \
         The truth is made of 1024 rays to the light at every pixel.",
        "Sharp at the foot, soft at the far end.",
    );
    cylinder.objects.push(PlacedMesh {
        transform: Transform::from_xyz(0.0, 0.01, 0.0),
        ..mesh(round(0.45, 1.3, 48), grey())
    });
    let mut deer = page(
        "soft-deer",
        "A deer under a square light",
        "A caster with legs and antlers (figure 11): many silhouette edges, whose penumbrae overlap.",
        "The antlers fade out, the hooves stay sharp.",
    );
    deer.models.push(PlacedModel {
        transform: Transform::from_scale(Vec3::splat(0.2)),
        ..model(models, "deer.glb")
    });
    let mut comb = page(
        "soft-comb",
        "A comb under a square light",
        "Bars behind one another (figures 8 and 9): the silhouette from the light’s centre is not that from the rest of the \
         light, and what overlaps is easily counted twice.",
        "Two rows of bars, whose penumbrae overlap on the ground.",
    );
    for i in 0..7 {
        let x = 0.22 * (i as f32 - 3.0);
        for (x, z) in [(x, 0.0), (x + 0.08, -0.5)] {
            comb.objects.push(PlacedMesh {
                transform: Transform::from_xyz(x, 0.75, z),
                ..mesh(MeshData::cuboid(Vec3::new(0.05, 0.6, 0.05)), grey())
            });
        }
    }
    comb.ways.extend(wedges());
    comb.ways.extend(slices());
    vec![cylinder, deer, comb]
}

/// Returns further settings of wedges: the paper's silhouette, and a light in parts.
fn wedges() -> [Way; 3] {
    let wedge = PenumbraWedge::default();
    let center = PenumbraWedge {
        silhouette: WedgeSilhouette::Center,
        ..wedge
    };
    let parts = |count| PenumbraWedge {
        split: [count; 2],
        ..wedge
    };
    [
        Way::with(Settings::of(center), "center", "from the centre"),
        Way::with(Settings::of(parts(2)), "2x2", "2×2 parts"),
        Way::with(Settings::of(parts(3)), "3x3", "3×3 parts"),
    ]
}

/// Returns further settings of occlusion textures: their number of slices, filters and combinations.
fn slices() -> [Way; 6] {
    let slices = OcclusionTexture {
        slices: 16,
        ..Default::default()
    };
    let few = OcclusionTexture { slices: 4, ..slices };
    let filtered = |filter| Settings::of(OcclusionTexture { filter, ..slices });
    let combined = |combine| Settings::of(OcclusionTexture { combine, ..slices });
    [
        Way::with(Settings::of(few), "4", "4 slices"),
        Way::with(filtered(SliceFilter::Mipmaps), "mipmaps", "16 slices, mipmaps"),
        Way::with(
            filtered(SliceFilter::SummedAreas),
            "sums",
            "16 slices, summed areas",
        ),
        Way::with(
            combined(SliceCombination::Product),
            "product",
            "16 slices, multiplied",
        ),
        Way::with(
            combined(SliceCombination::Maximum),
            "max",
            "16 slices, the darkest alone",
        ),
        Way::with(combined(SliceCombination::Sum), "sum", "16 slices, added"),
    ]
}

fn grey() -> Material {
    Material::matte(Vec3::splat(0.75))
}

fn light(name: &'static str, kind: LightKind) -> NamedLight {
    NamedLight {
        name,
        light: Light {
            kind,
            color: Vec3::ONE,
            intensity: 70.0,
            range: f32::INFINITY,
        },
        transform: Transform::from_translation(LIGHT).looking_at(Vec3::new(0.0, 0.4, 0.0), Vec3::Y),
    }
}

fn shots(light: &'static str, caption: &'static str) -> Vec<PageShot> {
    vec![PageShot {
        name: light,
        caption,
        camera: view([2.2, 2.4, 4.4], [-0.3, 0.5, 0.0], 43.0),
        light,
        exposure: 1.0,
    }]
}

/// Builds a closed cylinder that stands at the origin.
fn round(radius: f32, height: f32, sides: u32) -> MeshData {
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
