//! The comparisons: each finds exactly the errors put in, and says so when it has nothing to go by.

use antumbra::reference::{
    PrimaryCulling, ReferenceError, VisibilityImage, compare_hard, compare_soft, difference_image, edge_band,
    hard_visibility, primary_hits_culled, soft_visibility,
};
use antumbra::scene::{LightKind, MeshData};
use bevy_transform::prelude::Transform;
use glam::{UVec2, Vec3};

use super::harness::*;

/// 12 × 8: left half lit, right half dark, a corner pixel that does not count.
fn half_lit() -> VisibilityImage {
    let values = (0..96).map(|i| match i {
        0 => f32::NAN,
        _ => f32::from(u8::from(i % 12 < 6)),
    });
    VisibilityImage::new(UVec2::new(12, 8), values.collect()).unwrap()
}

fn with(image: &VisibilityImage, changes: &[(usize, f32)]) -> VisibilityImage {
    let mut values = image.values().to_vec();
    for (index, value) in changes {
        values[*index] = *value;
    }
    VisibilityImage::new(image.size(), values).unwrap()
}

#[test]
fn the_band_holds_edges_and_the_border_of_what_counts() {
    let band = edge_band(&half_lit(), 1);
    // Columns 5 and 6 at the edge, 0 and 11 where the image wraps round, and column 1 by the corner.
    let expected = |x: usize, y: usize| [0, 5, 6, 11].contains(&x) || (x == 1 && [0, 1, 7].contains(&y));
    for (index, in_band) in band.iter().enumerate() {
        assert_eq!(*in_band, expected(index % 12, index / 12), "pixel {index}");
    }
    let wide = edge_band(&half_lit(), 2);
    assert!(wide.iter().zip(&band).all(|(wide, band)| *wide || !band));
    assert!(wide[3 * 12 + 4] && !wide[3 * 12 + 3]);
    assert!(edge_band(&half_lit(), 100).iter().all(|in_band| *in_band));
}

#[test]
fn exactly_the_flipped_pixels_are_wrong() {
    let truth = half_lit();
    let same = compare_hard(&truth, &truth).unwrap();
    assert_eq!((same.counted, same.wrong_inner, same.wrong_all), (95, 0, 0));
    assert_eq!(same.share(), Some(0.0));
    // Two off the band, one in it, one that does not count, one off by less than half, one that is no number.
    let row = 3 * 12;
    let got = with(
        &truth,
        &[
            (row + 3, 0.0),
            (row + 8, 1.0),
            (row + 5, 0.0),
            (0, 0.0),
            (row + 2, 0.6),
            (row + 9, f32::NAN),
        ],
    );
    let error = compare_hard(&truth, &got).unwrap();
    assert_eq!((error.wrong_inner, error.wrong_all, error.counted), (3, 4, 95));
    assert_eq!(error.inner, 96 - 4 * 8 - 3);
    assert_eq!(error.share(), Some(3.0 / error.inner as f64));
    assert_eq!(error.share_all(), Some(4.0 / 95.0));
}

#[test]
fn soft_errors_are_those_put_in() {
    let truth = with(&half_lit(), &[(40, 0.5), (41, 0.25)]);
    let same = compare_soft(&truth, &truth).unwrap().unwrap();
    assert_eq!(
        (same.counted, same.penumbra, same.rmse, same.p99),
        (95, 2, 0.0, 0.0)
    );
    // Lit pixel 38 darkened by 0.25, dark pixel 44 lit by 0.5, penumbra pixel 40 off by 0.25.
    let got = with(&truth, &[(38, 0.75), (44, 0.5), (40, 0.75), (0, 0.3)]);
    let error = compare_soft(&truth, &got).unwrap().unwrap();
    assert!((error.rmse - (0.375f64 / 95.0).sqrt()).abs() < 1e-12);
    assert!((error.rmse_penumbra - (0.0625f64 / 2.0).sqrt()).abs() < 1e-12);
    assert_eq!(error.penumbra_rmse(), Some(error.rmse_penumbra));
    assert!((error.umbra_lit - 1.0 / 95.0).abs() < 1e-12 && (error.lit_dark - 1.0 / 95.0).abs() < 1e-12);
    // numpy: quantile 0.99 of 92 zeros, 0.25, 0.25, 0.5 is at place 93.06.
    assert!((error.p99 - (0.25 + 0.06 * 0.25)).abs() < 1e-9, "{}", error.p99);
}

#[test]
fn without_a_penumbra_its_error_is_unknown() {
    let error = compare_soft(&half_lit(), &with(&half_lit(), &[(38, 0.75)]));
    let error = error.unwrap().unwrap();
    assert!(error.rmse > 0.0);
    assert_eq!((error.penumbra, error.penumbra_rmse()), (0, None));
}

#[test]
fn without_pixels_there_is_no_verdict() {
    for size in [UVec2::ZERO, UVec2::new(4, 4)] {
        let nothing = VisibilityImage::new(size, vec![f32::NAN; (size.x * size.y) as usize]).unwrap();
        let hard = compare_hard(&nothing, &nothing).unwrap();
        assert_eq!((hard.share(), hard.share_all()), (None, None));
        assert_eq!(compare_soft(&nothing, &nothing).unwrap(), None);
    }
    let (truth, got) = (half_lit(), VisibilityImage::new(UVec2::ONE, vec![1.0]).unwrap());
    assert!(matches!(
        compare_hard(&truth, &got),
        Err(ReferenceError::Size { .. })
    ));
    assert!(compare_soft(&truth, &got).is_err() && difference_image(&truth, &got).is_err());
    let short = VisibilityImage::new(UVec2::new(3, 3), vec![1.0; 8]);
    assert!(matches!(short, Err(ReferenceError::ValueCount { values: 8, .. })));
    assert_eq!((truth.get(11, 7), truth.get(12, 0)), (Some(0.0), None));
}

#[test]
fn the_heat_map_shows_grey_green_red_and_a_faint_band() {
    let row = 3 * 12;
    let got = with(&half_lit(), &[(row + 3, 0.0), (row + 5, 0.0)]);
    let image = difference_image(&half_lit(), &got).unwrap();
    let pixel = |index: usize| <[u8; 4]>::try_from(&image.rgba8[index * 4..index * 4 + 4]).unwrap();
    assert_eq!(image.rgba8.len(), 96 * 4);
    assert_eq!(pixel(0), [96, 96, 96, 255]);
    assert_eq!(pixel(row + 2), [0, 255, 0, 255], "lit and right");
    assert_eq!(pixel(row + 8), [0, 128, 0, 255], "dark and right");
    assert_eq!(pixel(row + 3), [255, 0, 0, 255], "wrong");
    let [red, green, ..] = pixel(row + 5);
    assert!(
        red > green && red < 200 && green > 50,
        "wrong in the band is faint"
    );
}

#[test]
fn one_thread_and_many_give_the_same_bits() {
    let scene = scene_of([
        (MeshData::plane(6.0), Transform::IDENTITY),
        (MeshData::icosphere(1.0, 3), Transform::from_xyz(0.0, 1.5, 0.0)),
    ]);
    let lights = [
        light(
            LightKind::Rect {
                width: 1.0,
                height: 2.0,
            },
            Vec3::new(2.0, 5.0, 1.0),
            Vec3::ZERO,
        ),
        light(
            LightKind::Sphere { radius: 0.7 },
            Vec3::new(2.0, 5.0, 1.0),
            Vec3::ZERO,
        ),
        point_light(Vec3::new(2.0, 5.0, 1.0)),
    ];
    let bits = |threads: usize, seed: u64| -> Vec<u32> {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            let eye = looking_at(Vec3::new(0.0, 5.0, 6.0), Vec3::ZERO);
            let hits =
                primary_hits_culled(&scene, &camera(), &eye, SIZE, PrimaryCulling::SingleSided).unwrap();
            let soft = lights
                .iter()
                .map(|light| soft_visibility(&scene, &hits, light, 16, seed));
            let hard = lights.iter().map(|light| hard_visibility(&scene, &hits, light));
            let images: Vec<_> = soft.chain(hard).collect();
            images
                .iter()
                .flat_map(|image| image.values().iter().map(|v| v.to_bits()))
                .collect()
        })
    };
    let one = bits(1, 5);
    assert!(one == bits(4, 5), "threads change the result");
    assert!(one != bits(4, 6), "control: the seed does");
}
