//! Every set of draw features that the catalog's bodies allow.
//!
//! In: the catalog. Out: [`possible_features`], the list of all values that [`FeatureSelection::globe_features`], `cloud_features`, `ring_features`
//! and `sky_features` can return, and of the draws that fill their coarse images. Always: the shader keys that are validated ahead of time and those that
//! frames use come from the same functions.

use crate::catalog::{Body, Catalog, MAX_OVERLAYS, ShapeModel};
use crate::scene::atmosphere::air;
use crate::scene::draw::features::{
    AirPass, AtmosphereModel, BodyShadow, DrawFeatures, Eclipse, EclipseModel, MapSet, MeshFlags, PixelView, RingShadow,
};
use crate::scene::eclipse::model;
use crate::scene::features::choice::{BodyCapabilities, FeatureSelection};
use crate::scene::rings::rings_before_sun;
use crate::scene::thresholds::MAX_LIGHTS;
use std::collections::BTreeSet;

/// No occluder, and each possible number of occluders with each model; with refraction only if the air of a possible occluder refracts light.
fn possible_eclipses(catalog: &Catalog, body: &Body) -> Vec<Eclipse> {
    let (max_occluders, has_refracting_air) = model::max_occluders(catalog.bodies(), body);
    let mut all = vec![Eclipse::default()];
    for occluders in 1..=max_occluders {
        let models = [EclipseModel::Linear, EclipseModel::UniformDisc, EclipseModel::LimbDarkened];
        all.extend(models.map(|model| Eclipse { occluders, model }));
        all.extend(has_refracting_air.then_some(Eclipse { occluders, model: EclipseModel::Refracted }));
    }
    all
}

/// Every subset of the maps that a body has.
fn possible_maps(body: &Body) -> Vec<MapSet> {
    let available = BodyCapabilities::of(body).maps;
    let has = |bits: u8, bit: u8| bits & (1 << bit) != 0;
    let set = |bits| MapSet {
        albedo: available.albedo && has(bits, 0),
        normal: available.normal && has(bits, 1),
        specular: available.specular && has(bits, 2),
        night: available.night && has(bits, 3),
        cloud_shadow: available.cloud_shadow && has(bits, 4),
    };
    // All values of the five bits.
    (0..32).map(set).collect::<BTreeSet<_>>().into_iter().collect()
}

/// No mesh, and the body's mesh without and with vertex colours, because its file may lack them.
fn possible_meshes(body: &Body) -> Vec<Option<MeshFlags>> {
    let flags = |m: &ShapeModel, vertex_colour| Some(MeshFlags { two_sided: m.two_sided, alpha_texture: m.has_map_alpha, vertex_colour });
    let meshes = body.mesh.iter().flat_map(|m| [false, m.uses_vertex_colours].map(|coloured| flags(m, coloured)));
    std::iter::once(None).chain(meshes).collect()
}

/// The features of the globe for one selection, in every variation of mesh, overlays, custom surface, ring-shine, detail, lunar limb profile
/// and thin crescent.
fn possible_globes(chosen: FeatureSelection, body: &Body, view: PixelView) -> impl Iterator<Item = DrawFeatures> {
    let overlays = 0..=body.overlays.len().min(usize::from(MAX_OVERLAYS)) as u8;
    let has_rings = BodyCapabilities::of(body).has_rings;
    possible_meshes(body).into_iter().flat_map(move |mesh| {
        let with_overlays = move |overlays| {
            // Detail, limb profile and thin crescent, in this order. `globe_features` combines neither limb profile and thin crescent with each other nor one
            // of them with detail. Ring-shine occurs with each: a file of the user's may give relief to a body with rings, or rings to the Moon.
            let shapes = [(false, false, false), (true, false, false), (false, true, false), (false, false, true)];
            let combinations: Vec<_> = [false, true][..if has_rings { 2 } else { 1 }]
                .iter()
                .flat_map(|ring_shine| shapes.map(|(detail, limb_heights, crescent)| (*ring_shine, detail, limb_heights, crescent)))
                .collect();
            // Whether the body's custom surface is drawn; 0 is the number of no such surface.
            let custom = [false, true].into_iter().filter(|custom| !custom || body.custom_surface > 0);
            custom.flat_map(move |custom_surface| {
                combinations.clone().into_iter().map(move |(ring_shine, detail, limb_heights, thin_crescent)| {
                    let base = FeatureSelection { overlays, custom_surface, mesh, ..chosen };
                    FeatureSelection { ring_shine, detail, limb_heights, thin_crescent, ..base }.globe_features(body, view)
                })
            })
        };
        overlays.clone().flat_map(with_overlays)
    })
}

/// The shadows of rings that can fall on a body: those of its own rings or, if it has none, that of the rings of another body of its system.
fn possible_ring_shadows(catalog: &Catalog, body: &Body) -> Vec<RingShadow> {
    let has_rings = BodyCapabilities::of(body).has_rings;
    let is_behind_rings = !has_rings && rings_before_sun::bodies_with_rings(catalog, body).next().is_some();
    let is_possible = |shadow: &RingShadow| match shadow {
        RingShadow::None => true,
        RingShadow::PointSun | RingShadow::Penumbra => has_rings,
        RingShadow::OfPlanet => is_behind_rings,
    };
    RingShadow::ALL.into_iter().filter(is_possible).collect()
}

/// The pairs of ring shadow and air pass under an atmosphere. Each of the given ring shadows occurs with air that is evaluated per pixel. Where the air can be
/// interpolated from a coarse image, each way of reading that image occurs, only without a ring shadow (`atmosphere::air_pass::decide`).
fn shadows_and_air_passes(
    ring_shadows: &[RingShadow],
    air_model: AtmosphereModel,
    view: PixelView,
) -> impl Iterator<Item = (RingShadow, AirPass)> {
    let may_be_coarse = !matches!(air_model, AtmosphereModel::None | AtmosphereModel::Vertex) && view.shows_radiance();
    let per_pixel = ring_shadows.iter().map(|shadow| (*shadow, AirPass::None));
    let interpolated = [AirPass::Read, AirPass::ReadWithClouds].map(|air_pass| (RingShadow::None, air_pass));
    per_pixel.chain(interpolated.into_iter().filter(move |_| may_be_coarse))
}

/// The features of the cloud shell for one selection: plain, with procedural billows (`cloud_detail`), and for a thin crescent; the last two are not combined.
fn possible_clouds(chosen: FeatureSelection, body: &Body, view: PixelView) -> impl Iterator<Item = DrawFeatures> {
    [(false, false), (true, false), (false, true)].into_iter().filter_map(move |(cloud_detail, thin_crescent)| {
        FeatureSelection { cloud_detail, thin_crescent, ..chosen }.cloud_features(body, view)
    })
}

/// Every set of draw features that can occur in a frame, for any body of the catalog under any effects and pixel view: sorted, without duplicates.
pub fn possible_features(catalog: &Catalog) -> Vec<DrawFeatures> {
    let both = [false, true];
    let mut all = BTreeSet::new();
    for body in catalog.bodies() {
        let eclipses = possible_eclipses(catalog, body);
        let ring_shadows = possible_ring_shadows(catalog, body);
        for view in PixelView::ALL {
            for ellipsoid in both {
                for maps in possible_maps(body) {
                    // The Sun is one of the `MAX_LIGHTS`.
                    for secondary_light_count in 0..MAX_LIGHTS {
                        for &eclipse in &eclipses {
                            // The two shadows belong to different draws, so their values are paired instead of combined. The first pair is without shadows.
                            // Without rings the second of a pair has no draw.
                            for (&ring_shadow, body_shadow) in ring_shadows.iter().zip(BodyShadow::ALL) {
                                let air_model = AtmosphereModel::None;
                                let chosen = FeatureSelection {
                                    ellipsoid,
                                    maps,
                                    secondary_light_count,
                                    eclipse,
                                    ring_eclipse: eclipse,
                                    ring_shadow,
                                    body_shadow,
                                    air_model,
                                    ..FeatureSelection::default()
                                };
                                all.extend(possible_globes(chosen, body, view));
                                all.extend(possible_clouds(chosen, body, view));
                                all.extend(chosen.ring_features(body, view));
                            }
                            // The draws of the rings do not depend on the air, so they are not repeated here.
                            for air_model in air::possible_models(body) {
                                for (ring_shadow, air_pass) in shadows_and_air_passes(&ring_shadows, air_model, view) {
                                    let chosen = FeatureSelection {
                                        ellipsoid,
                                        maps,
                                        secondary_light_count,
                                        eclipse,
                                        air_model,
                                        ring_shadow,
                                        air_pass,
                                        ..FeatureSelection::default()
                                    };
                                    all.extend(possible_globes(chosen, body, view));
                                    all.extend(possible_clouds(chosen, body, view));
                                    let skies = both.into_iter().flat_map(|thin_rim| {
                                        both.map(|second_light_in_air| {
                                            FeatureSelection { thin_rim, second_light_in_air, ..chosen }.sky_features(body, view)
                                        })
                                    });
                                    all.extend(skies.flatten());
                                }
                            }
                        }
                    }
                }
            }
        }
    }
    // The draws that fill the coarse images.
    let coarse_images: Vec<_> = all.iter().flat_map(|f| [f.coarse_air(), f.coarse_sunlight()]).flatten().collect();
    all.extend(coarse_images);
    all.into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::draw::features::{Detail, Shape, Surface};

    /// An eclipse changes only the eclipse features of a draw and, under an atmosphere, the number of lights, which it can only increase.
    #[test]
    fn an_eclipse_removes_no_light() {
        let catalog = Catalog::embedded();
        let eclipse = Eclipse { occluders: 1, model: EclipseModel::LimbDarkened };
        let (mut with_planet_shine, mut with_ring_shine) = (0, 0);
        for body in catalog.bodies() {
            for air_model in air::possible_models(body) {
                for (secondary_light_count, ring_shine) in [(0, false), (1, false), (2, false), (0, true)] {
                    let chosen = FeatureSelection { secondary_light_count, ring_shine, air_model, ..FeatureSelection::default() };
                    let plain = chosen.globe_features(body, PixelView::Final);
                    let eclipsed = FeatureSelection { eclipse, ..chosen }.globe_features(body, PixelView::Final);
                    assert_eq!(DrawFeatures { eclipse: plain.eclipse, lights: plain.lights, ..eclipsed }, plain, "{}", body.name);
                    let has_air = air_model != AtmosphereModel::None;
                    assert!(eclipsed.lights == plain.lights || has_air && plain.lights > 1 && eclipsed.lights > plain.lights);
                    with_planet_shine +=
                        usize::from(has_air && secondary_light_count > 0 && eclipsed.lights > 1 && eclipsed.eclipse == eclipse);
                    with_ring_shine += usize::from(has_air && eclipsed.ring_shine && eclipsed.eclipse == eclipse);
                }
            }
        }
        // Both cases were tested often.
        assert!(with_planet_shine > 20 && with_ring_shine > 10, "{with_planet_shine} {with_ring_shine}");
    }

    /// The Earth is behind no rings, Rhea behind Saturn's, and Saturn behind its own. In the shadow of another body's rings, numbers of lights and models of
    /// eclipses are rounded up, and no crescent is averaged.
    #[test]
    fn shadows_of_rings_are_possible_where_rings_are() {
        let catalog = Catalog::embedded();
        let shadows = |id: i32| possible_ring_shadows(&catalog, catalog.body(crate::catalog::NaifId(id)).expect("in the catalog"));
        assert_eq!(shadows(399), [RingShadow::None]);
        assert_eq!(shadows(605), [RingShadow::None, RingShadow::OfPlanet]);
        assert_eq!(shadows(699), [RingShadow::None, RingShadow::PointSun, RingShadow::Penumbra]);
        let all = possible_features(&catalog);
        let in_shadow: Vec<_> = all.iter().filter(|f| f.ring_shadow == RingShadow::OfPlanet).collect();
        let is_rounded_up = |f: &DrawFeatures| {
            let has_simple_eclipse = matches!(f.eclipse.model, EclipseModel::Linear | EclipseModel::UniformDisc);
            !has_simple_eclipse && (f.surface == Surface::Sky || [1, MAX_LIGHTS].contains(&f.lights) && !f.thin_limb)
        };
        assert!(in_shadow.iter().all(|f| is_rounded_up(f)));
        assert!(in_shadow.iter().any(|f| f.eclipse.occluders > 0) && in_shadow.iter().any(|f| f.surface == Surface::Sky));
        println!("{} of {}", in_shadow.len(), all.len());
        assert!(5 * in_shadow.len() < all.len(), "{} of {}", in_shadow.len(), all.len());
    }

    #[test]
    fn features_that_the_body_lacks_are_impossible() {
        let catalog = Catalog::embedded();
        let all = possible_features(&catalog);
        let sun = catalog.body(crate::catalog::NaifId::SUN).expect("the Sun");
        let everything = MapSet { albedo: true, normal: true, specular: true, night: true, cloud_shadow: true };
        // More lights than `MAX_LIGHTS`.
        let features = FeatureSelection { ellipsoid: true, maps: everything, secondary_light_count: 200, ..FeatureSelection::default() }
            .globe_features(sun, PixelView::Final);
        assert_eq!((features.surface, features.lights, features.maps.night), (Surface::Emissive, 0, false));
        assert!(all.contains(&features));
        let mars = catalog.body(crate::catalog::NaifId(499)).expect("Mars");
        let many_lights = FeatureSelection { secondary_light_count: u8::MAX, ..FeatureSelection::default() };
        assert_eq!(many_lights.globe_features(mars, PixelView::Final).lights, MAX_LIGHTS);
        assert!(all.iter().all(|f| f.lights <= MAX_LIGHTS && (f.surface == Surface::Emissive) == (f.lights == 0)));
        // The built-in catalog has no shape models.
        assert!(!all.iter().any(|f| f.shape == Shape::Mesh));
        // A flag of a mesh on a draw of a sphere is impossible.
        let with_mesh_flag = DrawFeatures { flags: MeshFlags { two_sided: true, ..MeshFlags::default() }, ..features };
        assert!(!all.contains(&with_mesh_flag));
    }

    /// Saturn with relief and the Moon with a ring, which only a file of the user's has.
    #[test]
    fn ring_shine_is_possible_with_detail_and_a_limb_profile() {
        let relief = "[[body]]\nid = 699\ninvented_relief = \"hills\"\n";
        let ring = "[[ring]]\nbody = \"Moon\"\nname = \"X\"\ninner_km = 3e3\nouter_km = 5e3\ntau_normal = 1.0\n";
        let catalog = Catalog::with_files(&[("mine.toml".into(), format!("{relief}{ring}"))]).expect("a valid catalog");
        let all = possible_features(&catalog);
        let (mut with_detail, mut with_profile) = (0, 0);
        for body in [699, 301].map(|id| catalog.body(crate::catalog::NaifId(id)).expect("in the catalog")) {
            for bits in 0..16_u8 {
                let [ring_shine, detail, limb_heights, thin_crescent] = [0, 1, 2, 3].map(|k| bits >> k & 1 == 1);
                let chosen = FeatureSelection { ring_shine, detail, limb_heights, thin_crescent, ..FeatureSelection::default() };
                let features = chosen.globe_features(body, PixelView::Final);
                assert!(all.binary_search(&features).is_ok(), "{}: {features:?}", body.name);
                with_detail += usize::from(features.ring_shine && features.detail == Detail::Hills);
                with_profile += usize::from(features.ring_shine && features.limb_heights);
            }
        }
        assert!(with_detail > 0 && with_profile > 0, "{with_detail} {with_profile}");
    }

    #[test]
    fn a_mesh_and_its_flags_are_possible_if_the_catalog_has_them() {
        let file = |rest: &str| {
            let text = format!("[[body]]\nid = 401\n[body.mesh]\nfile = \"phobos.obj\"\n{rest}");
            Catalog::with_files(&[("mine.toml".into(), text)]).expect("a valid catalog")
        };
        let flags = |catalog: &Catalog| -> BTreeSet<MeshFlags> {
            possible_features(catalog).into_iter().filter(|f| f.shape == Shape::Mesh).map(|f| f.flags).collect()
        };
        let plain = MeshFlags::default();
        assert_eq!(flags(&file("")), [plain, MeshFlags { vertex_colour: true, ..plain }].into());
        let cut = MeshFlags { two_sided: true, alpha_texture: true, vertex_colour: false };
        // The alpha texture is part of the albedo map; without that map nothing is cut out.
        let both = [cut, MeshFlags { alpha_texture: false, ..cut }].into();
        assert_eq!(flags(&file("two_sided = true\nalpha = true\nvertex_colours = false\n")), both);
    }
}
