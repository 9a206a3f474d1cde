//! The textures in which the coverage of edges is summed.

/// The number and the format of the textures into which sums are blended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// One 32-bit float in each layer.
    Float,
    /// One half float in each layer.
    Half,
    /// Four 32-bit floats in each layer: sums by colour and by area.
    Color,
    /// Four half floats in each layer: sums by colour and by area, for devices that cannot blend 32-bit
    /// floats.
    HalfColor,
    /// 32-bit floats: the sum with the count of hard shadows, and places on the light.
    Sampled(Sampled),
    /// Two textures of four bytes in each layer.
    Split8,
}

impl Form {
    /// Returns the formats of the textures.
    pub fn formats(self) -> &'static [wgpu::TextureFormat] {
        match self {
            Self::Float => &[wgpu::TextureFormat::R32Float; 2],
            Self::Half => &[wgpu::TextureFormat::R16Float; 2],
            Self::Color => &[wgpu::TextureFormat::Rgba32Float; 2],
            Self::Sampled(sampled) => &[wgpu::TextureFormat::Rgba32Float; 4][..sampled.textures()],
            Self::HalfColor => &[wgpu::TextureFormat::Rgba16Float; 2],
            Self::Split8 => &[wgpu::TextureFormat::Rgba8Unorm; 4],
        }
    }

    /// Returns the places that are counted, if any are.
    pub fn sampled(self) -> Option<Sampled> {
        match self {
            Self::Sampled(sampled) => Some(sampled),
            _ => None,
        }
    }

    /// Whether more than [`MOST_IN_STEPS`](crate::techniques::penumbra_wedge::component::MOST_IN_STEPS) casters may lie one
    /// behind the other.
    pub fn is_deep(self) -> bool {
        self.sampled().is_some_and(|sampled| sampled.is_deep)
    }

    /// Returns the indices of the textures that hold the averted layer, or the facing layer where both are the same,
    /// and the second texture of a layer, counted from its first.
    pub fn averted_and_second(self) -> (usize, usize) {
        match self {
            Self::Sampled(sampled) => {
                let second = usize::from(sampled.is_dense);
                (usize::from(sampled.is_layered) * (1 + second), second)
            }
            Self::Split8 => (2, 1),
            _ => (1, 0),
        }
    }

    /// Returns whether there are sums by colour.
    pub fn is_textured(self) -> bool {
        matches!(self, Self::Color | Self::HalfColor)
    }
}

/// How places on a light are counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampled {
    /// Whether the layers have sums of their own.
    pub is_layered: bool,
    /// Whether there are 21 places, in two textures for each layer, instead of 9 in one.
    pub is_dense: bool,
    /// Whether there is room for 254 casters one behind the other. Places are then either hidden or not, without steps
    /// between.
    pub is_deep: bool,
}

impl Sampled {
    /// Returns the number of textures of four 32-bit floats.
    pub fn textures(self) -> usize {
        (1 + usize::from(self.is_layered)) * (1 + usize::from(self.is_dense))
    }

    /// Chooses the number of places for a device on which a pixel's targets may have this number of bytes. WebGPU
    /// guarantees 32.
    pub fn dense_if_allowed(is_layered: bool, is_deep: bool, bytes_per_pixel: u32) -> Self {
        let dense = Self {
            is_layered,
            is_dense: true,
            is_deep,
        };
        let is_dense = 16 * dense.textures() as u32 <= bytes_per_pixel;
        Self { is_dense, ..dense }
    }
}
