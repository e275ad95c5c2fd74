//! Local time as the displayed zone: every time that the window shows or reads is in this zone, or names another one.
//!
//! The zone is that of the computer, which a process reads from its environment. So the test runs itself again in a process with the zone of New York.

use crate::view::cut_texts::elided_texts;
use crate::view::events::open_events;
use crate::view::information::{texts, window_about};
use crate::view::input::{type_text, window_without_images};
use crate::view::interface::{session, settle};
use crate::view::search::{MARS, search};
use egui::accesskit::Role;
use egui_kittest::kittest::{NodeT, Queryable};
use orrery::catalog::NaifId;
use orrery::time::Instant;
use orrery::view::app::civil_time::ShownTimeZone;
use orrery::view::app::settings::Home;
use orrery::view::app::what_to_see_now::NowItem;
use orrery::view::language::Language;
use orrery::view::panels::Tab;
use std::process::Command;

/// The zone of New York with its present rules, as POSIX writes it, so that no database of zones is needed.
const NEW_YORK: &str = "EST5EDT,M3.2.0,M11.1.0";
/// Names the process that does the test.
const CHILD: &str = "ORRERY_TEST_IN_NEW_YORK";

/// Does nothing except in the process that the test below starts.
#[test]
fn child_in_new_york() {
    if std::env::var_os(CHILD).is_none() {
        return;
    }
    // The rows of the Events panel, the line above them and the contacts. At Greenwich, the observer's
    // place, the eclipse is after sunset, which is at 18:43 UTC.
    let mut window = window_without_images(MARS);
    window.state_mut().settings.time_zone = ShownTimeZone::Local;
    window.state_mut().settings.panels.timeline_shown = true;
    open_events(&mut window, "2024-01-01T00:00:00Z");
    window.get_by_label_contains("events after 2023-12-31 19:00 UTC-05:00");
    window.get_by_label_contains("Total solar eclipse, 2024-04-08 14:17 UTC-04:00").click();
    window.run_steps(3);
    let shown = texts(&window);
    let contact_hours: Vec<u32> = shown.iter().filter_map(|text| text.strip_prefix("04-08 ")?.get(..2)?.parse().ok()).collect();
    assert!(contact_hours.len() >= 3 && contact_hours.iter().all(|hour| (14..17).contains(hour)), "{contact_hours:?}");
    // What the timeline tells a screen reader.
    let timeline = window.get_by_role_and_label(Role::Slider, "Timeline").accesskit_node().value();
    assert_eq!(timeline.as_deref(), Some("2024-04-08 14:17 UTC-04:00"));
    // The row of the clock has room for the zone in a maximised window of a screen 1280 points wide: the last button went to a row of its own.
    window.set_size(egui::vec2(1264.0, 900.0));
    window.run_steps(3);
    let clock = window.get_by_role_and_label(Role::TextInput, "Date and time").rect();
    let is_switch = |node: &egui_kittest::Node<'_>| node.accesskit_node().role() != Role::Slider;
    let last = window.query_all_by_label("Timeline").find(is_switch).expect("the switch of the timeline").rect();
    assert!((clock.center().y - last.center().y).abs() < 6.0 && last.right() <= 1264.0, "{clock:?} {last:?}");
    // The line above the list has room for the zone in German, too.
    window.state_mut().language = Language::German;
    window.run_steps(3);
    window.get_by_label_contains("Ereignisse nach 31.12.2023, 19:00 UTC-05:00");
    let elided = elided_texts(&window);
    assert!(!elided.iter().any(|text| text.contains("UTC-05:00")), "{elided:?}");
    // A typed date is in local time, and the suggestion says so, unless the text names UTC.
    for (typed, suggested) in [
        ("8 April 2024 14:17", "2024-04-08 14:17 UTC-04:00"),
        ("8 April 2024 18:17 UTC", "2024-04-08 14:17 UTC-04:00"),
        ("2024-04-08T18:17:00Z", "2024-04-08 14:17 UTC-04:00"),
    ] {
        let mut window = window_without_images(MARS);
        window.state_mut().settings.time_zone = ShownTimeZone::Local;
        type_text(&mut window, "/");
        type_text(&mut window, typed);
        window.run_steps(2);
        window.get_by_label_contains(suggested);
        window.key_press(egui::Key::Enter);
        window.run_steps(3);
        assert_eq!(window.state().viewer.view.time().to_utc_iso(), "2024-04-08T18:17:00Z", "{typed}");
    }
    // A year begins at midnight in the zone.
    let mut window = window_without_images(MARS);
    window.state_mut().settings.time_zone = ShownTimeZone::Local;
    search(&mut window, "eclipse 2027");
    window.get_by_label_contains("events after 2027-01-01 00:00 UTC-05:00");
    // Rise, transit and set of the Information panel.
    let mut window = window_about(NaifId::SUN, NaifId::EARTH, "2024-04-09T02:00:00Z", Home::default());
    window.state_mut().settings.time_zone = ShownTimeZone::Local;
    settle(&mut window);
    let dated: Vec<String> = texts(&window).into_iter().filter(|text| text.starts_with("2024-04-0")).collect();
    assert!(dated.len() >= 3 && dated.iter().all(|text| text.starts_with("2024-04-08 ") && text.contains(" UTC-04:00")), "{dated:?}");
    // Days without a time of day: the transit of Venus was at its greatest on 6 June at 01:30 UTC, the eclipse of the Moon on 21 January at 04:44 UTC.
    let mut window = window_without_images(MARS);
    for (zone, label, day) in
        [(ShownTimeZone::Local, "Days in the time zone of this computer", "2012-06-05"), (ShownTimeZone::Utc, "Days in UTC", "2012-06-06")]
    {
        window.state_mut().settings.time_zone = zone;
        window.state_mut().tab = Some(Tab::Moments);
        window.run_steps(3);
        window.get_by_label(label);
        let days: Vec<String> = texts(&window).into_iter().filter(|text| text.starts_with("2012-06-0")).collect();
        assert!(days.len() == 1 && days[0].starts_with(day), "{zone:?}: {days:?}");
    }
    let mut window = window_without_images(MARS);
    window.state_mut().settings.time_zone = ShownTimeZone::Local;
    type_text(&mut window, "/");
    type_text(&mut window, "transit of venus");
    window.run_steps(2);
    window.get_by_label_contains("moment, 2012-06-05");
    let next_eclipse = NowItem::Eclipse.view(session(), Instant::from_tdb_seconds_past_j2000(0.0), &window.state().viewer.view);
    let next_eclipse = next_eclipse.expect("an eclipse");
    let about = [ShownTimeZone::Local, ShownTimeZone::Utc].map(|zone| next_eclipse.about(zone));
    assert!(about[0].ends_with("2000-01-20") && about[1].ends_with("2000-01-21"), "{about:?}");
    println!("all times are in local time");
}

#[test]
fn every_time_is_in_the_displayed_zone() {
    let own_path = module_path!().split_once("::").map_or("", |(_, path)| path);
    let output = Command::new(std::env::current_exe().expect("this binary"))
        .args(["--exact", &format!("{own_path}::child_in_new_york"), "--nocapture"])
        .env("TZ", NEW_YORK)
        .env(CHILD, "1")
        .output()
        .expect("starts");
    let text = String::from_utf8_lossy(&output.stdout);
    // The line shows that the child has run the test.
    assert!(output.status.success() && text.contains("all times are in local time"), "{text}{}", String::from_utf8_lossy(&output.stderr));
}
