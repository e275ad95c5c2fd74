//! Sweeps of extreme views (distances, angles, places, instants, sizes), f32 against f64.
//!
//! In: lists of views. Out: the worst pixel of each list. An impossible view, such as one from inside its target, is skipped.

use super::difference::{compare, least_differences, worst_of};
use super::{SINGLE_SAMPLE, SweepResult, SweepSetup, if_possible};
use crate::catalog::{Body, NaifId};
use crate::ephemeris::BEST_SOURCE;
use crate::ephemeris::topocentric::place_of_normal_deg;
use crate::events;
use crate::random::Random;
use crate::render::software::Precision;
use crate::scene::request::{Axes, Layers, Look, Position, Up, ViewRequest};
use crate::session::{SessionError, standard_scenes};
use crate::time::Instant;
use crate::units::{DAYS_PER_JULIAN_YEAR, JD_J2000, KM_PER_AU, RAD_PER_ARCSEC};
use glam::DVec3;
use serde_json::{Value, json};

pub(super) const SATURN: NaifId = NaifId(699);
pub(super) const JUPITER: NaifId = NaifId(599);
/// Two metres above the ground in Dallas, where the eclipse of 2024-04-08 was total.
pub(super) const DALLAS: Position = Position::Ground { body: NaifId::EARTH, latitude_deg: 32.78, longitude_deg: -96.8, height_km: 2e-3 };
/// 2024-04-08T18:17:16 UTC, in the middle of a total eclipse of the Sun.
const ECLIPSE_JD_TDB: f64 = 2_460_409.262_789_4;

/// A view, and what identifies it in a report.
pub(super) struct ExtremeView {
    pub case: Value,
    pub request: ViewRequest,
}

/// Compares f32 and f64 in each view. Impossible views are skipped: those from inside the target, or outside the years of a body's ephemeris.
fn compare_views(setup: &SweepSetup<'_>, views: impl IntoIterator<Item = ExtremeView>) -> Result<SweepResult, SessionError> {
    let mut found = SweepResult::empty();
    for ExtremeView { case, request } in views {
        if let Some(view) = if_possible(setup.plan_view(&request, SINGLE_SAMPLE))? {
            compare(setup, &mut found, &view, &case)?;
        }
    }
    Ok(found)
}

pub(super) fn eclipse_instant() -> Instant {
    Instant::from_jd_tdb(ECLIPSE_JD_TDB)
}

fn bodies_named(setup: &SweepSetup<'_>, names: &[&str]) -> Vec<Body> {
    names.iter().filter_map(|n| setup.session().catalog().body_named(n).ok().cloned()).collect()
}

/// Unit vector from the body to the Sun, ICRF; the x axis if the direction is unknown or the body is the Sun.
pub(super) fn sunward(setup: &SweepSetup<'_>, body: NaifId, time: Instant) -> DVec3 {
    let state = setup.session().ephemeris().state(NaifId::SUN, body, time, BEST_SOURCE);
    state.map_or(DVec3::X, |s| s.state.pos_km.try_normalize().unwrap_or(DVec3::X))
}

/// A square view of the body from an offset (km from the body's centre, ICRF axes). `side`: in pixels.
pub(super) fn view_from_offset(body: NaifId, time: Instant, offset_km: DVec3, fov_deg: f64, side: u32) -> ViewRequest {
    ViewRequest {
        position: Position::Offset { body, offset_km, axes: Axes::Icrf },
        fov_deg: Some(fov_deg),
        width: side,
        height: side,
        ..ViewRequest::of(body, time)
    }
}

/// Views from a metre above the ground to 100 au, at fields of view from an arcsecond to 170 degrees.
pub(super) fn distance(setup: &SweepSetup<'_>) -> Result<SweepResult, SessionError> {
    let bodies =
        setup.short_or_full(bodies_named(setup, &["earth", "saturn", "moon", "deimos"]), setup.session().catalog().bodies().to_vec());
    let (steps, side) = setup.short_or_full((10, 16), (27, 32));
    let fovs_deg = [RAD_PER_ARCSEC.to_degrees(), 0.05, 3.0, 45.0, 170.0];
    let time = eclipse_instant();
    let views = bodies.iter().flat_map(|body| {
        let radius_km = body.radii_km.max_element();
        let to_camera = (sunward(setup, body.id, time) + DVec3::new(0.2, -0.3, 0.25)).normalize();
        (0..steps).flat_map(move |k| {
            // Heights in logarithmic steps.
            let height_km = 1e-3 * (100.0 * KM_PER_AU / 1e-3).powf(f64::from(k) / f64::from(steps - 1));
            fovs_deg.into_iter().map(move |fov_deg| ExtremeView {
                case: json!({ "body": body.name, "height_km": height_km, "fov_deg": fov_deg }),
                request: view_from_offset(body.id, time, to_camera * (radius_km + height_km), fov_deg, side),
            })
        })
    });
    compare_views(setup, views.collect::<Vec<_>>())
}

/// Each body seen from the centre of each other body, fitted into the frame; a random sample of these pairs in a short run.
pub(super) fn pairs(setup: &SweepSetup<'_>) -> Result<SweepResult, SessionError> {
    let bodies = setup.session().catalog().bodies();
    let mut random = Random::new(setup.seed);
    // In a short run, about 150 pairs.
    let sampled_fraction = setup.short_or_full(150.0 / (bodies.len() * bodies.len()) as f64, 1.0);
    let mut views = Vec::new();
    for observer in bodies {
        for target in bodies.iter().filter(|t| t.id != observer.id) {
            if random.unit_interval() < sampled_fraction {
                let request = ViewRequest {
                    position: Position::Centre(observer.id),
                    width: 16,
                    height: 16,
                    ..ViewRequest::of(target.id, eclipse_instant())
                };
                views.push(ExtremeView { case: json!({ "from": observer.name, "body": target.name }), request });
            }
        }
    }
    compare_views(setup, views)
}

/// A view from a place on the ground (latitude and longitude in degrees, height in km) in a direction in body axes.
fn ground_view(
    body: &Body,
    [latitude_deg, longitude_deg, height_km]: [f64; 3],
    direction: DVec3,
    fov_deg: f64,
    time: Instant,
) -> ViewRequest {
    ViewRequest {
        position: Position::Ground { body: body.id, latitude_deg, longitude_deg, height_km },
        look: Look::Along { direction, axes: Axes::BodyFixed },
        up: Up::Zenith,
        target: None,
        fov_deg: Some(fov_deg),
        width: 16,
        height: 16,
        ..ViewRequest::of(body.id, time)
    }
}

/// Unit vectors east, north and up where the ground's normal has this latitude and longitude, body axes.
fn local_axes(latitude_deg: f64, longitude_deg: f64) -> [DVec3; 3] {
    let ((sin_lat, cos_lat), (sin_lon, cos_lon)) = (latitude_deg.to_radians().sin_cos(), longitude_deg.to_radians().sin_cos());
    [
        DVec3::new(-sin_lon, cos_lon, 0.0),
        DVec3::new(-sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat),
        DVec3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat),
    ]
}

/// Views along the horizon, from two metres to ten radii above the ground.
pub(super) fn grazing(setup: &SweepSetup<'_>) -> Result<SweepResult, SessionError> {
    horizon_views(setup, &[0.3, 30.0, 120.0])
}

/// Views along the horizon with a field of view of about 10 arcseconds.
pub(super) fn grazing_telescope(setup: &SweepSetup<'_>) -> Result<SweepResult, SessionError> {
    horizon_views(setup, &[0.003])
}

fn horizon_views(setup: &SweepSetup<'_>, fovs_deg: &[f64]) -> Result<SweepResult, SessionError> {
    let names: &[&str] =
        setup.short_or_full(&["earth", "moon", "saturn"], &["earth", "moon", "saturn", "mars", "titan", "jupiter", "phobos", "venus"]);
    let azimuth_count = setup.short_or_full(2, 12);
    let mut views = Vec::new();
    for body in bodies_named(setup, names) {
        let radius_km = body.radii_km.x;
        for height_km in [2e-3, 0.1, 10.0, 400.0, radius_km, 10.0 * radius_km] {
            let dip_rad = (radius_km / (radius_km + height_km)).acos();
            for k in 0..azimuth_count {
                let (latitude_deg, longitude_deg) = (23.0, 77.0);
                let [east, north, up] = local_axes(latitude_deg, longitude_deg);
                let place_deg = place_of_normal_deg(body.radii_km, up);
                // From north towards east.
                let azimuth_rad = 0.4 + f64::from(k) * std::f64::consts::TAU / f64::from(azimuth_count);
                let (sin, cos) = azimuth_rad.sin_cos();
                let direction = (east * sin + north * cos) * dip_rad.cos() - up * dip_rad.sin();
                for &fov_deg in fovs_deg {
                    let case =
                        json!({ "body": body.name, "height_km": height_km, "azimuth_deg": azimuth_rad.to_degrees(), "fov_deg": fov_deg });
                    views.push(ExtremeView {
                        case,
                        request: ground_view(&body, [place_deg[0], place_deg[1], height_km], direction, fov_deg, eclipse_instant()),
                    });
                }
            }
        }
    }
    compare_views(setup, views)
}

/// Views down, along the horizon and towards the Sun: at the poles, on the antimeridian, with the Sun in the zenith or in the nadir, and at the terminator.
pub(super) fn places(setup: &SweepSetup<'_>) -> Result<SweepResult, SessionError> {
    let names: &[&str] = setup.short_or_full(
        &["earth", "saturn", "moon"],
        &["earth", "saturn", "moon", "mars", "jupiter", "venus", "titan", "pluto", "io", "mercury"],
    );
    let mut views = Vec::new();
    for body in bodies_named(setup, names) {
        let Ok(body_from_icrf) = setup.session().ephemeris().body_from_icrf(body.id, eclipse_instant()) else { continue };
        let sun = body_from_icrf * sunward(setup, body.id, eclipse_instant());
        // The planetographic latitude at which the Sun is in the zenith is the Sun's declination. The sub-solar point, where the line from the body's centre to
        // the Sun meets the surface, has another one on an oblate body.
        let (zenith_latitude_deg, zenith_longitude_deg) = (sun.z.asin().to_degrees(), sun.y.atan2(sun.x).to_degrees());
        let spots = [
            ("north pole", 90.0, 0.0),
            ("south pole", -90.0, 10.0),
            ("beside the pole", 89.999, 45.0),
            ("antimeridian", 10.0, 180.0),
            ("beside the antimeridian", 0.0, -179.999_99),
            ("Sun in the zenith", zenith_latitude_deg, zenith_longitude_deg),
            ("Sun in the nadir", -zenith_latitude_deg, zenith_longitude_deg + 180.0),
            ("Sun on the horizon", 0.0, zenith_longitude_deg + 90.0),
            ("Sun just set", 0.0, zenith_longitude_deg + 90.5),
        ];
        for (place, latitude_deg, longitude_deg) in spots {
            let longitude_deg = (longitude_deg + 180.0_f64).rem_euclid(360.0) - 180.0;
            let [east, _, up] = local_axes(latitude_deg, longitude_deg);
            let place_deg = place_of_normal_deg(body.radii_km, up);
            for (look, direction) in [("down", east * 1e-3 - up), ("horizon", east - 0.05 * up), ("Sun", sun)] {
                for height_km in [2e-3, 1000.0] {
                    let case = json!({ "body": body.name, "place": place, "look": look, "height_km": height_km });
                    views.push(ExtremeView {
                        case,
                        request: ground_view(&body, [place_deg[0], place_deg[1], height_km], direction, 50.0, eclipse_instant()),
                    });
                }
            }
        }
    }
    compare_views(setup, views)
}

/// The camera within and beside the ring plane of each ringed body, and Saturn around the days on which the Earth and the Sun cross its ring plane.
pub(super) fn ring_plane(setup: &SweepSetup<'_>) -> Result<SweepResult, SessionError> {
    let mut views = Vec::new();
    let catalog = setup.session().catalog();
    let ringed = catalog.bodies().iter().filter(|b| !b.rings.is_empty());
    for body in ringed {
        let Ok(body_from_icrf) = setup.session().ephemeris().body_from_icrf(body.id, eclipse_instant()) else { continue };
        // Tangent of the camera's elevation above the ring plane.
        for tan_elevation in [0.0, 1e-9, -1e-6, 1e-4, 1e-2] {
            for distance_radii in [1.5, 4.0, 30.0, 1e5] {
                let offset = body_from_icrf.transpose() * DVec3::new(0.6, -0.8, tan_elevation) * distance_radii * body.radii_km.x;
                // The frame reaches 2.5 radii from the body's centre to each side; at these distances the limit of 120 degrees is not reached.
                let fov_deg = (2.0 * (2.5_f64 / distance_radii).atan().to_degrees()).min(120.0);
                let case = json!({ "body": body.name, "distance_radii": distance_radii, "tan_elevation": tan_elevation });
                views.push(ExtremeView {
                    case,
                    request: view_from_offset(body.id, eclipse_instant(), offset, fov_deg, setup.short_or_full(24, 64)),
                });
            }
        }
    }
    // The Earth crosses the plane at 2025-03-23 16 UTC, the Sun on 2025-05-06.
    for jd_tdb in [2_460_758.17, 2_460_801.5] {
        for hours in [-600.0, -24.0, -1.0, -0.01, 0.0, 0.3, 20.0, 500.0] {
            let time = Instant::from_jd_tdb(jd_tdb + hours / 24.0);
            let side = setup.short_or_full(24, 96);
            let request = ViewRequest { width: side, height: side, ..ViewRequest::of(SATURN, time) };
            views.push(ExtremeView { case: json!({ "body": "Saturn", "time": time.to_utc_iso() }), request });
        }
    }
    compare_views(setup, views)
}

/// Images at the contacts of solar and lunar eclipses: from space, and of the Sun from the place of greatest eclipse.
pub(super) fn contacts(setup: &SweepSetup<'_>) -> Result<SweepResult, SessionError> {
    let (catalog, ephemeris) = (setup.session().catalog(), setup.session().ephemeris());
    // 2023-01-01 to 2024-05-15, or 2010 to 2031: partial, annular, total and hybrid eclipses.
    let span_jd_tdb = setup.short_or_full([2_459_945.5, 2_460_445.5], [2_455_197.5, 2_463_232.5]);
    let [from, to] = span_jd_tdb.map(Instant::from_jd_tdb);
    let mut views = Vec::new();
    let side = 24;
    for eclipse in events::solar_eclipses(catalog, ephemeris, from, to)? {
        for contact in &eclipse.contacts {
            for seconds in [-0.5, 0.0, 0.5] {
                let (name, contact_time) = *contact;
                let time = contact_time.plus_seconds(seconds);
                let case = json!({ "eclipse": eclipse.greatest.to_utc_iso(), "contact": name, "seconds": seconds, "seen": "space" });
                views
                    .push(ExtremeView { case, request: ViewRequest { width: side, height: side, ..ViewRequest::of(NaifId::EARTH, time) } });
            }
        }
        // A partial eclipse has no duration.
        let half_s = eclipse.duration_s.unwrap_or(600.0) / 2.0;
        for seconds in [-half_s, -half_s + 0.5, 0.0, half_s - 0.5, half_s, 3000.0] {
            let time = eclipse.greatest.plus_seconds(seconds);
            let position = Position::Ground {
                body: NaifId::EARTH,
                latitude_deg: eclipse.place.latitude_deg,
                longitude_deg: eclipse.place.longitude_deg,
                height_km: 2e-3,
            };
            let request = ViewRequest { position, fov_deg: Some(1.5), width: side, height: side, ..ViewRequest::of(NaifId::SUN, time) };
            let case = json!({ "eclipse": eclipse.greatest.to_utc_iso(), "seconds": seconds, "seen": "ground" });
            views.push(ExtremeView { case, request });
        }
    }
    for eclipse in events::lunar_eclipses(catalog, ephemeris, from, to)? {
        for (name, time) in &eclipse.contacts {
            let request = ViewRequest { width: side, height: side, ..ViewRequest::of(NaifId::MOON, *time) };
            let case = json!({ "eclipse": eclipse.greatest.to_utc_iso(), "contact": name, "seen": "Earth" });
            views.push(ExtremeView { case, request });
        }
    }
    compare_views(setup, views)
}

/// Every body, from the smallest moon to the Sun, filling the frame.
pub(super) fn radii(setup: &SweepSetup<'_>) -> Result<SweepResult, SessionError> {
    let side = setup.short_or_full(24, 96);
    let view = |body: &Body| ExtremeView {
        case: json!({ "body": body.name, "radius_km": body.radii_km.x }),
        request: ViewRequest { width: side, height: side, ..ViewRequest::of(body.id, eclipse_instant()) },
    };
    compare_views(setup, setup.session().catalog().bodies().iter().map(view).collect::<Vec<_>>())
}

/// Bodies at instants from the year -3000 to 3000.
pub(super) fn years(setup: &SweepSetup<'_>) -> Result<SweepResult, SessionError> {
    let step = setup.short_or_full(500, 50);
    let mut views = Vec::new();
    for year in (-3000..=3000).step_by(step) {
        let time = Instant::from_jd_tdb(JD_J2000 + DAYS_PER_JULIAN_YEAR * f64::from(year - 2000));
        for body in bodies_named(setup, &["earth", "moon", "saturn", "jupiter", "io", "mercury", "sun"]) {
            let request = ViewRequest { width: 24, height: 24, ..ViewRequest::of(body.id, time) };
            views.push(ExtremeView { case: json!({ "body": body.name, "year": year }), request });
        }
    }
    compare_views(setup, views)
}

/// Discs with diameters from 0.3 pixels to four times the frame's side.
pub(super) fn sizes(setup: &SweepSetup<'_>) -> Result<SweepResult, SessionError> {
    const DISTANCE_RADII: f64 = 60.0;
    let (side, steps) = setup.short_or_full((24, 12), (48, 60));
    let mut views = Vec::new();
    for body in bodies_named(setup, &["earth", "saturn", "moon", "sun", "jupiter"]) {
        let distance_km = DISTANCE_RADII * body.radii_km.x;
        let to_camera = (sunward(setup, body.id, eclipse_instant()) + DVec3::new(0.4, 0.1, 0.2)).normalize();
        for k in 0..steps {
            let diameter_px = 0.3 * (4.0 * f64::from(side) / 0.3).powf(f64::from(k) / f64::from(steps - 1));
            let fov_deg = 2.0 * ((1.0 / DISTANCE_RADII) * f64::from(side) / diameter_px).atan().to_degrees();
            let case = json!({ "body": body.name, "diameter_px": diameter_px });
            views.push(ExtremeView {
                case,
                request: view_from_offset(body.id, eclipse_instant(), to_camera * distance_km, fov_deg.min(170.0), side),
            });
        }
    }
    compare_views(setup, views)
}

/// Views that use the simple shaders (those without a key): lines, labels, outline, bloom, points, corona, glare, refracted limb and tone map. Compares
/// display bytes.
pub(super) fn simple(setup: &SweepSetup<'_>) -> Result<SweepResult, SessionError> {
    let side = setup.short_or_full(96, 256);
    let all = Layers::ALL;
    let request_of = |body: NaifId, time: Instant| ViewRequest { width: side, height: side, layers: all, ..ViewRequest::of(body, time) };
    // 2022-11-08T11:00 UTC. From the Moon, which is in the Earth's umbra: the Sun's refracted image around the Earth.
    let umbra_time = Instant::from_jd_tdb(2_459_891.959);
    let night_sky = standard_scenes(side, side).into_iter().find(|s| s.name == "night-sky").map(|s| s.request);
    let night_sky = night_sky.unwrap_or_else(|| request_of(SATURN, eclipse_instant()));
    // Totality in Dallas.
    let totality = Instant::from_jd_tdb(2_460_409.280_4);
    let views = [
        (
            "labels and orbits",
            ViewRequest {
                fov_deg: Some(40.0),
                position: Position::AboveTarget { towards: None, distance_radii: Some(60.0) },
                ..request_of(JUPITER, eclipse_instant())
            },
        ),
        (
            "whole system",
            ViewRequest {
                fov_deg: Some(60.0),
                position: Position::AboveTarget { towards: None, distance_radii: Some(12_000.0) },
                ..request_of(NaifId::SUN, eclipse_instant())
            },
        ),
        ("corona", ViewRequest { position: DALLAS, fov_deg: Some(3.0), ..request_of(NaifId::SUN, totality) }),
        (
            "refracted limb",
            ViewRequest { position: Position::Centre(NaifId::MOON), fov_deg: Some(2.4), ..request_of(NaifId::EARTH, umbra_time) },
        ),
        ("glare", ViewRequest { position: Position::Centre(NaifId::EARTH), fov_deg: Some(20.0), ..request_of(NaifId::SUN, umbra_time) }),
        ("night sky", night_sky),
    ];
    let mut found = SweepResult::empty();
    for (name, request) in views {
        let view = setup.plan_view(&request, SINGLE_SAMPLE)?;
        let (f32_pixels, f64_frames) = (setup.draw_display(&view, Precision::F32)?, setup.f64_frames(&view)?);
        let difference = |a: &[u8; 4], b: &[u8; 4]| (0..3).map(|c| f64::from(a[c].abs_diff(b[c]))).fold(0.0, f64::max);
        // Of each pixel, the difference from the closest of the f64 frames, which differ in the grid to which vertices snap.
        let differences = least_differences(&f32_pixels, f64_frames.iter().map(|frame| &*frame.display), difference);
        let (worst_index, worst) = worst_of(&differences);
        let pixel = [worst_index as u32 % side, worst_index as u32 / side];
        found.add(worst, || {
            let modules: std::collections::BTreeSet<String> =
                view.plan.passes.iter().flat_map(|p| &p.draws).map(|d| d.module.to_string()).collect();
            let cause = format!(
                "{}; modules: {}",
                super::difference::describe_cause(setup, &view, [side, side], pixel),
                modules.into_iter().collect::<Vec<_>>().join(" ")
            );
            (json!({ "view": name, "pixel": pixel }), cause)
        });
    }
    Ok(found)
}
