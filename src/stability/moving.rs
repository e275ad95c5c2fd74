//! Two sweeps of image sequences: in `motion` the camera or bodies move by less than a pixel per step; `exposure` follows automatic exposure through eclipses.
//!
//! In: a sweep's setup. Out: the greatest change from one step to the next, in display levels or in stops.

use super::views::{DALLAS, JUPITER, SATURN, eclipse_instant, sunward, view_from_offset};
use super::{SINGLE_SAMPLE, SweepResult, SweepSetup, retain_draws};
use crate::catalog::NaifId;
use crate::measure::{LinearImage, PlannedView};
use crate::render::software::Precision;
use crate::scene::request::{Axes, ExposureRequest, Look, Position, ViewRequest};
use crate::session::SessionError;
use crate::time::Instant;
use crate::units::linear_to_srgb;
use glam::DVec3;
use serde_json::json;
use std::collections::BTreeSet;

/// Luminance of every pixel.
fn luminances(image: &LinearImage) -> Vec<f64> {
    image.light.iter().map(|p| crate::units::luminance([p[0], p[1], p[2]].map(f64::from))).collect()
}

/// Most that the mean over 3 x 3 pixels may change when the image moves by a pixel, as a fraction of the range of luminance around them. An edge that moves
/// by a pixel along an axis changes the mean by a third of the range, along the diagonal by 0.47 of it.
const MAX_CHANGE_FRACTION: f64 = 0.5;

/// Greatest change of luminance, in levels, that a movement of the first image by a pixel does not explain, and its pixel. Such a movement explains a change
/// of up to [`MAX_CHANGE_FRACTION`] of the luminance range within two pixels in the first image. Means over 3 x 3 pixels are compared, so that a point source
/// may move within its pixel. The two outermost rows and columns are excluded, because they lack neighbours.
fn change_unexplained_by_first(first: &LinearImage, second: &LinearImage) -> (f64, [i64; 2]) {
    let (a, b) = (luminances(first), luminances(second));
    let (w, h) = (first.width as i64, first.height as i64);
    let neighbourhood = |values: &[f64], x: i64, y: i64, radius: i64| -> Vec<f64> {
        (-radius..=radius)
            .flat_map(|dy| (-radius..=radius).map(move |dx| (dx, dy)))
            .map(|(dx, dy)| values[((y + dy) * w + x + dx) as usize])
            .collect()
    };
    let mean = |values: &[f64], x: i64, y: i64| neighbourhood(values, x, y, 1).iter().sum::<f64>() / 9.0;
    let level = |luminance: f64| 255.0 * linear_to_srgb((luminance * first.exposure_factor).clamp(0.0, 1.0));
    let mut worst = (0.0, [0, 0]);
    for (x, y) in (2..h - 2).flat_map(|y| (2..w - 2).map(move |x| (x, y))) {
        let (old, new) = (mean(&a, x, y), mean(&b, x, y));
        // `f64::max` ignores NaN, so that a broken pixel would pass as unchanged.
        if !old.is_finite() || !new.is_finite() {
            return (f64::INFINITY, [x, y]);
        }
        let (low, high) = neighbourhood(&a, x, y, 2).into_iter().fold((f64::INFINITY, 0.0_f64), |(low, high), v| (low.min(v), high.max(v)));
        let unexplained = (new - old).abs() - MAX_CHANGE_FRACTION * (high - low);
        let levels = level(old.max(new)) - level(old.max(new) - unexplained.max(0.0));
        if levels > worst.0 {
            worst = (levels, [x, y]);
        }
    }
    worst
}

/// The greater of two changes: that which a movement of the first image does not explain (light that appears), and that which a movement of the
/// second does not explain (light that disappears).
fn unexplained_change(first: &LinearImage, second: &LinearImage) -> (f64, [i64; 2]) {
    let (forward, reverse) = (change_unexplained_by_first(first, second), change_unexplained_by_first(second, first));
    if forward.0 >= reverse.0 { forward } else { reverse }
}

/// Names the draw whose removal leaves the least unexplained change between two frames.
fn responsible_draw(setup: &SweepSetup<'_>, views: [&PlannedView; 2]) -> String {
    let labels: BTreeSet<&str> = views.iter().filter_map(|v| v.plan.hdr_pass()).flat_map(|p| &p.draws).map(|d| d.label.as_str()).collect();
    let without = |label: &str| {
        let [first, second] = views.map(|view| {
            let mut view = PlannedView { scene: view.scene.clone(), plan: view.plan.clone() };
            retain_draws(&mut view.plan, |l| l != label);
            setup.draw_linear(&view, Precision::F32).ok()
        });
        Some((unexplained_change(&first?, &second?).0, label.to_owned()))
    };
    let best = labels.into_iter().filter_map(without).min_by(|a, b| a.0.total_cmp(&b.0));
    best.map_or_else(String::new, |(remaining, label)| {
        format!("light that motion does not explain; without the draw `{label}`, {remaining:.2} levels remain")
    })
}

/// Cameras that rotate by a third of a pixel per step or recede from a body, and moons and shadows that move by less than a pixel.
pub(super) fn motion(setup: &SweepSetup<'_>) -> Result<SweepResult, SessionError> {
    let mut found = SweepResult::empty();
    let (side, steps, steps_away) = setup.short_or_full((64, 10, 40), (160, 60, 300));
    let mut sequence = |name: &str, steps: u32, frame: &dyn Fn(f64) -> ViewRequest| -> Result<(), SessionError> {
        let mut previous: Option<(PlannedView, LinearImage)> = None;
        for k in 0..steps {
            let view = setup.plan_view(&frame(f64::from(k)), SINGLE_SAMPLE)?;
            let image = setup.draw_linear(&view, Precision::F32)?;
            if let Some((previous_view, previous_image)) = &previous {
                let (worst, pixel) = unexplained_change(previous_image, &image);
                found.add(worst, || {
                    (json!({ "sequence": name, "step": k, "pixel": pixel }), responsible_draw(setup, [previous_view, &view]))
                });
            }
            previous = Some((view, image));
        }
        Ok(())
    };
    let time = eclipse_instant();
    for (body, distance_radii, fov_deg) in
        [(NaifId::EARTH, 3.0, 50.0), (NaifId::EARTH, 1.02, 60.0), (SATURN, 6.0, 50.0), (JUPITER, 40.0, 30.0), (NaifId::MOON, 300.0, 0.5)]
    {
        let Some(radius_km) = setup.session().catalog().body(body).map(|b| b.radii_km.x) else { continue };
        let to_camera = (sunward(setup, body, time) + DVec3::new(0.3, -0.2, 0.3)).normalize();
        let base = view_from_offset(body, time, to_camera * distance_radii * radius_km, fov_deg, side);
        let base = setup.renderers.with_metered_exposure(base)?;
        let perpendicular = to_camera.cross(DVec3::Z).normalize();
        let step_rad = 0.33 * fov_deg.to_radians() / f64::from(side);
        sequence(&format!("camera rotates near {} at {distance_radii} radii", body.0), steps, &|k| ViewRequest {
            look: Look::Along { direction: -to_camera + perpendicular * (k * step_rad).tan(), axes: Axes::Icrf },
            ..base.clone()
        })?;
        // Each step multiplies the camera's height above the body by the same factor. Each step moves a point at the edge of the image, `side / 2` pixels from
        // the centre, by a third of a pixel. A full run ends at 3.4 times the first height.
        let growth = 0.33 / (0.5 * f64::from(side));
        sequence(&format!("away from {} at {distance_radii} radii", body.0), steps_away, &|k| {
            let offset_km = to_camera * (distance_radii - 1.0) * (1.0 + growth).powf(k) * radius_km + to_camera * radius_km;
            ViewRequest { position: Position::Offset { body, offset_km, axes: Axes::Icrf }, ..base.clone() }
        })?;
    }
    // Io and its shadow move onto Jupiter; the Moon enters the Earth's shadow.
    // Name, target, start (UTC), step in seconds, field of view in degrees (`None`: fitted to the target).
    for (name, body, start, step_s, fov_deg) in [
        ("Io's shadow on Jupiter", JUPITER, "2015-01-24T04:25:00Z", 30.0, None),
        ("the Moon into the penumbra", NaifId::MOON, "2022-11-08T08:00:00Z", 60.0, None),
        ("the Moon into the umbra", NaifId::MOON, "2022-11-08T09:05:00Z", 20.0, Some(0.7)),
    ] {
        let Ok(start) = Instant::parse(start) else { continue };
        let base = setup.renderers.with_metered_exposure(ViewRequest {
            fov_deg,
            width: side,
            height: side,
            position: Position::Centre(NaifId::EARTH),
            ..ViewRequest::of(body, start)
        })?;
        sequence(name, steps, &|k| ViewRequest { time: start.plus_seconds(k * step_s), ..base.clone() })?;
    }
    Ok(found)
}

/// Display level from which a pixel counts as visible beside black. A choice: 0.4 % of the light of white.
const VISIBLE_LEVEL: u8 = 12;
/// The result for an image in which nothing is visible.
const INVISIBLE_RESULT: f64 = 99.0;

/// A sequence whose changes of exposure are not checked: Io's entry into the shadow takes less than one step, and so does its exit.
const ORBIT_OF_IO: &str = "Io once around Jupiter";

/// Changes of automatic exposure in stops from step to step through eclipses, and whether anything is visible in each image.
pub(super) fn exposure(setup: &SweepSetup<'_>) -> Result<SweepResult, SessionError> {
    let mut found = SweepResult::empty();
    // A short sweep takes steps four times as long; changes are divided by this factor, so that both efforts have the same bound.
    let step_factor = setup.short_or_full(4.0, 1.0);
    let from_earth = Position::Centre(NaifId::EARTH);
    let from_sunward_side = Position::AboveTarget { towards: Some(NaifId::SUN), distance_radii: None };
    // Name, target, camera position, start (UTC), duration and step in seconds, field of view in degrees (`None`: the default).
    let sequences = [
        // The edge of the Moon that leaves the umbra brightens by 1.3 stops in a minute.
        ("the Moon, 2022-11-08", NaifId::MOON, from_earth, "2022-11-08T08:00:00Z", 6.0 * 3600.0, 20.0, None),
        ("the Earth in the Moon's shadow", NaifId::EARTH, from_sunward_side, "2024-04-08T15:30:00Z", 5.5 * 3600.0, 120.0, None),
        ("the Sun from Dallas, second contact", NaifId::SUN, DALLAS, "2024-04-08T18:30:00Z", 20.0 * 60.0, 1.0, Some(3.0)),
        // At the end of its entry into the umbra, Io loses 11 stops in ten seconds.
        ("Io into Jupiter's umbra", NaifId(501), from_earth, "2015-01-26T20:20:20Z", 45.0, 0.25, None),
        (ORBIT_OF_IO, NaifId(501), from_earth, "2015-01-26T00:00:00Z", 42.0 * 3600.0, 900.0, None),
    ];
    for (name, body, position, start, duration_s, step_s, fov_deg) in sequences {
        let Ok(start) = Instant::parse(start) else { continue };
        let step_s: f64 = step_s * step_factor;
        let mut previous_stops: Option<f64> = None;
        for k in 0..=(duration_s / step_s) as u32 {
            let time = start.plus_seconds(f64::from(k) * step_s);
            let request =
                ViewRequest { position, fov_deg, exposure: ExposureRequest::Auto, width: 24, height: 24, ..ViewRequest::of(body, time) };
            let view = setup.plan_view(&request, SINGLE_SAMPLE)?;
            let display = setup.draw_display(&view, Precision::F32)?;
            let brightest = display.iter().flat_map(|p| p[..3].iter()).copied().max().unwrap_or(0);
            let stops = view.scene.exposure.stops;
            // Along Io's orbit only visibility is checked.
            let compared_stops = previous_stops.filter(|_| name != ORBIT_OF_IO);
            let change_stops = compared_stops.map_or(0.0, |compared: f64| (stops - compared).abs() / step_factor);
            let result = if brightest < VISIBLE_LEVEL { INVISIBLE_RESULT } else { change_stops };
            found.add(result, || {
                let case = json!({ "sequence": name, "time": time.to_utc_iso(), "step_s": step_s });
                (case, format!("{stops:.2} stops, brightest level {brightest}: {}", view.scene.exposure.reason))
            });
            previous_stops = Some(stops);
        }
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An edge that moves by half a pixel is explained by motion; one that jumps by three pixels, or light that appears, is not.
    #[test]
    fn a_jump_is_distinguished_from_a_step() {
        let edge = |edge_x: f64| {
            let light = (0..16 * 16).map(|k| {
                let v = (edge_x - f64::from(k % 16)).clamp(0.0, 1.0) as f32;
                [v, v, v, 1.0]
            });
            LinearImage { width: 16, height: 16, light: light.collect(), exposure_factor: 1.0 }
        };
        assert!(unexplained_change(&edge(7.0), &edge(7.5)).0 < 0.5);
        assert!(unexplained_change(&edge(7.0), &edge(10.0)).0 > 50.0);
        let mut with_new_light = edge(7.0);
        with_new_light.light[8 * 16 + 12] = [1.0, 1.0, 1.0, 1.0];
        assert!(unexplained_change(&edge(7.0), &with_new_light).0 > 50.0);
        for broken in [f32::NAN, f32::INFINITY] {
            let mut with_broken_pixel = edge(7.0);
            with_broken_pixel.light[8 * 16 + 3][1] = broken;
            assert_eq!(unexplained_change(&edge(7.0), &with_broken_pixel).0, f64::INFINITY, "{broken}");
        }
    }
}
