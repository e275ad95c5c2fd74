//! Formats the JSON objects of `orrery eclipse find` as a text table.
//!
//! In: the objects in order of time; the catalog, whose radii the table states; the eclipses of the Moon as almanacs have them. Out: the lines. Always: times
//! are rounded to a second, those at the Moon's own limb to a tenth. Not here: the search for events (`events`).

use crate::catalog::Catalog;
use crate::events::{self, LunarEclipse, LunarType};
use crate::time::{Instant, MIN_SHOWN_DELTA_T_ERROR_S};
use crate::units::SECONDS_PER_DAY;
use crate::wording::fixed_decimals;
use serde_json::{Value, json};

// Numbers of decimals for `rounded_time`.
const TO_A_SECOND: u8 = 0;
const TO_A_TENTH: u8 = 1;

/// An ISO time without `T` and `Z`, its seconds rounded to this many decimals: with 0 decimals `2024-04-08 18:17:20`. Rounding up may change the date.
fn rounded_time(iso: &Value, decimals: u8) -> String {
    let text = iso.as_str().unwrap_or("");
    // To round, half a unit of the last decimal is added, and the digits after that decimal are cut.
    let half_unit_s = 0.5 * 0.1_f64.powi(i32::from(decimals));
    let raised = Instant::parse(text).map_or_else(|_| text.to_owned(), |t| t.plus_seconds(half_unit_s).to_utc_iso());
    let raised = raised.trim_end_matches('Z').replace('T', " ");
    // `to_utc_iso` omits a fraction of 0.
    let (whole, fraction) = raised.split_once('.').unwrap_or((raised.as_str(), ""));
    match usize::from(decimals) {
        0 => whole.to_owned(),
        kept => format!("{whole}.{:0<kept$}", fraction.get(..kept).unwrap_or(fraction)),
    }
}

/// The time of day of an ISO time, rounded to a second: `18:17:20`.
fn time_of_day(iso: &Value) -> String {
    rounded_time(iso, TO_A_SECOND).rsplit(' ').next().unwrap_or("").to_owned()
}

/// A key to sort ISO times by; infinite for a value that is no time. As texts, times in negative years would sort backwards.
fn seconds_past_j2000(iso: &Value) -> f64 {
    iso.as_str().and_then(|text| Instant::parse(text).ok()).map_or(f64::INFINITY, Instant::tdb_seconds_past_j2000)
}

/// A number with this many decimals, without a minus sign if it rounds to zero; `-` for null.
fn number_text(value: &Value, decimals: usize) -> String {
    value.as_f64().map_or_else(|| "-".to_owned(), |v| fixed_decimals(v, decimals))
}

/// A duration as text, rounded to its last unit: `4m28s` or `1h02m`; `-` for null.
fn duration_text(seconds: &Value) -> String {
    match seconds.as_f64() {
        None => "-".to_owned(),
        Some(s) if s.round() < 3600.0 => format!("{}m{:02}s", s.round() as i64 / 60, s.round() as i64 % 60),
        Some(s) => {
            let minutes = (s / 60.0).round() as i64;
            format!("{}h{:02}m", minutes / 60, minutes % 60)
        }
    }
}

/// A line about the largest error of Delta T among the rows, if it is large enough to change times that are printed to a second.
fn delta_t_text(rows: &[Value]) -> Option<String> {
    // Delta T enters through the Earth's rotation. It affects longitudes, local circumstances, and times before 1972, which are UT1; no others.
    let depends_on_rotation = |row: &Value| {
        let is_ut1 = seconds_past_j2000(&row["greatest"]) < seconds_past_j2000(&json!("1972-01-01"));
        row["lat"].is_number() || !row["local"].is_null() || is_ut1
    };
    let error_s = |row: &Value| if depends_on_rotation(row) { row["delta_t_error_s"].as_f64().unwrap_or(0.0) } else { 0.0 };
    let worst = rows.iter().max_by(|a, b| error_s(a).total_cmp(&error_s(b)))?;
    (error_s(worst) >= MIN_SHOWN_DELTA_T_ERROR_S).then(|| {
        let time = rounded_time(&worst["greatest"], TO_A_SECOND);
        let day = time.split(' ').next().unwrap_or("");
        let seconds = error_s(worst);
        let error = if seconds < 60.0 { format!("{seconds:.1} s") } else { duration_text(&json!(seconds)) };
        // The Earth turns by a degree in 240 s.
        let shift_deg = seconds / 240.0;
        format!(
            "Delta T has a standard error of {error} on {day}: longitudes may be off by {shift_deg:.3} degrees, times at a place and times before 1972 by {error}\n"
        )
    })
}

/// Type and magnitude of an eclipse of the Moon as almanacs have them: `total, magnitude 1.0095`.
fn almanac_text(eclipse: &LunarEclipse) -> String {
    let (name, magnitude) = match eclipse.class {
        LunarType::Penumbral => ("penumbral magnitude", eclipse.penumbral_magnitude),
        LunarType::Partial | LunarType::Total => ("magnitude", eclipse.umbral_magnitude),
    };
    format!("{}, {name} {}", eclipse.class.name(), fixed_decimals(magnitude, 4))
}

/// Whether a row is that of an eclipse of the Moon. Full moons are 29 days apart.
fn is_same_eclipse(row: &Value, eclipse: &LunarEclipse) -> bool {
    let difference_s = seconds_past_j2000(&row["greatest"]) - eclipse.greatest.tdb_seconds_past_j2000();
    row["kind"] == json!("lunar") && difference_s.abs() < SECONDS_PER_DAY
}

/// The line below a row whose type differs from that in almanacs.
fn almanac_note(row: &Value, lunar_by_almanacs: &[LunarEclipse]) -> Option<String> {
    let eclipse = lunar_by_almanacs.iter().find(|e| is_same_eclipse(row, e))?;
    (row["type"] != json!(eclipse.class.name()))
        .then(|| format!("almanacs, whose shadow the Earth's air enlarges: {}", almanac_text(eclipse)))
}

/// The line about eclipses that only almanacs have, because the Moon misses the geometric penumbra.
fn only_in_almanacs_text(rows: &[Value], lunar_by_almanacs: &[LunarEclipse]) -> Option<String> {
    let is_missing = |eclipse: &&LunarEclipse| !rows.iter().any(|row| is_same_eclipse(row, eclipse));
    let day =
        |eclipse: &LunarEclipse| rounded_time(&json!(eclipse.greatest.to_utc_iso()), TO_A_SECOND).split(' ').next().map(str::to_owned);
    let missing: Vec<String> = lunar_by_almanacs
        .iter()
        .filter(is_missing)
        .map(|eclipse| format!("{} ({})", day(eclipse).unwrap_or_default(), almanac_text(eclipse)))
        .collect();
    (!missing.is_empty())
        .then(|| format!("only in almanacs, whose shadow the Earth's air enlarges (--radii almanac): {}\n", missing.join(", ")))
}

/// The table. Its lines: a heading; a row for each event, followed by a line of local circumstances if the row has them, and by one with the type in almanacs
/// if that differs; a line with the number of events, the radii and the enlargement of the Earth's shadow; one about eclipses that only almanacs have; and a
/// line about the error of Delta T if it is large enough to matter. `lunar_by_almanacs`: empty if the rows are those of almanacs.
pub(super) fn as_text(catalog: &Catalog, rows: &[Value], lunar_by_almanacs: &[LunarEclipse]) -> String {
    let mut table =
        vec![["greatest (UTC)", "kind", "type", "gamma", "magnitude", "lat", "lon", "duration", "Saros", "contacts"].map(str::to_owned)];
    // For each line of `table`, the texts to print below it; none below the heading.
    let mut notes: Vec<Vec<String>> = vec![Vec::new()];
    for row in rows {
        let text_of = |name: &str| row[name].as_str().unwrap_or("-").to_owned();
        table.push([
            rounded_time(&row["greatest"], TO_A_SECOND),
            text_of("kind"),
            row["body"].as_str().map_or_else(
                || text_of("type"),
                |body| match row["by"].as_str() {
                    Some(by) => format!("{body} {} by {by}", text_of("type")),
                    None => format!("{body} {}", text_of("type")),
                },
            ),
            number_text(&row["gamma"], 4),
            number_text(&row["magnitude"], 4),
            number_text(&row["lat"], 2),
            number_text(&row["lon"], 2),
            duration_text(&row["duration_s"]),
            match (row["saros"].as_i64(), row["saros_member"].as_i64()) {
                (Some(series), Some(member)) => format!("{series}/{member}"),
                (Some(series), None) => series.to_string(),
                _ => "-".to_owned(),
            },
            contacts_text(row),
        ]);
        let local = (!row["local"].is_null()).then(|| local_text(&row["local"]));
        notes.push(almanac_note(row, lunar_by_almanacs).into_iter().chain(local).collect());
    }
    let widths: [usize; 10] = std::array::from_fn(|column| table.iter().map(|r| r[column].chars().count()).max().unwrap_or(0));
    let mut text = String::new();
    for (row, note) in table.iter().zip(notes) {
        let cells: Vec<String> = row.iter().zip(widths).map(|(cell, width)| format!("{cell:<width$}")).collect();
        text += &format!("{}\n", cells.join("  ").trim_end());
        text.extend(note.into_iter().map(|n| format!("    {n}\n")));
    }
    let shadow = events::shadow_enlargement(catalog.eclipse_radii());
    text += &format!("{} found; radii {}; the Earth's shadow: {shadow}\n", rows.len(), catalog.eclipse_radii_text());
    text.extend(only_in_almanacs_text(rows, lunar_by_almanacs));
    text.extend(delta_t_text(rows));
    text
}

/// The contacts that do not depend on a place, in order of time. C1 to C4 are local contacts, which [`local_text`] prints with their altitudes.
fn contacts_text(row: &Value) -> String {
    let Some(contacts) = row["contacts"].as_object() else { return String::new() };
    let mut by_time: Vec<_> = contacts.iter().filter(|(name, _)| !name.starts_with('C')).collect();
    by_time.sort_by(|(_, a), (_, b)| seconds_past_j2000(a).total_cmp(&seconds_past_j2000(b)));
    by_time.iter().map(|(name, time)| format!("{name} {}", time_of_day(time))).collect::<Vec<_>>().join(" ")
}

/// The line of local circumstances: `here: C1 09:11:33 (8.0°) · … · maximum 10:12:02 (11.2°) · … · magnitude 1.0180`, or `here: not visible`. A second line
/// follows if the Moon's limb profile is known.
fn local_text(local: &Value) -> String {
    if local["visible"] != json!(true) {
        return "here: not visible".to_owned();
    }
    let contact_text = |name: &str, c: &Value| {
        let below = if c["up"] == json!(true) { "" } else { ", below the horizon" };
        format!("{name} {} ({}°{below})", time_of_day(&c["time"]), number_text(&c["altitude_deg"], 1))
    };
    let mut by_time: Vec<(String, &Value)> =
        local["contacts"].as_object().into_iter().flatten().map(|(name, c)| (name.clone(), c)).collect();
    by_time.push(("maximum".to_owned(), &local["maximum"]));
    by_time.sort_by(|(_, a), (_, b)| seconds_past_j2000(&a["time"]).total_cmp(&seconds_past_j2000(&b["time"])));
    let mut parts: Vec<String> = by_time.iter().map(|(name, c)| contact_text(name, c)).collect();
    // The place sees only the penumbra in two cases: the eclipse is penumbral, and both magnitudes are equal; or the Moon is up only while it is outside the
    // umbra, and `magnitude` is not positive.
    let (magnitude, penumbral) = (&local["magnitude"], &local["penumbral_magnitude"]);
    let sees_only_penumbra = !penumbral.is_null() && (magnitude == penumbral || magnitude.as_f64().is_some_and(|m| m <= 0.0));
    parts.push(if sees_only_penumbra {
        format!("penumbral magnitude {}", number_text(penumbral, 4))
    } else {
        format!("magnitude {}", number_text(magnitude, 4))
    });
    if !local["obscuration"].is_null() {
        parts.push(format!("obscuration {}", number_text(&local["obscuration"], 4)));
    }
    for name in ["rise", "set"] {
        if !local[name].is_null() {
            parts.push(format!("{name} {}", time_of_day(&local[name])));
        }
    }
    if !local["duration_s"].is_null() {
        let is_transit = !local["contacts"]["II"].is_null();
        parts.push(format!("{} {}", if is_transit { "II to III" } else { "C2 to C3" }, duration_text(&local["duration_s"])));
    }
    let limb = &local["limb"];
    format!("here: {}{}", parts.join(" · "), if limb.is_null() { String::new() } else { format!("\n    {}", limb_text(limb)) })
}

/// The contacts computed with the Moon's limb profile:
/// `by the Moon's own limb: C1 … · C2, last bead, 18:42:12.4 (+1.3 s, at 72° from north) · …; 16.0000 heights a degree …`.
fn limb_text(limb: &Value) -> String {
    let mut by_time: Vec<(&str, &Value)> = limb["contacts"].as_object().into_iter().flatten().map(|(name, c)| (name.as_str(), c)).collect();
    by_time.sort_by(|(_, a), (_, b)| seconds_past_j2000(&a["time"]).total_cmp(&seconds_past_j2000(&b["time"])));
    let contact_text = |(name, c): &(&str, &Value)| {
        let bead = if *name == "C2" {
            ", last bead,"
        } else if *name == "C3" {
            ", first bead,"
        } else {
            ""
        };
        let time = rounded_time(&c["time"], TO_A_TENTH);
        let time = time.rsplit(' ').next().unwrap_or("");
        // Adding 0 turns -0 into +0, so that the sign is printed as a plus.
        let later_s = (10.0 * c["later_s"].as_f64().unwrap_or(0.0)).round() / 10.0 + 0.0;
        let angle_deg = c["position_angle_deg"].as_f64().unwrap_or(0.0).round().rem_euclid(360.0);
        format!("{name}{bead} {time} ({later_s:+.1} s, at {angle_deg:.0}° from north)")
    };
    let found = by_time.iter().map(contact_text).collect::<Vec<_>>().join(" · ");
    let missing = if limb["last_bead"].is_null() { "; beads throughout, or no inner contacts" } else { "" };
    format!("by the Moon's own limb: {found}{missing}; {}", limb["heights"].as_str().unwrap_or(""))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A lunar eclipse over midnight at the end of the year -2523.
    #[test]
    fn contacts_of_negative_years_are_in_order_of_time() {
        let contacts = json!({
            "P1": "-2523-12-31T20:18:32Z", "P4": "-2522-01-01T01:33:08Z", "U1": "-2523-12-31T21:25:02Z", "U4": "-2522-01-01T00:26:30Z",
        });
        assert_eq!(contacts_text(&json!({ "contacts": contacts })), "P1 20:18:32 U1 21:25:02 U4 00:26:30 P4 01:33:08");
        let contact = |time: &str| json!({ "time": time, "altitude_deg": 30.0, "up": true, "later_s": 0.0, "position_angle_deg": 90.0 });
        let by_name = json!({ "U1": contact("-2523-12-31T21:25:02Z"), "U4": contact("-2522-01-01T00:26:30Z") });
        let maximum = contact("-2523-12-31T22:55:46Z");
        let local = json!({ "visible": true, "contacts": by_name, "maximum": maximum, "magnitude": 0.5, "obscuration": null });
        let text = local_text(&local);
        assert!(text.starts_with("here: U1 21:25:02 (30.0°) · maximum 22:55:46 (30.0°) · U4 00:26:30 (30.0°) · magnitude"), "{text}");
        let text = limb_text(&json!({ "contacts": by_name, "last_bead": "", "heights": "" }));
        assert!(text.find("U1") < text.find("U4"), "{text}");
    }

    #[test]
    fn the_largest_error_of_delta_t_is_stated_if_seconds_are_wrong() {
        let row = |greatest: &str, error_s: f64| json!({ "greatest": greatest, "delta_t_error_s": error_s, "lat": 38.2 });
        let (old, recent) = (row("-0584-05-22T14:24:32.403Z", 462.4), row("2024-04-08T18:17:20Z", 0.02));
        let text = delta_t_text(&[recent.clone(), old]).expect("an error of minutes");
        assert!(text.contains("7m42s on -0584-05-22") && text.contains("1.927 degrees"), "{text}");
        let text = delta_t_text(&[row("1900-05-28T14:53:56Z", 0.8)]).expect("an error of almost a second");
        assert!(text.contains("0.8 s on 1900-05-28"), "{text}");
        assert_eq!(delta_t_text(&[recent]), None);
        assert_eq!(delta_t_text(&[]), None);
        // A transit of 2032 has neither a place nor a longitude.
        assert_eq!(delta_t_text(&[json!({ "greatest": "2032-11-13T08:54:00Z", "delta_t_error_s": 0.9, "lat": null })]), None);
    }

    #[test]
    fn times_and_durations_are_rounded_and_carry() {
        assert_eq!(rounded_time(&json!("2024-04-08T18:11:48.942Z"), TO_A_SECOND), "2024-04-08 18:11:49");
        assert_eq!(rounded_time(&json!("2024-12-31T23:59:59.500Z"), TO_A_SECOND), "2025-01-01 00:00:00");
        // The last minute of 2016 had a leap second.
        assert_eq!(rounded_time(&json!("2016-12-31T23:59:59.700Z"), TO_A_SECOND), "2016-12-31 23:59:60");
        assert_eq!(rounded_time(&json!("2016-12-31T23:59:60.700Z"), TO_A_SECOND), "2017-01-01 00:00:00");
        assert_eq!(rounded_time(&json!("2024-04-08T18:11:48.960Z"), TO_A_TENTH), "2024-04-08 18:11:49.0");
        assert_eq!(rounded_time(&json!("2024-04-08T18:11:48.940Z"), TO_A_TENTH), "2024-04-08 18:11:48.9");
        for (seconds, text) in [(267.6, "4m28s"), (3599.4, "59m59s"), (3599.6, "1h00m"), (3697.7, "1h02m"), (7199.0, "2h00m")] {
            assert_eq!(duration_text(&json!(seconds)), text, "{seconds}");
        }
    }

    #[test]
    fn what_rounds_to_zero_or_to_a_full_circle_is_zero() {
        assert_eq!((number_text(&json!(-0.00004), 4), number_text(&json!(-0.00006), 4)), ("0.0000".to_owned(), "-0.0001".to_owned()));
        let contact = json!({ "time": "2026-08-12T18:27:00Z", "later_s": -0.04, "position_angle_deg": 359.6 });
        let text = limb_text(&json!({ "contacts": { "C1": contact }, "last_bead": "", "heights": "" }));
        assert!(text.contains("C1 18:27:00.0 (+0.0 s, at 0° from north)"), "{text}");
    }
}
