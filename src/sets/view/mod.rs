//! The view, and the sets F and V.

pub(crate) mod frame_view;
pub(crate) mod frustum;
pub(crate) mod inverted_hulls;
pub(crate) mod invisible;
pub(crate) mod left_out;
pub(crate) mod screen;
pub(crate) mod screen_union;
pub(crate) mod seen_into;
pub(crate) mod stored_depth;
pub(crate) mod view_depth;
pub(crate) mod visible;
pub(crate) mod visible_parts;
