//! Whether the slices and texels of a light's pictures are too coarse for most of its casters.

use super::face::Slices;
use super::fit::SliceFaces;
use super::framing::LightBox;
use super::scene_box::SceneBox;

/// A caster is lost if a slice is more than this many times as thick as the caster is long: its shadow has not faded in where
/// its receivers are. By eye.
const THICK: f64 = 8.0;

/// Pictures that are too coarse for at least half of their casters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coarse {
    /// Number of casters that are too small for the picture that they are in.
    pub lost: usize,
    /// Number of all casters, counted once for each picture that they are in.
    pub casters: usize,
    /// Thickness of the thickest slice, metres.
    pub thickness: f64,
    /// Widest texel at a caster, metres.
    pub texel: f64,
}

impl Coarse {
    /// Compares the casters of a scene with the pictures of `resolution` texels that are fitted to it. `None` if the pictures
    /// are fine enough.
    pub(super) fn new(faces: &SliceFaces, scene: &[SceneBox], resolution: u32) -> Option<Self> {
        let mut coarse = Self {
            lost: 0,
            casters: 0,
            thickness: 0.0,
            texel: 0.0,
        };
        for face in faces.iter().filter(|face| face.slices != Slices::NONE) {
            let slices = &face.slices;
            let thickness = (slices.bottoms[slices.count - 1] - slices.top) / slices.count as f64;
            coarse.thickness = coarse.thickness.max(thickness);
            for caster in scene.iter().filter(|scene| scene.casts) {
                let whole = LightBox::new(caster, face.origin, &face.axes);
                let shown = match faces.len() {
                    1 => Some(whole),
                    _ => whole.within_pyramid(face.divisor.y),
                };
                let Some(shown) = shown.filter(|shown| shown.max.z > slices.top) else {
                    continue;
                };
                let depth = 0.5 * (shown.min.z.max(slices.top) + shown.max.z);
                let across = 2.0 * (face.divisor.x * depth + face.divisor.y) / face.scale.min_element();
                let texel = across / f64::from(resolution.max(1));
                coarse.texel = coarse.texel.max(texel);
                let size = (whole.max - whole.min).max_element();
                coarse.casters += 1;
                coarse.lost += usize::from(thickness > THICK * size || texel > size);
            }
        }
        (coarse.lost > 0 && 2 * coarse.lost >= coarse.casters).then_some(coarse)
    }
}

#[cfg(test)]
mod tests {
    use super::super::fit::{SliceSettings, fit_faces};
    use super::super::sliced_light::{SlicedKind, SlicedLight};
    use super::*;
    use crate::geometry::Aabb;
    use glam::{DVec2, DVec3, Vec3};

    #[test]
    fn hills_of_kilometres_are_too_much_for_a_box_and_a_ground_is_not() {
        let light = SlicedLight {
            origin: DVec3::new(0.5, 4.0, 1.0),
            axes: [DVec3::X, DVec3::Z, DVec3::NEG_Y],
            half: DVec2::splat(0.3),
            kind: SlicedKind::Rect,
        };
        let settings = SliceSettings {
            count: 8,
            weight: 0.0,
            guard: 1.0 / 128.0,
        };
        let small = SceneBox::of_bounds(Aabb::around(Vec3::Y * 0.5, Vec3::splat(0.5)), true);
        let of = |wide: SceneBox| {
            let scene = [small, wide];
            Coarse::new(&fit_faces(&light, &settings, &scene), &scene, 256)
        };
        let hills = Aabb::around(Vec3::NEG_Y * 100.0, Vec3::new(3000.0, 100.0, 3000.0));
        let coarse = of(SceneBox::of_bounds(hills, true)).expect("it is coarse");
        assert_eq!((coarse.lost, coarse.casters), (1, 2));
        assert!(coarse.thickness > 10.0 && coarse.texel > 1.0, "{coarse:?}");
        let ground = Aabb::around(Vec3::ZERO, Vec3::new(3e5, 0.0, 3e5));
        assert_eq!(of(SceneBox::of_bounds(ground, false)), None);
    }
}
