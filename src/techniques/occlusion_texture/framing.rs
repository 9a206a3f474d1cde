//! Chooses what a picture shows: its scene from a centre of projection, cut to where receivers find casters.

use glam::{DVec2, DVec3};

use super::face::Slices;
use super::scene_box::SceneBox;
use super::sliced_light::{SlicedKind, SlicedLight};

/// How far a picture reaches beyond a caster, in halves of the largest kernel there. Kernels that touch the caster fit into
/// 2.
const MARGIN: f64 = 2.0;

/// Largest kernel of a directional light that fits into the margins, in halves of the extent of all casters. Larger ones, of
/// receivers kilometres behind, see casters that hide almost nothing of the light. By eye.
const WIDE: f64 = 1.0;

/// A box in light space.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightBox {
    pub min: DVec3,
    pub max: DVec3,
    pub casts: bool,
}

impl LightBox {
    /// Makes the box of an object in the space of a light.
    pub fn new(scene: &SceneBox, origin: DVec3, axes: &[DVec3; 3]) -> Self {
        let [x, y, z] = axes.map(|axis| scene.range(axis, origin));
        Self {
            min: DVec3::new(x[0], y[0], z[0]),
            max: DVec3::new(x[1], y[1], z[1]),
            casts: scene.casts,
        }
    }

    /// Returns the part of the box in a pyramid of 90° along z whose apex is `behind` metres behind the light. Its depths are
    /// cut alone. `None` if no part is in it.
    pub fn within_pyramid(mut self, behind: f64) -> Option<Self> {
        let beside = self.min.truncate().max(-self.max.truncate()).max_element();
        let nearest = beside - behind;
        self.min.z = self.min.z.max(nearest);
        (nearest < self.max.z).then_some(self)
    }
}

/// A caster with the largest kernel that may touch it.
#[derive(Clone, Copy, Debug)]
struct Touched {
    min: DVec3,
    max: DVec3,
    plane: f64,
    margin: DVec2,
}

/// The scene of one picture, and the kernels that look for its casters.
pub(super) struct Framing<'a> {
    light: &'a SlicedLight,
    boxes: &'a [LightBox],
    casters: Vec<Touched>,
    nearest: f64,
}

impl<'a> Framing<'a> {
    /// Prepares the framing of a scene between two depths, metres.
    pub fn new(
        light: &'a SlicedLight,
        boxes: &'a [LightBox],
        slices: &Slices,
        [nearest, farthest]: [f64; 2],
    ) -> Self {
        let casters = boxes.iter().filter(|light| light.casts && light.max.z > nearest);
        let (least, greatest) = casters.clone().fold(
            (DVec2::INFINITY, DVec2::NEG_INFINITY),
            |(least, greatest), caster| {
                (
                    least.min(caster.min.truncate()),
                    greatest.max(caster.max.truncate()),
                )
            },
        );
        let widest = match light.kind {
            SlicedKind::Directional => WIDE * 0.5 * (greatest - least).max_element(),
            SlicedKind::Rect | SlicedKind::Sphere => f64::INFINITY,
        };
        let touched = |caster: &LightBox| {
            let min = caster.min.truncate().extend(caster.min.z.max(nearest));
            let plane = slices.least_plane(min.z);
            let beside = min.truncate().abs().max(caster.max.truncate().abs());
            let kernel = light.kernel_half(plane, farthest) * light.lengthening(beside / min.z);
            Touched {
                min,
                max: caster.max,
                plane,
                margin: MARGIN * kernel.min(DVec2::splat(widest)),
            }
        };
        Self {
            light,
            boxes,
            casters: casters.map(touched).collect(),
            nearest,
        }
    }

    /// Cuts a range of coordinates over the divisor to the part in which kernels find casters. A kernel that touches a
    /// caster reaches beyond it by its own size; all others find nothing.
    pub fn cut(&self, [least, greatest]: [DVec2; 2], divisor: DVec2) -> [DVec2; 2] {
        let (mut own_least, mut own_greatest) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for caster in &self.casters {
            let margin = caster.margin / (divisor.x * caster.plane + divisor.y);
            for z in [caster.min.z, caster.max.z] {
                let divisor = divisor.x * z + divisor.y;
                own_least = own_least.min(caster.min.truncate() / divisor - margin);
                own_greatest = own_greatest.max(caster.max.truncate() / divisor + margin);
            }
        }
        let cut = [least.max(own_least), greatest.min(own_greatest)];
        if cut[0].cmple(cut[1]).all() {
            cut
        } else {
            [least, greatest]
        }
    }

    /// Returns the least and greatest coordinate over the divisor that a picture shows, for a centre of projection `behind`
    /// metres behind the light.
    pub fn slopes(&self, behind: f64) -> [DVec2; 2] {
        let half = self.light.half;
        let (mut least, mut greatest) = (-half / behind, half / behind);
        for light in self.boxes.iter().filter(|light| light.max.z > self.nearest) {
            for z in [light.min.z.max(self.nearest), light.max.z] {
                least = least.min(light.min.truncate() / (z + behind));
                greatest = greatest.max(light.max.truncate() / (z + behind));
            }
        }
        self.cut([least, greatest], DVec2::new(1.0, behind))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A long table beside a lamp begins, for the picture downwards, where that picture begins to show it.
    #[test]
    fn boxes_begin_where_they_enter_a_pyramid() {
        let table = LightBox {
            min: DVec3::new(1.0, -2.0, -0.5),
            max: DVec3::new(4.0, 2.0, 2.0),
            casts: true,
        };
        let shown = table.within_pyramid(0.1).expect("a part of it is shown");
        assert!((shown.min.z - 0.9).abs() < 1e-12 && shown.max == table.max);
        let below = LightBox {
            min: DVec3::new(-1.0, -2.0, 1.0),
            ..table
        };
        assert_eq!(below.within_pyramid(0.1).map(|shown| shown.min), Some(below.min));
        let beside = LightBox {
            min: DVec3::new(2.2, -2.0, -0.5),
            ..table
        };
        assert!(beside.within_pyramid(0.1).is_none());
        let flat = LightBox {
            min: DVec3::new(-1.0, -1.0, 2.0),
            ..table
        };
        assert!(flat.within_pyramid(0.1).is_some(), "a floor");
    }
}
