//! What a scene shows in addition to the bodies of the catalog: stars, diffuse light, the user's sky images, minor planets and comets.
//!
//! In: the viewer, the exposure and the threshold of a [`SceneBuilder`]. Out: [`Sky`]. Not here: lines and names on the sky (`annotations`).

use super::SceneBuilder;
use crate::catalog::NaifId;
use crate::ephemeris::BEST_SOURCE;
use crate::scene::annotation::orbit_arcs::OrbitArc;
use crate::scene::atmosphere::tint_table::FrameTints;
use crate::scene::decision::Decision;
use crate::scene::draw::StarSprite;
use crate::scene::draw::features::PixelView;
use crate::scene::features::inputs::FrameContext;
use crate::scene::sky::background::{self, SkyBackground};
use crate::scene::sky::comets::{self, Comets};
use crate::scene::sky::images::{self, SkyImageDraw};
use crate::scene::sky::minor_planet_columns::MinorPlanetColumns;
use crate::scene::sky::minor_planets::{self, MinorPlanets};
use crate::scene::sky::stars;
use glam::DVec3;
use std::sync::Arc;

/// The contribution of the sky to a scene, with the decisions about it.
pub(super) struct Sky {
    pub background: Option<SkyBackground>,
    pub images: Vec<SkyImageDraw>,
    pub stars: Vec<StarSprite>,
    pub minor_planets: Option<MinorPlanets>,
    /// The comets, without their orbit lines.
    pub comets: Comets,
    /// The orbit lines of the comets.
    pub comet_orbits: Vec<OrbitArc>,
    pub decisions: Vec<Decision>,
}

impl Sky {
    /// `tints`: of the air around the camera. `has_corona`: whether the corona is drawn, so that the zodiacal light need not continue up to the Sun.
    pub(super) fn build(builder: &SceneBuilder<'_>, frame: &FrameContext<'_>, tints: &FrameTints<'_>, has_corona: bool) -> Self {
        let (request, viewer, white) = (builder.request, &builder.viewer, builder.exposure().white());
        let (stars, star_decision) = stars::stars(request, builder.catalog, viewer, frame.threshold, white, tints);
        let (background, background_decisions) = builder.background(frame, has_corona);
        let (images, image_decisions) = match request.layers.data && request.pixel_view == PixelView::Final {
            true => images::images(&builder.catalog.data_layers(), &viewer.camera, viewer.sky_aberration_velocity_km_s),
            false => Default::default(),
        };
        let columns = || {
            let of_catalog = || Arc::new(MinorPlanetColumns::of(&builder.catalog.small_bodies().minor_planets));
            Arc::clone(builder.caches.minor_planets.get_or_init(of_catalog))
        };
        let (minor_planets, minor_planet_decision) = minor_planets::minor_planets(request, columns, viewer, builder.sun_km(), white, tints);
        let (mut comets, comet_decision) = builder.comets(white, tints);
        let comet_orbits = std::mem::take(&mut comets.orbits);
        let decisions = star_decision.into_iter().chain(background_decisions).chain(image_decisions);
        let decisions = decisions.chain(minor_planet_decision).chain(comet_decision).collect();
        Self { background, images, stars, minor_planets, comets, comet_orbits, decisions }
    }
}

impl SceneBuilder<'_> {
    /// Barycentric position of the Sun, if it is known.
    fn sun_km(&self) -> Option<DVec3> {
        let sun = self.ephemeris.state(NaifId::SUN, NaifId::SOLAR_SYSTEM_BARYCENTER, self.request.time, BEST_SOURCE);
        sun.ok().map(|s| s.state.pos_km)
    }

    /// The comets of the frame, and the decision about them. `white`: the radiance displayed as white; `tints`: of the air around the camera.
    pub(super) fn comets(&self, white: f64, tints: &FrameTints<'_>) -> (Comets, Option<Decision>) {
        comets::comets(self.request, || self.catalog.small_bodies(), &self.viewer, self.sun_km(), white, tints)
    }

    /// Diffuse light of the sky, and the decisions about it.
    pub(super) fn background(&self, frame: &FrameContext<'_>, has_corona: bool) -> (Option<SkyBackground>, Vec<Decision>) {
        let resources = frame.context.resources;
        let map = resources.sky_map();
        let is_unreadable = resources.is_unreadable(&map.file);
        background::background(self.request, &self.viewer.camera, &self.placed, frame.threshold, &map, is_unreadable, has_corona)
    }
}
