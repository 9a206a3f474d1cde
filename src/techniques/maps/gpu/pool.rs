//! The textures of maps: one set for each light whose map is kept, sets that lights share, and scratch
//! textures.

use bevy_ecs::prelude::Entity;

use super::layouts::MapLayouts;
use super::pipelines::{BESIDE_FORMAT, MAP_DEPTH, texture_format};
use super::recorded::FaceRecord;
use crate::render::RenderContext;
use crate::render::gpu::bind_groups::bind_in_order;
use crate::techniques::maps::request::MapRequest;
use crate::techniques::maps::settings::{MapFormat, MapSurface};

/// An array of faces and a view of each.
#[derive(Debug)]
pub struct FaceArray {
    /// The array texture, with one layer for each face.
    pub texture: wgpu::Texture,
    /// The view of each layer.
    pub layers: Vec<wgpu::TextureView>,
}

impl FaceArray {
    /// Makes an array of square faces.
    pub fn new(
        context: &RenderContext,
        label: &str,
        side: u32,
        layers: u32,
        format: wgpu::TextureFormat,
    ) -> Self {
        let texture = context.device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size: wgpu::Extent3d {
                width: side,
                height: side,
                depth_or_array_layers: layers,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT
                | wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::COPY_SRC
                | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let layers = (0..layers)
            .map(|layer| {
                texture.create_view(&wgpu::TextureViewDescriptor {
                    dimension: Some(wgpu::TextureViewDimension::D2),
                    base_array_layer: layer,
                    array_layer_count: Some(1),
                    ..Default::default()
                })
            })
            .collect();
        Self { texture, layers }
    }

    /// Makes a view of all layers.
    pub fn array_view(&self) -> wgpu::TextureView {
        self.texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        })
    }
}

/// Everything that distinguishes two sets of textures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MapTexturesKey {
    /// The light to which the map belongs; `None` for a shared map.
    pub entity: Option<Entity>,
    /// The number of texels along a side of a face.
    pub side: u32,
    /// The number of faces.
    pub layers: u32,
    /// The format of the texture that is looked up.
    pub format: MapFormat,
    /// The surface of the casters that the map holds.
    pub surface: MapSurface,
    /// True if there is a layer for casters that move.
    pub moving: bool,
    /// True if there is a picture beside each depth.
    pub beside: bool,
}

impl MapTexturesKey {
    /// Makes the key of a request; `entity` is `None` for a shared map.
    pub fn new(entity: Option<Entity>, request: &MapRequest, side: u32, moving: bool) -> Self {
        Self {
            entity,
            side,
            layers: request.face_count(),
            format: request.format,
            surface: request.surface,
            moving,
            beside: request.beside.is_some(),
        }
    }

    fn has_final(&self) -> bool {
        self.format != MapFormat::Depth || self.surface != MapSurface::Nearest
    }
}

/// The pictures beside the depths of one map.
#[derive(Debug)]
pub struct BesideTextures {
    /// The picture beside the depth of still casters, or of all casters if there is no moving layer.
    pub still: FaceArray,
    /// The picture beside the depth of all casters, if some move.
    pub moving: Option<FaceArray>,
    /// The bind group 3 of the lookup.
    pub group: wgpu::BindGroup,
}

/// The textures of one map.
#[derive(Debug)]
pub struct MapTextures {
    /// The key of this set of textures.
    pub key: MapTexturesKey,
    /// The depth of still casters, or of all casters if there is no moving layer.
    pub still: FaceArray,
    /// The depth of all casters, if some move.
    pub moving: Option<FaceArray>,
    /// The converted texture that is looked up; `None` if a depth is looked up directly.
    pub shown: Option<FaceArray>,
    /// The pictures beside the depths, if the technique draws any.
    pub beside: Option<BesideTextures>,
    /// The bind group 3 of the lookup.
    pub group: wgpu::BindGroup,
    /// The revisions that each face holds.
    pub records: Vec<FaceRecord>,
    in_use: bool,
}

impl MapTextures {
    /// Returns the depths of all casters.
    pub fn all_casters(&self) -> &FaceArray {
        self.moving.as_ref().unwrap_or(&self.still)
    }
}

/// A scratch texture with the depth of the second surface of one face.
#[derive(Debug)]
struct Scratch {
    side: u32,
    second: FaceArray,
    in_use: bool,
}

/// The textures of all maps.
#[derive(Debug)]
pub struct MapPool {
    maps: Vec<MapTextures>,
    scratches: Vec<Scratch>,
    no_depth: wgpu::TextureView,
    no_distance: wgpu::TextureView,
}

impl MapPool {
    /// Makes an empty pool.
    pub fn new(context: &RenderContext) -> Self {
        let dummy = |format| FaceArray::new(context, "no map", 1, 1, format).array_view();
        Self {
            maps: Vec::new(),
            scratches: Vec::new(),
            no_depth: dummy(MAP_DEPTH),
            no_distance: dummy(wgpu::TextureFormat::R32Float),
        }
    }

    /// Begins to record which textures are in use.
    pub fn begin(&mut self) {
        for map in &mut self.maps {
            map.in_use = false;
        }
        for scratch in &mut self.scratches {
            scratch.in_use = false;
        }
    }

    /// Frees textures that were not requested since [`MapPool::begin`].
    pub fn end(&mut self) {
        self.maps.retain(|map| map.in_use);
        self.scratches.retain(|scratch| scratch.in_use);
    }

    /// Returns the textures of a key, if they were requested.
    pub fn get(&self, key: &MapTexturesKey) -> Option<&MapTextures> {
        self.maps.iter().find(|map| map.key == *key)
    }

    /// Returns the second surface for a side length, if it was requested.
    pub fn second(&self, side: u32) -> Option<&wgpu::TextureView> {
        let scratch = self.scratches.iter().find(|scratch| scratch.side == side)?;
        Some(&scratch.second.layers[0])
    }

    /// Keeps the textures of a key, if there are any.
    pub fn keep(&mut self, key: &MapTexturesKey) {
        for map in self.maps.iter_mut().filter(|map| map.key == *key) {
            map.in_use = true;
        }
    }

    /// Makes the textures of a key, if there are none.
    pub fn require(&mut self, context: &RenderContext, layouts: &MapLayouts, key: MapTexturesKey) {
        if key.has_final() {
            match self.scratches.iter_mut().find(|scratch| scratch.side == key.side) {
                Some(scratch) => scratch.in_use = true,
                None => self.scratches.push(Scratch {
                    side: key.side,
                    second: FaceArray::new(context, "second surface", key.side, 1, MAP_DEPTH),
                    in_use: true,
                }),
            }
        }
        if let Some(map) = self.maps.iter_mut().find(|map| map.key == key) {
            map.in_use = true;
            return;
        }
        let array = |label: &str, format| FaceArray::new(context, label, key.side, key.layers, format);
        let mut records: Vec<FaceRecord> = (0..key.layers).map(|_| Default::default()).collect();
        // The still layer is the same with and without a layer for moving casters.
        let twin = MapTexturesKey {
            moving: !key.moving,
            ..key
        };
        let twin = self
            .maps
            .iter()
            .position(|map| key.entity.is_some() && map.key == twin);
        let (still, still_beside) = match twin.map(|at| self.maps.swap_remove(at)) {
            Some(twin) => {
                for (record, old) in records.iter_mut().zip(&twin.records) {
                    record.still = old.still.clone();
                }
                (twin.still, twin.beside.map(|beside| beside.still))
            }
            None => (array("map", MAP_DEPTH), None),
        };
        let moving = key.moving.then(|| array("map with what moves", MAP_DEPTH));
        let shown = key
            .has_final()
            .then(|| array("map as looked up", texture_format(key.format)));
        let looked_up = shown.as_ref().or(moving.as_ref()).unwrap_or(&still).array_view();
        let (depth, distance) = if key.format == MapFormat::Depth {
            (&looked_up, &self.no_distance)
        } else {
            (&self.no_depth, &looked_up)
        };
        let group = bind_textures(context, layouts, depth, distance);
        let beside = key.beside.then(|| {
            let still_beside = still_beside.unwrap_or_else(|| array("beside map", BESIDE_FORMAT));
            let moving = key
                .moving
                .then(|| array("beside map with what moves", BESIDE_FORMAT));
            let picture = moving.as_ref().unwrap_or(&still_beside).array_view();
            let alone = still.array_view();
            let views = [depth, &alone, &picture].map(wgpu::BindingResource::TextureView);
            let device = &context.device;
            let group = bind_in_order(device, "map with a picture beside", &layouts.beside, views);
            BesideTextures {
                still: still_beside,
                moving,
                group,
            }
        });
        self.maps.push(MapTextures {
            key,
            still,
            moving,
            shown,
            beside,
            group,
            records,
            in_use: true,
        });
    }
}

fn bind_textures(
    context: &RenderContext,
    layouts: &MapLayouts,
    depth: &wgpu::TextureView,
    distance: &wgpu::TextureView,
) -> wgpu::BindGroup {
    bind_in_order(
        &context.device,
        "map textures",
        &layouts.textures,
        [
            wgpu::BindingResource::TextureView(depth),
            wgpu::BindingResource::TextureView(distance),
        ],
    )
}
