//! What one frame needs: which body is drawn how, with how much light, and what each option changes.

mod comets;
mod custom_surfaces;
mod data_layers;
mod depth_order;
mod detail;
mod eclipse_lines;
mod exposure;
mod features;
mod glint;
mod inspection_views;
mod layers;
mod linear_light;
mod magnitudes;
mod meshes;
mod metering;
mod milky_way;
mod minor_planets;
mod overlays;
mod real_sky;
mod relief;
mod shrinking;
mod silhouette;
mod six_cases;
mod sky_lines;
mod stars;
mod toggles;
