//! Reading `[[overlay]]`: images blended over a body's ground.

use super::fields::{NAME, each, is_name, number};
use super::table::{TableReader, WithLine};
use super::{MAX_OVERLAYS, Overlay, OverlayProjection};

fn projection(table: &mut TableReader) -> Option<OverlayProjection> {
    const KINDS: [&str; 2] = ["equirectangular", "orthographic"];
    let kind = table.required("projection", "one of \"equirectangular\", \"orthographic\"", |k: &String| KINDS.contains(&k.as_str()))?;
    if kind.value == KINDS[0] {
        let west_deg = number(table, "west_deg", "degrees east from -360 to 360", |x| x.abs() <= 360.0);
        let east_deg = number(table, "east_deg", "degrees above west_deg, by 360 at most", |x| {
            west_deg.is_none_or(|west| x > west && x - west <= 360.0) && x.abs() <= 720.0
        });
        let south_deg = number(table, "south_deg", "degrees from -90 to 90", |x| x.abs() <= 90.0);
        let north_deg =
            number(table, "north_deg", "degrees above south_deg, at most 90", |x| x <= 90.0 && south_deg.is_none_or(|south| x > south));
        return Some(OverlayProjection::Equirectangular {
            west_deg: west_deg?,
            east_deg: east_deg?,
            south_deg: south_deg?,
            north_deg: north_deg?,
        });
    }
    let latitude_deg = number(table, "latitude_deg", "degrees from -90 to 90", |x| x.abs() <= 90.0);
    let longitude_deg = number(table, "longitude_deg", "degrees east from -360 to 360", |x| x.abs() <= 360.0);
    let width_km = number(table, "width_km", "kilometres above 0", |x| x > 0.0 && x < 1e9);
    let height_km = number(table, "height_km", "kilometres above 0", |x| x > 0.0 && x < 1e9);
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
    let name = table.required("name", NAME, is_name);
    let file = table.required::<String>("file", "a file name without folders", |f| !f.is_empty() && !f.contains(['/', '\\']) && f != "..");
    let gain = table.optional("gain", "three numbers from 0 to 100 (red, green, blue)", each(|x| (0.0..=100.0).contains(&x)));
    let opacity = table.optional("opacity", "a number from 0 to 1", |x: &f64| (0.0..=1.0).contains(x));
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
        return Err(format!("overlay \"{}\" is one too many: a body takes {MAX_OVERLAYS}, here {}", new.name, names.join(" and ")));
    }
    Ok(())
}
