//! Formats the JSON objects of `orrery eclipse find` as a text table.

use crate::catalog::Catalog;
use crate::events;
use serde_json::{Value, json};

/// An ISO time without fractions of a second: `2024-04-08 18:17:20`.
fn short_time(iso: &Value) -> String {
    let text = iso.as_str().unwrap_or("");
    text.split('.').next().unwrap_or("").trim_end_matches('Z').replace('T', " ")
}

/// The time of day of an ISO time: `18:17:20`.
fn time_of_day(iso: &Value) -> String {
    short_time(iso).rsplit(' ').next().unwrap_or("").to_owned()
}

fn number(value: &Value, digits: usize) -> String {
    value.as_f64().map_or_else(|| "-".to_owned(), |v| format!("{v:.digits$}"))
}

/// A duration as text: `4m28s` or `1h02m`.
fn duration(seconds: &Value) -> String {
    match seconds.as_f64().map(|s| s.round() as i64) {
        None => "-".to_owned(),
        Some(s) if s < 3600 => format!("{}m{:02}s", s / 60, s % 60),
        Some(s) => format!("{}h{:02}m", s / 3600, s % 3600 / 60),
    }
}

/// The table: a heading, a row for each event, with `at_place` a line of local circumstances below it, and a last line with the number of events.
pub(super) fn as_text(catalog: &Catalog, rows: &[Value], at_place: bool) -> String {
    let mut table =
        vec![["greatest (UTC)", "kind", "type", "gamma", "magnitude", "lat", "lon", "duration", "Saros", "contacts"].map(str::to_owned)];
    // The line below each row; the heading has none.
    let mut notes: Vec<Option<String>> = vec![None];
    for row in rows {
        let word = |name: &str| row[name].as_str().unwrap_or("-").to_owned();
        table.push([
            short_time(&row["greatest"]),
            word("kind"),
            row["body"].as_str().map_or_else(
                || word("type"),
                |body| match row["by"].as_str() {
                    Some(by) => format!("{body} {} by {by}", word("type")),
                    None => format!("{body} {}", word("type")),
                },
            ),
            number(&row["gamma"], 4),
            number(&row["magnitude"], 4),
            number(&row["lat"], 2),
            number(&row["lon"], 2),
            duration(&row["duration_s"]),
            match (row["saros"].as_i64(), row["saros_member"].as_i64()) {
                (Some(series), Some(member)) => format!("{series}/{member}"),
                (Some(series), None) => series.to_string(),
                _ => "-".to_owned(),
            },
            contacts_text(row),
        ]);
        notes.push((at_place && !row["local"].is_null()).then(|| local_text(&row["local"])));
    }
    let widths: [usize; 10] = std::array::from_fn(|column| table.iter().map(|r| r[column].chars().count()).max().unwrap_or(0));
    let mut text = String::new();
    for (row, note) in table.iter().zip(notes) {
        let cells: Vec<String> = row.iter().zip(widths).map(|(cell, width)| format!("{cell:<width$}")).collect();
        text += &format!("{}\n", cells.join("  ").trim_end());
        text.extend(note.map(|n| format!("    {n}\n")));
    }
    let shadow = events::shadow_enlargement(catalog.eclipse_radii());
    text + &format!("{} found; radii {}; the Earth's shadow: {shadow}\n", rows.len(), catalog.eclipse_radii_text())
}

/// The contacts in order of time, without C1 to C4, which [`local_text`] prints on their own line.
fn contacts_text(row: &Value) -> String {
    let Some(contacts) = row["contacts"].as_object() else { return String::new() };
    let mut by_time: Vec<_> = contacts.iter().filter(|(name, _)| !name.starts_with('C')).collect();
    by_time.sort_by_key(|(_, time)| time.as_str().unwrap_or(""));
    by_time.iter().map(|(name, time)| format!("{name} {}", time_of_day(time))).collect::<Vec<_>>().join(" ")
}

/// The line of a place: `here: C1 09:11:33 (8.0°) · … · maximum 10:12:02 (11.2°) · … · magnitude 1.0180`, or `here: not visible`. A second line follows
/// if the Moon's limb profile is known.
fn local_text(local: &Value) -> String {
    if local["visible"] != json!(true) {
        return "here: not visible".to_owned();
    }
    let contact_text = |name: &str, c: &Value| {
        let below = if c["up"] == json!(true) { "" } else { ", below the horizon" };
        format!("{name} {} ({}°{below})", time_of_day(&c["time"]), number(&c["altitude_deg"], 1))
    };
    let mut by_time: Vec<(String, &Value)> =
        local["contacts"].as_object().into_iter().flatten().map(|(name, c)| (name.clone(), c)).collect();
    by_time.push(("maximum".to_owned(), &local["maximum"]));
    by_time.sort_by_key(|(_, c)| c["time"].as_str().unwrap_or("").to_owned());
    let mut parts: Vec<String> = by_time.iter().map(|(name, c)| contact_text(name, c)).collect();
    // A Moon that is up only outside the umbra has no umbral magnitude. In a penumbral eclipse both values are the same.
    let (magnitude, penumbral) = (&local["magnitude"], &local["penumbral_magnitude"]);
    let in_penumbra = !penumbral.is_null() && (magnitude == penumbral || magnitude.as_f64().is_some_and(|m| m <= 0.0));
    parts.push(if in_penumbra {
        format!("penumbral magnitude {}", number(penumbral, 4))
    } else {
        format!("magnitude {}", number(magnitude, 4))
    });
    if !local["obscuration"].is_null() {
        parts.push(format!("obscuration {}", number(&local["obscuration"], 4)));
    }
    for name in ["rise", "set"] {
        if !local[name].is_null() {
            parts.push(format!("{name} {}", time_of_day(&local[name])));
        }
    }
    if !local["duration_s"].is_null() {
        parts.push(format!("for {}", duration(&local["duration_s"])));
    }
    let limb = &local["limb"];
    format!("here: {}{}", parts.join(" · "), if limb.is_null() { String::new() } else { format!("\n    {}", limb_text(limb)) })
}

/// The contacts computed with the Moon's limb profile:
/// `by the Moon's own limb: C1 … · C2, last bead, 18:42:12.4 (+1.3 s, at 72° from north) · …; 16.0000 heights a degree …`.
fn limb_text(limb: &Value) -> String {
    let mut by_time: Vec<(&str, &Value)> = limb["contacts"].as_object().into_iter().flatten().map(|(name, c)| (name.as_str(), c)).collect();
    by_time.sort_by_key(|(_, c)| c["time"].as_str().unwrap_or("").to_owned());
    let contact_text = |(name, c): &(&str, &Value)| {
        let bead = if *name == "C2" {
            ", last bead,"
        } else if *name == "C3" {
            ", first bead,"
        } else {
            ""
        };
        // To a tenth of a second.
        let time =
            c["time"].as_str().unwrap_or("").trim_end_matches('Z').rsplit('T').next().unwrap_or("").chars().take(10).collect::<String>();
        let delay_s = c["later_s"].as_f64().unwrap_or(0.0);
        format!("{name}{bead} {time} ({delay_s:+.1} s, at {}° from north)", number(&c["position_angle_deg"], 0))
    };
    let found = by_time.iter().map(contact_text).collect::<Vec<_>>().join(" · ");
    let missing = if limb["last_bead"].is_null() { "; beads throughout, or no inner contacts" } else { "" };
    format!("by the Moon's own limb: {found}{missing}; {}", limb["heights"].as_str().unwrap_or(""))
}
