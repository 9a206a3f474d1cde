//! What is wrong with a file of a profile or a picture is said with the line or the texel.

use std::path::Path;

use antumbra::scene::{CookieImage, LightProfile};
use glam::Vec3;

use super::cookies::folder;
use super::files::{PlaneSymmetry, eulumdat, ies};

/// An IES file whose lines are known.
const IES: &str =
    "IESNA:LM-63-2002\n[TEST] 1\nTILT=NONE\n1 1000 1 3 2 1 2 0 0 0\n1 1 10\n0 45 90\n0 90\n5 4 3\n5 4 2\n";

/// Asserts that a text with one line replaced is refused in that line.
#[track_caller]
fn refused(
    text: &str,
    line: usize,
    by: &str,
    read: fn(&str) -> Result<LightProfile, antumbra::scene::ProfileError>,
    said: &str,
) {
    let mut lines: Vec<&str> = text.lines().collect();
    lines[line - 1] = by;
    let error = read(&lines.join("\n"))
        .err()
        .unwrap_or_else(|| panic!("line {line}: {by:?} is accepted"));
    let message = error.to_string();
    assert!(message.contains(said), "{message}");
    assert_eq!(error.line, line, "{message}");
}

#[test]
fn a_wrong_line_of_an_ies_file_is_named() {
    let read = LightProfile::from_ies;
    assert!(read(IES).is_ok());
    refused(
        IES,
        4,
        "1 1000 x 3 2 1 2 0 0 0",
        read,
        "multiplier of candelas is \"x\"",
    );
    refused(IES, 4, "1 1000 1 1 2 1 2 0 0 0", read, "vertical angles is 1");
    refused(IES, 4, "1 1000 1 3.5 2 1 2 0 0 0", read, "vertical angles is 3.5");
    refused(IES, 4, "1 1000 1 3 2 4 2 0 0 0", read, "type of photometry is 4");
    refused(IES, 6, "0 90 45", read, "follows 90");
    refused(IES, 6, "0 45 190", read, "vertical angle is 190");
    refused(IES, 7, "0 77", read, "go from 0° to 77°");
    refused(IES, 8, "5 NaN 3", read, "an intensity is \"NaN\"");
    refused(IES, 9, "5 -4 2", read, "an intensity is -4");
    refused(IES, 9, "5 4", read, "ends before an intensity");
    let dark = IES.replace("5 4 3", "0 0 0").replace("5 4 2", "0 0 0");
    assert!(read(&dark).is_err_and(|error| error.to_string().contains("would be dark")));
    for text in ["", "IESNA91\n1 2 3\n", "\u{0}\u{1}"] {
        assert!(read(text).is_err_and(|error| error.to_string().contains("TILT=")));
    }
}

#[test]
fn a_wrong_line_of_a_eulumdat_file_is_named() {
    let read = LightProfile::from_eulumdat;
    let text = eulumdat(PlaneSymmetry::None, 90.0, 90.0);
    assert!(read(&text).is_ok());
    refused(&text, 3, "7", read, "symmetry is 7");
    refused(&text, 3, "many", read, "symmetry is \"many\"");
    refused(&text, 4, "0", read, "C-planes is 0");
    refused(&text, 6, "1", read, "angles in a plane is 1");
    refused(&text, 44, "0", read, "follows");
    let first_value = 42 + 4 + 3 + 1;
    refused(&text, first_value, "-1", read, "an intensity is -1");
    let lines: Vec<&str> = text.lines().collect();
    for count in 0..lines.len() {
        let error = read(&lines[..count].join("\n")).expect_err("it is cut off");
        assert!(
            error.to_string().contains("ends before"),
            "{count} lines: {error}"
        );
    }
    let odd = eulumdat(PlaneSymmetry::None, 120.0, 90.0);
    let mut lines: Vec<&str> = odd.lines().collect();
    lines[2] = "4";
    let error = read(&lines.join("\n")).expect_err("3 planes have no such symmetry");
    assert!(
        error.line == 4 && error.to_string().contains("multiple of 4"),
        "{error}"
    );
}

#[test]
fn files_without_a_known_ending_or_content_are_named() {
    let path = folder().join("lamp.txt");
    std::fs::write(&path, "").expect("written");
    let error = LightProfile::load(&path)
        .expect_err("the ending is unknown")
        .to_string();
    assert!(error.contains("lamp.txt") && error.contains(".ies"), "{error}");
    let error = LightProfile::load(Path::new("/nowhere/lamp.ies")).expect_err("it is not there");
    assert!(error.to_string().contains("/nowhere/lamp.ies"));
    let path = folder().join("Lampe.IES");
    // Names in any encoding are no numbers.
    let mut bytes = ies(PlaneSymmetry::Axis, 1.0, 5.0).into_bytes();
    bytes.splice(18..18, *b"[LAMP] \xd6sterreich\n");
    std::fs::write(&path, bytes).expect("written");
    assert!(LightProfile::load(&path).is_ok());
}

#[test]
fn pictures_of_all_depths_are_read_and_others_named() {
    let path = folder().join("no-picture.png");
    std::fs::write(&path, "no picture").expect("written");
    let error = CookieImage::load(&path).expect_err("it is none").to_string();
    assert!(error.contains("no-picture.png"), "{error}");
    let error = CookieImage::load(Path::new("/nowhere/a.png")).expect_err("it is not there");
    assert!(error.to_string().contains("/nowhere/a.png"));

    let save = |name: &str, picture: image::DynamicImage| {
        let path = folder().join(name);
        picture.save(&path).expect("written");
        CookieImage::load(&path).expect("read").texels()[0]
    };
    let close = |a: Vec3, b: f32| (a - b).abs().max_element() < 1e-5;
    let grey8 = image::GrayImage::from_pixel(3, 1, image::Luma([188]));
    assert!(close(save("grey8.png", grey8.into()), 0.502_886_5));
    let grey16 = image::ImageBuffer::<image::Luma<u16>, _>::from_pixel(1, 2, image::Luma([48_316u16]));
    assert!(close(save("grey16.png", grey16.into()), 0.502_886_5));
    let clear = image::RgbaImage::from_pixel(1, 1, image::Rgba([255, 255, 255, 51]));
    assert!(
        close(save("clear.png", clear.into()), 0.2),
        "alpha holds light back"
    );
    let linear = image::Rgb32FImage::from_pixel(1, 1, image::Rgb([3.5; 3]));
    assert!(
        close(save("linear.exr", linear.into()), 3.5),
        "OpenEXR is linear and may be bright"
    );

    let wrong = |width, height, texels| CookieImage::from_linear("mine", width, height, texels);
    let error = wrong(2, 1, vec![Vec3::ONE, Vec3::new(0.0, f32::NAN, 0.0)])
        .expect_err("NaN")
        .to_string();
    assert!(error.contains("mine: texel (1, 0)"), "{error}");
    assert!(wrong(1, 1, vec![Vec3::splat(-1.0)]).is_err() && wrong(1, 1, vec![Vec3::splat(7e4)]).is_err());
    assert!(wrong(0, 0, vec![]).is_err() && wrong(2, 2, vec![Vec3::ONE]).is_err());
}
