//! A finished frame: linear HDR and the display bytes made from it.

/// Pixels by rows, top row first, without padding.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// In pixels.
    pub width: u32,
    /// In pixels.
    pub height: u32,
    /// Linear premultiplied RGBA: the final image if it is linear, otherwise the image of the HDR pass, if that is requested and has the size of the final
    /// image; else empty. The GPU renderer draws a plan with a linear final image only if the linear image is requested.
    pub hdr: Vec<[f32; 4]>,
    /// sRGB-encoded RGBA, opaque in images of a view; empty if the final image is linear.
    pub display: Vec<[u8; 4]>,
}
