//! Cost and error of drawing bodies. The choices (settings with several options) are the models of light and of shape, sampling, resolution and precision.
//! Each is measured in views in which its options differ.
//!
//! In: a session and an effort (how long the measurement may take). Out: a [`ChoiceMeasure`]. Always: all options of a choice draw the same views at the same
//! exposures. Which model a quality uses is read from the scene that the program builds at that quality; every quality uses the full resolution.

use super::images::{LinearImage, PlannedView, PrecisionRenderers, SINGLE_SAMPLE, larger_or_nan, level_differences, p999, precision_of};
use super::rule::ErrorUnit;
use super::{Candidate, ChoiceMeasure, Effort, measure_choice};
use crate::catalog::NaifId;
use crate::ephemeris::topocentric::ground_point_km;
use crate::render::plan::{self, SamplingQuality};
use crate::render::software::Precision;
use crate::scene::draw::{AtmosphereModel, BodyShadow, Draw, EclipseModel, PixelView, RingShadow, Shape};
use crate::scene::effects::EffectOverrides;
use crate::scene::request::{Axes, Layers, Look, Position, Quality, Up, ViewRequest};
use crate::session::invented_shape::{InventedShape, PHOBOS};
use crate::session::{Session, SessionError, Sources, standard_scenes};
use crate::time::Instant;
use glam::DVec3;

const SATURN: NaifId = NaifId(699);
const URANUS: NaifId = NaifId(799);
/// 2022-11-08T09:45 UTC: half of the Moon in the umbra, half in the penumbra.
const MOON_HALF_IN_UMBRA_JD_TDB: f64 = 2_459_891.907_1;
/// 2017-05-17: the Sun 26 degrees above Saturn's rings.
const RINGS_OPEN_JD_TDB: f64 = 2_457_890.5;
/// 2024-06-08: the Earth without an eclipse.
const EARTH_JD_TDB: f64 = 2_460_469.762;
/// Number of latitude bands of the shape model. With 144 columns it has 2 * 144 * (72 - 1) = 20,448 triangles.
const SHAPE_MODEL_BANDS: u32 = 72;
/// East longitude where the Sun is low in the west at [`EARTH_JD_TDB`]: at this instant the Sun is in the zenith at 86 degrees east.
const LONGITUDE_OF_LOW_SUN_DEG: f64 = 165.0;

/// A square view of `body`. The camera is at `distance_radii` (equatorial radii) from the body's centre, in the direction of the body `towards`. The field of
/// view is a quarter wider than the disc.
fn view_from_direction(body: NaifId, jd_tdb: f64, towards: NaifId, distance_radii: f64, effort: Effort) -> ViewRequest {
    let position = Position::AboveTarget { towards: Some(towards), distance_radii: Some(distance_radii) };
    let side = effort.side_px();
    ViewRequest {
        position,
        fov_deg: Some(2.0 * (1.25 / distance_radii).asin().to_degrees()),
        width: side,
        height: side,
        ..ViewRequest::of(body, Instant::from_jd_tdb(jd_tdb))
    }
}

/// The request with further effects, in the syntax of `--effects`.
fn with_effects(request: &ViewRequest, effects: &str) -> Result<ViewRequest, SessionError> {
    let text = format!("{},{effects}", request.effects.to_text());
    Ok(ViewRequest { effects: EffectOverrides::parse(text.trim_matches(','))?, ..request.clone() })
}

/// A standard scene without features of a fixed size in pixels (points, stars, glare), which would make the error depend on the image's size. A name that no
/// standard scene has gives the default view of the Earth.
pub(super) fn standard_request(name: &str, effort: Effort) -> Result<ViewRequest, SessionError> {
    let side = effort.side_px();
    let scene = standard_scenes(side, side).into_iter().find(|s| s.name == name).map(|s| s.request);
    let request = scene.unwrap_or_else(|| ViewRequest::of(NaifId::EARTH, Instant::from_jd_tdb(EARTH_JD_TDB)));
    with_effects(&ViewRequest { layers: Layers { stars: false, ..Layers::default() }, ..request }, "-points,-glow")
}

/// The qualities at which the scene of this view contains a draw that satisfies `condition`.
fn qualities_with_draw(
    renderers: &PrecisionRenderers<'_>,
    request: &ViewRequest,
    condition: impl Fn(&Draw) -> bool,
) -> Result<Vec<Quality>, SessionError> {
    let mut found = Vec::new();
    for quality in Quality::ALL {
        let view = renderers.plan_view(&ViewRequest { quality, ..request.clone() }, SINGLE_SAMPLE)?;
        if view.scene.draws.iter().any(&condition) {
            found.push(quality);
        }
    }
    Ok(found)
}

/// Difference from the reference in percent of the reference pixel's radiance: the 99.9th percentile over pixels and channels. A faint pixel counts as much
/// as a bright one, because the exposure may be chosen for it. Channels without light in the reference are left out.
fn p999_percent_of_pixel_light(image: &LinearImage, reference: &LinearImage) -> f64 {
    let channels = image.light.iter().zip(&reference.light).flat_map(|(p, q)| (0..3).map(move |c| (f64::from(p[c]), f64::from(q[c]))));
    p999(channels.filter(|(_, q)| *q > 0.0).map(|(p, q)| 100.0 * (p - q).abs() / q).collect())
}

/// Sum of absolute differences from the reference, in percent of the reference's summed light.
fn summed_difference_percent(image: &LinearImage, reference: &LinearImage) -> f64 {
    let sum = |value_at: &dyn Fn(usize, usize) -> f32| {
        (0..reference.light.len()).map(|k| (0..3).map(|c| f64::from(value_at(k, c))).sum::<f64>()).sum::<f64>()
    };
    let difference = sum(&|k, c| (image.light[k][c] - reference.light[k][c]).abs());
    100.0 * difference / sum(&|k, c| reference.light[k][c]).max(f64::MIN_POSITIVE)
}

/// The candidate that draws one planned view. `default_of`: the qualities that use it in the program.
fn candidate<'a>(
    renderers: &'a PrecisionRenderers<'_>,
    name: &str,
    view: PlannedView,
    precision: Precision,
    default_of: Vec<Quality>,
    error: impl Fn(&LinearImage) -> f64,
) -> Result<Candidate<'a>, SessionError> {
    let error = error(&renderers.draw_linear(&view, precision)?);
    Ok(Candidate { name: name.to_owned(), error, default_of, workload: Box::new(move || renderers.draw(&view, precision)) })
}

/// The eclipse models.
pub(super) fn eclipse_model(session: &Session, effort: Effort) -> Result<ChoiceMeasure, SessionError> {
    let renderers = PrecisionRenderers::new(session)?;
    let request = view_from_direction(NaifId::MOON, MOON_HALF_IN_UMBRA_JD_TDB, NaifId::EARTH, 20.0, effort);
    let request = ViewRequest { pixel_view: PixelView::Eclipse, ..request };
    let with_model = |model: EclipseModel| with_effects(&request, &format!("+eclipse={}", model.name()));
    let reference = renderers.draw_linear(&renderers.plan_view(&with_model(EclipseModel::Refracted)?, SINGLE_SAMPLE)?, Precision::F64)?;
    let mut candidates = Vec::new();
    for model in EclipseModel::CHOICES {
        let request_of_model = with_model(model)?;
        let default_of = qualities_with_draw(&renderers, &request, |d| d.body == NaifId::MOON && d.features.eclipse.model == model)?;
        let eclipse_view = renderers.plan_view(&request_of_model, SINGLE_SAMPLE)?;
        let default_set_below = Vec::new();
        let measured = candidate(&renderers, model.name(), eclipse_view, Precision::F32, default_set_below, |p| {
            p999_percent_of_pixel_light(p, &reference)
        })?;
        // The error is that of the sunlight on the ground; the time is that of the final image.
        let final_view = renderers.plan_view(&ViewRequest { pixel_view: PixelView::Final, ..request_of_model }, SINGLE_SAMPLE)?;
        let renderers = &renderers;
        candidates.push(Candidate { default_of, workload: Box::new(move || renderers.draw(&final_view, Precision::F32)), ..measured });
    }
    measure_choice(
        "eclipse",
        "sunlight on the Moon, 2022-11-08T09:45, half of it in the umbra; in percent of each pixel's own light",
        ErrorUnit::PercentOfLight,
        effort.rounds(),
        candidates,
    )
}

/// The planned view with `change` applied to all draws of its scene.
fn plan_with_changed_draws(
    renderers: &PrecisionRenderers<'_>,
    request: &ViewRequest,
    change: impl Fn(&mut Draw),
) -> Result<PlannedView, SessionError> {
    let mut scene = renderers.plan_view(request, SINGLE_SAMPLE)?.scene;
    scene.draws.iter_mut().for_each(change);
    let plan = plan::plan(&scene, renderers.session, SINGLE_SAMPLE)?;
    Ok(PlannedView { scene, plan })
}

/// The models of the rings' shadow on their planet.
pub(super) fn ring_shadow(session: &Session, effort: Effort) -> Result<ChoiceMeasure, SessionError> {
    let renderers = PrecisionRenderers::new(session)?;
    let request = renderers.with_metered_exposure(view_from_direction(SATURN, RINGS_OPEN_JD_TDB, NaifId::EARTH, 2.0, effort))?;
    let plan_of = |model: RingShadow| {
        plan_with_changed_draws(&renderers, &request, |d| {
            if d.features.ring_shadow.is_of_own_rings() {
                d.features.ring_shadow = model;
            }
        })
    };
    let reference = renderers.draw_linear(&plan_of(RingShadow::Penumbra)?, Precision::F64)?;
    let mut candidates = Vec::new();
    for (model, name) in [(RingShadow::PointSun, "point-sun"), (RingShadow::Penumbra, "penumbra")] {
        let default_of = qualities_with_draw(&renderers, &request, |d| d.features.ring_shadow == model)?;
        candidates
            .push(candidate(&renderers, name, plan_of(model)?, Precision::F32, default_of, |p| p999(level_differences(p, &reference)))?);
    }
    measure_choice(
        "ring-shadow",
        "Saturn from 2 radii, 2017-05-17, the Sun 26 degrees above the rings",
        ErrorUnit::Levels,
        effort.rounds(),
        candidates,
    )
}

/// The models of the planet's shadow on its rings.
pub(super) fn body_shadow(session: &Session, effort: Effort) -> Result<ChoiceMeasure, SessionError> {
    let renderers = PrecisionRenderers::new(session)?;
    // From the direction of Uranus the shadow is visible beside the globe.
    let request = renderers.with_metered_exposure(view_from_direction(SATURN, RINGS_OPEN_JD_TDB, URANUS, 4.0, effort))?;
    let plan_of = |model: BodyShadow| {
        plan_with_changed_draws(&renderers, &request, |d| {
            if d.features.body_shadow != BodyShadow::None {
                d.features.body_shadow = model;
            }
        })
    };
    let reference = renderers.draw_linear(&plan_of(BodyShadow::EllipsoidPenumbra)?, Precision::F64)?;
    let mut candidates = Vec::new();
    for (model, name) in [(BodyShadow::Sphere, "sphere"), (BodyShadow::EllipsoidPenumbra, "ellipsoid-penumbra")] {
        let default_of = qualities_with_draw(&renderers, &request, |d| d.features.body_shadow == model)?;
        candidates
            .push(candidate(&renderers, name, plan_of(model)?, Precision::F32, default_of, |p| p999(level_differences(p, &reference)))?);
    }
    measure_choice("body-shadow", "Saturn from 4 radii, 2017-05-17, seen from the side", ErrorUnit::Levels, effort.rounds(), candidates)
}

/// The Earth's day side from 3 radii (towards the Moon, two days after new moon), its limb from 400 km, and the sky at the
/// horizon from the ground. The views of limb and sky look north, with the Sun 12 to 17 degrees above the horizon in the west, outside the image.
fn atmosphere_views(renderers: &PrecisionRenderers<'_>, effort: Effort) -> Result<[ViewRequest; 3], SessionError> {
    let globe = view_from_direction(NaifId::EARTH, EARTH_JD_TDB, NaifId::MOON, 3.0, effort);
    // Three times as wide and as high. As in a window, the disc is then large enough for the coarse image of the air (`air-pass`), and its rim is wide enough
    // to be drawn without averaging over pixels (`air-rim`).
    let globe = ViewRequest { width: 3 * globe.width, height: 3 * globe.height, ..globe };
    let radii_km = renderers.session.catalog().body(NaifId::EARTH).map_or(DVec3::ONE, |earth| earth.radii_km);
    let northwards = |latitude_deg: f64, height_km: f64, altitude_deg: f64| {
        let (_, zenith) = ground_point_km(radii_km, latitude_deg, LONGITUDE_OF_LOW_SUN_DEG, height_km);
        let north = (DVec3::Z - zenith * zenith.z).normalize();
        let (sin, cos) = altitude_deg.to_radians().sin_cos();
        ViewRequest {
            position: Position::Ground { body: NaifId::EARTH, latitude_deg, longitude_deg: LONGITUDE_OF_LOW_SUN_DEG, height_km },
            look: Look::Along { direction: north * cos + zenith * sin, axes: Axes::BodyFixed },
            up: Up::Zenith,
            target: None,
            fov_deg: Some(40.0),
            ..globe.clone()
        }
    };
    // From 400 km the horizon is 20 degrees below the horizontal. The numbers: latitude, height of the camera, altitude of its direction.
    let (limb, sky) = (northwards(20.0, 400.0, -20.0), northwards(5.0, 0.1, 10.0));
    Ok([renderers.with_metered_exposure(globe.clone())?, renderers.with_metered_exposure(limb)?, renderers.with_metered_exposure(sky)?])
}

/// The models of atmospheric scattering, seen from far away.
pub(super) fn air_model(session: &Session, effort: Effort) -> Result<ChoiceMeasure, SessionError> {
    let renderers = PrecisionRenderers::new(session)?;
    let [globe, ..] = atmosphere_views(&renderers, effort)?;
    air_choice(&renderers, "air", "the Earth from 3 radii, against the table; the others leave out light scattered twice", &[globe], effort)
}

/// The models of atmospheric scattering, seen from the air and from an orbit close to it.
pub(super) fn near_air_model(session: &Session, effort: Effort) -> Result<ChoiceMeasure, SessionError> {
    let renderers = PrecisionRenderers::new(session)?;
    let [_, limb, sky] = atmosphere_views(&renderers, effort)?;
    let about =
        "the Earth's limb from 400 km and its sky at a low Sun, the worse; against the table; the others leave out light scattered twice";
    air_choice(&renderers, "air-near", about, &[limb, sky], effort)
}

/// Measures the models of atmospheric scattering in `views`. The error of a model is the greatest of its errors in these views.
fn air_choice(
    renderers: &PrecisionRenderers<'_>,
    name: &'static str,
    about: &'static str,
    views: &[ViewRequest],
    effort: Effort,
) -> Result<ChoiceMeasure, SessionError> {
    let plan_of = |request: &ViewRequest, model: AtmosphereModel| {
        renderers.plan_view(&with_effects(request, &format!("-clouds,+atmosphere={}", model.name()))?, SINGLE_SAMPLE)
    };
    let mut references = Vec::new();
    for request in views {
        references.push(renderers.draw_linear(&plan_of(request, AtmosphereModel::Table)?, Precision::F64)?);
    }
    let mut candidates = Vec::new();
    for model in AtmosphereModel::CHOICES {
        let default_of = qualities_with_draw(renderers, &views[0], |d| d.features.air.model == model)?;
        let mut worst = 0.0_f64;
        let mut planned_views = Vec::new();
        for (request, reference) in views.iter().zip(&references) {
            let view = plan_of(request, model)?;
            worst = larger_or_nan(worst, summed_difference_percent(&renderers.draw_linear(&view, Precision::F32)?, reference));
            planned_views.push(view);
        }
        let workload = Box::new(move || planned_views.iter().try_for_each(|view| renderers.draw(view, Precision::F32)));
        candidates.push(Candidate { name: model.name().to_owned(), error: worst, default_of, workload });
    }
    measure_choice(name, about, ErrorUnit::PercentOfLight, effort.rounds(), candidates)
}

/// Shading with the normals of a sphere or of the ellipsoid; the outline is that of the ellipsoid either way.
pub(super) fn shape(session: &Session, effort: Effort) -> Result<ChoiceMeasure, SessionError> {
    let renderers = PrecisionRenderers::new(session)?;
    let request = view_from_direction(SATURN, RINGS_OPEN_JD_TDB, URANUS, 4.0, effort);
    let request = renderers
        .with_metered_exposure(with_effects(&request, "-rings,-ring-shadow,-ring-shine,-atmosphere,-eclipse,-points,-planet-shine")?)?;
    let plan_of = |shape: Shape| {
        let effect = if shape == Shape::Ellipsoid { "+ellipsoid" } else { "-ellipsoid" };
        renderers.plan_target_body(&with_effects(&request, effect)?, SINGLE_SAMPLE)
    };
    let reference = renderers.draw_linear(&plan_of(Shape::Ellipsoid)?, Precision::F64)?;
    let mut candidates = Vec::new();
    for (shape, name) in [(Shape::Sphere, "sphere"), (Shape::Ellipsoid, "ellipsoid")] {
        let default_of = qualities_with_draw(&renderers, &request, |d| d.body == SATURN && d.features.shape == shape)?;
        candidates
            .push(candidate(&renderers, name, plan_of(shape)?, Precision::F32, default_of, |p| p999(level_differences(p, &reference)))?);
    }
    measure_choice(
        "shape",
        "shading of Saturn's globe; the outline is the ellipsoid's in both",
        ErrorUnit::Levels,
        effort.rounds(),
        candidates,
    )
}

/// Candidates that differ in sampling. Each option: its name, its sampling, and the qualities that use it. They are timed in f32, but their errors are those of
/// images in f64, which have no rounding errors of f32.
fn sampling_candidates<'a>(
    renderers: &'a PrecisionRenderers<'_>,
    request: &ViewRequest,
    options: impl Iterator<Item = (String, SamplingQuality, Vec<Quality>)>,
    finest: SamplingQuality,
) -> Result<Vec<Candidate<'a>>, SessionError> {
    let reference = renderers.draw_linear(&renderers.plan_target_body(request, finest)?, Precision::F64)?;
    let mut candidates = Vec::new();
    for (name, sampling, default_of) in options {
        let view = renderers.plan_target_body(request, sampling)?;
        let error = p999(level_differences(&renderers.draw_linear(&view, Precision::F64)?, &reference));
        candidates.push(Candidate { name, error, default_of, workload: Box::new(move || renderers.draw(&view, Precision::F32)) });
    }
    Ok(candidates)
}

/// The qualities whose sampling satisfies `condition`.
fn qualities_with_sampling(condition: impl Fn(SamplingQuality) -> bool) -> Vec<Quality> {
    Quality::ALL.into_iter().filter(|q| condition(SamplingQuality::of(*q))).collect()
}

/// Taps along the footprint of a pixel on a map (anisotropic filtering).
pub(super) fn map_taps(session: &Session, effort: Effort) -> Result<ChoiceMeasure, SessionError> {
    let renderers = PrecisionRenderers::new(session)?;
    let request = renderers.with_metered_exposure(standard_request("moon-limb", effort)?)?;
    let options = [1_u8, 2, 4, 8, 16].map(|anisotropy| {
        let sampling = SamplingQuality { samples: 4, anisotropy };
        (anisotropy.to_string(), sampling, qualities_with_sampling(|s| s.anisotropy == anisotropy))
    });
    let candidates = sampling_candidates(&renderers, &request, options.into_iter(), SamplingQuality::of(Quality::Reference))?;
    measure_choice("map-taps", "the Moon's ground and horizon from 400 km; against 16 taps", ErrorUnit::Levels, effort.rounds(), candidates)
}

/// Samples per pixel, on the triangles of a shape model. Limbs, rings and lines have antialiased edges at one sample, too.
pub(super) fn samples(session: &Session, effort: Effort) -> Result<ChoiceMeasure, SessionError> {
    let shape = InventedShape::of(session.sources(), SHAPE_MODEL_BANDS)?;
    // Everything is drawn in software, so no GPU is opened. Messages about the user's files were printed when the first session was opened.
    let session = Session::open(&Sources { will_draw: false, ..shape.sources.clone() }, |_| {})?;
    let renderers = PrecisionRenderers::new(&session)?;
    let view = view_from_direction(PHOBOS, EARTH_JD_TDB, NaifId::SUN, 4.0, effort);
    let request = renderers.with_metered_exposure(with_effects(&view, "-points,-glow")?)?;
    let options = [1_u8, 4].map(|samples| {
        (samples.to_string(), SamplingQuality { samples, ..SINGLE_SAMPLE }, qualities_with_sampling(|s| s.samples == samples))
    });
    let candidates = sampling_candidates(&renderers, &request, options.into_iter(), SamplingQuality { samples: 4, ..SINGLE_SAMPLE })?;
    let about = "an invented shape model of Phobos; against 4 samples; limbs, rings and lines are antialiased at 1 sample, too";
    measure_choice("samples", about, ErrorUnit::Levels, effort.rounds(), candidates)
}

/// Full resolution, or the lower resolutions that the window scales up while the view moves.
pub(super) fn resolution(session: &Session, effort: Effort) -> Result<ChoiceMeasure, SessionError> {
    let renderers = PrecisionRenderers::new(session)?;
    let request = renderers.with_metered_exposure(standard_request("saturn", effort)?)?;
    let side = |divisor: u32| request.width.div_ceil(divisor);
    let plan_reduced = |divisor: u32| {
        renderers.plan_target_body(
            &ViewRequest { width: side(divisor), height: side(divisor), ..request.clone() },
            SamplingQuality::of(Quality::Standard),
        )
    };
    let full_resolution = renderers.draw_linear(&plan_reduced(1)?, Precision::F32)?;
    let mut candidates = Vec::new();
    for divisor in [5, 4, 3, 2, 1] {
        let view = plan_reduced(divisor)?;
        let error =
            |p: &LinearImage| p999(level_differences(&p.upsampled(full_resolution.width, full_resolution.height), &full_resolution));
        let default_of = if divisor == 1 { Quality::ALL.to_vec() } else { vec![] };
        candidates.push(candidate(&renderers, &format!("1/{divisor}"), view, Precision::F32, default_of, error)?);
    }
    let about =
        "Saturn in motion, drawn with fewer pixels on each side and stretched; the window takes the finest that keeps 30 frames a second";
    measure_choice("resolution", about, ErrorUnit::Levels, effort.rounds(), candidates)
}

/// Precision: f32 or f64.
pub(super) fn precision(session: &Session, effort: Effort) -> Result<ChoiceMeasure, SessionError> {
    let renderers = PrecisionRenderers::new(session)?;
    let request = renderers.with_metered_exposure(standard_request("earth-3-radii", effort)?)?;
    let view = || renderers.plan_view(&request, SINGLE_SAMPLE);
    let reference = renderers.draw_linear(&view()?, Precision::F64)?;
    let mut candidates = Vec::new();
    for (precision, name) in [(Precision::F32, "f32"), (Precision::F64, "f64")] {
        let default_of = Quality::ALL.into_iter().filter(|q| precision_of(*q) == precision).collect();
        candidates.push(candidate(&renderers, name, view()?, precision, default_of, |p| p999(level_differences(p, &reference)))?);
    }
    measure_choice("precision", "the Earth from 3 radii in an eclipse", ErrorUnit::Levels, effort.rounds(), candidates)
}
