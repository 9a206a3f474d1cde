//! Reports of everything that the renderer cannot draw.

use bevy_ecs::prelude::*;
use glam::UVec2;

use super::gpu::mipmaps::size_within;
use super::light_model::textures::store::LightTextureStore;
use super::{RenderError, Renderer};
use crate::reports::{Reports, Round, code_of};
use crate::scene::SceneMesh;
use crate::sets::{View, ViewportSize};

/// Raises the report topics `renderer`, `mesh` and `texture`. Without a [`Renderer`] it raises nothing.
pub fn report_renderer(world: &World, reports: &mut Reports) {
    let renderer = world.get_resource::<Renderer>();
    let mut round = reports.round("renderer");
    if let Some(error) = renderer.and_then(Renderer::failure) {
        let view = world.resource::<View>().data.as_ref();
        raise_failure(&mut round, view.map(|view| view.camera), error);
    }
    // A host knows its own size and cameras.
    if let Some(renderer) = renderer.filter(|renderer| renderer.host.is_none()) {
        report_view(world, &mut round);
        if let Some(format) = renderer.unprepared_output() {
            round.state(
                None,
                10,
                format_args!(
                    "The picture was not written: its format is {format:?}, for which no pipeline was made. Call \
                     `Renderer::prepare_output` with this format once, before the first frame; if it was called, an earlier \
                     report says why it failed."
                ),
            );
        }
    }
    drop(round);
    let mut round = reports.round("mesh");
    for mesh in renderer.map_or(&[][..], Renderer::oversized_meshes) {
        let name = world
            .get::<SceneMesh>(mesh.entity)
            .map_or("", |mesh| mesh.0.name.as_str());
        let (needed, limit) = (mesh.needed, mesh.limit);
        round.state(
            Some(mesh.entity),
            1,
            format_args!(
                "The mesh `{name}` is not drawn and casts no shadow map: it needs a buffer of {needed} bytes, and the \
                 device allows {limit} bytes. Split the mesh, or reduce its vertices."
            ),
        );
    }
    drop(round);
    let mut round = reports.round("texture");
    if let Some(renderer) = renderer {
        report_textures(renderer, &mut round);
    }
}

/// Reports the textures of materials and cookies that are larger than those of the device can be.
fn report_textures(renderer: &Renderer, round: &mut Round<'_>) {
    let gpu = &renderer.gpu;
    let limit = gpu.context.device.limits().max_texture_dimension_2d;
    let mut report = |name: &str, size: [u32; 2]| {
        let held = size_within(size, limit);
        if held == size {
            return;
        }
        // The size tells textures of one name apart.
        let code = code_of(size[0] ^ size[1].rotate_left(16), name);
        round.raise(None, code, || {
            format!(
                "The texture `{name}` has {} × {} texels and is shown with {} × {}: the device allows {limit} along a side. \
                 Use a picture of at most this size, or cut it into several.",
                size[0], size[1], held[0], held[1]
            )
        });
    };
    gpu.materials
        .for_each_texture(|texture| report(&texture.name, [texture.width, texture.height]));
    gpu.part(LightTextureStore::new)
        .for_each_cookie(|image| report(image.name(), [image.width(), image.height()]));
}

/// Reports why there is no view, and so no picture.
fn report_view(world: &World, round: &mut Round<'_>) {
    if world.resource::<View>().data.is_some() {
        return;
    }
    let viewport = world
        .get_resource::<ViewportSize>()
        .map_or(UVec2::ZERO, |size| size.0);
    if viewport.min_element() == 0 {
        round.state(
            None,
            8,
            format_args!(
                "Nothing is drawn: the resource `ViewportSize` is {} × {} pixels. Set it to the size of the picture.",
                viewport.x, viewport.y
            ),
        );
    } else {
        round.raise(None, 9, || {
            "Nothing is drawn: the world has no `Camera` that can be used. Spawn one, and give it a field of view, an aspect \
             and a near plane greater than 0, and a transform that can be inverted."
                .to_owned()
        });
    }
}

/// Raises the error that keeps a view from being drawn. An error of the device or of a shader names no
/// camera.
pub(crate) fn raise_failure(round: &mut Round<'_>, camera: Option<Entity>, error: &RenderError) {
    let (code, entity, advice) = match error {
        RenderError::NoAdapter(_) | RenderError::UnknownAdapter { .. } => (1, None, "Install a driver."),
        RenderError::NoDevice { .. } => (2, None, "Ask for fewer features or lower limits."),
        RenderError::Shader { .. } => (
            3,
            None,
            "Repair the shader; if it is the crate's own, please report it with the name of the adapter.",
        ),
        RenderError::DeviceLost => (4, None, "Make a new `RenderContext` and a new `Renderer`."),
        RenderError::HostView { .. } => (
            5,
            camera,
            "Keep the viewport inside of its target, and give the camera a projection that can be inverted.",
        ),
        RenderError::Readback { .. } => (6, camera, "Read it in a later frame."),
        RenderError::Limit { .. } => (
            7,
            camera,
            "Show fewer objects or lights at once, or draw into a smaller target.",
        ),
    };
    round.state(
        entity,
        code,
        format_args!("No shadows are drawn: {error}. {advice}"),
    );
}
