// How many samples and nodes the air's integrals take, by tier: the sizes of the arrays in lib/draw.wgsl and of the loops that read them.

// Samples along a ray: lib/air/scatter.wgsl.
//: if air.vertex
const AIR_SAMPLES = 5u;
//: end
//: if air.pixel-8
const AIR_SAMPLES = 8u;
//: end
//: if air.pixel-16|air.table
const AIR_SAMPLES = 16u;
//: end
//: if air.pixel-32
const AIR_SAMPLES = 32u;
//: end

// Rows of lib/air/columns.wgsl's nodes; after the samples' come the camera's end and the far end.
//: if surface.cloud
  //: if air.pixel-32
const AIR_NODES = 8u;
  //: else
const AIR_NODES = 4u;
  //: end
//: else
  //: if air.vertex
const AIR_NODES = 4u;
  //: end
  //: if air.pixel-8
const AIR_NODES = 6u;
  //: end
  //: if air.pixel-16|air.table
const AIR_NODES = 8u;
  //: end
  //: if air.pixel-32
const AIR_NODES = 16u;
  //: end
//: end
