//! Eclipses of the Moon at draft quality: the light of the umbra, which the Earth's air refracts, and the exposure for it.

use crate::support::folds::larger;
use crate::support::session::SESSION;
use orrery::FrameImages;
use orrery::catalog::{Catalog, NaifId};
use orrery::ephemeris::Ephemeris;
use orrery::render::plan::SamplingQuality;
use orrery::scene::Scene;
use orrery::scene::draw::EclipseModel;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{Position, Purpose, Quality, ViewRequest};
use orrery::time::Instant;

const MINUTE_S: f64 = 60.0;
/// Middle of two total eclipses and of a partial one.
const ECLIPSES: [&str; 3] = ["2022-11-08T10:59:00Z", "2018-07-27T20:22:00Z", "2023-10-28T20:14:00Z"];

/// The Moon from the Earth's centre.
fn moon(time: Instant, quality: Quality, effects: &str) -> ViewRequest {
    ViewRequest {
        position: Position::Centre(NaifId::EARTH),
        quality,
        effects: EffectOverrides::parse(effects).expect("effects"),
        width: 96,
        height: 96,
        ..ViewRequest::of(NaifId::MOON, time)
    }
}

fn eclipse_model(scene: &Scene) -> EclipseModel {
    scene.draws.iter().find(|d| d.body == NaifId::MOON).expect("the Moon is drawn").features.eclipse.model
}

/// From before the penumbra until after it: draft refracts light as standard does, from the first touch of the penumbra on, so that nothing jumps where the
/// umbra touches. The exposures are within half a stop; with uniform discs in the umbra they are not.
#[test]
fn draft_refracts_light_into_the_umbra_and_meters_it() {
    let catalog = Catalog::embedded();
    let ephemeris = Ephemeris::embedded(&catalog).expect("the shipped ephemeris");
    let (mut in_shadow, mut in_sunlight, mut worst_draft_stops, mut worst_discs_stops) = (0, 0, 0.0_f64, 0.0_f64);
    for middle in ECLIPSES {
        for ten_minutes in -20..=20 {
            let time = Instant::parse(middle).expect("a time").plus_seconds(f64::from(ten_minutes) * 10.0 * MINUTE_S);
            let case = format!("{middle}, {ten_minutes}0 min");
            let scene = |quality, effects| Scene::build(&catalog, &ephemeris, &moon(time, quality, effects)).expect("a scene");
            let (standard, draft) = (scene(Quality::Standard, ""), scene(Quality::Draft, ""));
            match eclipse_model(&standard) {
                EclipseModel::Refracted => {
                    in_shadow += 1;
                    assert_eq!(eclipse_model(&draft), EclipseModel::Refracted, "{case}");
                    let discs = scene(Quality::Draft, "+eclipse=uniform-disc");
                    worst_discs_stops = worst_discs_stops.max((discs.exposure.stops - standard.exposure.stops).abs());
                }
                model => {
                    in_sunlight += 1;
                    assert_eq!((model, eclipse_model(&draft)), (EclipseModel::None, EclipseModel::None), "{case}");
                }
            }
            worst_draft_stops = larger(worst_draft_stops, (draft.exposure.stops - standard.exposure.stops).abs());
        }
    }
    println!("draft is off by {worst_draft_stops:.3} stops, uniform discs by {worst_discs_stops:.2}");
    println!("{in_shadow} scenes in the shadow, {in_sunlight} outside");
    assert!(in_shadow > 50 && in_sunlight > 3, "{in_shadow} scenes in the shadow, {in_sunlight} outside");
    assert!(
        worst_draft_stops < 0.5 && worst_discs_stops > 2.0,
        "draft is off by {worst_draft_stops} stops, uniform discs by {worst_discs_stops}"
    );
}

/// In totality the light of the draft image is that of the standard image within a tenth; with uniform discs it is missing.
#[test]
fn the_eclipsed_moon_has_its_light_at_draft_quality() {
    let time = Instant::parse(ECLIPSES[0]).expect("a time");
    let light = |quality, effects| {
        let request = ViewRequest { purpose: Purpose::LINEAR, ..moon(time, quality, effects) };
        let drawn = SESSION.draw(&request, SamplingQuality::of(quality), FrameImages::DisplayAndHdr).expect("drawn");
        drawn.frame.hdr.iter().map(|p| f64::from(p[1])).sum::<f64>()
    };
    let standard = light(Quality::Standard, "");
    let (draft, discs) = (light(Quality::Draft, ""), light(Quality::Draft, "+eclipse=uniform-disc"));
    assert!((draft / standard - 1.0).abs() < 0.1, "light at draft quality {draft}, at standard {standard}");
    assert!(discs < 0.1 * standard, "light with uniform discs {discs}, at standard quality {standard}");
}
