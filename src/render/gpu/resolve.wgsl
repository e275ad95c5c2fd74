// The mean of a pixel's samples. resolve.rs prepends the constant SAMPLES (samples per pixel) and shaders/lib/screen.wesl (the full-screen triangle).

@group(0) @binding(0) var samples: texture_multisampled_2d<f32>;

@vertex
fn vertex_main(@builtin(vertex_index) index: u32) -> @builtin(position) vec4f {
    return vec4f(screen_corner(index), 0.0, 1.0);
}

@fragment
fn fragment_main(@builtin(position) position: vec4f) -> @location(0) vec4f {
    let pixel = vec2i(position.xy);
    var sum = vec4f(0.0);
    for (var k = 0; k < SAMPLES; k++) {
        sum += textureLoad(samples, pixel, k);
    }
    return sum / f32(SAMPLES);
}
