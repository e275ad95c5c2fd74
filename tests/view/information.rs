//! The Information panel: the day of rise, transit, set and a solar eclipse.

use crate::view::interface::{harness, interface, settle};
use egui::accesskit::Role;
use egui_kittest::kittest::{NodeT, Queryable};
use orrery::catalog::NaifId;
use orrery::view::app::settings::{Home, Settings};
use orrery::view::panels::{Interface, Tab};

/// The texts of the panel about the Sun that contain a date of this month: rise, transit, set and the contacts of an eclipse.
fn dated_texts(utc: &str, home: Home, month: &str) -> Vec<String> {
    let Interface { mut viewer, settings, .. } = interface(NaifId::EARTH, utc);
    viewer.selected = NaifId::SUN;
    let mut interface = Interface::new(viewer, Settings { home, ..settings });
    interface.tab = Some(Tab::Information);
    let mut window = harness(interface);
    settle(&mut window);
    let texts = window.query_all_by_role(Role::Label).filter_map(|label| label.accesskit_node().value());
    texts.filter(|text| text.contains(month)).collect()
}

/// The day is that of UTC, which the date field shows. It was that of TDB, which began 69 s earlier in 2026 and five hours earlier in 585 BC.
#[test]
fn the_day_of_rise_and_set_is_the_displayed_one() {
    let late = ["2026-11-29T23:58:30Z", "2026-11-29T23:59:30Z"].map(|utc| dated_texts(utc, Home::default(), "2026-11-"));
    // Sunrise in Greenwich (timeanddate.com: 07:40 in London).
    assert!(late[0].iter().any(|text| text.starts_with("2026-11-29 07:4")), "{late:?}");
    assert_eq!(late[0], late[1]);
    // The eclipse that Thales is said to have predicted, in Istanbul.
    let istanbul = Home { latitude_deg: 41.01, longitude_deg: 28.95 };
    let of_thales = ["-0584-05-22T10:00:00Z", "-0584-05-22T19:30:00Z"].map(|utc| dated_texts(utc, istanbul, "-0584-05-2"));
    assert!(of_thales[0].len() >= 6 && of_thales[0].iter().all(|text| text.contains("-0584-05-22 ")), "{of_thales:?}");
    assert_eq!(of_thales[0], of_thales[1]);
    // Negative control: on the next day there is no eclipse.
    assert_eq!(dated_texts("-0584-05-23T10:00:00Z", istanbul, "-0584-05-2").len(), 3);
}
