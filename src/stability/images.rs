//! Two sweeps of complete images: `depth` draws bodies with clouds, air or rings from near to far, `scale` compares images of two sizes.
//!
//! In: a sweep's setup. Out: the greatest difference of two images in display levels: of the worst pixel for `depth`, the mean over the pixels for `scale`.

use super::difference::worst_pixel;
use super::views::{SATURN, sunward, view_from_offset};
use super::{SINGLE_SAMPLE, SweepResult, SweepSetup, retain_draws};
use crate::catalog::NaifId;
use crate::measure::{LinearImage, level_differences};
use crate::render::plan::SamplingQuality;
use crate::render::software::Precision;
use crate::scene::effects::EffectOverrides;
use crate::scene::request::{ExposureRequest, Layers, ViewRequest};
use crate::session::{SessionError, standard_scenes};
use crate::time::Instant;
use crate::units::{KM_PER_AU, SPEED_OF_LIGHT_KM_S};
use glam::DVec3;
use serde_json::json;

/// Diameter of the disc in the images of [`depth`], pixels.
const DISC_PX: f64 = 24.0;
/// Side of these images, in diameters of the disc.
const SIDE_IN_DISCS: f64 = 1.5;
/// Distance in radii beyond which images from consecutive distances are compared: there, perspective changes the image by less than a display level.
const COMPARED_BEYOND_RADII: f64 = 3e4;

/// The Earth with clouds and air, and Saturn with rings, from 1.2 radii to 100 au: f32 against f64, 1 sample against 4, and at large distances each distance
/// against the one before.
pub(super) fn depth(setup: &SweepSetup<'_>) -> Result<SweepResult, SessionError> {
    let mut found = SweepResult::empty();
    let session = setup.session();
    // On a day without an eclipse. The light that the camera receives leaves the body at this instant, whatever the distance.
    let emission_time = Instant::from_jd_tdb(2_460_469.762);
    let bodies = [(NaifId::EARTH, "+clouds,+atmosphere,-planet-shine,-eclipse,-points"), (SATURN, "+rings,-planet-shine,-eclipse,-points")];
    for (body, effects) in bodies {
        let Some((name, radius_km)) = session.catalog().body(body).map(|b| (b.name.as_str(), b.radii_km.x)) else { continue };
        let to_camera = (sunward(setup, body, emission_time) + DVec3::new(0.1, -0.2, 0.3)).normalize();
        let far_km = 100.0 * KM_PER_AU;
        let steps = setup.short_or_full(14, 60);
        let mut previous: Option<LinearImage> = None;
        for k in 0..steps {
            let distance_km = 1.2 * radius_km * (far_km / (1.2 * radius_km)).powf(f64::from(k) / f64::from(steps - 1));
            let side = (SIDE_IN_DISCS * DISC_PX) as u32;
            let half_fov_rad = ((radius_km / distance_km).asin().tan() * SIDE_IN_DISCS).atan();
            let request = ViewRequest {
                effects: EffectOverrides::parse(effects)?,
                // Saturn receives about 1/90 of the Earth's sunlight, six to seven stops less.
                exposure: ExposureRequest::Stops(if body == SATURN { 6.0 } else { 0.0 }),
                layers: Layers { stars: false, ..Layers::default() },
                ..view_from_offset(
                    body,
                    emission_time.plus_seconds(distance_km / SPEED_OF_LIGHT_KM_S),
                    to_camera * distance_km,
                    2.0 * half_fov_rad.to_degrees(),
                    side,
                )
            };
            // Only the draws of the body, because other bodies pass behind it.
            let drawn = |samples: u8, precision| -> Result<LinearImage, SessionError> {
                let mut view = setup.plan_view(&request, SamplingQuality { samples, ..SINGLE_SAMPLE })?;
                retain_draws(&mut view.plan, |label| label.starts_with(name));
                setup.draw_linear(&view, precision)
            };
            let (image, of_4_samples, in_f64) = (drawn(1, Precision::F32)?, drawn(4, Precision::F32)?, drawn(1, Precision::F64)?);
            let mut pairs = vec![("f32 against f64", &image, &in_f64), ("1 sample against 4", &image, &of_4_samples)];
            if let Some(previous) = previous.as_ref().filter(|_| distance_km > COMPARED_BEYOND_RADII * radius_km) {
                pairs.push(("this distance against the one before", &image, previous));
            }
            for (what, a, b) in pairs {
                let (worst_index, worst) = worst_pixel(a, b);
                found.add(worst, || {
                    let pixel = [worst_index as u32 % side, worst_index as u32 / side];
                    (json!({ "body": body.0, "distance_radii": distance_km / radius_km, "pixel": pixel }), what.to_owned())
                });
            }
            previous = Some(image);
        }
    }
    Ok(found)
}

/// Compares images of the targets of three standard scenes with larger images that are downsampled to the same size; the result is the mean difference over the
/// pixels. Points, stars and the Sun's glare are left out, because their size depends on that of a pixel.
pub(super) fn scale(setup: &SweepSetup<'_>) -> Result<SweepResult, SessionError> {
    let mut found = SweepResult::empty();
    let (side, factor) = setup.short_or_full((64, 8), (256, 8));
    for name in ["earth-3-radii", "saturn", "moon-limb"] {
        let Some(scene) = standard_scenes(side, side).into_iter().find(|s| s.name == name) else { continue };
        let layers = Layers { stars: false, ..Layers::default() };
        let request = ViewRequest { effects: EffectOverrides::parse("-points,-glow")?, layers, ..scene.request };
        let request = setup.renderers.with_metered_exposure(request)?;
        let fine_request = ViewRequest { width: side * factor, height: side * factor, ..request.clone() };
        let sampling = SamplingQuality { samples: 4, anisotropy: 8 };
        let coarse = setup.draw_linear(&setup.renderers.plan_target_body(&request, sampling)?, Precision::F32)?;
        let fine = setup.draw_linear(&setup.renderers.plan_target_body(&fine_request, sampling)?, Precision::F32)?.downsampled(factor);
        let differences = level_differences(&coarse, &fine);
        let mean = differences.iter().sum::<f64>() / differences.len() as f64;
        let (worst_index, worst) = worst_pixel(&coarse, &fine);
        // A pixel that is NaN or infinite in both images has no difference, so that the mean would not show it.
        found.add(if worst.is_finite() { mean } else { worst }, || {
            let pixel = [worst_index as u32 % side, worst_index as u32 / side];
            (
                json!({ "scene": name, "side_px": side, "finer_side_px": side * factor, "pixel": pixel }),
                format!("{worst:.1} levels at the worst pixel"),
            )
        });
    }
    Ok(found)
}
