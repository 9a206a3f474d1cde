//! The matrix that an object is drawn and casts with: its transform, or a substitute if that has no volume.
//!
//! | transform | matrix |
//! | --- | --- |
//! | finite, keeps volume | the transform, bit for bit |
//! | flattens any direction, skinned mesh | its translation alone, because the joints decide where the mesh is |
//! | flattens one direction, other mesh | the transform with a thickness that nothing notices: the object is a plate |
//! | flattens more directions, other mesh; or not finite | none: the object is left out |

use bevy_ecs::prelude::*;
use bevy_ecs::query::QueryData;
use bevy_transform::prelude::GlobalTransform;
use glam::{Affine3A, DMat3, DMat4, DVec3, Mat4};

use super::Skin;

/// A transform is flat if it scales some direction by less than this share of its longest axis. Products of rounded
/// rotations and a scale of 0 have a share of some 10⁻⁷.
const FLAT: f64 = 5e-7;

/// Thickness of a flat object, as a share of the longest axis of its transform. A light flush with a ceiling of a
/// kilometre is half a micrometre from its faces, far within its clearance ([`LightClearance`](crate::sets::LightClearance)).
/// The position of a light has coordinates of up to 10⁹ object sizes in the object's space, whose squares fit an `f32`.
const THICKNESS: f64 = 1e-9;

/// Greatest thickness of a flat object, as a share of the longest axis of its transform: a tenth of a pixel for an object
/// that fills 10,000 pixels. It is that of an object whose lost direction is between its axes.
const GREATEST_THICKNESS: f64 = 1e-5;

/// Thickness as a share of the lengths that cancel where the lost direction is between the object's axes. What lies at a
/// distance `h` before the object is at `h` divided by the thickness in the object's space, and the matrix takes it back as a
/// sum of terms that cancel. Their rounding errors are 2⁻²⁴ of them, so at most 0.3 % of `h`.
const CANCELLING: f64 = 2e-5;

/// The components that determine where an object stands.
#[derive(QueryData)]
#[query_data(derive(Clone, Copy))]
pub struct Placement {
    transform: &'static GlobalTransform,
    is_skinned: Has<Skin>,
}

impl PlacementItem<'_, '_> {
    /// The matrix that the object is drawn and casts with; `None` for one that is left out.
    pub fn affine(&self) -> Option<Affine3A> {
        placed(self.transform, self.is_skinned)
    }

    /// The matrix of [`affine`](Self::affine) in `f64`.
    pub fn world_from_local(&self) -> Option<DMat4> {
        self.affine().map(|affine| Mat4::from(affine).as_dmat4())
    }

    /// The matrix of [`affine`](Self::affine), but without the thickness of a flat object.
    pub fn exact_affine(&self) -> Option<Affine3A> {
        let affine = self.affine()?;
        Some(if self.is_flat() {
            self.transform.affine()
        } else {
            affine
        })
    }

    /// Whether the transform flattens one direction, so that the object is a plate.
    pub fn is_flat(&self) -> bool {
        let own = self.transform.affine();
        !self.is_skinned && !is_thick(&own) && flattened(&own).is_some()
    }
}

/// The matrix in `f64` that an entity is drawn and casts with; `None` for one that is left out. It is
/// [`PlacementItem::world_from_local`], for code that has the world instead of a query.
#[cfg(feature = "render")]
pub fn world_from_local(world: &World, entity: Entity) -> Option<DMat4> {
    let transform = world.get::<GlobalTransform>(entity)?;
    let is_skinned = world.get::<Skin>(entity).is_some();
    PlacementItem {
        transform,
        is_skinned,
    }
    .world_from_local()
}

/// The matrix that an object with this transform is drawn and casts with; `None` for one that is left out.
pub fn placed(transform: &GlobalTransform, is_skinned: bool) -> Option<Affine3A> {
    let affine = transform.affine();
    if !affine.is_finite() {
        return None;
    }
    if is_thick(&affine) {
        return Some(affine);
    }
    let plate = flattened(&affine);
    if plate.is_none() && has_volume(&affine) {
        return Some(affine);
    }
    if is_skinned {
        return Some(Affine3A::from_translation(affine.translation.into()));
    }
    plate
}

/// Whether a transform is far from flat, as most are. The test is cheap: `f32` rounds the volume by some 10⁻⁶ of the longest
/// axis cubed.
fn is_thick(affine: &Affine3A) -> bool {
    let m = &affine.matrix3;
    let longest = m.x_axis.length().max(m.y_axis.length()).max(m.z_axis.length());
    let volume = m.determinant().abs();
    volume > 1e-3 * (longest * longest * longest) && volume.is_finite()
}

/// Whether the volume of the transformed unit cube is neither 0 nor infinite in `f32`.
fn has_volume(affine: &Affine3A) -> bool {
    let determinant = affine.matrix3.determinant();
    determinant.is_finite() && determinant != 0.0
}

/// Gives a flat transform a thickness. `None` for a transform that is not flat, or that has no area either.
///
/// The transform `M` maps everything to a plane with unit normal `n`, and loses the direction `k`. With a thickness δ
/// it is `M + δ n kᵀ`, where `M` is without what its rounding left along `n`. This never mirrors, so fronts stay where
/// corners run counter-clockwise. The sum is rounded once. Where `k` is an axis, `M` has a column of zeros, which keeps δ to
/// its last bit.
fn flattened(affine: &Affine3A) -> Option<Affine3A> {
    let m = affine.matrix3;
    let columns = [m.x_axis, m.y_axis, m.z_axis].map(|axis| axis.as_dvec3());
    let (normal, area) = largest_cross(columns);
    let longest = columns.map(DVec3::length).into_iter().fold(0.0, f64::max);
    let volume = columns[0].dot(columns[1].cross(columns[2])).abs();
    if !(volume < FLAT * area * longest && area > FLAT * longest * longest) {
        return None;
    }
    let columns = columns.map(|axis| axis - normal * normal.dot(axis));
    let rows = DMat3::from_cols(columns[0], columns[1], columns[2]).transpose();
    let (lost, _) = largest_cross([rows.x_axis, rows.y_axis, rows.z_axis]);
    let cofactors = DMat3::from_cols(
        columns[1].cross(columns[2]),
        columns[2].cross(columns[0]),
        columns[0].cross(columns[1]),
    );
    let lost = lost * normal.dot(cofactors * lost).signum();
    let cancelling = (0..3).map(|axis| lost[axis].abs() * columns[axis].length());
    let thickness = (CANCELLING * cancelling.fold(0.0, f64::max))
        .clamp(THICKNESS * longest, GREATEST_THICKNESS * longest);
    let thickness = normal * thickness;
    let thick = DMat3::from_cols(
        columns[0] + thickness * lost.x,
        columns[1] + thickness * lost.y,
        columns[2] + thickness * lost.z,
    );
    let plate = Affine3A {
        matrix3: thick.as_mat3().into(),
        translation: affine.translation,
    };
    // In `f32` the volume of a tilted plate is less than the rounding of its terms.
    let m = plate.matrix3;
    let [x, y, z] = [m.x_axis, m.y_axis, m.z_axis].map(|axis| axis.as_dvec3());
    let volume = x.dot(y.cross(z)) as f32;
    (volume > 0.0 && volume.is_finite()).then_some(plate)
}

/// The longest cross product of two of three vectors, at unit length, and its length.
fn largest_cross([x, y, z]: [DVec3; 3]) -> (DVec3, f64) {
    let longest = [y.cross(z), z.cross(x), x.cross(y)]
        .into_iter()
        .fold(DVec3::ZERO, |longest, cross| {
            if cross.length_squared() > longest.length_squared() {
                cross
            } else {
                longest
            }
        });
    (longest.normalize_or_zero(), longest.length())
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy_transform::prelude::Transform;
    use glam::{Mat3, Mat3A, Quat, Vec3};

    fn of(transform: Transform) -> Option<Affine3A> {
        placed(&transform.into(), false)
    }

    #[test]
    fn what_keeps_volume_stays_as_it_is() {
        let turned = Quat::from_rotation_x(0.3);
        for scale in [Vec3::ONE, Vec3::new(-1.0, 1e3, 1e-2), Vec3::new(1.0, 1e-5, 1.0)] {
            let transform = Transform::from_rotation(turned).with_scale(scale);
            assert_eq!(of(transform), Some(GlobalTransform::from(transform).affine()));
        }
    }

    /// The cheap test and the exact one agree on transforms of all sizes and thicknesses.
    #[test]
    fn thick_ones_are_never_flat() {
        let turned = Quat::from_euler(glam::EulerRot::XYZ, 0.3, 1.1, -0.4);
        let mut found = [0; 2];
        for size in -20..=20 {
            for thickness in -10..=0 {
                let scale = Vec3::new(1.0, -0.7, 10f32.powi(thickness)) * 10f32.powi(size);
                let transform = Transform::from_rotation(turned).with_scale(scale);
                let affine = GlobalTransform::from(transform).affine();
                let is_thick = is_thick(&affine);
                found[usize::from(is_thick)] += 1;
                assert!(
                    !is_thick || (flattened(&affine).is_none() && has_volume(&affine)),
                    "{scale}"
                );
            }
        }
        assert!(found[0] > 100 && found[1] > 50, "{found:?}");
    }

    #[test]
    fn flat_ones_are_plates_that_keep_the_rest() {
        let turns = [
            Quat::IDENTITY,
            Quat::from_euler(glam::EulerRot::XYZ, 0.3, 1.1, -0.4),
        ];
        for (turn, inner) in turns.into_iter().flat_map(|a| turns.map(|b| (a, b))) {
            for scale in [
                Vec3::new(1.0, 0.0, 1.0),
                Vec3::new(0.0, 2.0, -0.5),
                Vec3::new(1.0, 1.0, -0.0),
            ] {
                let outer = Transform::from_rotation(turn).with_scale(scale);
                let flat = GlobalTransform::from(outer) * Transform::from_rotation(inner);
                let plate = placed(&flat, false).unwrap();
                let determinant = volume(&plate);
                assert!(determinant > 1e-10 && determinant < 1e-4, "{determinant}");
                if inner == Quat::IDENTITY {
                    assert!(determinant < 1e-8, "{determinant}");
                }
                let moved =
                    |a: Mat3A, b: Mat3A| (a.x_axis - b.x_axis).length().max((a.y_axis - b.y_axis).length());
                assert!(moved(plate.matrix3, flat.affine().matrix3) < 3e-5);
            }
        }
    }

    fn volume(affine: &Affine3A) -> f64 {
        Mat3::from(affine.matrix3).as_dmat3().determinant()
    }

    /// Plates of all sizes and tilts have a side that is the same as that of the thin object.
    #[test]
    fn plates_have_the_fronts_of_thin_objects() {
        let mut tilt = 0.0;
        for size in (-8..=8).map(|size| 10f32.powi(size)) {
            for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
                for sign in [1.0, -1.0] {
                    tilt += 0.37;
                    let turn = Quat::from_euler(glam::EulerRot::XYZ, tilt, 1.7 * tilt, -tilt);
                    let rest = Vec3::new(1.0, 0.3, 0.8) - axis * Vec3::new(1.0, 0.3, 0.8);
                    let flat = Transform::from_rotation(turn).with_scale(rest * size * sign);
                    let thin = flat.with_scale((rest * sign + axis * 0.01) * size);
                    let plate = of(flat).expect("it has an area");
                    let plate_volume = volume(&plate);
                    assert!(plate_volume > 0.0, "{flat:?}");
                    // A normal along the lost axis goes to the same side of the plane.
                    let normal = |affine: &Affine3A| {
                        let inverse = Mat3::from(affine.matrix3).as_dmat3().inverse();
                        (inverse.transpose() * axis.as_dvec3()).normalize()
                    };
                    let thin = normal(&GlobalTransform::from(thin).affine());
                    assert!(normal(&plate).dot(thin) > 0.99999, "{flat:?}: {plate:?}");
                }
            }
        }
    }

    #[test]
    fn lines_points_and_what_is_not_finite_are_left_out_but_for_skins() {
        for scale in [Vec3::ZERO, Vec3::X, Vec3::splat(1e-30), Vec3::splat(1e30)] {
            let transform = Transform::from_xyz(1.0, 2.0, 3.0).with_scale(scale);
            assert_eq!(of(transform), None, "{scale}");
            // The joints alone count for a scale that `f32` cannot hold, too.
            let skinned = placed(&transform.into(), true).unwrap();
            assert_eq!(skinned, Affine3A::from_translation(Vec3::new(1.0, 2.0, 3.0)));
        }
        let broken = Transform::from_xyz(f32::NAN, 0.0, 0.0);
        assert_eq!(placed(&broken.into(), true), None);
    }
}
