// The air of a draw, and its rows of heights.

//: use lib/draw.wgsl
//: use lib/air/columns.wgsl

fn air_of_draw() -> Air {
    var air: Air;
    air.top = draw.air_top;
    air.gas_height = draw.air_gas_height;
    air.gas_scattering = draw.air_gas_scattering;
    air.gas_extinction = draw.air_gas_extinction;
//: if air.mie
    air.haze_height = draw.air_haze_height;
    air.haze_asymmetry = draw.air_haze_asymmetry;
    air.haze_scattering = draw.air_haze_scattering;
    air.haze_extinction = draw.air_haze_extinction;
//: end
//: if air.absorption
    air.layer = draw.air_layer;
    air.layer_extinction = draw.air_layer_extinction;
//: end
    return air;
}

fn air_node(k: u32) -> AirNode {
    return AirNode(draw.air_nodes[3u * k], draw.air_nodes[3u * k + 1u], draw.air_nodes[3u * k + 2u]);
}
