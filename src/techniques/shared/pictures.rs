//! Texels that a surface covers in pictures of the casters, for debug views.

use glam::{DMat4, DVec2};

use crate::techniques::registry::{SurfacePatch, TexelLookup};

/// A square picture that looks up surface points by projecting them.
#[derive(Clone, Copy, Debug)]
pub struct Picture {
    /// Matrix from world space to the clip space of the picture.
    pub clip_from_world: DMat4,
    /// Number of texels along a side.
    pub resolution: u32,
}

/// Which of several pictures is looked up for a point that more than one shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Chosen {
    /// The first that shows the point at least this number of texels from its border, and within its depth.
    First {
        /// Width of the border, texels.
        border: f64,
    },
    /// The picture in which the point is farthest from the border.
    Innermost,
}

impl Picture {
    /// Returns the place of a point, NDC with depth, and the number of texels that a patch around it covers. `None` if the
    /// point lies behind the picture's centre of projection.
    ///
    /// With `c = M p` and a side `s`, the place `c.xy / c.w` moves by `((M s).xy − place · (M s).w) / c.w`.
    fn texels(&self, patch: &SurfacePatch) -> Option<(glam::DVec3, f64)> {
        let clip = self.clip_from_world * patch.at.extend(1.0);
        if !(clip.w > 0.0) {
            return None;
        }
        let place = clip.truncate() / clip.w;
        let [u, v] = patch.sides.map(|side| -> DVec2 {
            let side = self.clip_from_world * side.extend(0.0);
            (side.truncate().truncate() - place.truncate() * side.w) / clip.w
        });
        let half = 0.5 * f64::from(self.resolution);
        Some((place, u.perp_dot(v).abs() * half * half))
    }
}

/// Returns what counts the texels of a patch in the picture in which it is looked up.
pub fn texel_lookup(pictures: Vec<Picture>, chosen: Chosen) -> TexelLookup<'static> {
    Box::new(move |patch| {
        let shown = pictures.iter().filter_map(|picture| {
            let (place, texels) = picture.texels(patch)?;
            let off = place.truncate().abs().max_element();
            let is_shown = match chosen {
                Chosen::First { border } => {
                    off <= 1.0 - 2.0 * border / f64::from(picture.resolution)
                        && (0.0..=1.0).contains(&place.z)
                }
                Chosen::Innermost => off <= 1.0,
            };
            is_shown.then_some((off, texels))
        });
        let best = match chosen {
            Chosen::First { .. } => { shown }.next(),
            Chosen::Innermost => shown.min_by(|a, b| a.0.total_cmp(&b.0)),
        };
        best.map(|(_, texels)| texels)
    })
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, DVec4};

    use super::*;

    /// A picture along −Z of what lies within ±`half` metres of the axis, up to 10 m deep.
    fn parallel(half: f64, resolution: u32) -> Picture {
        let rows = [
            DVec4::X / half,
            DVec4::Y / half,
            DVec4::new(0.0, 0.0, 0.1, 1.0),
            DVec4::W,
        ];
        Picture {
            clip_from_world: DMat4::from_cols(rows[0], rows[1], rows[2], rows[3]).transpose(),
            resolution,
        }
    }

    /// A picture along −Z from the origin, as wide as it is far.
    fn perspective(resolution: u32) -> Picture {
        let rows = [DVec4::X, DVec4::Y, DVec4::W * 0.1, DVec4::NEG_Z];
        Picture {
            clip_from_world: DMat4::from_cols(rows[0], rows[1], rows[2], rows[3]).transpose(),
            resolution,
        }
    }

    fn patch(at: DVec3) -> SurfacePatch {
        SurfacePatch {
            at,
            sides: [DVec3::X * 0.1, DVec3::Y * 0.2],
        }
    }

    #[test]
    fn texels_are_the_area_of_a_patch_in_those_of_the_picture() {
        // 100 texels over 2 m are 50 a metre, in both directions.
        let lookup = texel_lookup(vec![parallel(1.0, 100)], Chosen::Innermost);
        let texels = lookup(&patch(DVec3::new(0.3, 0.2, -4.0))).expect("it is shown");
        assert!((texels - 0.1 * 0.2 * 2500.0).abs() < 1e-9, "{texels}");
        assert_eq!(lookup(&patch(DVec3::X * 1.1)), None);
        // At 4 m, the picture is 8 m wide; steps away from the viewer move nothing in the middle, and much beside it.
        let lookup = texel_lookup(vec![perspective(800)], Chosen::Innermost);
        let texels = lookup(&patch(DVec3::NEG_Z * 4.0)).expect("it is shown");
        assert!((texels - 0.1 * 0.2 * 1e4).abs() < 1e-9, "{texels}");
        let steep = |x: f64| SurfacePatch {
            at: DVec3::new(x, 0.0, -4.0),
            sides: [DVec3::Z * 0.1, DVec3::Y * 0.2],
        };
        assert_eq!(lookup(&steep(0.0)), Some(0.0));
        let beside = lookup(&steep(2.0)).expect("it is shown");
        assert!((beside - 0.5 * 0.1 * 0.2 * 1e4).abs() < 1e-9, "{beside}");
        assert_eq!(lookup(&patch(DVec3::Z)), None, "behind the light");
    }

    #[test]
    fn the_finest_cascade_and_the_innermost_face_are_looked_up() {
        let pictures = || vec![parallel(1.0, 100), parallel(5.0, 100)];
        let density = |texels: Option<f64>| (texels.unwrap_or_default() / 0.02).sqrt().round();
        let near = patch(DVec3::X * 0.9);
        let first = texel_lookup(pictures(), Chosen::First { border: 3.0 });
        assert_eq!(density(first(&near)), 50.0);
        assert_eq!(density(first(&patch(DVec3::X * 0.95))), 10.0, "in the border");
        assert_eq!(first(&patch(DVec3::NEG_Z * 11.0)), None, "too deep");
        let innermost = texel_lookup(pictures(), Chosen::Innermost);
        assert_eq!(density(innermost(&near)), 10.0);
    }
}
