//! Where slices end, how they fade in, and how they are combined.

use antumbra::insides::occlusion_textures::{
    Shares, SliceFace, Slices, add_overlapping, combine, measured_plane, measured_weight, slice_plane,
    slice_weight,
};
use antumbra::techniques::SliceCombination;
use glam::{DVec2, DVec3};

use super::Random;

#[test]
fn slices_fade_in_without_steps_and_end_where_they_should() {
    for weight in [0.0, 0.5, 1.0] {
        let slices = Slices::new([2.0, 6.0], 8, weight);
        assert!((slices.bottoms[7] - 6.0).abs() < 1e-12);
        let mut before = slices.top;
        for bottom in &slices.bottoms[..8] {
            assert!(*bottom > before, "{weight}: {slices:?}");
            before = *bottom;
        }
        let thickness = |slice: usize| slices.bottoms[slice] - slices.bottoms[slice - 1];
        let ratio = (slices.bottoms[0] - slices.top) / thickness(7);
        assert!(
            if weight == 0.0 {
                (ratio - 1.0).abs() < 1e-9
            } else {
                ratio > 1.5
            },
            "{weight}: {ratio}"
        );
        let face = SliceFace {
            origin: DVec3::ZERO,
            axes: [DVec3::X, DVec3::Y, DVec3::Z],
            scale: DVec2::ONE,
            offset: DVec2::ZERO,
            divisor: DVec2::Y,
            slices,
            farthest: 6.0,
        };
        let record = face.record(DVec3::ZERO);
        for slice in 0..8 {
            let bottom = slices.bottoms[slice] as f32;
            let next = bottom
                + if slice == 7 {
                    thickness(7)
                } else {
                    thickness(slice + 1)
                } as f32;
            let weight = |depth| slice_weight(&record, slice, 8, depth);
            assert_eq!((weight(bottom - 1e-3), weight(next + 1e-3)), (0.0, 1.0));
            assert!((weight(0.5 * (bottom + next)) - 0.5).abs() < 1e-3);
            let top = if slice == 0 {
                slices.top
            } else {
                slices.bottoms[slice - 1]
            } as f32;
            assert_eq!(slice_plane(&record, slice, 0.0), bottom);
            assert!((slice_plane(&record, slice, 1.0) - 0.5 * (top + bottom)).abs() < 1e-5);
        }
    }
}

#[test]
fn slices_combine_as_their_names_say() {
    let all = |combination, values: &[f32]| {
        values
            .iter()
            .fold(0.0, |hidden, more| combine(combination, hidden, *more))
    };
    let values = [0.5, 0.2, 0.7];
    assert!((all(SliceCombination::Product, &values) - (1.0 - 0.5 * 0.8 * 0.3)).abs() < 1e-6);
    assert_eq!(all(SliceCombination::Maximum, &values), 0.7);
    assert_eq!(all(SliceCombination::Sum, &values), 1.0);
    for combination in [
        SliceCombination::Product,
        SliceCombination::Maximum,
        SliceCombination::Sum,
    ] {
        assert!((all(combination, &[0.0, 0.4, 0.0]) - 0.4).abs() < 1e-6);
    }
}

/// Casters behind each other hide once, disjoint ones add up, and unrelated ones multiply.
#[test]
fn overlapping_slices_count_as_the_pictures_show_them() {
    let add = |hidden, own, above, united| add_overlapping(hidden, 1.0, Shares { own, above, united });
    let near = |got: f32, expected: f32| assert!((got - expected).abs() < 1e-5, "{got}, not {expected}");
    near(add(0.3, 0.3, 0.3, 0.3), 0.3);
    near(add(0.3, 0.3, 0.3, 0.6), 0.6);
    near(add(0.3, 0.4, 0.3, 0.3 + 0.7 * 0.4), 1.0 - 0.7 * 0.6);
    // The receiver is close under a caster that a caster high above hides from the centre of projection.
    near(add(0.4, 1.0, 1.0, 1.0), 1.0);
    // There is no caster in this slice, whatever is above it.
    near(add(0.4, 0.0, 1.0, 1.0), 0.4);
    near(add(0.0, 0.6, 0.9, 0.95), 0.6);
    near(
        add_overlapping(
            0.3,
            0.5,
            Shares {
                own: 0.4,
                above: 0.3,
                united: 0.7,
            },
        ),
        0.5,
    );
}

/// Whatever the pictures show, the result is neither lighter than the darker of both shadows nor darker than their sum.
#[test]
fn overlapping_slices_lie_between_the_maximum_and_the_sum() {
    let mut random = Random::new(4);
    for _ in 0..2000 {
        let [hidden, own, above] = [(); 3].map(|()| random.unit());
        let common = (own + above - 1.0).max(0.0);
        let common = common + (own.min(above) - common) * random.unit();
        let united = own + above - common;
        let got = add_overlapping(hidden, 1.0, Shares { own, above, united });
        let least = combine(SliceCombination::Maximum, hidden, own);
        let most = combine(SliceCombination::Sum, hidden, own);
        assert!(
            got >= least - 1e-5 && got <= most + 1e-5,
            "{hidden} {own} {above} {united}: {got}"
        );
    }
}

/// Shadows begin behind their caster, in its own slice too, and stay as they are where it passes into the next slice.
#[test]
fn measured_casters_shadow_what_is_behind_them() {
    let weight = |below, depth| measured_weight(measured_plane(2.0, 3.0, below), 1.0, depth);
    assert_eq!((weight(0.25, 2.25), weight(0.25, 2.2)), (0.0, 0.0));
    assert_eq!(weight(0.25, 3.1), 1.0);
    assert!((0.3..0.7).contains(&weight(0.25, 2.7)));
    assert_eq!(measured_plane(2.0, 3.0, 1.0), measured_plane(3.0, 4.0, 0.0));
}
