//! One picture of the casters from a light: its position, its projection, and what it can see.
//!
//! The space of a face has its origin at the light, x to the right, y up and z away from the light. For a
//! directional light the origin is on the side of the box towards the light. Depth is reversed as everywhere
//! ([`conventions`](crate::conventions)).

use glam::{DMat4, DVec3, DVec4, Vec4};

use crate::geometry::Aabb;

/// How a face projects.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FaceProjection {
    /// Projects from a point; depth is `near / z`.
    Perspective {
        /// Half the side of the picture at distance 1.
        tangent: f64,
        /// Distance of the near plane, metres.
        near: f64,
    },
    /// Projects along parallel rays; depth is `1 − z / length`.
    Parallel {
        /// Half the side of the picture, metres.
        half: f64,
        /// Length of the box along z, metres.
        length: f64,
    },
    /// Projects by a matrix whose centre of projection is the light, so every ray of the light falls on one
    /// point of the picture. The matrix may warp the picture in any way that keeps straight lines straight.
    Matrix {
        /// Matrix from the face's space to clip space. Its depth, divided by w, falls along every ray.
        clip_from_face: DMat4,
        /// Whether the rays are parallel to z; otherwise they come from the origin of the face's space.
        parallel: bool,
    },
}

/// One picture of the casters from a light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapFace {
    /// Origin of the face's space, world space, metres.
    pub origin: DVec3,
    /// Unit vectors at right angles, world space: right, up, away from the light.
    pub axes: [DVec3; 3],
    /// How the face projects.
    pub projection: FaceProjection,
}

impl MapFace {
    /// Returns the matrix from world space to the clip space of the face.
    pub fn clip_from_world(&self) -> DMat4 {
        let [x, y, z] = self.axes.map(|axis| axis.extend(-axis.dot(self.origin)));
        let rows = match self.projection {
            FaceProjection::Perspective { tangent, near } => [x / tangent, y / tangent, DVec4::W * near, z],
            FaceProjection::Parallel { half, length } => {
                [x / half, y / half, DVec4::W - z / length, DVec4::W]
            }
            FaceProjection::Matrix { clip_from_face, .. } => {
                return clip_from_face * DMat4::from_cols(x, y, z, DVec4::W).transpose();
            }
        };
        DMat4::from_cols(rows[0], rows[1], rows[2], rows[3]).transpose()
    }

    /// Returns the matrix to the clip space of the face from world axes with the origin at the eye.
    pub fn clip_from_relative(&self, eye: DVec3) -> DMat4 {
        let at_eye = Self {
            origin: self.origin - eye,
            ..*self
        };
        at_eye.clip_from_world()
    }

    /// Returns the face with its picture shrunk about the middle, so that a border shows more than before.
    /// Only faces with a matrix change.
    pub fn with_border(mut self, share_inside: f64) -> Self {
        if let FaceProjection::Matrix { clip_from_face, .. } = &mut self.projection {
            let shrink = DVec4::new(share_inside, share_inside, 1.0, 1.0);
            *clip_from_face = DMat4::from_diagonal(shrink) * *clip_from_face;
        }
        self
    }

    /// Returns the rows of the transform to the face's space from world axes with the origin at the eye.
    pub fn rows_from_relative(&self, eye: DVec3) -> [Vec4; 3] {
        self.axes
            .map(|axis| axis.extend(axis.dot(eye - self.origin)).as_vec4())
    }

    /// Returns the side of a texel, metres: at distance 1 for a perspective face, anywhere for a parallel
    /// one. A face with a matrix has texels of many sizes, and 0 is returned;
    /// [`matrix_faces::texel_at`](super::matrix_faces::texel_at) measures them.
    pub fn texel_metres(&self, resolution: u32) -> f64 {
        let half = match self.projection {
            FaceProjection::Perspective { tangent, .. } => tangent,
            FaceProjection::Parallel { half, .. } => half,
            FaceProjection::Matrix { .. } => 0.0,
        };
        2.0 * half / f64::from(resolution)
    }

    /// Whether a box may be visible in the face. Conservative.
    pub fn may_see(&self, aabb: &Aabb) -> bool {
        if aabb.is_empty() {
            return false;
        }
        let center = aabb.center().as_dvec3() - self.origin;
        let half = aabb.half_size().as_dvec3();
        let reaches = |normal: DVec3, offset: f64| {
            normal.dot(center) + normal.abs().dot(half) + offset >= -1e-9 * (center.length() + half.length())
        };
        let [x, y, z] = self.axes;
        match self.projection {
            FaceProjection::Perspective { tangent, near } => {
                reaches(z, -near)
                    && [x, -x, y, -y]
                        .iter()
                        .all(|side| reaches(z * tangent + *side, 0.0))
            }
            FaceProjection::Parallel { half: side, length } => {
                reaches(z, 0.0)
                    && reaches(-z, length)
                    && [x, -x, y, -y].iter().all(|&axis| reaches(axis, side))
            }
            FaceProjection::Matrix { .. } => {
                let rows = self.clip_from_relative(self.origin).transpose();
                let (x, y, z, w) = (rows.x_axis, rows.y_axis, rows.z_axis, rows.w_axis);
                [w + x, w - x, w + y, w - y, z, w - z].iter().all(|side| {
                    let length = side.truncate().length().max(f64::MIN_POSITIVE);
                    reaches(side.truncate() / length, side.w / length)
                })
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn faces() -> [MapFace; 4] {
        let z = DVec3::new(0.3, -0.9, 0.2).normalize();
        let (x, y) = z.any_orthonormal_pair();
        let face = |projection| MapFace {
            origin: DVec3::new(1.0, 2.0, 3.0),
            axes: [x, y, z],
            projection,
        };
        [
            face(FaceProjection::Perspective {
                tangent: 0.7,
                near: 0.01,
            }),
            face(FaceProjection::Parallel {
                half: 2.0,
                length: 9.0,
            }),
            face(FaceProjection::Matrix {
                clip_from_face: DMat4::from_cols(
                    DVec4::new(1.5, 0.1, 0.0, 0.2),
                    DVec4::new(-0.2, 1.1, 0.0, -0.3),
                    DVec4::new(0.3, -0.1, 0.0, 1.0),
                    DVec4::Z * 0.01,
                ),
                parallel: false,
            }),
            face(FaceProjection::Matrix {
                clip_from_face: DMat4::from_cols(
                    DVec4::new(0.5, 0.1, 0.0, 0.1),
                    DVec4::new(-0.1, 0.4, 0.0, -0.05),
                    DVec4::Z * -0.05,
                    DVec4::new(0.1, -0.1, 0.5, 1.0),
                ),
                parallel: true,
            }),
        ]
    }

    #[test]
    fn points_inside_project_inside_and_boxes_around_them_are_seen() {
        for face in faces() {
            let mut inside = 0;
            for i in 0..4000 {
                let at = |k: i32| f64::from((i * k) % 97) / 97.0 * 16.0 - 8.0;
                let point = face.origin + DVec3::new(at(13), at(29), at(41));
                let clip = face.clip_from_world() * point.extend(1.0);
                let ndc = clip.truncate() / clip.w;
                let seen =
                    clip.w > 0.0 && ndc.x.abs() <= 1.0 && ndc.y.abs() <= 1.0 && (0.0..=1.0).contains(&ndc.z);
                let aabb = Aabb::from_points([point.as_vec3()]).padded();
                assert_eq!(face.may_see(&aabb), seen, "{face:?} {point}");
                inside += usize::from(seen);
                let rows = face.rows_from_relative(point);
                let z = face.axes[2].dot(point - face.origin) as f32;
                assert!((rows[2].w - z).abs() < 1e-5);
            }
            assert!(inside > 50 && inside < 3500, "{inside}");
        }
        assert!(!faces()[0].may_see(&Aabb::EMPTY));
        let all = Aabb::from_points([Vec3::splat(-100.0), Vec3::splat(100.0)]);
        assert!(faces().iter().all(|face| face.may_see(&all)));
    }
}
