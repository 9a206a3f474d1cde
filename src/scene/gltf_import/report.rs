//! Records what was left out of a glTF file that was loaded all the same.

use std::fmt;

/// A part of a glTF file, named by its index in the file.
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
        /// Index of the mesh.
        mesh: usize,
        /// Index of the primitive within the mesh.
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
        /// Index of the animation.
        animation: usize,
        /// Index of the channel within the animation.
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

/// The kind of content that was left out or repaired.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum SkipKind {
    /// A primitive of points or lines, which has no surface. Counts primitives.
    DrawMode,
    /// A primitive without triangles, or whose triangles all lack area. Counts primitives.
    EmptyPrimitive,
    /// Triangles with a corner that is not finite. Counts triangles.
    NonFiniteTriangle,
    /// Indices at the end that do not fill a triangle. Counts indices.
    IncompleteTriangle,
    /// Vertex data that was repaired because it was not finite, had no length, named more than four joints or was
    /// missing, or whose meaning is lost. Counts vertices.
    VertexData,
    /// A node with a mesh at or below it whose transform leaves no area, or a node whose transform is not finite. It is
    /// loaded, but its objects are not drawn. Counts nodes.
    NodeTransform,
    /// A node or mesh whose skin or morph weights do not fit. Counts nodes, meshes or inverse bind matrices.
    NodeMesh,
    /// An instance of a node's mesh that is not drawn, or a node whose mesh is drawn once although it has instances.
    /// Counts instances, or nodes.
    Instance,
    /// A node that a scene lists twice, or although it has a parent. Counts such entries.
    SceneRoot,
    /// A node whose extras cannot be read. The file then has no cells and no portals. Counts nodes.
    Visibility,
    /// A texture that a material has to do without, or for which a primitive has no coordinates. Counts textures, images
    /// or materials.
    Texture,
    /// A material number that was out of range and was clamped, or that cannot be read. Counts numbers.
    MaterialValue,
    /// A camera whose numbers make no projection. Counts cameras.
    Camera,
    /// A light whose numbers are not usable. It is loaded and lights nothing. Counts lights.
    Light,
    /// A light's number that was out of range and was clamped. Counts lights.
    LightValue,
    /// An animation channel that cannot be read or that targets no node. Counts channels.
    AnimationChannel,
    /// An extension in use that is neither supported nor required, that says nothing readable of a node, or whose data is
    /// broken while its primitive or buffer view has other data. Counts extensions, or such elements.
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
            Self::Instance => "instance",
            Self::SceneRoot => "scene root",
            Self::Visibility => "visibility extras",
            Self::Texture => "texture",
            Self::MaterialValue => "material value",
            Self::Camera => "camera",
            Self::Light => "light",
            Self::LightValue => "light value",
            Self::AnimationChannel => "animation channel",
            Self::Extension => "extension",
        })
    }
}

/// One entry of a [`Report`]: content that was left out or repaired.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Skip {
    /// Kind of the content.
    pub kind: SkipKind,
    /// The part of the file that holds the content.
    pub element: Element,
    /// How many; [`SkipKind`] says what is counted.
    pub count: usize,
    /// Why the content was left out or repaired.
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

/// Everything that was left out or repaired, in the order of loading. `Display` prints one line for each
/// entry.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Report {
    /// The entries, in the order of loading.
    pub skips: Vec<Skip>,
}

impl Report {
    /// Sum of the counts of all entries of one kind.
    pub fn count(&self, kind: SkipKind) -> usize {
        self.skips
            .iter()
            .filter(|skip| skip.kind == kind)
            .map(|skip| skip.count)
            .sum()
    }

    /// Whether nothing was left out or repaired.
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
