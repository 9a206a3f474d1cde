//! What was left out of a glTF file that was loaded all the same.

use std::fmt;

/// A part of a glTF file, by its index there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Element {
    /// The file as a whole.
    File,
    /// A buffer.
    Buffer(usize),
    /// A buffer view.
    BufferView(usize),
    /// An accessor.
    Accessor(usize),
    /// An image.
    Image(usize),
    /// A texture: an image with a sampler.
    Texture(usize),
    /// A material.
    Material(usize),
    /// A mesh.
    Mesh(usize),
    /// A primitive of a mesh.
    Primitive {
        /// The mesh.
        mesh: usize,
        /// The primitive within it.
        primitive: usize,
    },
    /// A node.
    Node(usize),
    /// A scene.
    Scene(usize),
    /// A skin.
    Skin(usize),
    /// An animation.
    Animation(usize),
    /// A channel of an animation.
    Channel {
        /// The animation.
        animation: usize,
        /// The channel within it.
        channel: usize,
    },
    /// A camera.
    Camera(usize),
    /// A light of `KHR_lights_punctual`.
    Light(usize),
}

impl fmt::Display for Element {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File => write!(f, "file"),
            Self::Buffer(index) => write!(f, "buffer {index}"),
            Self::BufferView(index) => write!(f, "buffer view {index}"),
            Self::Accessor(index) => write!(f, "accessor {index}"),
            Self::Image(index) => write!(f, "image {index}"),
            Self::Texture(index) => write!(f, "texture {index}"),
            Self::Material(index) => write!(f, "material {index}"),
            Self::Mesh(index) => write!(f, "mesh {index}"),
            Self::Primitive { mesh, primitive } => write!(f, "mesh {mesh} primitive {primitive}"),
            Self::Node(index) => write!(f, "node {index}"),
            Self::Scene(index) => write!(f, "scene {index}"),
            Self::Skin(index) => write!(f, "skin {index}"),
            Self::Animation(index) => write!(f, "animation {index}"),
            Self::Channel { animation, channel } => write!(f, "animation {animation} channel {channel}"),
            Self::Camera(index) => write!(f, "camera {index}"),
            Self::Light(index) => write!(f, "light {index}"),
        }
    }
}

/// What kind of thing was left out or repaired.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum SkipKind {
    /// A primitive of points or lines: it has no surface. Counts primitives.
    DrawMode,
    /// A primitive without a triangle. Counts primitives.
    EmptyPrimitive,
    /// Triangles with a corner that is not finite. Counts triangles.
    NonFiniteTriangle,
    /// Indices at the end that do not fill a triangle. Counts indices.
    IncompleteTriangle,
    /// Vertex data that was repaired: not finite, no length, or more joints than four. Counts vertices.
    VertexData,
    /// A node whose transform leaves no area or is not finite; it is loaded, its objects are not drawn. Counts nodes.
    NodeTransform,
    /// A node whose skin or morph weights do not fit its mesh. Counts nodes.
    NodeMesh,
    /// Extras of a node that cannot be read; the file has no cells and portals then. Counts nodes.
    Visibility,
    /// A texture that a material does without. Counts textures or images.
    Texture,
    /// A material number that is out of range and was clamped. Counts numbers.
    MaterialValue,
    /// A camera that is not a perspective one, or whose numbers make none. Counts cameras.
    Camera,
    /// A light whose numbers cannot shine; it is loaded and lights nothing. Counts lights.
    Light,
    /// An animation channel that moves nothing. Counts channels.
    AnimationChannel,
    /// An extension in use that is not supported and not required. Counts extensions.
    Extension,
}

impl fmt::Display for SkipKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::DrawMode => "points or lines",
            Self::EmptyPrimitive => "empty primitive",
            Self::NonFiniteTriangle => "non-finite triangle",
            Self::IncompleteTriangle => "incomplete triangle",
            Self::VertexData => "vertex data",
            Self::NodeTransform => "node transform",
            Self::NodeMesh => "node mesh",
            Self::Visibility => "visibility extras",
            Self::Texture => "texture",
            Self::MaterialValue => "material value",
            Self::Camera => "camera",
            Self::Light => "light",
            Self::AnimationChannel => "animation channel",
            Self::Extension => "extension",
        })
    }
}

/// One thing that was left out or repaired.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Skip {
    /// What kind of thing.
    pub kind: SkipKind,
    /// Where.
    pub element: Element,
    /// How many; the kind says of what.
    pub count: usize,
    /// Why.
    pub reason: String,
}

impl fmt::Display for Skip {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}: skipped {} {}: {}",
            self.element, self.count, self.kind, self.reason
        )
    }
}

/// Everything that was left out or repaired, in the order of loading. `Display` gives one line each.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Report {
    /// The entries.
    pub skips: Vec<Skip>,
}

impl Report {
    /// Total of one kind.
    pub fn count(&self, kind: SkipKind) -> usize {
        self.skips
            .iter()
            .filter(|skip| skip.kind == kind)
            .map(|skip| skip.count)
            .sum()
    }

    /// Whether nothing was left out.
    pub fn is_empty(&self) -> bool {
        self.skips.is_empty()
    }

    pub(super) fn add(&mut self, kind: SkipKind, element: Element, count: usize, reason: impl Into<String>) {
        self.skips.push(Skip {
            kind,
            element,
            count,
            reason: reason.into(),
        });
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.skips.iter().try_for_each(|skip| writeln!(f, "{skip}"))
    }
}
