//! How bright the picture is: the exposure that is asked for, or one that is made for what fills the frame.
//!
//! In: the request, the camera and the bodies where they are seen. Out: [`Exposure`] with its reason. The light meter (`meter`) weighs what is in the
//! frame; what weighs most decides, sharply, so that no picture is a compromise between two that differ by twenty stops. Always: the Sun's
//! glare whitens no more than about a tenth of the frame, the exposure opens no further than a photograph of the night sky, and it changes continuously with place,
//! time, field of view and phase. Views that show numbers are exposed by their legend.

use super::camera::Camera;
use super::draw::PixelView;
use super::lights::Reflector;
use super::meter::{Meter, Metered, Reading};
use super::request::{ExposureRequest, ViewRequest};
use super::{Exposure, Placed, air, lamps, legend, lights};
use crate::catalog::NaifId;
use crate::ephemeris::Ephemeris;

/// Radiance of a fully lit disc in its brightest channel, as a part of white, at automatic exposure: bright features of twice the mean
/// still differ, and a coloured body keeps its colour.
pub const AUTO_EXPOSED_MEAN: f64 = 0.5;
/// The same for the Sun, whose disc is what white is: its centre meets white and the darkened limb stays below.
pub const AUTO_EXPOSED_SUN: f64 = 0.85;
/// Luminance of a white plane that faces the Sun at 1 au, cd/m2: radiance 1. The illuminance is that of V = -26.76 with 2.54e-6 lux for V = 0, 128
/// klx, over pi. An estimate to 5 %, a fourteenth of a stop: published solar illuminance constants lie between 128 and 134 klx.
pub const CANDELAS_PER_RADIANCE: f64 = 128_000.0 / std::f64::consts::PI;
/// Over 2^EV at ISO 100, cd/m2: what a camera's sensor shows as white (ISO 12232's saturation-based speed, a lens that lets 0.65 through:
/// 78 / (100 x 0.65)). Sunlit ground, EV 15, is then exposed by 0 stops.
const WHITE_AT_EV_0: f64 = 1.2;
/// The exposure opens no further: a photograph of the night sky at f/2.8, 8 s, ISO 1600 is one of EV -4. White is then 0.075 cd/m2; a star of 6 mag,
/// the faintest that the eye sees, is a fifteenth of it in a picture of 45 degrees and 1024 pixels.
pub const DARKEST_EV: f64 = -4.0;
/// How sharply what weighs more decides: the power of weights. Things that weigh as 1 to 3 decide as 1 to 9.
const DECIDES: i32 = 2;
/// How sharply the greater of two whites counts: at equality it is a quarter of a stop greater than either.
const JOINS: i32 = 4;

/// The Sun's glare in half of the frame is at most this part of white: before things that are brighter than it, and before a dark sky.
const GLARE_OF_WHITE: [f64; 2] = [0.2, 0.02];
/// Stops by which the brightest lamps must be beyond white to count in full.
const LAMPS_OVER_STOPS: f64 = 2.0;

/// The radiance that the longest exposure shows as white.
pub fn darkest_white() -> f64 {
    WHITE_AT_EV_0 * DARKEST_EV.exp2() / CANDELAS_PER_RADIANCE
}

/// The exposure of a picture: the metered one, or what was asked for of it.
pub(super) fn exposure(
    request: &ViewRequest,
    camera: &Camera,
    placed: &[Placed<'_>],
    reflectors: &[Reflector<'_>],
    air: Option<&air::Around<'_>>,
    ephemeris: &Ephemeris,
) -> Exposure {
    if let ExposureRequest::Stops(stops) = request.exposure {
        return Exposure::of(stops, "asked for");
    }
    let metered = metered(request, camera, placed, reflectors, air, ephemeris);
    Exposure { stops: request.exposure.stops_of(metered.stops), ..metered }
}

fn metered(
    request: &ViewRequest,
    camera: &Camera,
    placed: &[Placed<'_>],
    reflectors: &[Reflector<'_>],
    air: Option<&air::Around<'_>>,
    ephemeris: &Ephemeris,
) -> Exposure {
    match request.pixel_view {
        PixelView::Shaded => {}
        // White: a plane that faces the Sun at the target.
        PixelView::Sunlight => {
            let target = placed.iter().find(|p| Some(p.body.id) == request.target && p.body.id != NaifId::SUN);
            let irradiance = target.map_or(1.0, |p| lights::sunlight(p.sun_from_body_km).irradiance.x);
            return Exposure::of(-irradiance.log2(), "a plane that faces the Sun at the target is white");
        }
        PixelView::Cost => {
            let stops = legend::COST_STOPS;
            return Exposure::of(stops, format!("{:.0} instructions are white", (-stops).exp2()));
        }
        _ => return Exposure::of(0.0, "the picture shows a number: 1 is white"),
    }
    let drawn = request.effects.asked(super::effects::Effect::Atmosphere) != Some(false);
    let air = air.filter(|a| drawn && a.is_bright());
    let by = |lamps: f64| chosen(Meter { request, camera, placed, reflectors, air, ephemeris, lamps }.read(darkest_white()));
    let without = by(0.0);
    // Lamps count as far as the exposure would overexpose them.
    let brightest = placed.iter().filter(|p| request.lamps.contains_key(&p.body.id)).map(|p| lamps::brightest(p.body)).fold(0.0, f64::max);
    let beyond = (brightest / without.white()).max(1e-30).log2() / LAMPS_OVER_STOPS;
    if beyond > 0.0 { by(beyond.min(1.0)) } else { without }
}

/// The exposure that a reading makes.
fn chosen(reading: Reading) -> Exposure {
    let mut metered = reading.metered;
    let power = |m: &Metered| m.weight.powi(DECIDES);
    let whole: f64 = metered.iter().map(power).sum();
    let log_white: f64 = metered.iter().map(|m| power(m) / whole * (m.radiance / m.shown_at).ln()).sum();
    let key = log_white.exp();
    // Before what is brighter than the glare, it matters little; before a dark sky it is what makes the picture grey.
    let drowns = reading.glare.powi(2) / (reading.glare.powi(2) + (key * AUTO_EXPOSED_MEAN).powi(2));
    let [lit, dark] = GLARE_OF_WHITE.map(f64::recip);
    let limits = [key, reading.glare * (lit + (dark - lit) * drowns), darkest_white()];
    let white = limits.iter().map(|w| w.powi(JOINS)).sum::<f64>().powf(1.0 / f64::from(JOINS));
    metered.sort_by(|a, b| b.weight.total_cmp(&a.weight));
    Exposure::of(-white.log2(), reason(&metered, |m| power(m) / whole, limits))
}

/// Bodies in the frame whose lamps the exposure would overexpose, and that were not read.
pub(super) fn unread_lamps(request: &ViewRequest, camera: &Camera, placed: &[Placed<'_>], exposure: &Exposure) -> Vec<NaifId> {
    let metered = !matches!(request.exposure, ExposureRequest::Stops(_)) && request.pixel_view == PixelView::Shaded;
    let drawn = request.effects.asked(super::effects::Effect::Night) != Some(false);
    let wanted = |p: &&Placed<'_>| {
        let map = p.body.maps.night.as_ref().is_some_and(|m| !request.missing_maps.contains(&m.file));
        map && !request.lamps.contains_key(&p.body.id)
            && lamps::brightest(p.body) > (-exposure.metered_stops).exp2()
            && p.outline.rect(camera).is_some()
    };
    placed.iter().filter(|_| metered && drawn).filter(wanted).map(|p| p.body.id).collect()
}

/// One sentence: what was metered, how bright it is, what held the exposure.
fn reason(metered: &[Metered], part: impl Fn(&Metered) -> f64, [key, glare, darkest]: [f64; 3]) -> String {
    let candelas = |radiance: f64| {
        let l = radiance * CANDELAS_PER_RADIANCE;
        if (0.01..1e4).contains(&l) { format!("{} cd/m2", Rounded(l)) } else { format!("{l:.1e} cd/m2") }
    };
    let Some(first) = metered.first() else { return "nothing in the frame".into() };
    let mut text = format!("{} metered at {}, shown at {} of white", first.name, candelas(first.radiance), Rounded(first.shown_at));
    if let Some(second) = metered.get(1).filter(|m| part(m) > 0.1) {
        text.push_str(&format!("; {:.0} % of the choice for {} at {}", 100.0 * part(second), second.name, candelas(second.radiance)));
    }
    if glare > key.max(darkest) {
        text.push_str(&format!("; held by the Sun's glare, shown as white at {}", candelas(glare)));
    } else if darkest >= 0.999 * key {
        text.push_str(&format!("; opened no further than a photograph of the night sky, EV {DARKEST_EV}"));
    }
    text
}

/// A number of three digits or so.
struct Rounded(f64);

impl std::fmt::Display for Rounded {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let digits = (2 - self.0.abs().log10().floor() as i32).clamp(0, 4) as usize;
        let text = format!("{:.digits$}", self.0);
        let short = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
        f.write_str(short)
    }
}
