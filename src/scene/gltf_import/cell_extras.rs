//! The entries in a glTF node's `extras` about cells, portals and occluders.

use glam::Vec3;
use gltf::json::Value;

/// The entries in a glTF node's `extras` about cells, portals and occluders.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GltfVisibility {
    /// Name of the cell, if the node is a cell.
    pub cell: Option<String>,
    /// The portal, if the node is a portal.
    pub portal: Option<GltfPortal>,
    /// Half of the size of the cell or portal, metres. `None` takes the size of the node's mesh.
    pub half_size: Option<Vec3>,
    /// Names of the cells that the node's mesh is in.
    pub in_cells: Option<Vec<String>>,
    /// Names of the selection layers of the node's mesh and of those below it
    /// ([`LayerNames`](crate::scene::LayerNames)).
    pub layers: Option<Vec<String>>,
    /// Whether the node's mesh hides the objects behind it. `None` leaves the choice to the default rule.
    pub occluder: Option<bool>,
}

/// A portal between two named cells.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GltfPortal {
    /// Names of the two cells that the portal connects.
    pub joins: [String; 2],
    /// Whether the portal can be seen through.
    pub open: bool,
}

impl GltfVisibility {
    /// Whether the node's mesh only gives the shape of a cell or portal and is not drawn.
    pub fn takes_mesh(&self) -> bool {
        (self.cell.is_some() || self.portal.is_some()) && self.half_size.is_none()
    }

    pub(super) fn read(value: &Value) -> Result<Self, String> {
        let Some(value) = value.get("antumbra") else {
            return Ok(Self::default());
        };
        let object = value.as_object().ok_or("antumbra is not an object")?;
        let mut visibility = Self::default();
        for (key, value) in object {
            match key.as_str() {
                "cell" => visibility.cell = Some(name(value)?),
                "portal" => visibility.portal = Some(portal(value)?),
                "half_size" => visibility.half_size = Some(half_size(value)?),
                "in_cells" => {
                    let names = value.as_array().ok_or("in_cells is not a list")?;
                    visibility.in_cells = Some(names.iter().map(name).collect::<Result<_, _>>()?);
                }
                "layers" => {
                    let names = value.as_array().ok_or("layers is not a list")?;
                    let name = |value: &Value| match value.as_str() {
                        Some(name) if !name.is_empty() => Ok(name.to_owned()),
                        _ => Err(format!("{value} is not the name of a layer")),
                    };
                    visibility.layers = Some(names.iter().map(name).collect::<Result<_, _>>()?);
                }
                "occluder" => {
                    visibility.occluder = Some(value.as_bool().ok_or("occluder is not true or false")?)
                }
                other => return Err(format!("antumbra.{other} is not known")),
            }
        }
        if visibility.cell.is_some() && visibility.portal.is_some() {
            return Err("it is both a cell and a portal".to_owned());
        }
        Ok(visibility)
    }
}

fn name(value: &Value) -> Result<String, String> {
    value
        .as_str()
        .map(str::to_owned)
        .ok_or_else(|| format!("{value} is not the name of a cell"))
}

fn portal(value: &Value) -> Result<GltfPortal, String> {
    let joins = value.get("joins").and_then(Value::as_array);
    let [a, b] = joins.map(Vec::as_slice).unwrap_or_default() else {
        return Err("portal.joins is not a list of two cells".to_owned());
    };
    let open = match value.get("open") {
        None => true,
        Some(open) => open.as_bool().ok_or("portal.open is not true or false")?,
    };
    Ok(GltfPortal {
        joins: [name(a)?, name(b)?],
        open,
    })
}

/// Parses `half_size`, a list of two or three positive numbers. A missing third number is 1.
fn half_size(value: &Value) -> Result<Vec3, String> {
    let numbers = value.as_array().map(Vec::as_slice).unwrap_or_default();
    let mut size = Vec3::ONE;
    for (axis, number) in numbers.iter().enumerate().take(3) {
        size[axis] = number.as_f64().unwrap_or(0.0) as f32;
    }
    if !(2..=3).contains(&numbers.len()) || !size.is_finite() || size.min_element() <= 0.0 {
        return Err(format!(
            "half_size is {value}, two or three positive numbers are needed"
        ));
    }
    Ok(size)
}
