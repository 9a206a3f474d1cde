//! The textures that are in use.

use super::maker::Maker;
use super::pipelines::SliceLayouts;
use super::textures::{SliceTextures, TexturesKey};
use crate::render::RenderContext;

/// The pictures of all lights.
#[derive(Debug, Default)]
pub struct TexturePool {
    all: Vec<SliceTextures>,
}

impl TexturePool {
    /// Begins to record which textures are in use.
    pub fn begin(&mut self) {
        self.all.iter_mut().for_each(|textures| textures.in_use = false);
    }

    /// Frees textures that were not requested since [`TexturePool::begin`].
    pub fn end(&mut self) {
        self.all.retain(|textures| textures.in_use);
    }

    /// Returns the textures of a key, if they were requested.
    pub fn get(&self, key: &TexturesKey) -> Option<&SliceTextures> {
        self.all.iter().find(|textures| textures.key == *key)
    }

    /// Keeps the textures of a key, if there are any.
    pub fn keep(&mut self, key: &TexturesKey) {
        for textures in self.all.iter_mut().filter(|textures| textures.key == *key) {
            textures.in_use = true;
        }
    }

    /// Makes the textures of a key, if there are none.
    pub fn require(&mut self, context: &RenderContext, layouts: &SliceLayouts, key: TexturesKey) {
        if self.get(&key).is_some() {
            self.keep(&key);
        } else {
            let maker = Maker {
                context,
                layouts,
                key,
            };
            self.all.push(maker.make());
        }
    }
}
