//! What one body's draw gets and does not get, each by a number against a bound.

use super::camera::{self, AnchorForm, ClipRect};
use super::draw::{AirTier, Amounts, Draw, Light, MapFiles, MapSet, Part, PixelView, Point};
use super::draw::{EclipseAmounts, EclipseModel, RingAmounts, RingShadow, Shape};
use super::eclipse::{self, Extent, Receiver, Wanted};
use super::effects::{Available, Chosen, Decision, Effect, VISIBLE_CHANGE, flattening};
use super::lights::{self, LightOn, Reflector};
use super::overlays;
use super::request::{Quality, ViewRequest};
use super::rings;
use super::silhouette::Outline;
use super::tiers::{self, Tier};
use super::{Appearance, Exposure, Placed, of_white, photometry};
use crate::catalog::{Body, Map, NaifId, Overlay, Photometry};
use crate::ephemeris::Ephemeris;
use glam::{DVec2, DVec3, Vec3};

/// What the decisions of all bodies of a frame share.
#[derive(Clone, Copy)]
pub(super) struct Frame<'a> {
    pub request: &'a ViewRequest,
    pub camera: &'a camera::Camera,
    pub exposure: &'a Exposure,
    pub reflectors: &'a [Reflector<'a>],
    pub ephemeris: &'a Ephemeris,
    /// The air that the camera stands in.
    pub air: Option<&'a super::air::Around<'a>>,
}

/// Radiance of a white texel of a night map of gain 1, in units of a sunlit white plane's at 1 au: city cores reach 500 nW/cm2/sr in
/// VIIRS' day-night band (Elvidge et al. 2017, Int. J. Remote Sensing 38, 5860), times pi, over the 600 W/m2 of sunlight in that band.
const NIGHT_MAP_WHITE_RADIANCE: f64 = 2.6e-5;

/// What became of one body.
pub(super) struct Seen {
    pub appearance: Appearance,
    pub diameter_px: f64,
    pub decisions: Vec<Decision>,
}

/// Reach of a point's sprite: three standard deviations of its point-spread function, so that a star is 1.6 pixels wide at half height.
pub const POINT_RADIUS_PX: f64 = 2.0;
/// Diameters between which a disc takes over from a point. Below, a pixel's one place on the disc stands for too much of it: over places
/// in the pixel a full disc of 4 pixels is 6 % too bright, a half-lit one within 10 %; at 2 pixels 18 % and 25 % (worked outside).
pub const BLEND_FROM_PX: f64 = 2.0;
pub const BLEND_TO_PX: f64 = 4.0;
/// Ground that a pixel may span for relief to show: slopes average out over more.
const RELIEF_DEG_PER_PX: f64 = 2.5;
/// Disc at which the Sun's glint, some 20 degrees of ground, covers a pixel.
const GLINT_DIAMETER_PX: f64 = 8.0;
/// Mean square slope of the sea's waves in a wind of 5 m/s (Cox and Munk 1954: 0.003 + 0.00512 per m/s).
const WAVE_SLOPE_SQ: f64 = 0.0286;

/// Part of the light that the disc draw carries at a diameter; the point carries the rest.
pub fn disc_share(diameter_px: f64) -> f64 {
    let x = ((diameter_px - BLEND_FROM_PX) / (BLEND_TO_PX - BLEND_FROM_PX)).clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

/// Part of a point's flux that its brightest pixel gets.
pub(super) fn point_peak() -> f64 {
    1.0 / (2.0 * std::f64::consts::PI * (POINT_RADIUS_PX / 3.0).powi(2))
}

struct Ledger<'a> {
    request: &'a ViewRequest,
    decisions: Vec<Decision>,
}

impl Ledger<'_> {
    fn note(&mut self, feature: &'static str, on: bool, reason: String) -> bool {
        self.decisions.push(Decision { feature, on, reason, tier: None });
        on
    }
    /// Says how a feature that was decided on is computed.
    fn tier(&mut self, feature: &'static str, tier: Option<Tier>) {
        if let Some(last) = self.decisions.iter_mut().rfind(|d| d.feature == feature && d.on) {
            last.tier = tier;
        }
    }
    /// The bound decides, unless the viewer asked.
    fn effect(&mut self, effect: Effect, by_bound: bool, reason: String) -> bool {
        match self.request.effects.asked(effect) {
            Some(on) => self.note(effect.name(), on, "asked for".into()),
            None => self.note(effect.name(), by_bound, reason),
        }
    }
    /// A map: absent and unreadable files cannot be asked for.
    fn map(&mut self, effect: Effect, map: Option<&Map>, bound: impl FnOnce() -> (bool, String)) -> bool {
        match map {
            None => self.note(effect.name(), false, "the catalog names no such map".into()),
            Some(m) if self.request.missing_maps.contains(&m.file) => {
                self.note(effect.name(), false, format!("{} could not be read: drawn without it", m.file))
            }
            Some(_) => {
                let (on, reason) = bound();
                self.effect(effect, on, reason)
            }
        }
    }
}

/// Decides one body's features, and its draws (the globe first) and point where it has them.
pub(super) fn decide(frame: &Frame<'_>, p: &Placed<'_>, inside: bool) -> (Seen, Vec<Draw>, Option<Point>) {
    let (camera, body) = (frame.camera, p.body);
    let mut ledger = Ledger { request: frame.request, decisions: Vec::new() };
    let diameter_px = match p.outline {
        Outline::Ellipse { area_px, .. } => 2.0 * (area_px / std::f64::consts::PI).sqrt(),
        Outline::Open | Outline::Beside => 2.0 * body.radii_km.x / p.distance_km / camera.pixel_tangent(),
        Outline::Behind => 0.0,
    };
    let not_shown = |mut ledger: Ledger<'_>, reason: &str| {
        ledger.note("visible", false, reason.into());
        (Seen { appearance: Appearance::NotShown, diameter_px, decisions: ledger.decisions }, Vec::new(), None)
    };
    if inside {
        return not_shown(ledger, "the camera is at its centre");
    }
    let model = super::meshes::model(frame.request, body);
    let rect = model.map_or_else(|| p.outline.rect(camera), |m| super::meshes::rect(camera, &p.placement, m));
    let ring_view = ring_view(frame, p).filter(|v| rect.is_some() || v.meets_frame());
    if rect.is_none() && ring_view.is_none() {
        if let Some(sky) = sky_alone(frame, p, &mut ledger, diameter_px) {
            return (Seen { appearance: Appearance::Disc, diameter_px, decisions: ledger.decisions }, vec![sky], None);
        }
        return not_shown(ledger, if p.outline == Outline::Behind { "behind the camera" } else { "outside the frame" });
    }
    let what = if rect.is_some() { "its outline meets" } else { "its rings meet" };
    ledger.note("visible", true, format!("{what} the frame"));
    let share = match ledger.request.effects.asked(Effect::Points) {
        Some(false) => 1.0,
        _ => disc_share(diameter_px),
    };
    // Light from beyond the camera's air comes reddened.
    let tint = frame.air.as_ref().filter(|a| a.body.id != body.id).map_or(DVec3::ONE, |a| a.tint(p.placement.centre_km));
    let flux = point_flux(frame, p) * (1.0 - share) * tint;
    // A point that can be seen at all goes dark in a shadow.
    let shows = share < 1.0 && flux.max_element() / frame.exposure.white() > VISIBLE_CHANGE;
    let flux = if shows { flux * dimming(frame.request, frame.ephemeris, p, diameter_px).0 } else { flux };
    let mut point = None;
    let reason = format!("{diameter_px:.3} px across against {BLEND_FROM_PX} to {BLEND_TO_PX} px");
    let flux = if frame.request.pixel_view == PixelView::Shaded { flux } else { DVec3::ZERO };
    if ledger.effect(Effect::Points, share < 1.0, reason) && share < 1.0 {
        let part = flux.max_element() / frame.exposure.white();
        if part > VISIBLE_CHANGE {
            point = camera.clip(p.placement.centre_km).map(|clip| sprite(body.id, clip, flux));
        } else {
            ledger.note("point-visible", false, of_white(part));
        }
    }
    if share <= 0.0 {
        let appearance = if point.is_some() { Appearance::Point } else { Appearance::NotShown };
        return (Seen { appearance, diameter_px, decisions: ledger.decisions }, Vec::new(), point);
    }

    let (mut chosen, mut shine, eclipse) = choose(frame, p, &mut ledger, diameter_px);
    let laid = laid_over(&mut ledger, body, diameter_px);
    chosen.overlays = laid.len() as u8;
    let (ring, ring_draws) = ring_view.map(|view| ring_parts(frame, p, &view, &mut ledger, &mut chosen, share)).unwrap_or_default();
    let (sky, veil) = sky_draw(frame, p, &mut ledger, &mut chosen, diameter_px);
    if chosen.air != AirTier::None && chosen.ring_shadow != RingShadow::None && chosen.eclipse.casters > 0 {
        // Each ring's shadow under each tier, number of casters and model would triple those keys for a rare sight.
        ledger.note(Effect::RingShadow.name(), false, "left out under air in an eclipse".into());
        chosen.ring_shadow = RingShadow::None;
    }
    if chosen.ring_shine && !shine.is_empty() {
        ledger.note(Effect::PlanetShine.name(), false, "left out where the rings light the globe: they give far more".into());
        shine.clear();
    }
    let shades = shaped(frame, p, &mut ledger, &mut chosen);
    let needs = chosen.needs(body, frame.request.pixel_view);
    let files = |on: bool, map: &Option<Map>| map.as_ref().filter(|_| on).map(|m| m.file.clone());
    let map_files = MapFiles {
        albedo: files(needs.maps.albedo, &body.maps.albedo),
        normal: files(needs.maps.normal, &body.maps.normal),
        specular: files(needs.maps.specular, &body.maps.specular),
        night: files(needs.maps.night, &body.maps.night),
        cloud: body.clouds.as_ref().filter(|_| needs.maps.cloud_shadow).map(|c| c.map.file.clone()),
        overlays: laid.iter().map(|o| o.file.clone()).collect(),
    };
    let globe = rect.map(|rect| {
        let amounts = Amounts { ring: ring.clone(), ..amounts(frame, p, &p.placement, rect, chosen.maps, &shine, share) };
        let factor = tone(p) * share * tint;
        let overlays = laid.iter().map(|o| overlays::amounts(body, o, factor)).collect();
        let mut amounts = Amounts { albedo: amounts.albedo * camera::narrow(tint), overlays, ..amounts };
        if let Some(model) = model.filter(|_| needs.shape == Shape::Mesh) {
            super::meshes::set(&mut amounts, camera, &p.placement, model, shades);
        }
        Draw { body: body.id, part: Part::Globe, name: body.name.clone(), needs, amounts, map_files }
    });
    let mut draws: Vec<_> = globe.into_iter().chain(sky).chain(cloud_draw(frame, p, &mut ledger, chosen, &shine, share)).collect();
    for draw in &mut draws {
        // Needs round the number of lights up.
        let dark =
            Light { direction_in_body: draw.amounts.lights.first().map_or(Vec3::Z, |l| l.direction_in_body), irradiance: Vec3::ZERO };
        while draw.amounts.lights.len() < usize::from(draw.needs.lights) {
            draw.amounts.lights.push(dark);
        }
        draw.amounts.eclipse.clone_from(&eclipse);
        if draw.part == Part::Sky && draw.needs.ring_shadow != RingShadow::None {
            draw.amounts.ring.clone_from(&ring);
        }
        draw.amounts.air.veil = veil;
    }
    draws.extend(ring_draws);
    let appearance = if point.is_some() { Appearance::DiscAndPoint } else { Appearance::Disc };
    (Seen { appearance, diameter_px, decisions: ledger.decisions }, draws, point)
}

/// Decides on the mesh and on its own shadow: the direction of the Sun, body axes, and its angular radius where it shades itself.
fn shaped(frame: &Frame<'_>, p: &Placed<'_>, ledger: &mut Ledger<'_>, chosen: &mut Chosen) -> Option<(DVec3, f64)> {
    let (name, body) = (Effect::Mesh.name(), p.body);
    let Some(named) = &body.mesh else {
        ledger.note(name, false, "the catalog names none".into());
        return None;
    };
    if ledger.request.missing_maps.contains(&named.file) {
        ledger.note(name, false, format!("{} could not be read: drawn as its ellipsoid", named.file));
        return None;
    }
    let Some(model) = super::meshes::model(frame.request, body) else {
        ledger.effect(Effect::Mesh, false, format!("{} is not read here: drawn as its ellipsoid", named.file));
        return None;
    };
    let reason = format!("{} triangles of {}, up to {:.3} radii from the centre", model.triangles(), named.file, model.reach);
    ledger.effect(Effect::Mesh, true, reason);
    chosen.mesh = Some(super::meshes::flags(body, model));
    let sun = frame.reflectors.iter().find(|r| r.body.id == NaifId::SUN && r.body.id != body.id)?;
    let radius_rad = (sun.body.radii_km.x / p.sun_from_body_km.length()).clamp(0.0, 1.0).asin();
    let reason = format!("at each vertex, of a Sun of {:.3} degrees across; sharp to an edge's length", 2.0 * radius_rad.to_degrees());
    let lit = !Available::of(body).emissive;
    ledger.effect(Effect::SelfShadow, lit, reason).then(|| ((p.body_from_icrf * p.sun_from_body_km).normalize(), radius_rad))
}

/// The images that are laid over the ground.
fn laid_over<'b>(ledger: &mut Ledger<'_>, body: &'b Body, diameter_px: f64) -> Vec<&'b Overlay> {
    let name = Effect::Overlays.name();
    if body.overlays.is_empty() {
        ledger.note(name, false, "the catalog names none".into());
    }
    let counts = |overlay: &&Overlay| {
        if ledger.request.missing_maps.contains(&overlay.file) {
            return ledger.note(name, false, format!("{} could not be read: drawn without it", overlay.file));
        }
        let (on, reason) = overlays::bound(body, overlay, ground_deg_per_px(diameter_px));
        ledger.effect(Effect::Overlays, on, reason)
    };
    body.overlays.iter().filter(counts).collect()
}

fn ground_deg_per_px(diameter_px: f64) -> f64 {
    (360.0 / std::f64::consts::PI) / diameter_px.max(1e-9)
}

/// Brightness of a disc at this phase over that of its model; of the Sun its radiance.
fn brightness(p: &Placed<'_>) -> f64 {
    match p.body.photometry {
        Photometry::Emissive { .. } => photometry::sun_disc_radiance(),
        _ => photometry::phase_correction(p.body, p.alpha, p.distance_km / p.body.radii_km.x),
    }
}

/// The same, and what makes the model's albedo the catalog's.
fn tone(p: &Placed<'_>) -> DVec3 {
    photometry::normalisation(p.body) * brightness(p)
}

/// What is to be known of a body's rings before anything is decided.
fn ring_view<'v>(frame: &'v Frame<'_>, p: &'v Placed<'_>) -> Option<rings::View<'v>> {
    let lit = !p.body.rings.is_empty() && !matches!(p.body.photometry, Photometry::Emissive { .. });
    lit.then(|| rings::View {
        body: p.body,
        camera: frame.camera,
        placement: &p.placement,
        sun: (p.body_from_icrf * p.sun_from_body_km).normalize(),
        sun_km: p.sun_from_body_km.length(),
        alpha: p.alpha,
        brightness: lights::sunlight(p.sun_from_body_km).irradiance.x / frame.exposure.white(),
    })
}

/// The ring's amounts for the globe it shades, and its draws: the half behind the globe's centre, then the half before it.
fn ring_parts(
    frame: &Frame<'_>,
    p: &Placed<'_>,
    view: &rings::View<'_>,
    ledger: &mut Ledger<'_>,
    chosen: &mut Chosen,
    share: f64,
) -> (RingAmounts, Vec<Draw>) {
    let asked = |e: Effect| frame.request.effects.asked(e) == Some(true);
    let sun = frame.reflectors.iter().find(|r| r.body.id == NaifId::SUN).map(|r| r.body);
    let sun_radius_km = sun.map_or(0.0, |s| s.radii_km.x);
    let seen = view.counted(asked(Effect::Rings));
    let drawn = ledger.effect(Effect::Rings, seen.bound.on, seen.bound.reason);
    // What shades the globe need not be seen itself.
    let all = view.counted(true).rings;
    let (bound, model) = view.ring_shadow(&all, sun_radius_km);
    if ledger.effect(Effect::RingShadow, bound.on, bound.reason) {
        chosen.ring_shadow = model;
        ledger.tier(Effect::RingShadow.name(), tiers::of_ring_shadow(model));
    }
    let wanted = frame.request.effects.asked(Effect::RingShine);
    let (bound, shine) = view.ring_shine(&all, sun_radius_km, wanted);
    let mut for_globe = if chosen.ring_shadow == RingShadow::None { RingAmounts::default() } else { view.amounts(&all, sun) };
    if ledger.effect(Effect::RingShine, bound.on, bound.reason)
        && let Some(shine) = shine
    {
        for_globe.shine_frame = view.shine_frame(&shine, brightness(p));
        for_globe.shine = Some(shine);
        chosen.ring_shine = true;
    }
    if !drawn || seen.rings.is_empty() {
        ledger.note(Effect::BodyShadow.name(), false, "no ring is drawn".into());
        return (for_globe, Vec::new());
    }
    let (bound, model) = view.body_shadow(&seen.rings, sun_radius_km);
    if ledger.effect(Effect::BodyShadow, bound.on, bound.reason) {
        chosen.body_shadow = model;
        ledger.tier(Effect::BodyShadow.name(), tiers::of_body_shadow(model));
    }
    let outer_km = seen.rings.iter().map(|r| r.outer_km).fold(0.0, f64::max);
    let eclipse = darkened_ring(frame, p, ledger, chosen, outer_km);
    let (Some(rect), Some(needs)) = (view.rect(outer_km), chosen.ring_needs(view.body, frame.request.pixel_view)) else {
        return (for_globe, Vec::new());
    };
    let sunlight = lights::sunlight(view.sun * view.sun_km);
    let shared = Amounts {
        albedo: camera::narrow(DVec3::splat(share)),
        lights: vec![Light { direction_in_body: camera::narrow(view.sun), irradiance: camera::narrow(sunlight.irradiance) }],
        // One table serves both where the same rings count.
        ring: if for_globe.table.is_some() && seen.rings.len() == all.len() { for_globe.clone() } else { view.amounts(&seen.rings, sun) },
        eclipse,
        ..view.rays(rect)
    };
    let half = |part: Part, which: f32| {
        let mut amounts = shared.clone();
        amounts.ring.half = which;
        Draw { body: view.body.id, part, name: format!("{} rings", view.body.name), needs, amounts, map_files: MapFiles::default() }
    };
    (for_globe, vec![half(Part::RingBehind, -1.0), half(Part::Ring, 1.0)])
}

/// Decides on the air: sets the globe's tier, and returns the draw of the air beside the ground and [`crate::scene::draw::AirAmounts::veil`].
fn sky_draw(frame: &Frame<'_>, p: &Placed<'_>, ledger: &mut Ledger<'_>, chosen: &mut Chosen, diameter_px: f64) -> (Option<Draw>, f32) {
    let body = p.body;
    let Some((air, shell)) = body.atmosphere.as_ref().zip(super::air::shell(body, &p.placement)) else { return (None, 0.0) };
    let inside = shell.camera_is_inside();
    let (on, reason) = super::air::bound(body, air, inside, diameter_px);
    if !ledger.effect(Effect::Atmosphere, on, reason) {
        return (None, 0.0);
    }
    let (tier, reason) = super::air::tier(frame.request.effects.way(Effect::Atmosphere), frame.request.quality);
    ledger.note("air-samples", true, reason.into());
    chosen.air = tier;
    ledger.tier(Effect::Atmosphere.name(), tiers::of_air(tier));
    if !chosen.ellipsoid && Available::of(body).ellipsoid {
        ledger.note(Effect::Ellipsoid.name(), true, "air lies on the true shape".into());
    }
    let needs = chosen.sky_needs(body, frame.request.pixel_view);
    let no_rim = !inside && super::air::rim_px(body, air, diameter_px) < super::air::RIM_PX;
    // Only a bare ground's colour lacks what the air does to it from afar.
    let held = !inside && !super::air::ground_is_bare(body) && frame.request.pixel_view != PixelView::OpticalDepth;
    if held && (no_rim || !super::air::is_opaque(air) || chosen.ring_shadow != RingShadow::None && chosen.eclipse.casters > 0) {
        ledger.note("air-over-ground", false, "the colours of its disc have the air in them".into());
        chosen.air = AirTier::None;
    } else if held {
        ledger.note("air-over-ground", true, "where it is brighter than the disc, whose colours have the air in them".into());
    }
    let veil = if held { 1.0 } else { 0.0 };
    let rect = if inside { Some(ClipRect::VIEWPORT) } else { Outline::of(frame.camera, &shell).rect(frame.camera) };
    let (Some(rect), Some(needs), false) = (rect, needs, no_rim) else { return (None, veil) };
    let mut amounts = amounts(frame, p, &p.placement, rect, MapSet::default(), &[], 1.0);
    super::air::set_ends(&mut amounts, true);
    let name = format!("{} air", body.name);
    (Some(Draw { body: body.id, part: Part::Sky, name, needs, amounts, map_files: MapFiles::default() }), veil)
}

/// The air of a body whose ground is outside the frame.
fn sky_alone(frame: &Frame<'_>, p: &Placed<'_>, ledger: &mut Ledger<'_>, diameter_px: f64) -> Option<Draw> {
    p.body.atmosphere.as_ref()?;
    let mut chosen = Chosen::default();
    let eclipse = darkened(frame, p, ledger, &mut chosen, diameter_px);
    let mut sky = sky_draw(frame, p, ledger, &mut chosen, diameter_px).0?;
    sky.amounts.eclipse = eclipse;
    Some(sky)
}

/// The cloud shell over the globe.
fn cloud_draw(frame: &Frame<'_>, p: &Placed<'_>, ledger: &mut Ledger<'_>, chosen: Chosen, shine: &[LightOn], share: f64) -> Option<Draw> {
    let body = p.body;
    let clouds = body.clouds.as_ref()?;
    let needs = chosen.cloud_needs(body, frame.request.pixel_view)?;
    let scale = super::clouds::shell_scale(body, clouds);
    let shell = super::clouds::shell(&p.placement, scale);
    if shell.camera_is_inside() {
        ledger.note(Effect::Clouds.name(), false, format!("the camera is below them, {} km over the ground", clouds.height_km));
        return None;
    }
    let part = frame.exposure.white().recip() * clouds.albedo * lights::sunlight(p.sun_from_body_km).irradiance.x;
    if !ledger.map(Effect::Clouds, Some(&clouds.map), || (part > VISIBLE_CHANGE, format!("a closed deck is {}", of_white(part)))) {
        return None;
    }
    let rect = Outline::of(frame.camera, &shell).rect(frame.camera)?;
    let mut amounts = amounts(frame, p, &shell, rect, MapSet::default(), shine, share);
    let brightness = photometry::phase_correction(body, p.alpha, p.distance_km / body.radii_km.x);
    amounts.air = super::air::amounts(body, scale);
    super::air::set_ends(&mut amounts, false);
    amounts.albedo = camera::narrow(DVec3::splat(clouds.albedo * brightness * share));
    let map_files = MapFiles { cloud: Some(clouds.map.file.clone()), ..MapFiles::default() };
    Some(Draw { body: body.id, part: Part::Clouds, name: format!("{} clouds", body.name), needs, amounts, map_files })
}

/// Sum of the body's radiance over the pixels, linear RGB.
fn point_flux(frame: &Frame<'_>, p: &Placed<'_>) -> DVec3 {
    let direction = p.placement.centre_km / p.distance_km;
    let cos_off_axis = direction.dot(frame.camera.forward);
    // Solid angle of the pixel at that place of the image plane.
    let pixel_sr = frame.camera.pixel_tangent().powi(2) * cos_off_axis.max(1e-3).powi(3);
    p.body.colour.as_dvec3() * (p.irradiance * std::f64::consts::PI / pixel_sr)
}

/// Drawn over all bodies: what nearer ones hide of it is taken from its flux (`super::hidden`).
fn sprite(body: NaifId, clip: DVec2, flux: DVec3) -> Point {
    Point { body, centre: camera::narrow(clip.extend(1.0)), radius_px: camera::narrow_scalar(POINT_RADIUS_PX), flux: camera::narrow(flux) }
}

fn choose(frame: &Frame<'_>, p: &Placed<'_>, ledger: &mut Ledger<'_>, diameter_px: f64) -> (Chosen, Vec<LightOn>, EclipseAmounts) {
    let (body, white) = (p.body, frame.exposure.white());
    let available = Available::of(body);
    let lean = flattening(body);
    let bound = format!("its normals lean {lean:.2e} rad from a sphere's against {VISIBLE_CHANGE:.2e}");
    let ellipsoid = available.ellipsoid && ledger.effect(Effect::Ellipsoid, lean > VISIBLE_CHANGE, bound);
    if !available.ellipsoid {
        ledger.note(Effect::Ellipsoid.name(), false, "its axes are equal".into());
    }
    let albedo = ledger.map(Effect::Albedo, body.maps.albedo.as_ref(), || (true, format!("a disc of {diameter_px:.1} px is drawn")));
    let mut chosen = Chosen { ellipsoid, maps: MapSet { albedo, ..MapSet::default() }, ..Chosen::default() };
    if available.emissive {
        ledger.note("lights", false, "it glows by itself".into());
        return (chosen, Vec::new(), EclipseAmounts::default());
    }
    let ground_per_px = ground_deg_per_px(diameter_px);
    chosen.maps.normal = ledger.map(Effect::Normal, body.maps.normal.as_ref(), || {
        (ground_per_px < RELIEF_DEG_PER_PX, format!("a pixel spans {ground_per_px:.2} degrees of ground against {RELIEF_DEG_PER_PX}"))
    });
    chosen.maps.specular = ledger.map(Effect::Specular, body.maps.specular.as_ref(), || {
        (diameter_px > GLINT_DIAMETER_PX, format!("{diameter_px:.1} px across against {GLINT_DIAMETER_PX} for the Sun's glint"))
    });
    chosen.maps.night = ledger.map(Effect::Night, body.maps.night.as_ref(), || {
        let part = body.maps.night.as_ref().map_or(0.0, |m| m.gain.iter().copied().fold(0.0, f64::max)) * NIGHT_MAP_WHITE_RADIANCE / white;
        (part > VISIBLE_CHANGE, format!("brightest lamps {}", of_white(part)))
    });
    if let Some(clouds) = &body.clouds {
        chosen.maps.cloud_shadow =
            ledger.map(Effect::CloudShadow, Some(&clouds.map), || super::clouds::shadow_bound(body, clouds, diameter_px));
    }
    ledger.note("sunlight", true, format!("irradiance {:.3e} of that at 1 au", lights::sunlight(p.sun_from_body_km).irradiance.x));
    let everything = frame.request.effects.asked(Effect::PlanetShine) == Some(true);
    let (mut shine, strongest) = lights::planet_shine(body, p.position_km, frame.reflectors, white, everything);
    let reason = match strongest {
        Some((from, part)) => format!("the strongest, from {}, gives {}", name_of(frame, from), of_white(part)),
        None => "no other body reflects light on it".into(),
    };
    if !ledger.effect(Effect::PlanetShine, !shine.is_empty(), reason) {
        shine.clear();
    }
    chosen.shine = shine.len() as u8;
    let eclipse = darkened(frame, p, ledger, &mut chosen, diameter_px);
    (chosen, shine, eclipse)
}

/// Who stands before the Sun, and by which model.
fn darkened(frame: &Frame<'_>, p: &Placed<'_>, ledger: &mut Ledger<'_>, chosen: &mut Chosen, diameter_px: f64) -> EclipseAmounts {
    let Some(mut found) = before_sun(frame.request, frame.ephemeris, p, diameter_px, None) else {
        return EclipseAmounts::default();
    };
    if !ledger.effect(Effect::Eclipse, !found.casters.is_empty(), std::mem::take(&mut found.reason)) {
        found.casters.clear();
    }
    chosen.eclipse = eclipse::model(&mut found.casters, wanted(frame.request));
    ledger.tier(Effect::Eclipse.name(), tiers::of_eclipse(chosen.eclipse.model));
    eclipse::amounts_of(&found.casters, chosen.eclipse.model, &found.receiver, found.sun)
}

/// Which moons' shadows fall on the rings: switched together with those on the globe.
fn darkened_ring(frame: &Frame<'_>, p: &Placed<'_>, ledger: &mut Ledger<'_>, chosen: &mut Chosen, outer_km: f64) -> EclipseAmounts {
    let diameter_px = 2.0 * p.body.radii_km.x / (p.distance_km * frame.camera.pixel_tangent());
    let reach = outer_km / p.body.radii_km.x;
    let Some(mut found) = before_sun(frame.request, frame.ephemeris, p, diameter_px, Some(reach)) else {
        return EclipseAmounts::default();
    };
    if frame.request.effects.asked(Effect::Eclipse) == Some(false) {
        found.casters.clear();
        found.reason = "switched off with the eclipse".into();
    }
    ledger.note("eclipse-on-rings", !found.casters.is_empty(), found.reason);
    chosen.ring_eclipse = eclipse::model(&mut found.casters, wanted(frame.request));
    ledger.tier("eclipse-on-rings", tiers::of_eclipse(chosen.ring_eclipse.model));
    eclipse::amounts_of(&found.casters, chosen.ring_eclipse.model, &found.receiver, found.sun)
}

fn wanted(request: &ViewRequest) -> Wanted {
    match (request.effects.way(Effect::Eclipse), request.quality) {
        (Some("linear"), _) => Wanted::Asked(EclipseModel::Linear),
        (Some("uniform-disc"), _) => Wanted::Asked(EclipseModel::UniformDisc),
        (Some("limb-darkened"), _) => Wanted::Asked(EclipseModel::LimbDarkened),
        (Some(_), _) => Wanted::Asked(EclipseModel::Refracted),
        (None, Quality::Draft) => Wanted::Draft,
        (None, Quality::Standard | Quality::Reference) => Wanted::Best,
    }
}

struct BeforeSun<'a> {
    receiver: Receiver<'a>,
    sun: &'a Body,
    camera: DVec3,
    casters: Vec<eclipse::Caster<'a>>,
    reason: String,
}

/// The casters over a body that the viewer sees, or over all within `reach` equatorial radii of its centre; `None` where there is no Sun.
fn before_sun<'a>(
    request: &ViewRequest,
    ephemeris: &Ephemeris,
    p: &Placed<'a>,
    diameter_px: f64,
    reach: Option<f64>,
) -> Option<BeforeSun<'a>> {
    let body = p.body;
    let sun = p.catalog.body(NaifId::SUN).filter(|s| s.id != body.id)?;
    let (receiver, candidates) = p.before_sun.get_or_init(|| {
        let moving = ephemeris.state(body.id, NaifId::SOLAR_SYSTEM_BARYCENTER, p.seen_at, None);
        let receiver = Receiver {
            body,
            position_km: p.position_km,
            time: p.seen_at,
            body_from_icrf: p.body_from_icrf,
            velocity_km_s: moving.map_or(DVec3::ZERO, |a| a.state.vel_km_s),
            sun_from_body_km: p.sun_from_body_km,
        };
        let candidates = eclipse::candidates(ephemeris, p.catalog.bodies().iter(), sun, &receiver);
        (receiver, candidates)
    });
    let receiver = *receiver;
    let clouds = body.clouds.as_ref().map_or(1.0, |c| super::clouds::shell_scale(body, c));
    let air = body.atmosphere.as_ref().map_or(1.0, |a| 1.0 + a.top_km / body.radii_km.x);
    let camera = p.placement.camera_in_unit_sphere() * body.radii_km / body.radii_km.x;
    let mesh = super::meshes::model(request, body).map_or(1.0, |m| m.reach);
    let extent = Extent { reach: reach.unwrap_or(air.max(clouds).max(mesh)), camera: Some(camera), pixel: 2.0 / diameter_px.max(1e-9) };
    let everything = request.effects.asked(Effect::Eclipse) == Some(true);
    let found = eclipse::find_among(candidates, sun, &receiver, extent, everything);
    Some(BeforeSun { receiver, sun, camera, casters: found.casters, reason: found.reason })
}

/// About what part of its sunlight eclipses leave a body: the mean of what the viewer sees, and the most.
pub(super) fn dimming(request: &ViewRequest, ephemeris: &Ephemeris, p: &Placed<'_>, diameter_px: f64) -> (f64, f64) {
    if request.effects.asked(Effect::Eclipse) == Some(false) {
        return (1.0, 1.0);
    }
    let Some(mut found) = before_sun(request, ephemeris, p, diameter_px, None) else { return (1.0, 1.0) };
    let model = eclipse::model(&mut found.casters, wanted(request)).model;
    eclipse::estimate(&found.casters, model, &found.receiver, found.sun, found.camera)
}

fn name_of<'a>(frame: &Frame<'a>, id: NaifId) -> &'a str {
    frame.reflectors.iter().find(|r| r.body.id == id).map_or("?", |r| r.body.name.as_str())
}

/// The amounts of a draw of the globe, or of a shell around it by its own placement. `share`: part of the light that the disc carries.
fn amounts(
    frame: &Frame<'_>,
    p: &Placed<'_>,
    placement: &camera::Placement,
    rect: ClipRect,
    maps: MapSet,
    shine: &[LightOn],
    share: f64,
) -> Amounts {
    let (camera, body) = (frame.camera, p.body);
    let rays = camera.view_rays(placement, rect, AnchorForm::Auto);
    let gain = |map: &Option<Map>| map.as_ref().map_or(DVec3::ONE, |m| DVec3::from_array(m.gain));
    let emissive = matches!(body.photometry, Photometry::Emissive { .. });
    let brightness = brightness(p);
    let reflectance = match (maps.albedo, emissive) {
        (true, _) => gain(&body.maps.albedo),
        (false, true) => body.colour.as_dvec3(),
        (false, false) => body.colour.as_dvec3() * body.geometric_albedo,
    };
    let (u1, u2) = eclipse::limb_law(body);
    let photometric_parameter = match body.photometry {
        Photometry::LunarLambert { lunar_weight } => lunar_weight,
        Photometry::OrenNayar { roughness_deg } => roughness_deg.to_radians().powi(2),
        _ => 0.0,
    };
    // The correction of the Sun's phase is in the albedo; another body's light falls, and is seen, at a phase of its own.
    let of_phase = |l: &LightOn| {
        let alpha = crate::ephemeris::angle_rad(l.direction, -p.placement.centre_km);
        photometry::phase_correction(body, alpha, p.distance_km / body.radii_km.x) / brightness.max(1e-6)
    };
    let in_body = |l: &LightOn| Light {
        direction_in_body: camera::narrow((p.body_from_icrf * l.direction).normalize()),
        irradiance: camera::narrow(l.irradiance * if l.from == NaifId::SUN { 1.0 } else { of_phase(l) }),
    };
    let lights =
        if emissive { Vec::new() } else { std::iter::once(&lights::sunlight(p.sun_from_body_km)).chain(shine).map(in_body).collect() };
    let mut amounts = Amounts {
        axis_ratios: camera::narrow(body.radii_km / body.radii_km.x),
        albedo: camera::narrow(reflectance * tone(p) * share),
        lights,
        photometric_parameter: camera::narrow_scalar(photometric_parameter),
        limb_u1: camera::narrow(u1),
        limb_u2: camera::narrow(u2),
        map_latitude_stretch: camera::narrow_scalar(body.map_latitude_stretch()),
        night_radiance: camera::narrow(gain(&body.maps.night) * NIGHT_MAP_WHITE_RADIANCE * share),
        specular_strength: camera::narrow_scalar(gain(&body.maps.specular).x),
        wave_slope_sq: camera::narrow_scalar(WAVE_SLOPE_SQ),
        normal_strength: camera::narrow_scalar(gain(&body.maps.normal).x),
        clouds: super::clouds::amounts(body),
        eclipse: EclipseAmounts::default(),
        air: super::air::amounts(body, 1.0),
        camera_in_unit_sphere: rays.camera_in_unit_sphere,
        pixel_size: camera.clip_per_pixel(),
        ..Amounts::of_rays(&rays)
    };
    super::air::set_ends(&mut amounts, false);
    amounts
}
