//! The sky in the sea: near the horizon water has the part of the low sky's light that its waves mirror, at dusk and by day, towards the Sun and beside it.

use super::glint::fresnel;
use crate::support::session::SESSION;
use glam::DVec3;
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::render::plan::SamplingQuality;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{Position, Up, ViewRequest};
use orrery::time::Instant;

const PIXELS: u32 = 48;
const HALF_FIELD_DEG: f64 = 35.0;

/// Altitudes of the sky that waves mirror to a horizontal view, in thirds of the light, degrees.
const MIRRORED_ALTITUDES_DEG: [f64; 3] = [5.7, 12.7, 21.1];

/// A view towards the Sun from the height of the eyes above the Atlantic. The middle of the image is in the Sun's direction, also below the horizon.
struct SeaView {
    light: Vec<DVec3>,
    sun_altitude_deg: f64,
}

impl SeaView {
    fn of(time: &str, sun_altitude_deg: f64, effects: &str) -> Self {
        let view = ViewRequest {
            position: Position::Ground { body: NaifId::EARTH, latitude_deg: 0.0, longitude_deg: -25.0, height_km: 0.0017 },
            up: Up::Zenith,
            fov_deg: Some(2.0 * HALF_FIELD_DEG),
            effects: EffectOverrides::parse(effects).expect("effects"),
            width: PIXELS,
            height: PIXELS,
            ..ViewRequest::of(NaifId::SUN, Instant::parse(time).expect("a time"))
        };
        let drawn = SESSION.draw(&view, SamplingQuality { samples: 1, anisotropy: 4 }, FrameImages::DisplayAndHdr).expect("drawn");
        let light = drawn.frame.hdr.iter().map(|p| DVec3::from_array([0, 1, 2].map(|channel| f64::from(p[channel])))).collect();
        Self { light, sun_altitude_deg }
    }

    /// The light of the pixel in a direction. `azimuth_deg`: from the Sun's, positive to the right.
    fn at(&self, altitude_deg: f64, azimuth_deg: f64) -> DVec3 {
        let (sin_sun, cos_sun) = self.sun_altitude_deg.to_radians().sin_cos();
        let (sin, cos) = altitude_deg.to_radians().sin_cos();
        let (to_right, along) = azimuth_deg.to_radians().sin_cos();
        let direction = DVec3::new(cos * along, cos * to_right, sin);
        let depth = direction.dot(DVec3::new(cos_sun, 0.0, sin_sun)) * HALF_FIELD_DEG.to_radians().tan();
        let place = [direction.y, -direction.dot(DVec3::new(-sin_sun, 0.0, cos_sun))].map(|x| 0.5 + 0.5 * x / depth);
        assert!(place.iter().all(|x| (0.0..1.0).contains(x)), "{altitude_deg} {azimuth_deg} is outside the image");
        let [column, row] = place.map(|x| (x * f64::from(PIXELS)) as usize);
        self.light[row * PIXELS as usize + column]
    }

    /// The light of the sea 3 degrees below the horizon, divided by that of the sky that waves mirror.
    fn sea_to_sky(&self, azimuth_deg: f64) -> DVec3 {
        let sky: DVec3 = MIRRORED_ALTITUDES_DEG.iter().map(|deg| self.at(*deg, azimuth_deg)).sum();
        self.at(-3.0, azimuth_deg) * MIRRORED_ALTITUDES_DEG.len() as f64 / sky
    }
}

/// The sea mirrors 0.44 of the sky to a view 3 degrees below the horizon (`mean_fresnel_water` of shaders/lib/glint.wesl). Measured, with a table that was read
/// from images of the sky: 0.45 to 0.60 with the Sun below the horizon, where the light between the table's columns is too much, and 0.46 to 0.53 by day, when
/// light from below the surface is added. Without the effect the sea was black at dusk.
#[test]
fn the_sea_mirrors_the_low_sky() {
    // The Sun 4 and 7 degrees below the horizon: in all directions, also towards the glow, where the sky is several times as bright as its mean.
    for (time, sun_altitude_deg) in [("2026-03-20T20:03:24Z", -4.0), ("2026-03-20T20:15:24Z", -7.0)] {
        let view = |effects: &str| SeaView::of(time, sun_altitude_deg, effects);
        let (with, without) = (view("-clouds,-glow"), view("-clouds,-glow,-specular"));
        for azimuth_deg in [-28.0, -15.0, 0.0, 20.0] {
            let (mirrored, dark) = (with.sea_to_sky(azimuth_deg), without.sea_to_sky(azimuth_deg));
            println!("Sun at {sun_altitude_deg}, azimuth {azimuth_deg}: {mirrored:.3}, without the effect {dark:.3}");
            assert!(mirrored.cmpgt(DVec3::splat(0.36)).all() && mirrored.cmplt(DVec3::splat(0.68)).all(), "{azimuth_deg}: {mirrored}");
            assert!(dark.cmplt(DVec3::splat(0.02)).all(), "{azimuth_deg}: {dark}");
        }
        // Negative control: a uniform sky would light the sea evenly.
        let (towards, beside) = (with.at(-3.0, 0.0), with.at(-3.0, -28.0));
        assert!(towards.y > 1.1 * beside.y, "{sun_altitude_deg}: {towards} {beside}");
    }
    // The Sun 10 degrees high: beside its glitter.
    let view = |effects: &str| SeaView::of("2026-03-20T19:07:24Z", 10.0, effects);
    let (with, without) = (view("-clouds,-glow"), view("-clouds,-glow,-specular"));
    for azimuth_deg in [-28.0, 28.0] {
        let (mirrored, dark) = (with.sea_to_sky(azimuth_deg), without.sea_to_sky(azimuth_deg));
        println!("by day, azimuth {azimuth_deg}: {mirrored:.3}, without the effect {dark:.3}");
        assert!(mirrored.cmpgt(DVec3::splat(0.36)).all() && mirrored.cmplt(DVec3::splat(0.68)).all(), "{azimuth_deg}: {mirrored}");
        assert!((mirrored - dark).cmpgt(DVec3::splat(0.25)).all(), "{azimuth_deg}: {mirrored} {dark}");
    }
}

/// Middles of the thirds of the light that waves of 5 m/s of wind mirror to a horizontal view, by the altitude from which it comes, degrees: the sum over the
/// slopes of facets, each with the area that it turns to the viewer, as `mean_fresnel` of the tests of the glint has it.
fn mirrored_altitudes_deg(reflectance: impl Fn(f64) -> f64) -> [f64; 3] {
    const STEPS: i32 = 120;
    const SLOPE_SQ: f64 = 0.0286;
    let mut facets = Vec::new();
    // A facet of another sign turns away from the viewer.
    for i in 1..=STEPS {
        for j in -STEPS..=STEPS {
            // In units of the root mean square slope in one direction, up to 5.
            let [x, y] = [i, j].map(|k| 5.0 * f64::from(k) / f64::from(STEPS));
            let [slope_x, slope_y] = [x, y].map(|s| s * (0.5 * SLOPE_SQ).sqrt());
            let length_sq = 1.0 + slope_x * slope_x + slope_y * slope_y;
            let light = slope_x * (-0.5 * (x * x + y * y)).exp() * reflectance(slope_x / length_sq.sqrt());
            facets.push(((2.0 * slope_x / length_sq).asin().to_degrees(), light));
        }
    }
    facets.sort_by(|a, b| a.0.total_cmp(&b.0));
    let all: f64 = facets.iter().map(|(_, light)| light).sum();
    [1.0, 3.0, 5.0].map(|sixths| {
        let mut sum = 0.0;
        let reaches = |(_, light): &&(f64, f64)| {
            sum += light;
            sum >= all * sixths / 6.0
        };
        facets.iter().find(reaches).expect("less than all").0
    })
}

/// The altitudes of the sky that the table and the test above count are those of the light that waves mirror: 6.1, 12.4 and 20.8 degrees. Negative control:
/// facets that mirror everything.
#[test]
fn mirrored_altitudes_are_the_middles_of_thirds_of_the_light() {
    let is_near = |found: [f64; 3]| found.iter().zip(MIRRORED_ALTITUDES_DEG).all(|(found, used)| (found - used).abs() < 1.0);
    let found = mirrored_altitudes_deg(fresnel);
    assert!(is_near(found), "{found:?}");
    assert!(!is_near(mirrored_altitudes_deg(|_| 1.0)), "the check above cannot fail");
}
