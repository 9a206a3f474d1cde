//! Textures that the coverage of edges is summed in.

/// Textures that sums are blended into.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// A 32-bit float a layer.
    Float,
    /// A half float a layer.
    Half,
    /// Four of them a layer: by colour and area.
    Color,
    /// Four half floats a layer, where the device blends no more.
    HalfColor,
    /// Four floats: a sum and hard shadows, and nine places on the light. All casters are one layer.
    Sampled,
    /// Four floats a layer, as [`Form::Sampled`].
    SampledLayers,
    /// As [`Form::Sampled`], with room for 254 layers one behind the other: places are hidden or not, without steps between.
    Deep,
    /// Four floats a layer, as [`Form::Deep`].
    DeepLayers,
    /// Two textures of four bytes a layer.
    Split8,
}

impl Form {
    /// Formats of the textures.
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

    /// Places on the light are counted.
    pub fn is_sampled(self) -> bool {
        matches!(self, Self::Sampled | Self::SampledLayers) || self.is_deep()
    }

    /// Many layers may lie one behind the other.
    pub fn is_deep(self) -> bool {
        matches!(self, Self::Deep | Self::DeepLayers)
    }

    /// There are sums by colour.
    pub fn is_textured(self) -> bool {
        matches!(self, Self::Color | Self::HalfColor)
    }
}
