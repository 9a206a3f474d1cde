//! Where slices end, how they fade in, and how they are combined.

use antumbra::insides::occlusion_textures::{SliceFace, Slices, combine, slice_plane, slice_weight};
use antumbra::techniques::SliceCombination;
use glam::{DVec2, DVec3};

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
