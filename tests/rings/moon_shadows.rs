//! Moons' shadows on rings: those in the image take precedence over larger moons' shadows outside it.

use crate::support::session::SESSION;
use glam::DVec3;
use orrery::catalog::NaifId;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{Axes, Position, ViewRequest};
use orrery::time::Instant;

const PAN: i32 = 618;
const SATURN: NaifId = NaifId(699);

/// Pan, 17 km in radius, over Saturn's rings from 27 000 km: a view found by a random sweep.
fn view(effects: &str) -> ViewRequest {
    let radius_km = SESSION.catalog().body(NaifId(PAN)).expect("Pan").radii_km.max_element();
    let direction = DVec3::new(-0.784_842_955_904_222_4, -0.222_785_865_765_931_07, -0.578_262_909_568_344_5);
    let offset_km = direction * 1_582.960_268_969 * radius_km;
    ViewRequest {
        position: Position::Offset { body: NaifId(PAN), offset_km, axes: Axes::Icrf },
        fov_deg: Some(0.226_324_461_891_858_23),
        width: 32,
        height: 32,
        effects: EffectOverrides::parse(effects).expect("effects"),
        ..ViewRequest::of(NaifId(PAN), Instant::parse("1944-07-16T04:37:10.406Z").expect("a time"))
    }
}

fn decision(effects: &str) -> (bool, String) {
    let scene = SESSION.scene(&view(effects)).expect("a scene");
    let decisions = &scene.body(SATURN).expect("Saturn").decisions;
    let found = decisions.iter().find(|d| d.effect == "eclipse-on-rings").expect("decided");
    (found.on, found.reason.to_string())
}

/// With all rings drawn, larger moons also cast shadows on them, but outside the image. A draw has room for few occluders, and Pan must be
/// one of them.
#[test]
fn shadows_of_larger_moons_outside_the_image_do_not_displace_that_of_a_small_moon_in_it() {
    for effects in ["", "+rings", "+rings,+eclipse"] {
        let (on, reason) = decision(effects);
        assert!(on && reason.starts_with("penumbra of Pan"), "`{effects}`: {reason}");
    }
    // By default only Pan's shadow is computed. `+eclipse` adds shadows outside the image, after Pan's.
    assert!(decision("+rings").1.starts_with("penumbra of Pan on"), "{}", decision("+rings").1);
    assert!(decision("+rings,+eclipse").1.starts_with("penumbra of Pan, "), "{}", decision("+rings,+eclipse").1);
}
