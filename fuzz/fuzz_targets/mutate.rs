//! Mutants of GLB files that are still GLB files: a random value of the JSON is changed, exchanged or left out, or a
//! number in the binary chunk becomes an extreme one. Mutants of bytes alone seldom pass the JSON parser.

use std::borrow::Cow;

use fastrand::Rng;
use gltf::binary::{Glb, Header};
use libfuzzer_sys::fuzzer_mutate;
use serde_json::{Value, json};

/// Changes `data` in place and returns its new size. One mutant in eight is made of bytes alone.
pub fn mutate(data: &mut [u8], size: usize, max_size: usize, seed: u32) -> usize {
    let mut random = Rng::with_seed(seed.into());
    if random.u32(0..8) > 0
        && let Some(mutant) = mutant_of(&data[..size], &mut random)
        && mutant.len() <= max_size
    {
        data[..mutant.len()].copy_from_slice(&mutant);
        return mutant.len();
    }
    fuzzer_mutate(data, size, max_size)
}

/// Returns a changed GLB; `None` if the bytes are no GLB with a JSON document.
fn mutant_of(bytes: &[u8], random: &mut Rng) -> Option<Vec<u8>> {
    // The crate subtracts the size of the header from this length without looking at it.
    let length = u32::from_le_bytes(bytes.get(8..12)?.try_into().ok()?);
    if length < 12 {
        return None;
    }
    let glb = Glb::from_slice(bytes).ok()?;
    let mut document: Value = serde_json::from_slice(&glb.json).ok()?;
    let mut binary = glb.bin.map(Cow::into_owned);
    for _ in 0..random.u32(1..=3) {
        match &mut binary {
            Some(binary) if random.u32(0..3) == 0 => change_number(binary, random),
            _ => change_value(&mut document, random),
        }
    }
    let glb = Glb {
        header: Header {
            magic: *b"glTF",
            version: 2,
            length: 0, // written by `to_vec`
        },
        json: Cow::Owned(serde_json::to_vec(&document).ok()?),
        bin: binary.map(Cow::Owned),
    };
    glb.to_vec().ok()
}

/// Overwrites four bytes that are aligned as a number is.
fn change_number(binary: &mut [u8], random: &mut Rng) {
    let count = binary.len() / 4;
    if count == 0 {
        return;
    }
    let at = 4 * random.usize(0..count);
    let floats = [f32::NAN, f32::INFINITY, f32::MAX, -f32::MAX, f32::MIN_POSITIVE, -0.0, 1e-38, 1.0];
    let bytes = match random.u32(0..3) {
        0 => random.u32(..).to_le_bytes(),
        1 => [u32::MAX, 0, 0xffff, 0x7fff_ffff][random.usize(0..4)].to_le_bytes(),
        _ => floats[random.usize(0..floats.len())].to_le_bytes(),
    };
    binary[at..at + 4].copy_from_slice(&bytes);
}

/// Changes one value of the document, each with the same chance.
fn change_value(document: &mut Value, random: &mut Rng) {
    let count = count_values(document);
    let other = {
        let mut at = random.usize(0..count);
        nth(document, &mut at).cloned().unwrap_or_default()
    };
    let mut at = random.usize(0..count);
    let Some(value) = nth(document, &mut at) else {
        return;
    };
    match value {
        _ if random.u32(0..6) == 0 => *value = other,
        Value::Number(number) => {
            let before = number.as_f64().unwrap_or(0.0);
            let extremes = [0.0, -1.0, 1.0, 0.5, 255.0, 65535.0, 4294967295.0, 1e30, -1e30, 1e-30];
            *value = match random.u32(0..4) {
                0 => json!(before + 1.0),
                1 => json!((before as i64).saturating_sub(1)),
                2 => json!((before as i64).saturating_mul(2)),
                _ => json!(extremes[random.usize(0..extremes.len())]),
            };
        }
        Value::Array(elements) if !elements.is_empty() => {
            let at = random.usize(0..elements.len());
            match random.u32(0..3) {
                0 => elements.truncate(at),
                1 => elements.push(elements[at].clone()),
                _ => elements.swap(0, at),
            }
        }
        Value::Object(members) if !members.is_empty() => {
            let at = random.usize(0..members.len());
            if let Some(key) = members.keys().nth(at).cloned() {
                members.remove(&key);
            }
        }
        Value::Bool(flag) => *flag = !*flag,
        _ => *value = Value::Null,
    }
}

fn count_values(value: &Value) -> usize {
    1 + match value {
        Value::Array(elements) => elements.iter().map(count_values).sum(),
        Value::Object(members) => members.values().map(count_values).sum(),
        _ => 0,
    }
}

/// Returns the value that comes `at` places after this one, depth first.
fn nth<'a>(value: &'a mut Value, at: &mut usize) -> Option<&'a mut Value> {
    if *at == 0 {
        return Some(value);
    }
    *at -= 1;
    match value {
        Value::Array(elements) => elements.iter_mut().find_map(|element| nth(element, at)),
        Value::Object(members) => members.values_mut().find_map(|member| nth(member, at)),
        _ => None,
    }
}
