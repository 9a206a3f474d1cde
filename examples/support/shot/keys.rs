//! The keys of an object whose fields are told apart by one of them: none twice, and each error with its key.

use std::fmt;

use serde::Deserialize;
use serde::de::{self, DeserializeOwned, Deserializer, MapAccess, SeqAccess};
use serde_json::{Map, Value};

/// An object in which no key stands twice, at any depth.
pub struct Keys(pub Map<String, Value>);

impl<'de> Deserialize<'de> for Keys {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        match Unique::deserialize(deserializer)?.0 {
            Value::Object(keys) => Ok(Self(keys)),
            other => Err(de::Error::custom(format_args!(
                "invalid type: {other}, expected a map"
            ))),
        }
    }
}

/// A value in whose objects no key stands twice. `Value` by itself takes the last one.
struct Unique(Value);

impl<'de> Deserialize<'de> for Unique {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Visitor).map(Self)
    }
}

struct Visitor;

impl<'de> de::Visitor<'de> for Visitor {
    type Value = Value;

    fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str("a value")
    }

    fn visit_unit<E: de::Error>(self) -> Result<Value, E> {
        Ok(Value::Null)
    }

    fn visit_bool<E: de::Error>(self, value: bool) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_i64<E: de::Error>(self, value: i64) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_u64<E: de::Error>(self, value: u64) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_f64<E: de::Error>(self, value: f64) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_str<E: de::Error>(self, value: &str) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut elements: A) -> Result<Value, A::Error> {
        let mut values = Vec::new();
        while let Some(Unique(value)) = elements.next_element()? {
            values.push(value);
        }
        Ok(Value::Array(values))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<Value, A::Error> {
        let mut keys = Map::new();
        while let Some((key, Unique(value))) = entries.next_entry::<String, Unique>()? {
            if keys.contains_key(&key) {
                return Err(de::Error::custom(format_args!("duplicate field `{key}`")));
            }
            keys.insert(key, value);
        }
        Ok(Value::Object(keys))
    }
}

/// The key whose value is the cause of an error: without it the error is another one. serde does not name it where a key, the
/// tag, tells the fields apart. The tag is the cause if no other key is.
pub fn key_of<'a, T: DeserializeOwned>(
    error: &str,
    object: &'a Map<String, Value>,
    tag: &str,
) -> Option<&'a str> {
    let is_missing = |error: &str| error.starts_with("missing field");
    let is_cause = |key: &&String| {
        let mut others = object.clone();
        others.remove(*key);
        let without = T::deserialize(Value::Object(others));
        without.map_or_else(
            |other| {
                let other = other.to_string();
                // Without a required key the error is another one too: that this key is missing.
                other != error && !(is_missing(error) && is_missing(&other))
            },
            |_| true,
        )
    };
    let others = object.keys().filter(|key| *key != tag);
    let tags = object.keys().filter(|key| *key == tag);
    others.chain(tags).find(is_cause).map(String::as_str)
}
