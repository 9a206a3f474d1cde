//! The bundled pages.

use std::path::Path;
use std::sync::Arc;

use antumbra::prelude::*;
use bevy_transform::prelude::Transform;
use glam::{Quat, Vec3};

use super::lantern::lantern;
use super::page::{NamedLight, Page, PageShot, PlacedMesh, PlacedModel, view};
use super::soft_pages;

/// Returns all bundled pages, in the order of the gallery.
pub fn bundled(models: &Path) -> Vec<Page> {
    vec![
        interior(models),
        figures(models),
        bonsai(models),
        office(models),
        jack_o_lantern(),
        inside(),
    ]
    .into_iter()
    .chain(soft_pages::all(models))
    .collect()
}

/// The furnished flat under its own seven lights.
pub fn interior(models: &Path) -> Page {
    let shot = |name, caption, eye, target, light, exposure| PageShot {
        name,
        caption,
        camera: view(eye, target, 68.0),
        light,
        exposure,
    };
    Page {
        models: vec![model(models, "interior.glb")],
        clear_panes: true,
        sun_gain: 20.0,
        ambient: Vec3::new(0.42, 0.44, 0.48),
        background: Vec3::new(1.6, 2.4, 3.6),
        shots: vec![
            shot(
                "dining",
                "Chairs of bent wood, a ceiling fan that stands in the lamp's way, the sun through the south window.",
                [0.95, 1.6, 5.35],
                [3.45, 0.8, 7.55],
                "ceiling_1",
                0.135,
            ),
            shot(
                "stairs",
                "Hall: a spiral staircase, every step and baluster a caster against the wall.",
                [7.2, 1.6, 5.3],
                [9.2, 0.9, 8.2],
                "ceiling_3",
                0.135,
            ),
        ],
        ..Page::new(
            "interior",
            "A furnished flat",
            "Seven lights of its own: five ceiling lamps, a desk lamp and the sun, all of them shadowed, half a million \
             triangles. Window panes are blended and let the light through; the sun is twenty times as strong as in \
             the file, so that it shows beside the lamps.",
        )
    }
}

fn figures(models: &Path) -> Page {
    let place = |name, x: f32, y: f32, z: f32, scale: f32, turn: f32| PlacedModel {
        transform: Transform::from_xyz(x, y, z)
            .with_rotation(Quat::from_rotation_y(turn))
            .with_scale(Vec3::splat(scale)),
        ..model(models, name)
    };
    let shot = |name, caption, eye, target, light| PageShot {
        name,
        caption,
        camera: view(eye, target, 38.0),
        light,
        exposure: 1.25,
    };
    Page {
        models: vec![
            place("deer.glb", -1.5, 0.02, -0.4, 0.17, 0.6),
            place("suzanne.glb", 0.15, 0.62, 0.3, 0.75, -0.35),
            place("generic_hand_left.glb", 1.6, 0.95, 0.0, 7.0, 0.0),
        ],
        objects: vec![ground(8.0)],
        lights: vec![
            point("point, warm", [2.6, 3.0, 2.2], [1.0, 0.62, 0.32], 26.0, 14.0),
            directional("directional, white", [-0.5, -1.0, -0.65], [1.0, 1.0, 1.0], 1.1),
            spot(
                "spot, blue",
                [-3.2, 3.4, 2.4],
                [0.1, 0.5, 0.0],
                [0.3, 0.5, 1.0],
                60.0,
            ),
        ],
        shots: vec![
            shot(
                "point",
                "Deer, Suzanne (an open mesh: her eyes are separate shells) and a hand.",
                [0.9, 1.9, 4.6],
                [0.05, 0.72, 0.0],
                "point, warm",
            ),
            shot(
                "spot",
                "From the other side, against the light of the spot.",
                [2.9, 1.7, -2.9],
                [-0.15, 0.6, 0.3],
                "spot, blue",
            ),
        ],
        ..Page::new(
            "figures",
            "Three figures, three lights",
            "A point, a directional and a spot light in three colours: where one is blocked, the others colour its \
             shadow.",
        )
    }
}

fn bonsai(models: &Path) -> Page {
    let shot = |name, caption, light| PageShot {
        name,
        caption,
        camera: view([1.5, 2.0, 2.9], [-0.1, 0.9, 0.0], 45.0),
        light,
        exposure: 1.0,
    };
    Page {
        models: vec![PlacedModel {
            transform: Transform::from_xyz(0.3, 1.17, 0.0).with_scale(Vec3::splat(0.05)),
            ..model(models, "bonsai_alpha_leaves.glb")
        }],
        objects: vec![ground(6.0)],
        lights: vec![
            directional("directional", [-0.55, -1.0, -0.45], [1.0, 0.95, 0.85], 2.6),
            point("point", [-1.2, 1.6, 1.4], [0.55, 0.7, 1.0], 3.0, 8.0),
        ],
        shots: vec![
            shot(
                "leaves",
                "Look at the gaps between the leaves: techniques that know texels let light through them.",
                "directional",
            ),
            shot("lamp", "The same under the lamp.", "point"),
        ],
        ..Page::new(
            "bonsai",
            "Leaves with an alpha mask",
            "An alpha mask cuts the leaves out of cards. Techniques that know triangles and no texels cast the whole card; \
             maps cut the holes. Visibility and errors are of solid leaves, in the rendered frame and in the truth alike.",
        )
    }
}

fn office(models: &Path) -> Page {
    Page {
        models: vec![model(models, "room_office_small.glb")],
        lights: vec![
            point("lamp", [-0.75, 1.75, 0.75], [1.0, 0.86, 0.68], 2.6, 8.0),
            point("monitor", [0.06, 1.25, -0.62], [0.45, 0.65, 1.0], 0.5, 4.0),
        ],
        shots: vec![PageShot {
            name: "room",
            caption: "A captured room: planes and boxes that meet and overlap.",
            camera: view([0.95, 1.75, 1.1], [-0.25, 0.95, -0.75], 72.0),
            light: "lamp",
            exposure: 1.0,
        }],
        ..Page::new(
            "office",
            "A captured office",
            "Walls, floor and furniture as a headset saw them: open planes that cast from both sides, boxes that \
             stand in one another.",
        )
    }
}

fn jack_o_lantern() -> Page {
    let orange = Material::matte(Vec3::new(0.85, 0.32, 0.06));
    let shot = |name, caption, eye, target| PageShot {
        name,
        caption,
        camera: view(eye, target, 45.0),
        light: "lamp",
        exposure: 1.0,
    };
    Page {
        objects: vec![
            PlacedMesh {
                // The walls reach two centimetres into the ground, so that no light leaks under them.
                transform: Transform::from_xyz(0.0, -0.02, 0.0).with_rotation(Quat::from_rotation_y(0.45)),
                ..mesh(lantern(0.5, 0.09), orange)
            },
            ground(7.0),
        ],
        lights: vec![
            point("lamp", [0.02, 0.84, 0.02], [1.0, 0.66, 0.3], 9.0, 9.0),
            directional("moon", [0.6, -1.0, -0.5], [0.5, 0.65, 1.0], 0.3),
        ],
        shots: vec![
            shot(
                "ground",
                "Light falls in patches shaped like the face, on all four sides.",
                [1.9, 3.3, 3.9],
                [0.1, 0.1, 0.5],
            ),
            shot(
                "close",
                "Close by: walls are as thick as they cast.",
                [1.0, 0.95, 1.9],
                [0.0, 0.4, 0.1],
            ),
        ],
        ..Page::new(
            "lantern",
            "Jack-o’-lantern",
            "A hollow caster with holes and the light inside (figure 9-2 of GPU Gems, ch. 9): every patch on the \
             ground is bounded by silhouettes of both the inside and the outside of a wall.",
        )
    }
}

fn inside() -> Page {
    let red = Material::matte(Vec3::new(0.75, 0.22, 0.16));
    let blue = Material::matte(Vec3::new(0.2, 0.36, 0.75));
    let pale = Material::matte(Vec3::new(0.75, 0.72, 0.6));
    let at = |x: f32, y: f32, z: f32, placed: PlacedMesh| PlacedMesh {
        transform: Transform::from_xyz(x, y, z).with_rotation(Quat::from_rotation_y(0.5 * x + 0.3)),
        ..placed
    };
    let cube = |half: f32, material: &Material| mesh(MeshData::cuboid(Vec3::splat(half)), material.clone());
    let ball = |radius: f32, material: &Material| mesh(MeshData::icosphere(radius, 3), material.clone());
    Page {
        objects: vec![
            at(0.0, 0.6, 0.0, cube(0.6, &red)),
            at(0.55, 0.95, 0.35, ball(0.55, &blue)),
            at(-0.7, 0.45, 0.45, ball(0.45, &pale)),
            at(-0.45, 1.25, -0.1, cube(0.35, &pale)),
            at(1.6, 0.35, -0.7, cube(0.35, &blue)),
            at(-1.5, 0.3, -0.9, ball(0.4, &red)),
            ground(9.0),
        ],
        lights: vec![
            point("lamp", [-1.6, 3.4, -2.6], [1.0, 0.85, 0.65], 30.0, 16.0),
            directional("sky", [-0.6, -1.0, -0.75], [0.5, 0.65, 1.0], 1.1),
        ],
        shots: vec![
            PageShot {
                name: "outside",
                caption: "Boxes and spheres that overlap: their volumes do too, and the stencil counts them.",
                camera: view([3.0, 2.1, 3.2], [0.0, 0.5, 0.0], 45.0),
                light: "lamp",
                exposure: 1.3,
            },
            PageShot {
                name: "in-shadow",
                caption: "The camera stands in the shadow of the group: those casters count by depth-fail, the others \
                          by depth-pass.",
                camera: view([0.75, 0.35, 1.9], [-0.3, 0.55, -0.6], 60.0),
                light: "lamp",
                exposure: 1.3,
            },
        ],
        ..Page::new(
            "inside",
            "Inside the shadow",
            "Where the near plane cuts a shadow volume, counting from the camera fails; counting from infinity does \
             not. Which way is chosen for each caster.",
        )
    }
}

/// Returns a file of the folder at the origin.
pub fn model(folder: &Path, name: &str) -> PlacedModel {
    PlacedModel {
        file: folder.join(name),
        transform: Transform::IDENTITY,
        pose: None,
    }
}

/// Returns a light grey ground at height 0.
pub fn ground(half_size: f32) -> PlacedMesh {
    mesh(MeshData::plane(half_size), Material::matte(Vec3::splat(0.62)))
}

/// Returns a mesh at the origin.
pub fn mesh(mesh: MeshData, material: Material) -> PlacedMesh {
    PlacedMesh {
        mesh: Arc::new(mesh),
        material,
        transform: Transform::IDENTITY,
    }
}

/// Returns a point light; intensity in candela, lengths in metres.
pub fn point(name: &'static str, at: [f32; 3], color: [f32; 3], intensity: f32, range: f32) -> NamedLight {
    NamedLight {
        name,
        light: Light::point(color.into(), intensity, range),
        transform: Transform::from_translation(at.into()),
    }
}

/// Returns a directional light; intensity in lux.
pub fn directional(name: &'static str, direction: [f32; 3], color: [f32; 3], intensity: f32) -> NamedLight {
    NamedLight {
        name,
        light: Light::directional(color.into(), intensity),
        transform: Transform::IDENTITY.looking_to(Vec3::from(direction), Vec3::Z),
    }
}

/// Returns a spot light; intensity in candela.
pub fn spot(
    name: &'static str,
    at: [f32; 3],
    target: [f32; 3],
    color: [f32; 3],
    intensity: f32,
) -> NamedLight {
    NamedLight {
        name,
        light: Light {
            kind: LightKind::Spot {
                inner_angle: 0.28,
                outer_angle: 0.46,
            },
            color: color.into(),
            intensity,
            range: 14.0,
        },
        transform: Transform::from_translation(at.into()).looking_at(target.into(), Vec3::Y),
    }
}
