//! English texts of other layers have messages in the window's Fluent files: reasons of scenes, and texts of the shipped catalogs.

use crate::view::interface::session;
use crate::view::marked_texts::Scan;
use orrery::catalog::NaifId;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{Layers, Position, Purpose, Quality, ViewRequest};
use orrery::time::Instant;
use orrery::view::language::{self, Language, translated};
use std::collections::BTreeSet;

/// Each body has a property that the others lack: air, rings, clouds, a shape, an invented map.
const BODIES: [&str; 14] =
    ["Sun", "Mercury", "Venus", "Earth", "Moon", "Mars", "Phobos", "Jupiter", "Io", "Saturn", "Titan", "Iapetus", "Triton", "Vesta"];

/// Reasons of scenes of every moment and of many bodies, by day and night, near and far, with all effects on and off: each has a message.
#[test]
fn reasons_of_scenes_are_messages() {
    language::set(Language::Marked);
    let mut scan = Scan::new();
    let catalog = session().catalog();
    let time = Instant::parse("2024-04-08T18:30:00Z").expect("a time");
    let named = BODIES.map(|name| catalog.bodies().iter().find(|body| body.name == name).expect(name));
    let subjects =
        named.iter().map(|body| (body.id, time)).chain(catalog.moments().iter().filter_map(|m| Some((catalog.body(m.target)?.id, m.time))));
    let mut features = BTreeSet::new();
    for (k, (target, time)) in subjects.enumerate() {
        for (n, distance_radii) in [Some(1.001), Some(3.0), Some(400.0)].into_iter().enumerate() {
            let effects =
                ["", "+eclipse=linear,+atmosphere=vertex", "-clouds,-eclipse,-atmosphere", "+atmosphere=table,+planet-shine,+ring-shine"]
                    [(k + n) % 4];
            let request = ViewRequest {
                position: Position::Over { towards: (target != NaifId::SUN && k % 2 == 0).then_some(NaifId::SUN), distance_radii },
                width: 96,
                height: 64,
                quality: [Quality::Draft, Quality::Standard][k % 2],
                effects: EffectOverrides::parse(effects).expect("effects"),
                layers: if n == 0 { Layers::default() } else { Layers::ALL },
                purpose: if k % 3 == 2 { Purpose::Linear { floor: 1e-6 } } else { Purpose::Display },
                ..ViewRequest::of(target, time)
            };
            let Ok(scene) = session().scene(&request) else { continue };
            let mut reasons = vec![scene.exposure.reason.clone()];
            for decision in scene.bodies.iter().flat_map(|body| &body.decisions).chain(&scene.sky) {
                features.insert(decision.feature);
                reasons.push(decision.tier.map_or(decision.reason.clone(), |tier| format!("{}; {tier}", decision.reason)));
            }
            reasons.sort();
            reasons.dedup();
            scan.check(&format!("{target:?}"), reasons.iter().map(|text| translated(text).into_owned()));
        }
    }
    assert!(features.len() > 35 && scan.checked > 2000, "{} features, {} reasons", features.len(), scan.checked);
    assert!(scan.faults.is_empty(), "{} of {} texts: {:#?}", scan.faults.len(), scan.checked, scan.faults);
    language::set(Language::English);
}

/// The texts of moments, tours and estimates in the shipped catalogs have messages.
#[test]
fn texts_of_catalogs_are_messages() {
    language::set(Language::Marked);
    let mut scan = Scan::new();
    let catalog = session().catalog();
    let mut texts: Vec<String> = catalog.moments().iter().flat_map(|moment| [moment.name.clone(), moment.about.clone()]).collect();
    for body in catalog.bodies() {
        texts.extend(body.estimate_notes());
        texts.extend(body.atmosphere.iter().flat_map(|air| &air.species).map(|species| species.name.clone()));
    }
    for (title, about, text) in orrery_catalogs::TOURS {
        let tour: serde_json::Value = serde_json::from_str(text).expect("JSON");
        texts.extend([title, about].map(|text| (*text).to_owned()));
        texts.extend(tour["stops"].as_array().expect("stops").iter().filter_map(|stop| stop["text"].as_str().map(str::to_owned)));
    }
    assert!(texts.len() > 100, "{} texts", texts.len());
    scan.check("catalogs", texts.iter().map(|text| translated(text).into_owned()));
    assert!(scan.faults.is_empty(), "{:#?}", scan.faults);
    language::set(Language::English);
}
