//! Light scattered, absorbed and refracted by air and clouds.

mod air_pass;
mod aureole;
mod clouds;
mod clouds_with_ground;
mod corona_in_air;
mod draft;
mod dusk;
mod dusk_at_height;
mod limb_profile;
mod model_bounds;
mod night_sky;
mod refracted_limb;
mod shadows;
mod single_scattering;
mod sky_from_inside;
mod sky_in_umbra;
mod skylight;
mod top_of_air;
