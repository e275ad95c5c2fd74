//! A finished frame: linear HDR and the display bytes made from it.

/// Pixels by rows, top row first, without padding.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// In pixels.
    pub width: u32,
    /// In pixels.
    pub height: u32,
    /// Linear premultiplied RGBA: the final image if that is linear, otherwise the image of the HDR pass. The latter is left out, and this is empty, unless it
    /// is requested and has the size of the final image. The GPU renderer draws a plan with a linear final image only if that is requested.
    pub hdr: Vec<[f32; 4]>,
    /// sRGB-encoded RGBA, opaque in images of a view; empty if the final image is linear.
    pub display: Vec<[u8; 4]>,
}
