//! The textures and vertices of one scene's maps.

use std::ops::Range;
use std::sync::Arc;

use bevy_ecs::prelude::*;
use wgpu::util::DeviceExt;

use super::footprint::Seen;
use super::gpu_types::{IntervalVertex, NO_PAGE};
use super::runs::{Run, add_triangle};
use super::welded::Welded;
use crate::render::RenderContext;
use crate::scene::SceneMesh;
use crate::techniques::occlusion_interval::intervals::PER_PAIR;
use crate::techniques::occlusion_interval::maps::{Corner, IntervalMaps, Pair};
use crate::techniques::occlusion_interval::matching::IntervalScene;
use crate::techniques::occlusion_interval::surface::local_triangles;

/// A drawable surface of the maps.
#[derive(Clone, Debug, PartialEq)]
pub struct GpuSurface {
    /// Index in [`IntervalScene::matched`].
    pub matched: u32,
    /// Range of [`GpuMaps::runs`].
    pub runs: Range<usize>,
    /// Whether the maps hold what its back sees, too.
    pub is_two_sided: bool,
}

/// The maps of a scene on the GPU.
#[derive(Debug)]
pub struct GpuMaps {
    /// The maps that the textures hold.
    pub maps: Arc<IntervalMaps>,
    /// Rises and falls of four intervals a texel, a layer for each pair of each page.
    pub view: wgpu::TextureView,
    /// Vertices of all surfaces.
    pub vertices: wgpu::Buffer,
    /// Indices of all triangles, 32 bits each.
    pub indices: wgpu::Buffer,
    /// The surfaces that were found. Those that showed no shadows when the maps were baked are on no page.
    pub surfaces: Vec<GpuSurface>,
    /// The runs of triangles of all surfaces.
    pub runs: Vec<Run>,
    /// Generation of the scene whose vertices these are.
    pub generation: u64,
}

impl GpuMaps {
    /// Uploads maps and the vertices of the surfaces that were found. `None` if the device cannot hold them.
    pub fn new(context: &RenderContext, world: &World, scene: &IntervalScene) -> Option<Self> {
        let maps = &scene.maps;
        let limits = context.device.limits();
        let layers = maps.layer_count().max(1) as u32;
        if maps.size > limits.max_texture_dimension_2d || layers > limits.max_texture_array_layers {
            return None;
        }
        let Built {
            surfaces,
            runs,
            welded,
        } = build(world, scene);
        let bytes = size_of_val(&welded.vertices[..]).max(size_of_val(&welded.indices[..]));
        if bytes as u64 > limits.max_buffer_size {
            return None;
        }
        let [vertices, indices] = buffers(context, &welded);
        Some(Self {
            maps: maps.clone(),
            view: upload(context, maps),
            vertices,
            indices,
            surfaces,
            runs,
            generation: scene.generation,
        })
    }

    /// Builds the vertices again after the scene changed.
    pub fn refresh(&mut self, context: &RenderContext, world: &World, scene: &IntervalScene) {
        let built = build(world, scene);
        [self.vertices, self.indices] = buffers(context, &built.welded);
        self.surfaces = built.surfaces;
        self.runs = built.runs;
        self.generation = scene.generation;
    }
}

/// Makes the buffers of vertices and indices.
fn buffers(context: &RenderContext, welded: &Welded) -> [wgpu::Buffer; 2] {
    let nothing = [0; size_of::<IntervalVertex>()];
    let buffer = |label, bytes: &[u8], usage| {
        context
            .device
            .create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some(label),
                contents: if bytes.is_empty() { &nothing } else { bytes }, // a buffer without room cannot be bound
                usage,
            })
    };
    [
        buffer(
            "interval vertices",
            bytemuck::cast_slice(&welded.vertices),
            wgpu::BufferUsages::VERTEX,
        ),
        buffer(
            "interval indices",
            bytemuck::cast_slice(&welded.indices),
            wgpu::BufferUsages::INDEX,
        ),
    ]
}

/// Uploads the pairs. A channel of a texel holds the first step of an interval in its lower byte and the last one in its upper
/// byte, so a lookup loads a pair at once.
fn upload(context: &RenderContext, maps: &IntervalMaps) -> wgpu::TextureView {
    let size = wgpu::Extent3d {
        width: maps.size.max(1),
        height: maps.size.max(1),
        depth_or_array_layers: maps.layer_count().max(1) as u32,
    };
    let texture = context.device.create_texture(&wgpu::TextureDescriptor {
        label: Some("interval maps"),
        size,
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba16Uint,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    let pairs = maps
        .pages
        .iter()
        .flat_map(|page| (0..page.pairs.len()).map(move |pair| (page, pair)));
    let mut texels: Vec<u8> = Vec::new();
    for (layer, (page, pair)) in pairs.enumerate() {
        let Pair { rise, fall } = &page.pairs[pair];
        texels.clear();
        texels.extend(rise.iter().zip(fall).flat_map(|(&rise, &fall)| [rise, fall]));
        context.queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                texture: &texture,
                mip_level: 0,
                origin: wgpu::Origin3d {
                    z: layer as u32,
                    ..Default::default()
                },
                aspect: wgpu::TextureAspect::All,
            },
            &texels,
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(maps.size * 2 * PER_PAIR as u32),
                rows_per_image: Some(maps.size),
            },
            wgpu::Extent3d {
                depth_or_array_layers: 1,
                ..size
            },
        );
    }
    texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2Array),
        ..Default::default()
    })
}

/// First layer of each page in the lower half of a number, and the number of its pairs in the upper half.
fn page_layers(maps: &IntervalMaps) -> Vec<u32> {
    let mut first = 0;
    maps.pages
        .iter()
        .map(|page| {
            let pairs = page.pairs.len() as u32;
            first += pairs;
            (first - pairs) | pairs << 16
        })
        .collect()
}

/// The surfaces of a scene, their triangles and vertices.
#[derive(Default)]
struct Built {
    surfaces: Vec<GpuSurface>,
    runs: Vec<Run>,
    welded: Welded,
}

fn build(world: &World, scene: &IntervalScene) -> Built {
    let maps = &scene.maps;
    let layers = page_layers(maps);
    let mut built = Built::default();
    for (index, matched) in (0u32..).zip(&scene.matched) {
        let baked = &maps.surfaces[matched.surface as usize];
        let corners = &maps.corners[baked.corners.start as usize..baked.corners.end as usize];
        let Some(mesh) = world.get::<SceneMesh>(matched.entity) else {
            continue;
        };
        let Some(submesh) = mesh.0.submeshes.get(matched.submesh as usize) else {
            continue;
        };
        let first_run = built.runs.len();
        built.welded.begin();
        // A surface that showed no shadows has no corners.
        let nowhere = std::iter::repeat(&[Corner::NOWHERE; 3][..]);
        let corners = corners.chunks_exact(3).chain(nowhere);
        for (triangle, corners) in local_triangles(&mesh.0, submesh).zip(corners) {
            let Some(positions) = triangle else { continue };
            let first_index = built.welded.indices.len() as u32;
            let page = page_of(maps, corners);
            let layers = page.map_or(NO_PAGE, |page| layers[page]);
            for (position, corner) in positions.into_iter().zip(corners) {
                built.welded.add(IntervalVertex {
                    position_local: position.to_array(),
                    texel: corner.texel.to_array(),
                    layers,
                });
            }
            let texels = [corners[0].texel, corners[1].texel, corners[2].texel];
            let seen = page.map_or(Seen::ALWAYS, |page| {
                Seen::of_triangle(texels, &maps.pages[page], maps.size)
            });
            add_triangle(&mut built.runs, first_run, first_index, &seen);
        }
        if first_run < built.runs.len() {
            built.surfaces.push(GpuSurface {
                matched: index,
                runs: first_run..built.runs.len(),
                is_two_sided: baked.is_two_sided,
            });
        }
    }
    built
}

/// The index of the page of a triangle; `None` if it is on no page.
fn page_of(maps: &IntervalMaps, corners: &[Corner]) -> Option<usize> {
    let is_nowhere = corners.iter().all(|corner| *corner == Corner::NOWHERE);
    let page = corners.first()?.page as usize;
    (!is_nowhere && page < maps.pages.len()).then_some(page)
}
