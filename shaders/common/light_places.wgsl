// Places on a light, of each of which wedges count by how much it is hidden.
// Host    src/techniques/penumbra_wedge/gpu/passes.rs
// Spaces  places on the light: the square from −1 to 1, or the unit disc
#define_import_path antumbra::light_places

#import antumbra::coverage::Seen

// Places on the light, three in each column. `more` is used by dense sums alone.
struct Places {
    first: mat3x3f,
    more: mat4x3f,
}

const NO_MORE = mat4x3f();

// Nine places, spread evenly. On the square they are a lattice with no two in line with a side; on the disc they are
// rings of three and six. For lines across the light, the share of places beyond has the smallest error (0.035 root mean
// square).
const SQUARE_X = Places(
    mat3x3f(
        vec3f(-0.88889, -0.66667, -0.44444),
        vec3f(-0.22222, 0.00000, 0.22222),
        vec3f(0.44444, 0.66667, 0.88889),
    ),
    NO_MORE,
);
const SQUARE_Y = Places(
    mat3x3f(
        vec3f(0.60000, -0.16000, -0.92000),
        vec3f(0.32000, -0.44000, 0.80000),
        vec3f(0.04000, -0.72000, 0.52000),
    ),
    NO_MORE,
);
const DISC_X = Places(
    mat3x3f(
        vec3f(0.30715, -0.29890, -0.00826),
        vec3f(0.80000, 0.40000, -0.40000),
        vec3f(-0.80000, -0.40000, 0.40000),
    ),
    NO_MORE,
);
const DISC_Y = Places(
    mat3x3f(
        vec3f(0.16780, 0.18210, -0.34990),
        vec3f(0.00000, 0.69282, 0.69282),
        vec3f(0.00000, -0.69282, -0.69282),
    ),
    NO_MORE,
);

// Twenty-one places, a lattice on the square and rings of two, seven and twelve on the disc. For lines across the light
// the error is 0.023 on the square and 0.020 on the disc.
const DENSE_SQUARE_X = Places(
    mat3x3f(
        vec3f(-0.95238, -0.85714, -0.76190),
        vec3f(-0.66667, -0.57143, -0.47619),
        vec3f(-0.38095, -0.28571, -0.19048),
    ),
    mat4x3f(
        vec3f(-0.09524, 0.00000, 0.09524),
        vec3f(0.19048, 0.28571, 0.38095),
        vec3f(0.47619, 0.57143, 0.66667),
        vec3f(0.76190, 0.85714, 0.95238),
    ),
);
const DENSE_SQUARE_Y = Places(
    mat3x3f(
        vec3f(0.38095, -0.85714, -0.09524),
        vec3f(0.66667, -0.57143, 0.19048),
        vec3f(0.95238, -0.28571, 0.47619),
    ),
    mat4x3f(
        vec3f(-0.76190, 0.00000, 0.76190),
        vec3f(-0.47619, 0.28571, -0.95238),
        vec3f(-0.19048, 0.57143, -0.66667),
        vec3f(0.09524, 0.85714, -0.38095),
    ),
);
const DENSE_DISC_X = Places(
    mat3x3f(
        vec3f(0.19681, -0.19681, -0.40374),
        vec3f(-0.01663, 0.38300, 0.49422),
        vec3f(0.23328, -0.20332, -0.48682),
    ),
    mat4x3f(
        vec3f(-0.82254, -0.63179, -0.27175),
        vec3f(0.16111, 0.55079, 0.79289),
        vec3f(0.82254, 0.63179, 0.27175),
        vec3f(-0.16111, -0.55079, -0.79289),
    ),
);
const DENSE_DISC_Y = Places(
    mat3x3f(
        vec3f(0.04193, -0.04193, -0.30070),
        vec3f(-0.50314, -0.32670, 0.09575),
        vec3f(0.44610, 0.46053, 0.12817),
    ),
    mat4x3f(
        vec3f(-0.16111, -0.55079, -0.79289),
        vec3f(-0.82254, -0.63179, -0.27175),
        vec3f(0.16111, 0.55079, 0.79289),
        vec3f(0.82254, 0.63179, 0.27175),
    ),
);

// A place is not a point: it changes from visible to hidden over this width, in this number of steps, so that
// none jumps when the light moves. Wider places see less of thin casters, and count casters of one outline as if they
// hid different parts of a place. All are by trial over the models and over posts that overlap.
const PLACE_WIDTH: f32 = 0.2;
const DENSE_PLACE_WIDTH: f32 = 0.1;
const PLACE_STEPS: f32 = 8.0;

// How places are sampled.
struct Sampling {
    is_sphere: bool,
    is_dense: bool,
    steps: f32,                     // steps of one place
}

fn unit_line(line: vec3f) -> vec3f {
    return line * inverseSqrt(max(dot(line.xy, line.xy), 1e-30));
}

// For three places, the part on the positive side of a line of unit normal, in steps.
fn three_beyond(line: vec3f, x: vec3f, y: vec3f, sampling: Sampling) -> vec3f {
    let steps = sampling.steps;
    let scale = steps / select(PLACE_WIDTH, DENSE_PLACE_WIDTH, sampling.is_dense);
    let distance = line.x * x + line.y * y + line.z;
    return round(clamp(distance * scale + 0.5 * steps, vec3f(0.0), vec3f(steps)));
}

// The lines that bound what lies on one side of an edge: one through each of its ends, and its own, whose positive side
// is meant.
struct Sides {
    first: vec3f,
    last: vec3f,
    beyond: vec3f,
}

// For three places, the part between the lines through the ends of an edge and beyond its own line. The steps of the ends
// come in separately: edges that meet at a vertex agree on them, so they cancel around a loop.
fn three_between(sides: Sides, x: vec3f, y: vec3f, sampling: Sampling) -> vec3f {
    let between = abs(three_beyond(sides.first, x, y, sampling) - three_beyond(sides.last, x, y, sampling));
    return round(between * three_beyond(sides.beyond, x, y, sampling) / sampling.steps);
}

fn places_x(sampling: Sampling) -> Places {
    if sampling.is_dense {
        if sampling.is_sphere {
            return DENSE_DISC_X;
        }
        return DENSE_SQUARE_X;
    }
    if sampling.is_sphere {
        return DISC_X;
    }
    return SQUARE_X;
}

fn places_y(sampling: Sampling) -> Places {
    if sampling.is_dense {
        if sampling.is_sphere {
            return DENSE_DISC_Y;
        }
        return DENSE_SQUARE_Y;
    }
    if sampling.is_sphere {
        return DISC_Y;
    }
    return SQUARE_Y;
}

// For all places, the part behind the edge as seen from the centre, in steps.
fn places_behind(seen: Seen, sampling: Sampling) -> Places {
    let line = cross(seen.first, seen.last);
    let sides = Sides(
        unit_line(vec3f(-seen.first.y, seen.first.x, 0.0)),
        unit_line(vec3f(-seen.last.y, seen.last.x, 0.0)),
        unit_line(line * select(1.0, -1.0, line.z > 0.0)),
    );
    return places_between(sides, sampling);
}

// For all places, the part between the lines through the ends of an edge and beyond its own line, in steps.
fn places_between(sides: Sides, sampling: Sampling) -> Places {
    let x = places_x(sampling);
    let y = places_y(sampling);
    var beyond: Places;
    beyond.first = mat3x3f(
        three_between(sides, x.first[0], y.first[0], sampling),
        three_between(sides, x.first[1], y.first[1], sampling),
        three_between(sides, x.first[2], y.first[2], sampling),
    );
    if sampling.is_dense {
        beyond.more = mat4x3f(
            three_between(sides, x.more[0], y.more[0], sampling),
            three_between(sides, x.more[1], y.more[1], sampling),
            three_between(sides, x.more[2], y.more[2], sampling),
            three_between(sides, x.more[3], y.more[3], sampling),
        );
    }
    return beyond;
}

// For all places, the part above the horizon, 0 to 1. The sampling has `PLACE_STEPS`.
fn places_above(horizon: vec3f, sampling: Sampling) -> Places {
    let line = unit_line(horizon);
    let x = places_x(sampling);
    let y = places_y(sampling);
    var above: Places;
    above.first = mat3x3f(
        three_beyond(line, x.first[0], y.first[0], sampling),
        three_beyond(line, x.first[1], y.first[1], sampling),
        three_beyond(line, x.first[2], y.first[2], sampling),
    ) * (1.0 / PLACE_STEPS);
    if sampling.is_dense {
        above.more = mat4x3f(
            three_beyond(line, x.more[0], y.more[0], sampling),
            three_beyond(line, x.more[1], y.more[1], sampling),
            three_beyond(line, x.more[2], y.more[2], sampling),
            three_beyond(line, x.more[3], y.more[3], sampling),
        ) * (1.0 / PLACE_STEPS);
    }
    return above;
}
