//! Reads `KHR_materials_clearcoat`, which `gltf::json` leaves unparsed. A part that cannot be read counts as absent.

use gltf::json::texture::Info;
use gltf::json::{Value, deserialize};

/// The name of the extension.
pub(super) const CLEARCOAT: &str = "KHR_materials_clearcoat";

/// The coat that the extension states.
#[derive(Default)]
pub(super) struct Clearcoat {
    /// Share of the coat, as stated.
    pub factor: f32,
    pub texture: Option<Info>,
    /// Perceptual roughness of the coat, as stated.
    pub roughness: f32,
    pub roughness_texture: Option<Info>,
    /// Whether the coat has normals of its own.
    pub has_normals: bool,
    /// Names of the numbers that are none.
    pub unread_numbers: Vec<&'static str>,
    /// Names of the textures that cannot be read.
    pub unread_textures: Vec<&'static str>,
}

/// Reads the extension of a material, if it is an object.
pub(super) fn parse(json: &Value) -> Option<Clearcoat> {
    let json = json.as_object()?;
    let mut read = Clearcoat::default();
    let mut number = |name: &'static str| match json.get(name) {
        None => 0.0,
        Some(value) => value.as_f64().map_or_else(
            || {
                read.unread_numbers.push(name);
                0.0
            },
            |number| number as f32,
        ),
    };
    read.factor = number("clearcoatFactor");
    read.roughness = number("clearcoatRoughnessFactor");
    let mut texture = |name: &'static str| {
        let info = deserialize::from_value(json.get(name)?.clone()).ok();
        if info.is_none() {
            read.unread_textures.push(name);
        }
        info
    };
    read.texture = texture("clearcoatTexture");
    read.roughness_texture = texture("clearcoatRoughnessTexture");
    read.has_normals = json.contains_key("clearcoatNormalTexture");
    Some(read)
}
