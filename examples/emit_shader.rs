//! Prints the WGSL module of a shader key, such as `lambert.albedo.sun1.ellipsoid`: Lambert shading, albedo map, one light, ellipsoid.
//!
//!     cargo run --release --example emit_shader -- lambert.albedo.sun1.ellipsoid > body.wgsl

use orrery::shader::{emit, key::ShaderKey};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let key_text = std::env::args().nth(1).unwrap_or_else(|| "lambert.albedo.sun1.ellipsoid".into());
    let key: ShaderKey = key_text.parse()?;
    print!("{}", emit(&key)?.wgsl);
    Ok(())
}
