//! Files of profiles, written from a formula.

use std::fmt::Write as _;

/// Which planes of a luminaire are mirror images of others.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlaneSymmetry {
    None,
    Axis,
    C0,
    C90,
    Four,
}

/// Intensity at a plane's angle and an angle in the plane, degrees. It has the symmetry.
pub fn intensity(symmetry: PlaneSymmetry, c: f64, g: f64) -> f64 {
    let (sin, cos) = c.to_radians().sin_cos();
    let lobe = match symmetry {
        PlaneSymmetry::None => 0.3 * sin + 0.2 * cos + 0.1 * (2.0 * sin * cos),
        PlaneSymmetry::Axis => 0.0,
        PlaneSymmetry::C0 => 0.3 * cos + 0.1 * sin.abs(),
        PlaneSymmetry::C90 => 0.3 * sin + 0.1 * cos * cos,
        PlaneSymmetry::Four => 0.3 * cos.abs() + 0.1 * sin * sin,
    };
    let in_plane = 1.0 + 0.4 * (g.to_radians() * 2.0).cos();
    700.0 * (in_plane + lobe * g.to_radians().sin())
}

fn steps(from: f64, to: f64, step: f64) -> Vec<f64> {
    let count = ((to - from) / step).round() as usize;
    (0..=count).map(|at| from + step * at as f64).collect()
}

/// An IES file of type C. Its numbers break lines in odd places, as those of manufacturers do.
pub fn ies(symmetry: PlaneSymmetry, c_step: f64, g_step: f64) -> String {
    let planes = match symmetry {
        PlaneSymmetry::None => steps(0.0, 360.0, c_step),
        PlaneSymmetry::Axis => vec![0.0],
        PlaneSymmetry::C0 => steps(0.0, 180.0, c_step),
        PlaneSymmetry::C90 => steps(90.0, 270.0, c_step),
        PlaneSymmetry::Four => steps(0.0, 90.0, c_step),
    };
    let gammas = steps(0.0, 180.0, g_step);
    let mut text =
        "IESNA:LM-63-2002\n[TEST] 1\n[MANUFAC] Nobody = anybody\nTILT=INCLUDE\n1\n2\n0 90\n1 1\n".to_owned();
    let _ = writeln!(
        text,
        "1 1000 2.0 {} {} 1 2 0.1 0.1 0 0.5 1.0 100",
        gammas.len(),
        planes.len()
    );
    let candela = planes
        .iter()
        .flat_map(|&c| gammas.iter().map(move |&g| intensity(symmetry, c, g)));
    for (index, value) in gammas.iter().chain(&planes).copied().chain(candela).enumerate() {
        let _ = write!(text, "{value}{}", if index % 7 == 6 { "\r\n" } else { "  " });
    }
    text
}

/// A EULUMDAT file with decimal commas.
pub fn eulumdat(symmetry: PlaneSymmetry, c_step: f64, g_step: f64) -> String {
    let all = steps(0.0, 360.0 - c_step, c_step);
    let count = all.len();
    let measured: Vec<f64> = match symmetry {
        PlaneSymmetry::None => all.clone(),
        PlaneSymmetry::Axis => vec![0.0],
        PlaneSymmetry::C0 => all[..=count / 2].to_vec(),
        PlaneSymmetry::C90 => (0..=count / 2)
            .map(|at| all[(3 * count / 4 + at) % count])
            .collect(),
        PlaneSymmetry::Four => all[..=count / 4].to_vec(),
    };
    let gammas = steps(0.0, 180.0, g_step);
    let indicator = match symmetry {
        PlaneSymmetry::None => 0,
        PlaneSymmetry::Axis => 1,
        PlaneSymmetry::C0 => 2,
        PlaneSymmetry::C90 => 3,
        PlaneSymmetry::Four => 4,
    };
    let mut lines = vec!["Nobody".to_owned(), "1".to_owned(), format!("{indicator}")];
    lines.extend([format!("{count}"), format!("{c_step}")]);
    lines.extend([format!("{}", gammas.len()), format!("{g_step}")]);
    lines.extend(["report", "lamp", "1", "lamp.ldt", "today"].map(str::to_owned));
    lines.extend(
        [
            "100", "100", "50", "90", "90", "0", "0", "0", "0", "50", "80", "1", "0",
        ]
        .map(str::to_owned),
    );
    lines.push("1".to_owned());
    lines.extend(["1", "LED", "2500", "3000", "80", "20"].map(str::to_owned));
    lines.extend((0..10).map(|_| "0,5".to_owned()));
    lines.extend(all.iter().chain(&gammas).map(f64::to_string));
    for &c in &measured {
        // Candela for each 1000 lumens.
        lines.extend(
            gammas
                .iter()
                .map(|&g| (intensity(symmetry, c, g) / 2.5).to_string()),
        );
    }
    lines.iter().map(|line| line.replace('.', ",") + "\r\n").collect()
}
