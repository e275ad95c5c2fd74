// What a fragment with a depth of its own gives.
//
// Reversed depth falls to 1e-12 and less at the planets' distances. Where clip space reaches from -1 to 1 (GL) a vertex's depth is rounded to 6e-8
// on its way, which makes all of that infinitely far, and hidden behind nothing: so what is drawn at such distances writes it here.
struct OwnDepth {
    @location(0) colour: vec4f,
    @builtin(frag_depth) depth: f32,
}
