//! Names of selection layers, as scene files and shots have them.

use bevy_ecs::prelude::*;

/// The names of the world's selection layers. Each name has one bit of
/// [`SelectionLayers`](crate::scene::SelectionLayers) and of the masks of a
/// [`LightSelection`](crate::scene::LightSelection). The bit of value 1 has no name: every object is on it by
/// default.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub struct LayerNames {
    names: Vec<String>,
}

/// There is no bit left for the name of a layer.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no layer is left for the name `{name}`, there are {count} already")]
pub struct TooManyLayers {
    /// The name without a layer.
    pub name: String,
    /// Number of names that have a layer.
    pub count: usize,
}

/// The largest number of named layers.
const MOST: usize = 31;

impl LayerNames {
    /// Returns the bit of a name, if it has one.
    pub fn bit(&self, name: &str) -> Option<u32> {
        let at = self.names.iter().position(|known| known == name)?;
        Some(2 << at)
    }

    /// Returns the bit of a name, and gives it the next one if it has none.
    ///
    /// # Errors
    /// [`TooManyLayers`] if all 31 bits have other names.
    pub fn add(&mut self, name: &str) -> Result<u32, TooManyLayers> {
        if let Some(bit) = self.bit(name) {
            return Ok(bit);
        }
        if self.names.len() == MOST {
            return Err(TooManyLayers {
                name: name.to_owned(),
                count: MOST,
            });
        }
        self.names.push(name.to_owned());
        Ok(1 << self.names.len())
    }

    /// Returns all names, in the order of their bits.
    pub fn iter(&self) -> impl Iterator<Item = &str> {
        self.names.iter().map(String::as_str)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_name_has_a_bit_of_its_own() {
        let mut names = LayerNames::default();
        let mut all = 1;
        for layer in 0..MOST {
            let bit = names.add(&format!("layer {layer}")).expect("there is room");
            assert_eq!((bit.count_ones(), all & bit), (1, 0));
            assert_eq!(names.bit(&format!("layer {layer}")), Some(bit));
            all |= bit;
        }
        assert_eq!(all, u32::MAX);
        assert_eq!(names.add("layer 3"), Ok(16), "a known name keeps its bit");
        assert_eq!(names.bit("another"), None);
        assert!(names.add("another").is_err_and(|error| error.name == "another"));
    }
}
