//! Measures of a frame at each pixel, for debug views: the number of lights, and the plane of the surface.
//!
//! Both are drawn after the frame from its own draw lists, so they show what the frame drew and not what it should have
//! drawn. [`RenderSettings::pixel_measures`](crate::render::RenderSettings::pixel_measures) must have been on when the
//! frame was prepared.

use glam::{Vec2, Vec3};

use super::canvas::Canvas;
use super::targets::FrameTargets;
use crate::render::nodes::receiver_plane::{self, NO_PLANE};
use crate::render::nodes::surface_pass::SurfacePass;
use crate::render::nodes::surfaces::draw_batches;
use crate::render::renderer::Renderer;

/// The plane of the triangle that a pixel shows, in world axes with the origin at the eye.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePlane {
    /// Unit normal of the triangle, on the side of the eye.
    pub normal: Vec3,
    /// Value of `normal · p` for all points `p` of the plane, metres.
    pub offset: f32,
}

impl SurfacePlane {
    /// Reads a texel that [`Renderer::record_planes`] drew; `None` where the pixel shows no surface, or one that is seen
    /// edge on.
    ///
    /// Twin of `receiver_at` in `shaders/common/receiver.wgsl`.
    pub fn of_texel([normal, offset]: [u32; 2]) -> Option<Self> {
        if normal == NO_PLANE {
            return None;
        }
        let snorm = |bits: u32| (f32::from(bits as u16 as i16) / 32767.0).max(-1.0);
        let place = Vec2::new(snorm(normal), snorm(normal >> 16));
        let z = 1.0 - place.x.abs() - place.y.abs();
        let fold = (-z).max(0.0);
        let unfolded = |p: f32| if p >= 0.0 { p - fold } else { p + fold };
        Some(Self {
            normal: Vec3::new(unfolded(place.x), unfolded(place.y), z).normalize(),
            offset: f32::from_bits(offset),
        })
    }
}

impl Renderer {
    /// Counts the lights that the last recorded frame draws at each pixel: those with the pixel's surface among the
    /// surfaces that they light, and the pixel in their scissor. Each of them costs its light shader there, unless a
    /// stencil finds the pixel in shadow. Blended surfaces are left out.
    ///
    /// `counts` says by index into [`FrameLights`](crate::sets::FrameLights) which lights count. The target has the format
    /// [`VISIBILITY_FORMAT`](crate::render::VISIBILITY_FORMAT) and the size of the view. It holds the number, exactly up
    /// to 2048 lights. Record it after [`Renderer::record`], before the next frame is prepared.
    pub fn record_light_count(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        target: &wgpu::TextureView,
        counts: impl Fn(usize) -> bool,
    ) {
        let Some(targets) = self.measured() else { return };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("light count"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: target,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(targets.read_only()),
            ..Default::default()
        });
        self.frame.viewport.set(&mut pass);
        pass.set_bind_group(0, &self.view_group, &[]);
        let surfaces = self.surface_resources();
        for light in self.frame.lights.iter().filter(|light| counts(light.light)) {
            let [x, y, width, height] = light.scissor;
            pass.set_scissor_rect(x, y, width, height);
            let batches = self.batches(&light.batches);
            draw_batches(&mut pass, SurfacePass::LightCount, batches, &surfaces);
        }
    }

    /// Draws the plane of the opaque surface that the last recorded frame shows at each pixel. The target has the format
    /// [`RECEIVER_PLANE_FORMAT`](crate::render::RECEIVER_PLANE_FORMAT) and the size of the view;
    /// [`SurfacePlane::of_texel`] reads its texels. Record it after [`Renderer::record`], before the next frame is
    /// prepared.
    pub fn record_planes(&self, encoder: &mut wgpu::CommandEncoder, target: &wgpu::TextureView) {
        let (Some(targets), Some((radiance, _))) = (self.measured(), &self.radiance) else {
            return;
        };
        let canvas = Canvas {
            radiance: &radiance.view,
            targets,
            viewport: self.frame.viewport,
        };
        let mut pass = receiver_plane::begin(encoder, &canvas, target, None);
        pass.set_bind_group(0, &self.view_group, &[]);
        let batches = self.batches(&self.frame.ambient);
        draw_batches(
            &mut pass,
            SurfacePass::ReceiverPlane,
            batches,
            &self.surface_resources(),
        );
    }

    /// Returns the depth of the last frame, unless it cannot be measured.
    fn measured(&self) -> Option<&FrameTargets> {
        let is_ready = self.settings.pixel_measures && self.frame.has_view && !self.gpu.context.is_lost();
        self.targets.as_ref().filter(|_| is_ready)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Packs a normal as the shader does.
    fn packed(normal: Vec3) -> u32 {
        let p = normal.truncate() / normal.abs().element_sum();
        let sign = |x: f32| if x >= 0.0 { 1.0 } else { -1.0 };
        let p = if normal.z >= 0.0 {
            p
        } else {
            Vec2::new((1.0 - p.y.abs()) * sign(p.x), (1.0 - p.x.abs()) * sign(p.y))
        };
        let snorm = |x: f32| u32::from((x * 32767.0).round() as i16 as u16);
        snorm(p.x) | snorm(p.y) << 16
    }

    #[test]
    fn planes_are_read_as_they_are_packed() {
        for normal in [
            Vec3::Z,
            Vec3::NEG_Z,
            Vec3::X,
            Vec3::NEG_Y,
            Vec3::new(-0.4, 0.5, -0.7).normalize(),
        ] {
            let plane = SurfacePlane::of_texel([packed(normal), 2.5_f32.to_bits()]).expect("a plane");
            assert!(plane.normal.distance(normal) < 1e-4, "{normal}: {plane:?}");
            assert_eq!(plane.offset, 2.5);
        }
        assert_eq!(SurfacePlane::of_texel([NO_PLANE, 0]), None);
    }
}
