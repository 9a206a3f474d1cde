//! A light as it is edited: the keys of a shot's light, and a technique for each side.

use antumbra::prelude::*;
use antumbra::techniques::Techniques;
use antumbra_stage::shadow::nest_softness;
use antumbra_stage::shot::{LightParts, ShotLight};
use bevy_transform::prelude::Transform;
use glam::Vec3;
use serde_json::{Map, Value, json};

use crate::document::Side;

/// A light as a shot file holds it, without its technique, and a technique for each [`Side`].
#[derive(Clone, Debug, PartialEq)]
pub struct LightDoc {
    /// Name in the list.
    pub name: String,
    /// Keys of the shot's light except `shadow`.
    pub keys: Map<String, Value>,
    /// Technique and settings of each side, as the value of `shadow`.
    pub shadows: [Map<String, Value>; 2],
}

/// Keys of a light that only some techniques take.
const SPECIAL: [&str; 3] = [PATH, ANGLE, "texture"];

/// Key of the path along which a light moves.
const PATH: &str = "path";

/// Key of the angle that a light covers in the sky. Techniques that know it have a setting of this name.
const ANGLE: &str = "angle_deg";

/// Keys of [`SPECIAL`] that are left out because a technique does not take them.
struct LeftOut {
    /// A bit for each key of [`SPECIAL`].
    bits: usize,
    /// Why the light is refused with them.
    why: String,
}

impl LeftOut {
    fn has(&self, key: &str) -> bool {
        is_left_out(self.bits, key)
    }
}

/// Whether the bits of the keys of [`SPECIAL`] have that of a key.
fn is_left_out(bits: usize, key: &str) -> bool {
    let index = SPECIAL.iter().position(|special| *special == key);
    index.is_some_and(|index| bits >> index & 1 == 1)
}

/// Name of no technique.
pub const NONE: &str = "none";

/// Returns the value of `shadow` for a technique with its default settings.
pub fn shadow_of(technique: &str) -> Map<String, Value> {
    Map::from_iter([("technique".to_owned(), json!(technique))])
}

impl LightDoc {
    /// Makes a light from the value of a shot's light.
    pub fn new(name: String, mut keys: Map<String, Value>, techniques: &Techniques) -> Self {
        let mut shadow = match keys.remove("shadow") {
            Some(Value::Object(shadow)) => shadow,
            _ => shadow_of(NONE),
        };
        nest_softness(&mut shadow);
        let mut light = Self {
            name,
            keys,
            shadows: [shadow.clone(), shadow],
        };
        light.shadows[Side::B.index()] = light.other_technique(techniques);
        light.settle_angle(techniques);
        light
    }

    /// Makes the light's angle a setting of the techniques that have this setting, because only one of the light and its
    /// shadow may have it. The light keeps an angle that no side takes.
    pub fn settle_angle(&mut self, techniques: &Techniques) {
        let Some(angle) = self.keys.remove(ANGLE) else {
            return;
        };
        let mut is_taken = false;
        for side in Side::ALL {
            let mut shadow = self.shadows[side.index()].clone();
            shadow.insert(ANGLE.to_owned(), angle.clone());
            if self.fits(&shadow, techniques) {
                self.shadows[side.index()] = shadow;
                is_taken = true;
            }
        }
        if !is_taken {
            self.keys.insert(ANGLE.to_owned(), angle);
        }
    }

    /// Returns the last technique of the list that fits the light and is not that of side A, so that the sides
    /// differ from the start.
    fn other_technique(&self, techniques: &Techniques) -> Map<String, Value> {
        let others = techniques.rows().iter().rev().map(|row| shadow_of(row.name()));
        let mut others = others.filter(|other| other.get("technique") != self.shadows[0].get("technique"));
        others
            .find(|shadow| self.fits(shadow, techniques))
            .unwrap_or_else(|| self.shadows[Side::A.index()].clone())
    }

    /// Returns the name of the technique of a side.
    pub fn technique(&self, side: Side) -> &str {
        let name = self.shadows[side.index()].get("technique");
        name.and_then(Value::as_str).unwrap_or(NONE)
    }

    /// Returns the name of the light's kind.
    pub fn kind(&self) -> &str {
        self.keys.get("kind").and_then(Value::as_str).unwrap_or("point")
    }

    /// Returns all keys of the light, with the technique of a side. Together they may be refused.
    pub fn to_keys(&self, side: Side) -> Map<String, Value> {
        let mut keys = self.keys.clone();
        let shadow = self.shadows[side.index()].clone();
        keys.insert("shadow".to_owned(), Value::Object(shadow));
        keys
    }

    /// Returns the keys of the light in a shot file with the technique of a side. Keys of [`SPECIAL`] that the technique
    /// does not take are left out, so that the file opens.
    pub fn saved_keys(&self, side: Side, techniques: &Techniques) -> Map<String, Value> {
        let mut keys = self.to_keys(side);
        if let Ok((parts, Some(left_out))) = self.taken(Some(&self.shadows[side.index()]), techniques) {
            keys.retain(|key, _| !left_out.has(key));
            if left_out.has(PATH) {
                self.place_off_path(side, parts.transform, techniques, &mut keys);
            }
        }
        keys
    }

    /// Gives a light whose path is left out the place at which it is shown. That is where the path puts it on side A, if
    /// the technique there follows the path, and otherwise the place that the light has without moving.
    fn place_off_path(
        &self,
        side: Side,
        mut place: Transform,
        techniques: &Techniques,
        keys: &mut Map<String, Value>,
    ) {
        let mut is_moved = false;
        if side == Side::B
            && let Ok((of_a, _)) = self.parts(Side::A, techniques)
            && let Some(path) = &of_a.path
        {
            // The techniques that follow a path call the share of it `time`, 0 by default.
            let time = self.shadows[Side::A.index()].get("time").and_then(Value::as_f64);
            path.place(time.unwrap_or_default() as f32, &mut place);
            is_moved = true;
        }
        let (key, value) = if self.kind() == "directional" {
            let direction = place.rotation * Vec3::NEG_Z;
            ("direction", json!(direction.to_array().map(rounded)))
        } else {
            ("position", json!(place.translation.to_array().map(exactly)))
        };
        if is_moved || !keys.contains_key(key) {
            keys.insert(key.to_owned(), value);
        }
    }

    /// Makes the parts of the light, without the keys of [`SPECIAL`] whose bits are set.
    fn parts_without(
        &self,
        bits: usize,
        shadow: Option<&Map<String, Value>>,
        techniques: &Techniques,
    ) -> Result<LightParts, String> {
        let mut keys = self.keys.clone();
        // A path also places the light, so it is read before it is left out.
        keys.retain(|key, _| key == PATH || !is_left_out(bits, key));
        if let Some(shadow) = shadow {
            keys.insert("shadow".to_owned(), Value::Object(shadow.clone()));
        }
        let mut light = ShotLight::try_from(keys)?;
        if is_left_out(bits, PATH) {
            light.path = None;
        }
        light.parts(techniques)
    }

    /// Makes the parts of the light. Keys of [`SPECIAL`] that the technique does not take are left out, because the
    /// technique of the other side may need them.
    fn taken(
        &self,
        shadow: Option<&Map<String, Value>>,
        techniques: &Techniques,
    ) -> Result<(LightParts, Option<LeftOut>), String> {
        let why = match self.parts_without(0, shadow, techniques) {
            Ok(parts) => return Ok((parts, None)),
            Err(error) => error,
        };
        let all = SPECIAL.iter().enumerate();
        let there = all.filter(|(_, key)| self.keys.contains_key(**key));
        let there = there.fold(0_usize, |bits, (index, _)| bits | 1 << index);
        // As few as possible are left out.
        let mut choices: Vec<usize> = (1..1 << SPECIAL.len())
            .filter(|bits| bits & !there == 0)
            .collect();
        choices.sort_by_key(|bits| bits.count_ones());
        for bits in choices {
            if let Ok(parts) = self.parts_without(bits, shadow, techniques) {
                return Ok((parts, Some(LeftOut { bits, why })));
            }
        }
        Err(why)
    }

    /// Returns what to spawn for the light, and a note if a key is left out that the technique does not take.
    ///
    /// # Errors
    /// A key or a setting that cannot be used.
    pub fn parts(&self, side: Side, techniques: &Techniques) -> Result<(LightParts, Option<String>), String> {
        let (parts, left_out) = self.taken(Some(&self.shadows[side.index()]), techniques)?;
        Ok((parts, left_out.map(|left_out| left_out.why)))
    }

    /// Returns what to spawn for the light without a shadow.
    ///
    /// # Errors
    /// A key that cannot be used.
    pub fn bare_parts(&self, techniques: &Techniques) -> Result<LightParts, String> {
        self.taken(None, techniques).map(|(parts, _)| parts)
    }

    /// Whether a value of `shadow` can be used for the light.
    pub fn fits(&self, shadow: &Map<String, Value>, techniques: &Techniques) -> bool {
        self.taken(Some(shadow), techniques).is_ok()
    }

    /// Returns a vector that the light's keys hold.
    pub fn vector(&self, key: &str) -> Option<Vec3> {
        let parts = self.keys.get(key)?.as_array()?;
        let at = |index: usize| parts.get(index).and_then(Value::as_f64).map(|x| x as f32);
        Some(Vec3::new(at(0)?, at(1)?, at(2)?))
    }

    /// Moves the light.
    pub fn set_position(&mut self, to: Vec3) {
        self.keys
            .insert("position".to_owned(), json!(to.to_array().map(exactly)));
    }

    /// Turns the light.
    pub fn set_direction(&mut self, to: Vec3) {
        self.keys
            .insert("direction".to_owned(), json!(to.to_array().map(rounded)));
    }
}

/// Rounds to six digits, so that saved files stay readable at any scale. What is left of a zero becomes one. Positions are
/// not rounded: far from the origin, the seventh digit is metres.
pub fn rounded(value: f32) -> f64 {
    if value.abs() < 1e-7 {
        return 0.0;
    }
    format!("{value:.5e}").parse().unwrap_or(f64::from(value))
}

/// Returns the number with the digits that an `f32` has, so that it is read back as it is.
pub fn exactly(value: f32) -> f64 {
    let value = value + 0.0; // no negative zero
    value.to_string().parse().unwrap_or(f64::from(value))
}

/// Returns the value of a light in a shot file.
pub fn light_value(light: &Light, transform: &Transform) -> Map<String, Value> {
    let forward = (transform.rotation * Vec3::NEG_Z).to_array().map(rounded);
    let mut value = match light.kind {
        LightKind::Point => json!({"kind": "point"}),
        LightKind::Spot {
            inner_angle,
            outer_angle,
        } => json!({
            "kind": "spot",
            "direction": forward,
            "inner_deg": rounded(inner_angle.to_degrees()),
            "outer_deg": rounded(outer_angle.to_degrees()),
        }),
        LightKind::Directional => json!({"kind": "directional", "direction": forward}),
        LightKind::Rect { width, height } => json!({
            "kind": "rect",
            "direction": forward,
            "up": (transform.rotation * Vec3::Y).to_array().map(rounded),
            "width": exactly(width),
            "height": exactly(height),
        }),
        LightKind::Sphere { radius } => json!({"kind": "sphere", "radius": exactly(radius)}),
    };
    if light.kind != LightKind::Directional {
        value["position"] = json!(transform.translation.to_array().map(exactly));
        if light.range.is_finite() {
            value["range"] = json!(exactly(light.range));
        }
    }
    value["color"] = json!(light.color.to_array().map(rounded));
    value["intensity"] = json!(rounded(light.intensity));
    match value {
        Value::Object(keys) => keys,
        _ => Map::new(),
    }
}

/// Returns the name of a light in the list.
pub fn light_name(index: usize, keys: &Map<String, Value>) -> String {
    let kind = keys.get("kind").and_then(Value::as_str).unwrap_or("light");
    format!("{kind} {index}")
}
