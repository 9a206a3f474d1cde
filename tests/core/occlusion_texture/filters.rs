//! Means over rectangles by the three filters.

use antumbra::insides::occlusion_textures::{
    DENSE_LEVEL, Kernel, Picture, level_count, mipmap_mean, mipmaps, n_buffer_mean, n_buffers,
    reached_levels, spacing, square_mean, summed_areas, summed_mean, tap_count,
};
use glam::{IVec2, Vec2};

use super::Random;

fn picture(side: usize, seed: u64) -> Picture {
    let blobs: Vec<(Vec2, f32)> = {
        let mut random = Random::new(seed);
        (0..12)
            .map(|_| {
                (
                    Vec2::new(random.unit(), random.unit()),
                    0.05 + 0.1 * random.unit(),
                )
            })
            .collect()
    };
    Picture::from_fn(side, |texel: IVec2| {
        let at = (texel.as_vec2() + 0.5) / side as f32;
        let hit = blobs
            .iter()
            .any(|(middle, radius)| at.distance(*middle) < *radius);
        f32::from(u8::from(hit))
    })
}

/// The mean over a kernel by many points.
fn brute_mean(picture: &Picture, kernel: &Kernel) -> f32 {
    let steps = 64;
    let mut sum = 0.0;
    for index in 0..steps * steps {
        let share =
            (Vec2::new((index % steps) as f32, (index / steps) as f32) + 0.5) / steps as f32 * 2.0 - 1.0;
        let at = (kernel.center + share * kernel.half) * picture.side as f32;
        sum += picture.at(at.floor().as_ivec2());
    }
    sum / (steps * steps) as f32
}

/// Kernels inside a picture, at least a texel wide.
fn kernels(aspect: f32) -> Vec<Kernel> {
    let mut random = Random::new(9);
    (0..60)
        .map(|_| {
            let half = Vec2::new(aspect, 1.0) * (0.015 + 0.06 * random.unit());
            let room = Vec2::ONE - 4.0 * half.max(Vec2::splat(half.max_element()));
            let center =
                2.0 * half.max_element() + Vec2::new(random.unit(), random.unit()) * room.max(Vec2::ZERO);
            Kernel { center, half }
        })
        .collect()
}

fn root_mean_square(errors: impl Iterator<Item = f32>) -> f32 {
    let (sum, count) = errors.fold((0.0, 0.0), |(sum, count), error| {
        (sum + error * error, count + 1.0)
    });
    f32::sqrt(sum / count)
}

#[test]
fn filters_give_the_means_over_rectangles_that_points_give() {
    let picture = picture(128, 3);
    let (levels, mips, sums) = (
        n_buffers(picture.clone()),
        mipmaps(picture.clone()),
        summed_areas(picture.clone()),
    );
    println!("aspect  n-buffers  one square  mipmaps  sums: root mean square errors of 60 kernels");
    for aspect in [1.0, 3.0] {
        let kernels = kernels(aspect);
        let taps = tap_count(Vec2::new(aspect, 1.0));
        let error = |of: &dyn Fn(&Kernel) -> f32| {
            root_mean_square(
                kernels
                    .iter()
                    .map(|kernel| of(kernel) - brute_mean(&picture, kernel)),
            )
        };
        let n = error(&|kernel| n_buffer_mean(&levels, kernel, taps));
        let one = error(&|kernel| n_buffer_mean(&levels, kernel, 1));
        let mip = error(&|kernel| mipmap_mean(&mips, kernel));
        let sum = error(&|kernel| summed_mean(&sums, kernel));
        println!("{aspect:>6} {n:>10.4} {one:>11.4} {mip:>8.4} {sum:>7.4}");
        assert!(sum < 0.006, "{aspect}: {sum}");
        assert!(n < 0.04 && n < mip, "{aspect}: {n}, {mip}");
        assert!(taps == 1 || n < 0.7 * one, "{aspect}: {n}, {one}");
    }
}

/// Sums count what lies outside the picture as empty, however far a kernel reaches beyond.
#[test]
fn kernels_beyond_the_border_find_nothing_there() {
    let picture = Picture::from_fn(32, |_| 1.0);
    let (levels, sums) = (n_buffers(picture.clone()), summed_areas(picture));
    for step in 0..40 {
        let center = Vec2::new(0.5 + 0.02 * step as f32, 0.5);
        let kernel = Kernel {
            center,
            half: Vec2::splat(0.125),
        };
        let inside = ((1.0 - (center.x - 0.125)) / 0.25).clamp(0.0, 1.0);
        let sum = summed_mean(&sums, &kernel);
        assert!((sum - inside).abs() < 1e-3, "{step}: {sum}, not {inside}");
        let n = n_buffer_mean(&levels, &kernel, 1);
        assert!(
            (n - inside).abs() < 0.52 && (inside > 0.0 || n == 0.0),
            "{step}: {n}, not {inside}"
        );
    }
}

#[test]
fn small_kernels_reach_few_levels() {
    for (size, levels) in [(0.1, 2), (1.0, 2), (1.9, 2), (2.0, 3), (60.0, 7), (255.0, 9)] {
        assert_eq!(reached_levels(Vec2::splat(size), 1), levels, "{size}");
    }
    assert_eq!(reached_levels(Vec2::new(8.0, 1.0), 8), 2);
    assert_eq!(level_count(256), 9);
}

/// A kernel at any border of the picture that does not touch a caster finds nothing, also where it blends two sizes of
/// squares.
#[test]
fn kernels_at_a_border_find_nothing_beyond_themselves() {
    // Kernels of 24 texels, between squares of 16 and of 32. Casters begin 24 texels from each border.
    let picture = Picture::from_fn(128, |texel| {
        f32::from(u8::from(texel.min_element() >= 24 && texel.max_element() < 104))
    });
    let levels = n_buffers(picture);
    let mean = |center: Vec2| {
        let half = Vec2::splat(12.0 / 128.0);
        n_buffer_mean(&levels, &Kernel { center, half }, 1)
    };
    for step in -12..=8 {
        let beside = step as f32 / 128.0;
        for along in [0.3, 0.5] {
            for center in [Vec2::new(beside, along), Vec2::new(along, beside)] {
                assert_eq!(mean(center), 0.0, "{center}");
                assert!(mean(1.0 - center) < 1e-6, "{center}");
            }
        }
    }
    assert_eq!(mean(Vec2::splat(0.5)), 1.0);
}

/// The exact mean over the square of a level around a place, in texels.
fn exact_mean(sums: &Picture, level: usize, place: Vec2) -> f32 {
    let side = sums.side as f32;
    let half = 0.5 * (1u32 << level) as f32;
    summed_mean(
        sums,
        &Kernel {
            center: place / side,
            half: Vec2::splat(half / side),
        },
    )
}

/// Each value of each level is the mean over the square that begins at its texel. What is outside the picture is empty.
#[test]
fn every_value_of_n_buffers_is_the_mean_over_its_square() {
    let picture = picture(64, 5);
    let (levels, sums) = (n_buffers(picture.clone()), summed_areas(picture));
    assert_eq!(levels.len(), 7);
    for (level, values) in levels.iter().enumerate() {
        let apart = spacing(level as u32) as usize;
        assert_eq!(values.side * apart, 64, "level {level}");
        for (index, value) in values.texels.iter().enumerate() {
            let corner = Vec2::new((index % values.side) as f32, (index / values.side) as f32) * apart as f32;
            let exact = exact_mean(&sums, level, corner + 0.5 * (1u32 << level) as f32);
            assert!(
                (value - exact).abs() < 1e-5,
                "level {level}, {corner}: {value}, not {exact}"
            );
        }
    }
}

/// Lookups between the values of sparse levels are near the exact means. The same bounds find lookups that are off by half of
/// the distance between two values, and lookups in the next level.
#[test]
fn sparse_levels_are_interpolated_to_means_over_squares_around_any_place() {
    let mut random = Random::new(11);
    let pictures = [3, 7, 12].map(|seed| picture(256, seed));
    let looked_up = pictures.map(|picture| (n_buffers(picture.clone()), summed_areas(picture)));
    println!("level    sparse  half a value off  next level: root mean square and largest errors");
    for level in DENSE_LEVEL as usize + 1..7 {
        let half_value = 0.5 * spacing(level as u32) as f32;
        // Squares of the next level must begin inside, too.
        let room = (1 << level) as f32;
        let places: Vec<Vec2> = (0..500)
            .map(|_| room + Vec2::new(random.unit(), random.unit()) * (256.0 - 2.0 * room))
            .collect();
        let error = |shift: f32, level_of_lookup: usize| {
            let of = |(levels, sums): &(Vec<Picture>, Picture)| {
                let off = |place: &Vec2| {
                    square_mean(levels, level_of_lookup, place + shift) - exact_mean(sums, level, *place)
                };
                places.iter().map(off).collect::<Vec<f32>>()
            };
            let errors: Vec<f32> = looked_up.iter().flat_map(of).collect();
            let largest = errors
                .iter()
                .fold(0.0, |largest: f32, error| largest.max(error.abs()));
            (root_mean_square(errors.into_iter()), largest)
        };
        let (right, shifted, next) = (error(0.0, level), error(half_value, level), error(0.0, level + 1));
        println!("{level:>5} {right:.4?} {shifted:.4?} {next:.4?}");
        let is_near = |(mean, largest): (f32, f32)| mean < 0.006 && largest < 0.03;
        assert!(is_near(right), "level {level}: {right:?}");
        assert!(
            !is_near(shifted) && !is_near(next),
            "level {level}: {shifted:?}, {next:?}"
        );
    }
}

/// Where squares leave a full picture, means fall evenly to 0 at all levels.
#[test]
fn squares_beyond_the_last_value_are_empty() {
    let picture = Picture::from_fn(64, |_| 1.0);
    let levels = n_buffers(picture);
    for level in 0..levels.len() {
        let side = (1u32 << level) as f32;
        for step in 0..=40 {
            let corner = 60.0 + 0.125 * step as f32;
            let place = Vec2::new(corner + 0.5 * side, 0.5 * side);
            let expected = ((64.0 - corner) / side).clamp(0.0, 1.0);
            let got = square_mean(&levels, level, place);
            assert!(
                (got - expected).abs() < 1e-5,
                "level {level}, {corner}: {got}, not {expected}"
            );
        }
    }
}
