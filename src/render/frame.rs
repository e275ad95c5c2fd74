//! A finished frame: linear HDR and the display bytes made from it.

/// Pixels by rows, top row first, without padding.
#[derive(Clone, Debug, PartialEq)]
pub struct Frame {
    /// In pixels.
    pub width: u32,
    /// In pixels.
    pub height: u32,
    /// Linear premultiplied RGBA of the HDR pass; empty unless requested. The software renderer also fills it if the plan's final image is linear.
    pub hdr: Vec<[f32; 4]>,
    /// Display RGBA; empty if the final image is linear.
    pub display: Vec<[u8; 4]>,
}
