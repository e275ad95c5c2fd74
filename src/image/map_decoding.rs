//! How a map's file is decoded: its colour space, the filter of its polar rows, and the quantity that is averaged for its coarser levels.
//!
//! The values here can be compared and hashed: a file and its [`MapDecoding`] together identify a decoded map. Not here: decoding; which map is decoded how
//! (`render::plan::map_decoding`).

use super::{PoleFilter, TexelFormat};

/// How a map's file is decoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MapDecoding {
    /// Format of the texels, which includes their colour space.
    pub format: TexelFormat,
    /// How rows near the poles are filtered.
    pub poles: PoleFilter,
    /// For a map whose texel values shaders convert to opacities: the parameters of the conversion. `None`: a coarser texel has the mean value of its finer
    /// texels.
    pub opacity: Option<OpacityTexels>,
}

impl MapDecoding {
    /// A decoding without a pole filter; coarser levels have the mean values of the finest.
    pub const fn plain(format: TexelFormat) -> Self {
        Self { format, poles: PoleFilter::None, opacity: None }
    }
}

/// The texel values of a clear sky (opacity 0) and of a closed cloud deck (opacity 1), between which opacity rises by `smoothstep`. A coarser
/// texel of such a map has the mean opacity of its finer texels. Because `smoothstep` is not linear, the opacity of their mean value would differ: a body's
/// small image, which reads coarse levels, would be brighter or darker than a large one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct OpacityTexels {
    /// The bits of the f32 value of a clear sky. Bits, unlike floats, can be compared for equality and hashed.
    clear_bits: u32,
    /// The bits of the f32 value of a closed deck.
    closed_bits: u32,
}

impl OpacityTexels {
    /// Texel values, 0 to 1; `closed` must be greater than `clear`.
    pub fn new(clear: f32, closed: f32) -> Self {
        Self { clear_bits: clear.to_bits(), closed_bits: closed.to_bits() }
    }

    /// Opacity of a texel, as `cloud_opacity` of shaders/lib/clouds.wesl; tests/shader/formulas.rs compares the two.
    pub fn opacity(self, texel: f32) -> f32 {
        let [clear, closed] = self.range();
        let t = ((texel - clear) / (closed - clear)).clamp(0.0, 1.0);
        t * t * (3.0 - 2.0 * t)
    }

    /// The texel values for a clear sky and for a closed deck.
    pub(super) fn range(self) -> [f32; 2] {
        [self.clear_bits, self.closed_bits].map(f32::from_bits)
    }
}
