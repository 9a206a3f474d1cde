//! glTF files load to what they say: held against values worked out by hand, and against the models.

mod animation;
mod materials;
mod meshes;
mod mirrored_skins;
mod models;
mod poses;
mod scenes;

use glam::Vec3;

fn assert_near(actual: Vec3, expected: Vec3) {
    assert!(actual.distance(expected) < 1e-5, "{actual} is not {expected}");
}

#[test]
#[should_panic(expected = "is not")]
fn assert_near_fails_when_one_component_moves() {
    assert_near(Vec3::ZERO, Vec3::new(0.0, 1e-3, 0.0));
}
