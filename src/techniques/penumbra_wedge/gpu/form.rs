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
    /// Four 32-bit floats for both layers together: the sum with the count of hard shadows, and nine places
    /// on the light.
    Sampled,
    /// Four 32-bit floats in each layer: the sum with the count of hard shadows, and nine places on the
    /// light.
    SampledLayers,
    /// Four 32-bit floats as for [`Form::Sampled`], with room for 254 casters one behind the other. Places are either hidden
    /// or not, without steps between.
    Deep,
    /// Four 32-bit floats in each layer, as for [`Form::Deep`].
    DeepLayers,
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
            Self::Sampled | Self::Deep => &[wgpu::TextureFormat::Rgba32Float; 1],
            Self::SampledLayers | Self::DeepLayers => &[wgpu::TextureFormat::Rgba32Float; 2],
            Self::HalfColor => &[wgpu::TextureFormat::Rgba16Float; 2],
            Self::Split8 => &[wgpu::TextureFormat::Rgba8Unorm; 4],
        }
    }

    /// Returns whether places on the light are counted.
    pub fn is_sampled(self) -> bool {
        matches!(self, Self::Sampled | Self::SampledLayers) || self.is_deep()
    }

    /// Whether more than [`MOST_IN_STEPS`](crate::techniques::penumbra_wedge::component::MOST_IN_STEPS) casters may lie one
    /// behind the other.
    pub fn is_deep(self) -> bool {
        matches!(self, Self::Deep | Self::DeepLayers)
    }

    /// Returns whether there are sums by colour.
    pub fn is_textured(self) -> bool {
        matches!(self, Self::Color | Self::HalfColor)
    }
}
