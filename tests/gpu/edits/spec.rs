//! The description of a small scene, from which a world can be made or brought up to date.

use std::sync::{Arc, LazyLock};

use antumbra::geometry::Aabb;
use antumbra::prelude::*;
use antumbra::scene::{
    BarnMap, BlurredGround, ExtraBounds, IgnoresScale, LightDistance, LightShape, LightWeights, MorphTarget,
    MorphWeights, ShadowOrigin, ShadowSoftness, ShadowTint, Submesh, SurfaceWeights, Texture, TextureWrap,
};
use antumbra::sets::OcclusionSettings;
use bevy_transform::prelude::Transform;
use glam::{UVec2, Vec2, Vec3, Vec4};

/// A mesh: one of [`SHAPES`], and the factor by which its positions are scaled.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    pub at: usize,
    pub grown: f32,
}

impl Shape {
    pub fn build(&self) -> Arc<MeshData> {
        if self.grown == 1.0 {
            return SHAPES[self.at].clone();
        }
        let mut mesh = MeshData::clone(&SHAPES[self.at]);
        mesh.positions
            .iter_mut()
            .for_each(|position| *position *= self.grown);
        Arc::new(mesh)
    }
}

/// Shapes from which objects choose.
pub static SHAPES: LazyLock<Vec<Arc<MeshData>>> = LazyLock::new(|| {
    let cuboid = MeshData::cuboid(Vec3::splat(0.4));
    let mut halves = cuboid.clone();
    let half = cuboid.indices.len() as u32 / 2;
    halves.submeshes = [0, half]
        .map(|first_index| Submesh {
            first_index,
            index_count: half,
        })
        .to_vec();
    let mut inverted = MeshData::cuboid(Vec3::splat(0.55));
    inverted
        .indices
        .chunks_mut(3)
        .for_each(|corners| corners.swap(0, 1));
    let mut twin = MeshData::icosphere(0.35, 1);
    let count = twin.indices.len() as u32;
    twin.indices
        .extend(twin.indices.clone().chunks(3).flat_map(|c| [c[1], c[0], c[2]]));
    twin.submeshes.push(Submesh {
        first_index: count,
        index_count: count,
    });
    let mut card = MeshData::plane(0.7);
    card.uv0 = [(0.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, 0.0)]
        .map(Vec2::from)
        .to_vec();
    let mut morphing = MeshData::icosphere(0.4, 1);
    morphing.morph_targets.push(MorphTarget {
        positions: vec![Vec3::new(0.1, 0.7, 0.0); morphing.positions.len()],
        ..Default::default()
    });
    let mut skinned = MeshData::cuboid(Vec3::splat(0.3));
    skinned.joints = vec![[0; 4]; skinned.positions.len()];
    skinned.joint_weights = vec![Vec4::X; skinned.positions.len()];
    let mut torn = MeshData::icosphere(0.4, 1);
    torn.positions[3] = Vec3::NAN;
    let all = [
        cuboid,
        MeshData::icosphere(0.4, 1),
        card,
        MeshData::cuboid(Vec3::new(1.3, 1.3, 0.05)),
        halves,
        inverted,
        MeshData::plane(5.0),
        morphing,
        skinned,
        torn,
        twin,
        MeshData::default(),
    ];
    all.map(Arc::new).into()
});

/// Pictures with holes, and one that is a hole altogether.
pub static TEXTURES: LazyLock<[Arc<Texture>; 2]> = LazyLock::new(|| {
    [[255, 0, 0, 255], [0; 4]].map(|alphas: [u8; 4]| {
        Arc::new(Texture {
            name: "holes".to_owned(),
            width: 2,
            height: 2,
            rgba8: alphas.iter().flat_map(|&alpha| [200, 200, 200, alpha]).collect(),
            wrap: [TextureWrap::Clamp; 2],
            linear_magnify: false,
            linear_minify: false,
        })
    })
});

/// Pictures of cookies.
pub static IMAGES: LazyLock<[Arc<CookieImage>; 2]> = LazyLock::new(|| {
    [Vec3::new(1.0, 0.3, 0.1), Vec3::new(0.1, 0.5, 1.0)].map(|color| {
        let texels = [color, Vec3::ZERO, Vec3::ZERO, color].to_vec();
        CookieImage::from_linear("checks", 2, 2, texels).expect("four texels")
    })
});

/// Profiles of lamps.
pub static PROFILES: LazyLock<[LightProfile; 2]> = LazyLock::new(|| {
    ["5 4 3", "1 5 0"].map(|candela| {
        let head = "IESNA:LM-63-2002\nTILT=NONE\n1 1000 1 3 1 1 2 0 0 0\n1 1 10\n0 45 90\n0\n";
        LightProfile::from_ies(&format!("{head}{candela}\n")).expect("the file is read")
    })
});

/// An object.
#[derive(Clone, Debug, PartialEq)]
pub struct Thing {
    pub id: u32,
    pub parent: Option<usize>,
    pub place: Transform,
    pub shape: Option<Shape>,
    pub materials: Vec<Material>,
    pub caster: Option<ShadowCaster>,
    pub receiver: Option<ShadowReceiver>,
    pub layers: Option<SelectionLayers>,
    /// Whether it hides others: its own triangles, a proxy, or never.
    pub occluder: Option<u8>,
    pub morph: Option<MorphWeights>,
    /// The pivot that is the only joint of its skin.
    pub skin: Option<usize>,
    pub blurred: Option<BlurredGround>,
    pub extra: Option<ExtraBounds>,
    pub weights: Option<SurfaceWeights>,
    pub cells: Option<Vec<usize>>,
}

/// A light.
#[derive(Clone, Debug, PartialEq)]
pub struct Lamp {
    pub id: u32,
    pub parent: Option<usize>,
    pub place: Transform,
    pub light: Option<Light>,
    pub selection: Option<LightSelection>,
    pub stencil: Option<StencilVolume>,
    pub wedge: Option<PenumbraWedge>,
    pub map: Option<ShadowMap>,
    pub omni: Option<OmniMap>,
    pub perspective: Option<PerspectiveMap>,
    pub smoothie: Option<Smoothie>,
    pub slices: Option<OcclusionTexture>,
    pub shape: Option<LightShape>,
    pub distance: Option<LightDistance>,
    pub weights: Option<LightWeights>,
    pub tint: Option<ShadowTint>,
    pub origin: Option<ShadowOrigin>,
    pub softness: Option<ShadowSoftness>,
    pub barn_map: Option<BarnMap>,
    pub cookie: Option<Cookie>,
    pub profile: Option<usize>,
}

impl Lamp {
    pub fn new(id: u32) -> Self {
        Self {
            id,
            parent: None,
            place: Transform::from_xyz(1.0, 3.0, 1.0).looking_at(Vec3::ZERO, Vec3::Z),
            light: Some(Light::point(Vec3::ONE, 20.0, 20.0)),
            selection: None,
            stencil: None,
            wedge: None,
            map: None,
            omni: None,
            perspective: None,
            smoothie: None,
            slices: None,
            shape: None,
            distance: None,
            weights: None,
            tint: None,
            origin: None,
            softness: None,
            barn_map: None,
            cookie: None,
            profile: None,
        }
    }

    pub fn without_technique(&mut self) {
        self.stencil = None;
        self.wedge = None;
        self.map = None;
        self.omni = None;
        self.perspective = None;
        self.smoothie = None;
        self.slices = None;
    }
}

impl Thing {
    pub fn new(id: u32, at: usize) -> Self {
        Self {
            id,
            parent: None,
            place: Transform::IDENTITY,
            shape: Some(Shape { at, grown: 1.0 }),
            materials: vec![Material::matte(Vec3::splat(0.7)); 2],
            caster: Some(ShadowCaster),
            receiver: Some(ShadowReceiver),
            layers: None,
            occluder: None,
            morph: None,
            skin: None,
            blurred: None,
            extra: None,
            weights: None,
            cells: None,
        }
    }
}

/// Everything that a frame depends on.
#[derive(Clone, Debug, PartialEq)]
pub struct Spec {
    pub things: Vec<Thing>,
    pub lamps: Vec<Lamp>,
    pub pivots: [Transform; 2],
    pub camera: Option<Camera>,
    pub eye: Transform,
    pub ignores_scale: Option<IgnoresScale>,
    pub size: UVec2,
    pub culling: FaceCulling,
    pub culled: CulledCasters,
    pub occlusion: OcclusionSettings,
    pub ambient: Vec3,
    pub scissor: bool,
    pub depth_bounds: bool,
    pub cells: [Option<(Vec3, Transform, u32)>; 2],
    pub portal: Option<(Transform, bool)>,
}

/// Bounds beyond a mesh.
pub fn extra() -> ExtraBounds {
    ExtraBounds(Aabb::around(Vec3::ZERO, Vec3::splat(1.5)))
}
