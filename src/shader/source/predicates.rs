//! Predicates: names for conditions that several WESL files use.
//!
//! An `@if` may use a predicate wherever it may use a feature of the key. Each predicate is a WESL condition over features,
//! evaluated for every key. The features are those of the key's dimensions (`shader::key`), with `_` in place of `.` and `-`:
//! `air.pixel-8` is `air_pixel_8`. A count enables all lesser counts, so `lights_2` means two lights or more.

/// A named condition.
pub struct Predicate {
    pub name: &'static str,
    /// A condition over features.
    pub condition: &'static str,
    /// The rest of a sentence that begins "The condition holds where".
    pub meaning: &'static str,
}

const fn predicate(name: &'static str, condition: &'static str, meaning: &'static str) -> Predicate {
    Predicate { name, condition, meaning }
}

/// Every predicate. No condition may use another predicate, so some conditions repeat others.
pub static PREDICATES: &[Predicate] = &[
    predicate(
        "has_air",
        "air_vertex || air_pixel_8 || air_pixel_16 || air_pixel_32 || air_table",
        "light scattered by an atmosphere is summed along the ray, by whichever model",
    ),
    predicate(
        "has_ring_shadow",
        "ring_shadow_point_sun || ring_shadow_penumbra",
        "a ring of the body itself can hide the Sun from a point of the draw",
    ),
    predicate("has_body_shadow", "body_shadow_sphere || body_shadow_ellipsoid_penumbra", "the body casts its shadow on its own ring"),
    predicate(
        "loses_sunlight",
        "eclipse_1 || ring_shadow_point_sun || ring_shadow_penumbra || ring_shadow_of_planet || body_shadow_sphere || \
         body_shadow_ellipsoid_penumbra",
        "an occluder, a ring or the body itself blocks a part of the sunlight",
    ),
    predicate("has_secondary_light", "lights_2 || ring_shine", "another body or the ring lights the ground"),
    predicate(
        "reflects_light",
        "view_shaded && !surface_emissive && !surface_sky && lights_1",
        "the pixel shows light that ground or clouds reflect",
    ),
    predicate(
        "reads_albedo",
        "view_albedo || (view_shaded && (surface_emissive || lights_1))",
        "the pixel depends on the surface's colour",
    ),
    predicate(
        "has_custom_surface",
        "custom_1 || custom_2 || custom_3 || custom_4",
        "a WESL function that the user supplies colours the surface",
    ),
    predicate("reads_normal", "surface_emissive || lights_1 || view_normal", "the pixel depends on the surface normal"),
    predicate(
        "has_photometric_parameter",
        "surface_lunar_lambert || surface_oren_nayar",
        "the photometric model has a parameter of its own",
    ),
    predicate(
        "reads_coarse_air",
        "air_pass_read || air_pass_read_with_clouds",
        "the air's light is interpolated in the coarse image of the air where the interpolation is accurate enough",
    ),
    predicate(
        "reads_coarse_sunlight",
        "(air_pass_read || air_pass_read_with_clouds) && eclipse_1 && !surface_cloud",
        "the sunlight past other bodies is interpolated in the coarse image of the air where the interpolation is accurate enough",
    ),
    predicate(
        "ground_draws_clouds",
        "air_pass_read_with_clouds && !surface_cloud",
        "the ground's draw also shows the clouds, at the pixels whose air it interpolates in the coarse image",
    ),
    predicate(
        "clouds_fill_gaps",
        "air_pass_read_with_clouds && surface_cloud",
        "the clouds' draw shows only the pixels whose air is not interpolated in the coarse image",
    ),
    predicate("has_cloud_map", "maps_cloud_shadow || surface_cloud", "the cloud map is read, for the clouds or for their shadow"),
    predicate("has_detail", "detail_craters || detail_hills || detail_billows", "procedural relief finer than the map is drawn"),
    // In lib/detail.wesl, the noise of the hills also gives city lights their structure.
    predicate("has_city_light_detail", "maps_night && detail_hills", "city lights have structure finer than the night map"),
    // `flags_alphatexture`: the alpha of a shape model's albedo map is its coverage.
    predicate("is_translucent", "flags_alphatexture || surface_cloud", "a map makes the surface partly transparent"),
    predicate(
        "has_map",
        "maps_albedo || maps_normal || maps_specular || maps_night || maps_cloud_shadow || surface_cloud",
        "any map of the body is read",
    ),
    predicate(
        "reads_map_coordinates",
        "maps_albedo || maps_normal || maps_specular || maps_night || maps_cloud_shadow || surface_cloud || view_uv",
        "the pixel's place in the body's maps is needed",
    ),
    predicate(
        "needs_ray_differentials",
        "(shape_sphere || shape_ellipsoid) && (maps_albedo || maps_normal || maps_specular || maps_night || maps_cloud_shadow || surface_cloud || \
         view_uv || overlays_1)",
        "a pixel's footprint on a map is computed from the derivatives of its view ray",
    ),
    predicate(
        "filters_maps",
        "maps_albedo || maps_normal || maps_specular || maps_night || maps_cloud_shadow || surface_cloud || overlays_1",
        "a map or an overlay is read along the pixel's footprint",
    ),
    predicate(
        "has_quadric_shape",
        "shape_sphere || shape_ellipsoid",
        "each pixel's view ray meets a quadric, and the fragment stage writes the depth of the intersection",
    ),
    predicate("has_axis_ratios", "shape_ellipsoid || shape_mesh", "lengths in the unit-sphere frame are scaled by the axis ratios"),
    predicate("reads_ring_profile", "surface_ring || ring_shadow_point_sun || ring_shadow_penumbra", "the ring's profile table is read"),
];
