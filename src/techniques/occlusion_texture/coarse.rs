//! Whether the slices and texels of a light's pictures are too coarse for most of its casters.

use super::face::{SliceFace, Slices};
use super::fit::SliceFaces;
use super::framing::LightBox;
use super::scene_box::SceneBox;

/// A caster is lost if a slice is more than this many times as thick as the caster is long: its shadow has not faded in where
/// its receivers are. By eye.
const THICK: f64 = 8.0;

/// Depth of a caster as a share of its size from which on its shadow is missed. Panels that a light lies in have less.
const SHALLOW: f64 = 1e-3;

/// Pictures that are too coarse for at least half of their casters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coarse {
    /// Number of casters that are too small for every picture that they are in, or too near to the light.
    pub lost: usize,
    /// Number of all casters before the light.
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
        for caster in scene.iter().filter(|scene| scene.casts) {
            let (mut is_shown, mut is_fine) = (false, false);
            for face in faces.iter().filter(|face| face.slices != Slices::NONE) {
                let whole = LightBox::new(caster, face.origin, &face.axes);
                let size = (whole.max - whole.min).max_element();
                let shown = match faces.len() {
                    1 => Some(whole),
                    _ => whole.within_pyramid(face.divisor.y),
                };
                let is_before = |shown: &LightBox| face.divisor.x == 0.0 || shown.max.z > SHALLOW * size;
                let Some(shown) = shown.filter(is_before) else {
                    continue;
                };
                is_shown = true;
                is_fine |= coarse.is_fine(face, &shown, size, resolution);
            }
            coarse.casters += usize::from(is_shown);
            coarse.lost += usize::from(is_shown && !is_fine);
        }
        (coarse.lost > 0 && 2 * coarse.lost >= coarse.casters).then_some(coarse)
    }

    /// Whether a picture is fine enough for a part of a caster that it shows. Slices begin behind casters that are much nearer
    /// than others.
    fn is_fine(&mut self, face: &SliceFace, shown: &LightBox, size: f64, resolution: u32) -> bool {
        let slices = &face.slices;
        let thickness = (slices.bottoms[slices.count - 1] - slices.top) / slices.count as f64;
        self.thickness = self.thickness.max(thickness);
        if shown.max.z <= slices.top {
            return false;
        }
        let depth = 0.5 * (shown.min.z.max(slices.top) + shown.max.z);
        let across = 2.0 * (face.divisor.x * depth + face.divisor.y) / face.scale.min_element();
        let texel = across / f64::from(resolution.max(1));
        self.texel = self.texel.max(texel);
        thickness <= THICK * size && texel <= size
    }
}

/// A length for people, with two significant digits or more.
pub(super) struct Metres(pub f64);

impl std::fmt::Display for Metres {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let magnitude = self.0.abs().log10().floor();
        let decimals = if magnitude.is_finite() {
            (1.0 - magnitude).clamp(0.0, 12.0)
        } else {
            0.0
        };
        write!(f, "{:.*} m", decimals as usize, self.0)
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
        // The slices of mountains far away begin behind what is near.
        let far = Aabb::around(Vec3::new(4e3, 0.0, 9e3), Vec3::new(1e3, 3e3, 1e3));
        assert_eq!(
            of(SceneBox::of_bounds(far, true)).map(|coarse| coarse.lost),
            Some(1)
        );
        let ground = Aabb::around(Vec3::ZERO, Vec3::new(3e5, 0.0, 3e5));
        assert_eq!(of(SceneBox::of_bounds(ground, false)), None);
    }

    #[test]
    fn lengths_have_two_significant_digits() {
        let texts = [123.4, 12.34, 1.234, 0.1234, 0.001_234, 0.0].map(|length| Metres(length).to_string());
        assert_eq!(texts, ["123 m", "12 m", "1.2 m", "0.12 m", "0.0012 m", "0 m"]);
    }
}
