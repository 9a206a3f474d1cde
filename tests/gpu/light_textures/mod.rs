//! Cookies and luminaire profiles: at every pixel a light gives what their files say, whatever shadows it.

mod changes;
mod cookies;
mod cubes;
mod errors;
mod files;
mod profiles;
mod properties;
mod scenes;
