//! What drawing costs: models of light, shapes, sampling, resolution and precision, each in a view that shows it.
//!
//! In: a session and an effort. Out: a [`ChoiceMeasure`]. Always: all options of a choice draw one view at one exposure; what a quality takes is read from the
//! scene that the program makes at that quality.

use super::pictures::{LightPicture, PlannedView, Studio, levels_apart, p999};
use super::rule::Unit;
use super::{Candidate, ChoiceMeasure, Effort, weighed};
use crate::catalog::NaifId;
use crate::render::plan::{self, SamplingQuality};
use crate::render::software::Precision;
use crate::scene::draw::{AtmosphereModel, BodyShadow, Draw, EclipseModel, PixelView, RingShadow};
use crate::scene::effects::EffectOverrides;
use crate::scene::request::{Layers, Position, Quality, ViewRequest};
use crate::session::{Session, SessionError, standard_scenes};
use crate::time::Instant;

const SATURN: NaifId = NaifId(699);
/// One sample a pixel, eight taps: nothing but the choice at hand differs.
const PLAIN: SamplingQuality = SamplingQuality { samples: 1, anisotropy: 8 };
/// 2022-11-08T09:45 UTC: half of the Moon in the umbra, half in the penumbra.
const MOON_IN_PENUMBRA_JD_TDB: f64 = 2_459_891.907_1;
/// 2017-05-17: the Sun 26 degrees above Saturn's rings.
const RINGS_OPEN_JD_TDB: f64 = 2_457_890.5;
/// 2024-06-08: the Earth without an eclipse.
const EARTH_JD_TDB: f64 = 2_460_469.762;

fn over(body: NaifId, jd_tdb: f64, towards: NaifId, distance_radii: f64, effort: Effort) -> ViewRequest {
    let position = Position::Over { towards: Some(towards), distance_radii: Some(distance_radii) };
    let side = effort.side_px();
    ViewRequest {
        position,
        fov_deg: Some(2.0 * (1.25 / distance_radii).asin().to_degrees()),
        width: side,
        height: side,
        ..ViewRequest::of(body, Instant::from_jd_tdb(jd_tdb))
    }
}

/// With effects switched as `--effects` does.
fn with_effects(request: &ViewRequest, effects: &str) -> Result<ViewRequest, SessionError> {
    let text = format!("{},{effects}", request.effects.to_text());
    Ok(ViewRequest { effects: EffectOverrides::parse(text.trim_matches(','))?, ..request.clone() })
}

/// A standard scene without what is drawn in pixels and not in angles (points, stars, glare), which would change with the picture's size.
pub(super) fn standard(name: &str, effort: Effort) -> Result<ViewRequest, SessionError> {
    let side = effort.side_px();
    let scene = standard_scenes(side, side).into_iter().find(|s| s.name == name).map(|s| s.request);
    let request = scene.unwrap_or_else(|| ViewRequest::of(NaifId::EARTH, Instant::from_jd_tdb(EARTH_JD_TDB)));
    with_effects(&ViewRequest { layers: Layers { stars: false, ..Layers::default() }, ..request }, "-points,-glow")
}

/// The qualities whose scene of this view has `what`.
fn qualities(studio: &Studio<'_>, request: &ViewRequest, what: impl Fn(&Draw) -> bool) -> Result<Vec<Quality>, SessionError> {
    let mut found = Vec::new();
    for quality in Quality::ALL {
        let view = studio.planned(&ViewRequest { quality, ..request.clone() }, PLAIN)?;
        if view.scene.draws.iter().any(&what) {
            found.push(quality);
        }
    }
    Ok(found)
}

/// Percent of the truth's greatest light by which a picture differs at most.
fn percent_of_light(picture: &LightPicture, truth: &LightPicture) -> f64 {
    let most = truth.light.iter().flat_map(|p| p[..3].iter()).fold(0.0_f32, |a, b| a.max(*b));
    let apart = picture.light.iter().zip(&truth.light).flat_map(|(p, q)| (0..3).map(move |c| (p[c] - q[c]).abs())).fold(0.0, f32::max);
    100.0 * f64::from(apart) / f64::from(most.max(f32::MIN_POSITIVE))
}

/// An option that draws one planned view.
fn drawing<'a>(
    studio: &'a Studio<'_>,
    name: &str,
    view: PlannedView,
    precision: Precision,
    default_of: Vec<Quality>,
    error: impl Fn(&LightPicture) -> f64,
) -> Result<Candidate<'a>, SessionError> {
    let error = error(&studio.light(&view, precision)?);
    Ok(Candidate { name: name.to_owned(), error, default_of, work: Box::new(move || studio.draw(&view, precision)) })
}

/// Who darkens the Sun, by which model.
pub(super) fn eclipse_model(session: &Session, effort: Effort) -> Result<ChoiceMeasure, SessionError> {
    let studio = Studio::new(session)?;
    let request = over(NaifId::MOON, MOON_IN_PENUMBRA_JD_TDB, NaifId::EARTH, 20.0, effort);
    let request = ViewRequest { pixel_view: PixelView::Eclipse, ..request };
    let asked = |model: EclipseModel| with_effects(&request, &format!("+eclipse={}", model.name()));
    let truth = studio.light(&studio.planned(&asked(EclipseModel::Refracted)?, PLAIN)?, Precision::F64)?;
    let mut candidates = Vec::new();
    for model in EclipseModel::CHOICES {
        let asked = asked(model)?;
        let default_of = qualities(&studio, &request, |d| d.body == NaifId::MOON && d.features.eclipse.model == model)?;
        let measured =
            drawing(&studio, model.name(), studio.planned(&asked, PLAIN)?, Precision::F32, vec![], |p| percent_of_light(p, &truth))?;
        // The error is of sunlight on the ground; the time is that of the picture.
        let shown = studio.planned(&ViewRequest { pixel_view: PixelView::Final, ..asked }, PLAIN)?;
        let studio = &studio;
        candidates.push(Candidate { default_of, work: Box::new(move || studio.draw(&shown, Precision::F32)), ..measured });
    }
    weighed("eclipse", "sunlight on the Moon, 2022-11-08T09:45, half of it in the umbra", Unit::PercentOfLight, effort.rounds(), candidates)
}

/// Saturn's view with another model in all draws.
fn with_draws(studio: &Studio<'_>, request: &ViewRequest, change: impl Fn(&mut Draw)) -> Result<PlannedView, SessionError> {
    let mut scene = studio.planned(request, PLAIN)?.scene;
    scene.draws.iter_mut().for_each(change);
    let plan = plan::plan(&scene, studio.session, PLAIN)?;
    Ok(PlannedView { scene, plan })
}

/// The rings' shadow on their planet.
pub(super) fn ring_shadow(session: &Session, effort: Effort) -> Result<ChoiceMeasure, SessionError> {
    let studio = Studio::new(session)?;
    let request = studio.exposed(over(SATURN, RINGS_OPEN_JD_TDB, NaifId::EARTH, 2.0, effort))?;
    let model_of = |model: RingShadow| {
        with_draws(&studio, &request, |d| {
            if d.features.ring_shadow != RingShadow::None {
                d.features.ring_shadow = model;
            }
        })
    };
    let truth = studio.light(&model_of(RingShadow::Penumbra)?, Precision::F64)?;
    let mut candidates = Vec::new();
    for (model, name) in [(RingShadow::PointSun, "point-sun"), (RingShadow::Penumbra, "penumbra")] {
        let default_of = qualities(&studio, &request, |d| d.features.ring_shadow == model)?;
        candidates.push(drawing(&studio, name, model_of(model)?, Precision::F32, default_of, |p| p999(levels_apart(p, &truth)))?);
    }
    weighed("ring-shadow", "Saturn from 2 radii, 2017-05-17, the Sun 26 degrees above the rings", Unit::Levels, effort.rounds(), candidates)
}

/// The planet's shadow on its rings.
pub(super) fn body_shadow(session: &Session, effort: Effort) -> Result<ChoiceMeasure, SessionError> {
    let studio = Studio::new(session)?;
    // From the side of Uranus the shadow is seen beside the globe.
    let request = studio.exposed(over(SATURN, RINGS_OPEN_JD_TDB, NaifId(799), 4.0, effort))?;
    let model_of = |model: BodyShadow| {
        with_draws(&studio, &request, |d| {
            if d.features.body_shadow != BodyShadow::None {
                d.features.body_shadow = model;
            }
        })
    };
    let truth = studio.light(&model_of(BodyShadow::EllipsoidPenumbra)?, Precision::F64)?;
    let mut candidates = Vec::new();
    for (model, name) in [(BodyShadow::Sphere, "sphere"), (BodyShadow::EllipsoidPenumbra, "ellipsoid-penumbra")] {
        let default_of = qualities(&studio, &request, |d| d.features.body_shadow == model)?;
        candidates.push(drawing(&studio, name, model_of(model)?, Precision::F32, default_of, |p| p999(levels_apart(p, &truth)))?);
    }
    weighed("body-shadow", "Saturn from 4 radii, 2017-05-17, seen from aside", Unit::Levels, effort.rounds(), candidates)
}

/// How finely the light of the air is summed.
pub(super) fn air_tier(session: &Session, effort: Effort) -> Result<ChoiceMeasure, SessionError> {
    let studio = Studio::new(session)?;
    let request = studio.exposed(over(NaifId::EARTH, EARTH_JD_TDB, NaifId::MOON, 3.0, effort))?;
    let asked = |tier: AtmosphereModel| with_effects(&request, &format!("+atmosphere={}", tier.name()));
    let truth = studio.light(&studio.planned(&asked(AtmosphereModel::Table)?, PLAIN)?, Precision::F64)?;
    let mut candidates = Vec::new();
    for tier in AtmosphereModel::CHOICES {
        let default_of = qualities(&studio, &request, |d| d.features.air.tier == tier)?;
        let view = studio.planned(&asked(tier)?, PLAIN)?;
        candidates.push(drawing(&studio, tier.name(), view, Precision::F32, default_of, |p| p999(levels_apart(p, &truth)))?);
    }
    let about = "the Earth from 3 radii, day and night; against the table, for the others leave out light that is scattered more than once";
    weighed("air", about, Unit::Levels, effort.rounds(), candidates)
}

/// A sphere or the oblate figure.
pub(super) fn shape(session: &Session, effort: Effort) -> Result<ChoiceMeasure, SessionError> {
    let studio = Studio::new(session)?;
    let request = over(SATURN, RINGS_OPEN_JD_TDB, NaifId::SUN, 4.0, effort);
    let request = with_effects(&request, "-rings,-ring-shadow,-ring-shine,-atmosphere,-eclipse,-points,-planet-shine")?;
    // Of one colour, so that a pixel's light is the part of it that the disc covers.
    let outline = ViewRequest { pixel_view: PixelView::Albedo, ..with_effects(&request, "-albedo")? };
    let asked = |on: bool| with_effects(&request, if on { "+ellipsoid" } else { "-ellipsoid" });
    let outline_of = |on: bool, precision| {
        let of = with_effects(&outline, if on { "+ellipsoid" } else { "-ellipsoid" })?;
        studio.light(&studio.planned(&of, PLAIN)?, precision)
    };
    let truth = outline_of(true, Precision::F64)?;
    let full = truth.light.iter().map(|p| f64::from(p[1])).fold(0.0, f64::max);
    let covered = |p: &LightPicture| p.light.iter().map(|p| f64::from(p[1]) / full).sum::<f64>();
    // As long as that of a disc of the same area.
    let limb_px = (4.0 * std::f64::consts::PI * covered(&truth)).sqrt();
    let mut candidates = Vec::new();
    for (on, name) in [(false, "sphere"), (true, "ellipsoid")] {
        let apart = outline_of(on, Precision::F32)?;
        let area: f64 = apart.light.iter().zip(&truth.light).map(|(p, q)| f64::from((p[1] - q[1]).abs()) / full).sum();
        let default_of = qualities(&studio, &request, |d| {
            let is_sphere = d.features.shape == crate::scene::draw::Shape::Sphere;
            d.body == SATURN && is_sphere != on
        })?;
        candidates.push(drawing(&studio, name, studio.planned(&asked(on)?, PLAIN)?, Precision::F32, default_of, |_| area / limb_px)?);
    }
    weighed("shape", "Saturn's globe, as wide as 0.8 of the picture", Unit::PixelsOfLimb, effort.rounds(), candidates)
}

/// Taps along the footprint of a pixel on a map.
pub(super) fn map_taps(session: &Session, effort: Effort) -> Result<ChoiceMeasure, SessionError> {
    let studio = Studio::new(session)?;
    let request = studio.exposed(standard("moon-limb", effort)?)?;
    let truth = studio.best(&request)?;
    let mut candidates = Vec::new();
    for anisotropy in [1, 2, 4, 8, 16] {
        let sampling = SamplingQuality { samples: 4, anisotropy };
        let default_of = Quality::ALL.into_iter().filter(|q| SamplingQuality::of(*q).anisotropy == anisotropy).collect();
        let view = studio.planned(&request, sampling)?;
        candidates.push(drawing(&studio, &anisotropy.to_string(), view, Precision::F32, default_of, |p| p999(levels_apart(p, &truth)))?);
    }
    weighed("map-taps", "the Moon's ground and horizon from 400 km; against 64 samples a pixel", Unit::Levels, effort.rounds(), candidates)
}

/// Samples of a pixel.
pub(super) fn samples(session: &Session, effort: Effort) -> Result<ChoiceMeasure, SessionError> {
    let studio = Studio::new(session)?;
    let request = studio.exposed(standard("saturn", effort)?)?;
    let truth = studio.best(&request)?;
    let mut candidates = Vec::new();
    for samples in [1, 4] {
        let sampling = SamplingQuality { samples, anisotropy: 8 };
        let default_of = Quality::ALL.into_iter().filter(|q| SamplingQuality::of(*q).samples == samples).collect();
        let view = studio.planned(&request, sampling)?;
        candidates.push(drawing(&studio, &samples.to_string(), view, Precision::F32, default_of, |p| p999(levels_apart(p, &truth)))?);
    }
    weighed("samples", "Saturn with its rings; against 64 samples a pixel", Unit::Levels, effort.rounds(), candidates)
}

/// Whole pixels, or fewer that are stretched over the window while things move.
pub(super) fn resolution(session: &Session, effort: Effort) -> Result<ChoiceMeasure, SessionError> {
    let studio = Studio::new(session)?;
    let request = studio.exposed(standard("saturn", effort)?)?;
    let side = |by: u32| request.width.div_ceil(by);
    let coarse = |by: u32| {
        studio.planned(&ViewRequest { width: side(by), height: side(by), ..request.clone() }, SamplingQuality::of(Quality::Standard))
    };
    let whole = studio.light(&coarse(1)?, Precision::F32)?;
    let mut candidates = Vec::new();
    for by in [5, 4, 3, 2, 1] {
        let view = coarse(by)?;
        let error = |p: &LightPicture| p999(levels_apart(&p.stretched(whole.width, whole.height), &whole));
        let default_of = if by == 1 { Quality::ALL.to_vec() } else { vec![] };
        candidates.push(drawing(&studio, &format!("1/{by}"), view, Precision::F32, default_of, error)?);
    }
    let about =
        "Saturn in motion, drawn with fewer pixels on each side and stretched; the window takes the finest that keeps 30 frames a second";
    weighed("resolution", about, Unit::Levels, effort.rounds(), candidates)
}

/// f32 or f64.
pub(super) fn precision(session: &Session, effort: Effort) -> Result<ChoiceMeasure, SessionError> {
    let studio = Studio::new(session)?;
    let request = studio.exposed(standard("earth-3-radii", effort)?)?;
    let view = || studio.planned(&request, PLAIN);
    let truth = studio.light(&view()?, Precision::F64)?;
    let mut candidates = Vec::new();
    for (precision, name, default_of) in
        [(Precision::F32, "f32", vec![Quality::Draft, Quality::Standard]), (Precision::F64, "f64", vec![Quality::Reference])]
    {
        candidates.push(drawing(&studio, name, view()?, precision, default_of, |p| p999(levels_apart(p, &truth)))?);
    }
    weighed("precision", "the Earth from 3 radii in an eclipse", Unit::Levels, effort.rounds(), candidates)
}
