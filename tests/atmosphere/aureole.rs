//! The aureole of Venus in transit (Lomonosov's arc): the Sun refracted by the air over its clouds, along the limb outside the Sun's disc.

use crate::support::folds::larger;
use crate::support::session::SESSION;
use glam::DVec2;
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::render::plan::{SamplingQuality, plan};
use orrery::render::software::{Options, SoftwareRenderer};
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{ExposureRequest, Position, ViewRequest};
use orrery::time::Instant;

const VENUS: NaifId = NaifId(299);

fn view(time: &str, effects: &str) -> ViewRequest {
    ViewRequest {
        position: Position::Centre(NaifId::EARTH),
        fov_deg: Some(0.03),
        width: 256,
        height: 256,
        exposure: ExposureRequest::Stops(0.0),
        effects: EffectOverrides::parse(&format!("sun:-glow,sun:-corona{effects}")).expect("effects"),
        ..ViewRequest::of(VENUS, Instant::parse(time).expect("a time"))
    }
}

/// The light of the aureole per arcsecond of the limb, within 30 degrees of the point opposite the Sun, per channel; unit: that of a square arcsecond of the
/// brightest part of the Sun in the image.
fn aureole(time: &str) -> [f64; 3] {
    let renderer = SoftwareRenderer::new(Options::default()).expect("a renderer");
    let sampling = SamplingQuality { samples: 1, anisotropy: 1 };
    let [(scene, with), (_, without)] = ["", ",-refracted-limb"].map(|effects| {
        let scene = SESSION.scene(&view(time, effects)).expect("a scene");
        let plan = plan(&scene, &*SESSION, sampling).expect("a plan");
        let hdr = renderer.render(&plan, SESSION.library(), FrameImages::DisplayAndHdr).expect("drawn").0.hdr;
        (scene, hdr)
    });
    let photosphere = without.iter().map(|p| f64::from(p[1])).fold(0.0, larger);
    let camera = &scene.camera;
    let [venus, sun] = [VENUS, NaifId::SUN].map(|id| scene.body(id).expect("placed").placement.centre_km.normalize());
    let to_sun = (sun - venus * sun.dot(venus)).normalize();
    let radius_rad = 6051.8 / scene.body(VENUS).expect("placed").placement.centre_km.length();
    let mut light = [0.0; 3];
    for (k, (with, without)) in with.iter().zip(&without).enumerate() {
        let pixel = DVec2::new((k as u32 % camera.width).into(), (k as u32 / camera.width).into()) + 0.5;
        let offset = camera.ray(camera.clip_from_pixel(pixel)).normalize() - venus;
        let is_at_limb = (offset.length() / radius_rad - 1.0).abs() < 0.1;
        if is_at_limb && offset.dot(to_sun) < -(30_f64.to_radians().cos()) * offset.length() {
            for c in 0..3 {
                light[c] += f64::from(with[c]) - f64::from(without[c]);
            }
        }
    }
    let arcseconds = |angle: f64| angle.to_degrees() * 3600.0;
    let arc = arcseconds(radius_rad) * 60_f64.to_radians();
    light.map(|sum| sum * arcseconds(camera.pixel_tangent()).powi(2) / arc / photosphere)
}

/// During the ingress of 2012. A telescope that resolves 1.2 arcseconds sees the aureole much darker than the photosphere: SDO/HMI in this ingress less than
/// 5 % (Yeo et al. 2014, A&A 561, A22, figure 9). It is the brighter, the nearer the limb is to that of the Sun, whose yellowish light it has.
#[test]
fn venus_has_its_aureole_at_the_ingress_of_2012() {
    let series = ["2012-06-05T22:12:00Z", "2012-06-05T22:20:00Z", "2012-06-05T22:25:00Z"].map(aureole);
    for light in series {
        println!("{light:?}");
        assert!(light[1] > 1e-4 && light[1] < 0.05 * 1.2, "{light:?}");
        assert!((1.0..2.5).contains(&(light[0] / light[2])), "{light:?}");
    }
    assert!(series[0][1] < series[1][1] && series[1][1] < series[2][1], "{series:?}");
    // Half outside the Sun: of a layer of air 10 km high, 0.05 arcseconds, which bends the light enough, the haze leaves a tenth.
    assert!((1.5e-3..8e-3).contains(&series[1][1]), "{series:?}");
}

/// The step costs something only where the aureole may be seen: a day before the transit no layer shows the Sun.
#[test]
fn the_aureole_is_drawn_only_next_to_the_sun() {
    let limbs = |time: &str| SESSION.scene(&view(time, "")).expect("a scene").refracted_limbs.len();
    assert_eq!([limbs("2012-06-04T22:20:00Z"), limbs("2012-06-05T22:20:00Z")], [0, 1]);
    let scene = SESSION.scene(&view("2012-06-04T22:20:00Z", "")).expect("a scene");
    let decisions = &scene.body(VENUS).expect("there").decisions;
    let decision = decisions.iter().find(|d| d.effect == "refracted-limb").expect("decided");
    assert!(!decision.on && decision.reason.to_string().contains("no layer"), "{}", decision.reason);
}
