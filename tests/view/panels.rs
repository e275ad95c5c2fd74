//! Each panel as screen readers see it: the accessibility tree as recorded text, without measured values. Costs of effects, tone maps, choice of the
//! renderer.

use crate::view::input::window_without_images;
use crate::view::interface::{harness, harness_of, interface, session, settle};
use egui::accesskit::{Role, Toggled};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use orrery::FrameImages;
use orrery::catalog::NaifId;
use orrery::render::plan::SamplingQuality;
use orrery::scene::effects::Effect;
use orrery::scene::request::{Composition, ExposureRequest, Position, Quality, Stereo, StereoLayout, ToneMap, ViewRequest};
use orrery::session::{Readiness, RendererPreference, Session, Sources};
use orrery::time::Instant;
use orrery::view::panels::{Interface, Tab};
use std::fmt::Write;

const SATURN: NaifId = NaifId(699);
const EQUINOX: &str = "2017-05-17T00:00:00Z";
/// Units of measured values.
const MEASURED: [&str; 3] = ["ms", "MiB", "µs"];

/// A line with `#` for the numbers that differ from run to run: in the Performance and Shader panels all numbers, in the Information panel, whose durations are
/// light times, none, and in other panels those in front of a measured unit.
fn without_measurements(line: &str, tab: Option<Tab>) -> String {
    let words: Vec<&str> = line.split(' ').collect();
    let is_number = |w: &str| w.trim_matches(|c| "+-−(,%".contains(c)).parse::<f64>().is_ok();
    let is_unit = |w: Option<&&str>| w.is_some_and(|w| MEASURED.contains(&w.trim_end_matches(',')));
    let is_measured = |k: usize| match tab {
        Some(Tab::Performance | Tab::Shader) => true,
        Some(Tab::Information) => false,
        _ => is_unit(words.get(k + 1)),
    };
    let kept = words.iter().enumerate().map(|(k, w)| if is_number(w) && is_measured(k) { "#" } else { w });
    kept.collect::<Vec<_>>().join(" ")
}

/// Indented lines: role, name or value, and toggle state, without measured values.
fn outline(harness: &Harness<'static, Interface>) -> String {
    fn walk(node: &egui_kittest::Node<'_>, depth: usize, tab: Option<Tab>, out: &mut String) {
        let n = node.accesskit_node();
        let shown_text = n.label().or_else(|| n.value()).unwrap_or_default();
        // Text runs repeat their label; other tests cover source lines. In other panels, numbers aligned at the right begin with blanks.
        let is_source_line = n.role() == Role::Unknown || tab == Some(Tab::Shader) && shown_text.starts_with("    ");
        if n.role() == Role::TextRun || is_source_line && !shown_text.is_empty() {
            return;
        }
        let is_layout = matches!(n.role(), Role::GenericContainer | Role::Unknown | Role::Window);
        let child_depth = if is_layout && shown_text.is_empty() { depth } else { depth + 1 };
        if child_depth > depth {
            let state = match n.toggled() {
                Some(Toggled::True) => " [on]",
                Some(Toggled::False) => " [off]",
                _ => "",
            };
            let shown_text = shown_text.split("view?").next().unwrap_or_default().replace('\n', " / ");
            // The current folder differs between machines.
            let current_folder = std::env::current_dir().map_or(String::new(), |d| d.display().to_string());
            let shown_text = if current_folder.is_empty() { shown_text } else { shown_text.replace(&current_folder, "(here)") };
            let line = without_measurements(&shown_text, tab);
            let _ = writeln!(out, "{}{:?} {line}{state}", "  ".repeat(depth), n.role());
        }
        for child in node.children() {
            walk(&child, child_depth, tab, out);
        }
    }
    let mut out = String::new();
    walk(&harness.root(), 0, harness.state().tab, &mut out);
    out
}

#[test]
fn each_panel_is_as_recorded() {
    let mut interface = interface(SATURN, EQUINOX);
    interface.settings.panels.timeline_shown = true;
    let mut harness = harness(interface);
    for tab in Tab::ALL {
        harness.state_mut().tab = Some(tab);
        settle(&mut harness);
        let name = format!("panel_{}", tab.title().to_lowercase());
        insta::assert_snapshot!(name, outline(&harness));
    }
    harness.state_mut().tab = None;
    harness.state_mut().help_shown = true;
    settle(&mut harness);
    insta::assert_snapshot!("panel_help", outline(&harness));
}

#[test]
fn measurements_are_left_out_of_the_record_and_nothing_else() {
    assert_eq!(without_measurements("software · 300x200 · 12 ms", None), "software · 300x200 · # ms");
    assert_eq!(without_measurements("+1.2 ms, -3.9 % light (4.1 %)", Some(Tab::Effects)), "# ms, -3.9 % light (4.1 %)");
    assert_eq!(without_measurements("1 429 000 km", None), "1 429 000 km");
    assert_eq!(without_measurements("991.3 ms", Some(Tab::Information)), "991.3 ms");
    assert_eq!(without_measurements("draws 12", Some(Tab::Performance)), "draws #");
}

fn saturn_view() -> ViewRequest {
    let time = Instant::parse(EQUINOX).expect("a time");
    let position = Position::AboveTarget { towards: Some(NaifId::SUN), distance_radii: Some(5.0) };
    ViewRequest { position, width: 240, height: 160, quality: Quality::Draft, ..ViewRequest::of(SATURN, time) }
}

#[test]
fn an_effect_cost_includes_its_change_of_light() {
    let view = saturn_view();
    let cost_of = |effect, on, body| session().effect_cost(&view, 2.0, (effect, on), body).expect("a cost");
    let shadow = cost_of(Effect::RingShadow, true, None);
    assert!(shadow.light.net < -1e-3 && shadow.light.absolute >= -shadow.light.net - 1e-9, "a shadow takes light: {shadow:?}");
    assert_eq!(cost_of(Effect::RingShadow, true, Some("Saturn")).light, shadow.light, "no other body has this effect");
    let rings = cost_of(Effect::Rings, true, None);
    assert!(rings.light.net > 0.05, "the rings add light: {rings:?}");
    // An effect that no body of the view has changes nothing.
    let night = cost_of(Effect::Night, false, None);
    assert!(night.light.net == 0.0 && night.light.absolute == 0.0, "{night:?}");
    assert!(cost_of(Effect::RingShadow, true, Some("Titan")).light.absolute == 0.0, "Titan has no rings");
    // A stereo pair has display values only; the change is that of one eye's image.
    let stereo = Some(Stereo { layout: StereoLayout::Anaglyph, eye_separation_km: None });
    let pair = ViewRequest { composition: Composition { stereo, ..Composition::default() }, ..view.clone() };
    let of_pair = session().effect_cost(&pair, 2.0, (Effect::RingShadow, true), None).expect("a cost");
    assert_eq!(of_pair.light, shadow.light);
}

#[test]
fn effect_costs_appear_once_the_view_is_at_rest() {
    let mut harness = harness(interface(SATURN, EQUINOX));
    harness.state_mut().tab = Some(Tab::Effects);
    let costs_shown = |h: &Harness<'static, Interface>| h.query_all_by_label_contains("% light").count();
    let time_rate = &mut harness.state_mut().viewer.time_rate;
    time_rate.toggle_pause();
    (0..8).for_each(|_| time_rate.faster());
    settle(&mut harness);
    assert!(harness.state().viewer.is_animating());
    assert_eq!(costs_shown(&harness), 0, "nothing is measured while the view moves");
    harness.state_mut().viewer.time_rate.toggle_pause();
    settle(&mut harness);
    assert!(costs_shown(&harness) > 5, "{} costs", costs_shown(&harness));
}

#[test]
fn the_tone_map_clips_or_compresses_light_above_white() {
    // At an exposure of 4.5 stops a part of the Moon exceeds white.
    let time = Instant::parse("2024-04-20T00:00:00Z").expect("a time");
    let view = ViewRequest { width: 48, height: 48, exposure: ExposureRequest::Stops(4.5), ..ViewRequest::of(NaifId::MOON, time) };
    let drawn = |tone_map| {
        let view = ViewRequest { tone_map, ..view.clone() };
        session().draw(&view, SamplingQuality::of(Quality::Standard), FrameImages::DisplayAndHdr).expect("an image").frame
    };
    let (filmic, clipped) = (drawn(ToneMap::Filmic), drawn(ToneMap::Clipped));
    assert_eq!(filmic.hdr, clipped.hdr, "the light is the same");
    let peak = |rgba: [f32; 4]| rgba[..3].iter().fold(0.0_f32, |a, b| a.max(*b)) * 4.5_f32.exp2();
    let mut dark_and_bright = [0, 0];
    for ((light, filmic_pixel), clipped_pixel) in filmic.hdr.iter().zip(&filmic.display).zip(&clipped.display) {
        if peak(*light) < 0.79 {
            assert_eq!(filmic_pixel, clipped_pixel, "below 0.8 of white both curves are the same");
            dark_and_bright[0] += 1;
        } else if peak(*light) > 1.01 {
            assert_eq!(clipped_pixel[..3].iter().max(), Some(&255), "the clipped curve ends at white");
            assert!(filmic_pixel[..3].iter().all(|c| *c < 255), "the filmic curve stays below white: {filmic_pixel:?}");
            dark_and_bright[1] += 1;
        }
    }
    assert!(dark_and_bright.iter().all(|n| *n > 20), "dark and bright pixels: {dark_and_bright:?}");
}

/// A link or a file may set any valid exposure and any valid brightness of stars, also beyond the ends of the sliders.
#[test]
fn an_opened_panel_does_not_change_values_beyond_its_sliders() {
    for (exposure_stops, stars_boost) in [(-40.0, -10.0), (45.0, 25.0)] {
        let mut window = window_without_images(SATURN);
        let view = &mut window.state_mut().viewer.view;
        (view.exposure_stops, view.stars_boost) = (Some(exposure_stops), stars_boost);
        window.state_mut().tab = Some(Tab::Effects);
        window.run_steps(3);
        window.get_by_label("Sky and lines").click_accesskit();
        window.run_steps(30);
        assert!(window.query_all_by_label("Faint light, stops").next().is_some(), "the slider is not shown");
        let view = &window.state().viewer.view;
        assert_eq!((view.exposure_stops, view.stars_boost), (Some(exposure_stops), stars_boost));
    }
}

#[test]
fn the_renderer_is_chosen_in_the_window() {
    // Not the shared session, which must keep the software renderer.
    let cache = tempfile::tempdir().expect("a folder").keep();
    let sources = Sources { cache: Some(cache), ..Sources::default() };
    let session: &'static Session = Box::leak(Box::new(Session::open(&sources, |line| println!("{line}")).expect("a session")));
    let mut harness = harness_of(session, interface(SATURN, EQUINOX));
    harness.set_size(egui::vec2(700.0, 400.0));
    harness.state_mut().tab = Some(Tab::Effects);
    settle(&mut harness);
    harness.get_by_label("clipped").click();
    settle(&mut harness);
    assert_eq!(harness.state().viewer.view.tone_map, ToneMap::Clipped);
    assert_eq!(harness.state().shown().expect("an image").scene.tone_map, ToneMap::Clipped);
    let (choices, chosen) = session.renderers();
    assert_eq!(chosen, RendererPreference::Software);
    if choices.len() == 1 {
        assert!(harness.query_by_label("auto").is_none(), "a build with one renderer offers no choice");
        return;
    }
    for (name, preference) in [("GPU", RendererPreference::Gpu), ("software", RendererPreference::Software)] {
        harness.get_by_label(name).click();
        settle(&mut harness);
        assert_eq!(session.renderers().1, preference);
        assert!(harness.state().shown().is_some() && harness.state().message_line().is_empty(), "{}", harness.state().message_line());
        // The session is never dropped, and a driver that still works when the process exits would crash.
        while session.readiness() == Readiness::Preparing {
            std::thread::sleep(std::time::Duration::from_millis(10));
        }
    }
    assert_eq!(harness.state().shown().expect("an image").drawn_by.renderer, "software");
}

#[test]
fn settings_open_no_panel_twice() {
    for (kept, kept_tab) in [("Share", None), ("Events", Some(Tab::Events)), ("No such panel", None)] {
        let Interface { viewer, mut settings, .. } = interface(SATURN, EQUINOX);
        (settings.panels.open_panel, settings.panels.kept_panel) = (Some("Share".into()), Some(kept.into()));
        let interface = Interface::new(viewer, settings);
        assert_eq!((interface.tab, interface.kept_tab), (Some(Tab::Share), kept_tab), "{kept}");
    }
}
