//! Reading `[[overlay]]`: images blended over a body's ground.
//!
//! In: the TOML table. Out: the [`Overlay`] and the name of its body, which the caller looks up, or problems, which the
//! [`TableReader`] collects. Not here: the image of a `[[layer]]` on a body, which is drawn as an overlay, too (`data_layer`).

use super::fields::{ALLOWED_FILE_NAME, ALLOWED_NAME, each_component, is_file_name, is_name, required_number};
use super::table::{TableReader, WithLine};
use super::{MAX_OVERLAYS, Overlay, OverlayProjection};

/// Reads the field `projection`, and the fields that this projection needs.
fn projection(table: &mut TableReader) -> Option<OverlayProjection> {
    const KINDS: [&str; 2] = ["equirectangular", "orthographic"];
    let kind = table.required("projection", "one of \"equirectangular\", \"orthographic\"", |k: &String| KINDS.contains(&k.as_str()))?;
    if kind.value == KINDS[0] {
        let west_deg = required_number(table, "west_deg", "degrees east from -360 to 360", |x| x.abs() <= 360.0);
        let east_deg = required_number(table, "east_deg", "degrees above west_deg, by 360 at most", |x| {
            west_deg.is_none_or(|west| x > west && x - west <= 360.0) && x.abs() <= 720.0
        });
        let south_deg = required_number(table, "south_deg", "degrees from -90 to 90", |x| x.abs() <= 90.0);
        let north_deg = required_number(table, "north_deg", "degrees above south_deg, at most 90", |x| {
            x <= 90.0 && south_deg.is_none_or(|south| x > south)
        });
        return Some(OverlayProjection::Equirectangular {
            west_deg: west_deg?,
            east_deg: east_deg?,
            south_deg: south_deg?,
            north_deg: north_deg?,
        });
    }
    let latitude_deg = required_number(table, "latitude_deg", "degrees from -90 to 90", |x| x.abs() <= 90.0);
    let longitude_deg = required_number(table, "longitude_deg", "degrees east from -360 to 360", |x| x.abs() <= 360.0);
    let width_km = required_number(table, "width_km", "kilometres above 0 and below 1e9", |x| x > 0.0 && x < 1e9);
    let height_km = required_number(table, "height_km", "kilometres above 0 and below 1e9", |x| x > 0.0 && x < 1e9);
    Some(OverlayProjection::Orthographic {
        latitude_deg: latitude_deg?,
        longitude_deg: longitude_deg?,
        width_km: width_km?,
        height_km: height_km?,
    })
}

/// Reads an `[[overlay]]`: the body's name and the overlay.
pub(super) fn overlay(mut table: TableReader) -> Option<(WithLine<String>, Overlay)> {
    let body_name = table.required("body", "the name of a body", |_: &String| true);
    let name = table.required("name", ALLOWED_NAME, is_name);
    let file = table.required::<String>("file", ALLOWED_FILE_NAME, |f| is_file_name(f));
    let gain = table.optional("gain", "three numbers from 0 to 100 (red, green, blue)", each_component(|x| (0.0..=100.0).contains(&x)));
    let opacity = table.optional("opacity", "a number from 0 to 1", |x: &f64| (0.0..=1.0).contains(x));
    // For readers of the file; read here so that it is not reported as unknown.
    let _ = table.optional::<String>("source", "a string", |_| true);
    let projection = projection(&mut table);
    table.finish();
    let overlay = Overlay {
        name: name?.value,
        file: file?.value,
        gain: gain.map_or([1.0; 3], |g| g.value),
        opacity: opacity.map_or(1.0, |o| o.value),
        projection: projection?,
    };
    Some((body_name?, overlay))
}

/// Adds an overlay, or replaces the overlay of the same name. The error states why it cannot be added.
pub(super) fn add(overlays: &mut Vec<Overlay>, new: Overlay) -> Result<(), String> {
    if let Some(same_name) = overlays.iter_mut().find(|o| o.name == new.name) {
        *same_name = new;
    } else if overlays.len() < usize::from(MAX_OVERLAYS) {
        overlays.push(new);
    } else {
        let names: Vec<_> = overlays.iter().map(|o| format!("\"{}\"", o.name)).collect();
        return Err(format!(
            "overlay \"{}\" is one too many: a body can have {MAX_OVERLAYS}, and this one has {}",
            new.name,
            names.join(" and ")
        ));
    }
    Ok(())
}
