//! Bind groups of lights' textures, kept while their textures stay the same.

use std::sync::{Arc, Weak};

use super::store::{GpuProfile, LightTextureStore};
use crate::render::Gpu;
use crate::render::gpu::bind_groups::bind_in_order;
use crate::scene::light_model::cookie::CookieImage;
use crate::scene::light_model::profile::ProfileTable;
use crate::scene::{LightTextures, TextureWrap};

/// A bind group and what it was made from. The weak references keep the addresses from being used again.
#[derive(Debug)]
struct Entry {
    image: Option<Weak<CookieImage>>,
    wrap: [TextureWrap; 2],
    table: Option<Weak<ProfileTable>>,
    profile: Option<Arc<GpuProfile>>,
    group: wgpu::BindGroup,
}

/// The bind groups of one view's lights. A group lives as long as its picture and its table, so a light that changes
/// between pictures finds its groups again.
#[derive(Debug, Default)]
pub struct LightTextureGroups {
    entries: Vec<Entry>,
    /// Number of groups that were made. It does not grow in a steady frame.
    pub made: usize,
}

impl LightTextureGroups {
    /// Removes the groups whose picture or table is gone.
    pub fn remove_dead(&mut self) {
        fn lives<T>(weak: &Option<Weak<T>>) -> bool {
            weak.as_ref().is_none_or(|weak| weak.strong_count() > 0)
        }
        self.entries
            .retain(|entry| lives(&entry.image) && lives(&entry.table));
    }

    /// Removes all groups, because the buffer of constants was replaced.
    pub fn clear(&mut self) {
        self.entries.clear();
    }

    /// Returns the index of the group of a light's textures. It is made if there is none.
    pub fn acquire(
        &mut self,
        gpu: &Gpu,
        store: &LightTextureStore,
        textures: &LightTextures,
        constants: wgpu::BindingResource<'_>,
    ) -> usize {
        let cookie = textures.cookie.as_ref();
        let image = cookie.map(|cookie| &cookie.image);
        let table = textures.profile.as_ref().map(|profile| profile.table());
        let wrap = cookie.map_or([TextureWrap::Repeat; 2], |cookie| cookie.wrap);
        let found = self
            .entries
            .iter()
            .position(|entry| entry.wrap == wrap && is_of(&entry.image, image) && is_of(&entry.table, table));
        if let Some(found) = found {
            return found;
        }
        let context = &gpu.context;
        let picture = image.map_or_else(|| store.white.clone(), |image| store.cookie(context, image));
        let is_cube = image.is_some_and(|image| image.is_cube());
        let (flat, cube) = if is_cube {
            (&store.white, &picture)
        } else {
            (&picture, &store.white_cube)
        };
        let profile = table.map(|table| store.profile(context, table));
        let sampler = store.sampler(context, wrap);
        let resources = [
            constants,
            wgpu::BindingResource::TextureView(flat),
            wgpu::BindingResource::Sampler(&sampler),
            wgpu::BindingResource::TextureView(
                profile.as_ref().map_or(&store.white, |profile| &profile.view),
            ),
            wgpu::BindingResource::TextureView(cube),
        ];
        self.made += 1;
        self.entries.push(Entry {
            image: image.map(Arc::downgrade),
            wrap,
            table: table.map(Arc::downgrade),
            group: bind_in_order(&context.device, "light texture", &store.layout, resources),
            profile,
        });
        self.entries.len() - 1
    }

    /// The group at an index, unless it was removed.
    pub fn get(&self, index: usize) -> Option<&wgpu::BindGroup> {
        self.entries.get(index).map(|entry| &entry.group)
    }

    /// The profile of the group at an index.
    pub fn profile(&self, index: usize) -> Option<&GpuProfile> {
        self.entries.get(index)?.profile.as_deref()
    }
}

fn is_of<T>(weak: &Option<Weak<T>>, strong: Option<&Arc<T>>) -> bool {
    match (weak, strong) {
        (None, None) => true,
        (Some(weak), Some(strong)) => weak.as_ptr() == Arc::as_ptr(strong),
        _ => false,
    }
}
