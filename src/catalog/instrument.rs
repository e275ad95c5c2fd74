//! Fields of view of instruments and eyepieces: `[[instrument]]` of a catalog file.
//!
//! In: the TOML table. Out: an [`Instrument`] with its field of view in degrees, or problems, added to the catalog's list. The table gives a circle by
//! `diameter_deg`, or by `focal_length_mm` and `field_stop_mm`; a rectangle by `width_deg` and `height_deg`, or by `focal_length_mm` and `sensor_mm`. Lenses
//! are taken as free of distortion, so a field stop or sensor side of length s covers the angle 2 atan(s / (2 focal length)).

use super::fields::{ALLOWED_NAME, is_name, required_word};
use super::table::TableReader;

/// The field of view of an instrument or eyepiece.
#[derive(Clone, Debug, PartialEq)]
pub struct Instrument {
    /// The name, drawn as the label of the outline.
    pub name: String,
    /// Shape and size on the sky.
    pub field_of_view: FieldOfView,
    /// Position angle of the upper side of the field of view, from north through east.
    pub position_angle_deg: f64,
}

/// The shape of a field of view, degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FieldOfView {
    /// A circle, for example of an eyepiece.
    Circle {
        /// Diameter on the sky.
        diameter_deg: f64,
    },
    /// A rectangle, for example of a sensor.
    Rectangle {
        /// Width along the middle row.
        width_deg: f64,
        /// Height along the middle column.
        height_deg: f64,
    },
}

/// Largest angle of a field of view. At 180 degrees the tangent of half the angle, with which outlines are drawn, would be infinite.
pub(crate) const MAX_FIELD_OF_VIEW_DEG: f64 = 170.0;

/// The values of the key `shape`.
#[derive(Clone, Copy, PartialEq)]
enum FieldShape {
    Circle,
    Rectangle,
}

/// The angle on the sky that a length of `size_mm` in the focal plane covers.
pub(crate) fn angle_deg(size_mm: f64, focal_length_mm: f64) -> f64 {
    2.0 * (0.5 * size_mm / focal_length_mm).atan().to_degrees()
}

/// Reads an instrument; `None` if something required is missing or wrong, which is reported as a problem.
pub(super) fn instrument(mut table: TableReader) -> Option<Instrument> {
    let name = table.required("name", ALLOWED_NAME, is_name);
    let shape = required_word(&mut table, "shape", &[("circle", FieldShape::Circle), ("rectangle", FieldShape::Rectangle)]);
    let is_allowed_angle = |x: &f64| *x > 0.0 && *x <= MAX_FIELD_OF_VIEW_DEG;
    let is_length = |x: &f64| *x > 0.0 && x.is_finite();
    let allowed_angle = format!("degrees above 0, at most {MAX_FIELD_OF_VIEW_DEG}");
    let has_focal_length = table.has("focal_length_mm");
    let focal_length_mm =
        if has_focal_length { table.optional("focal_length_mm", "millimetres above 0", is_length).map(|l| l.value) } else { None };
    // Without a valid focal length, any size is accepted, so that the only problem reported is that of the focal length.
    let covers_allowed_angle = |size_mm: &f64| {
        is_length(size_mm) && focal_length_mm.is_none_or(|focal_length_mm| angle_deg(*size_mm, focal_length_mm) <= MAX_FIELD_OF_VIEW_DEG)
    };
    let allowed_size = format!("millimetres above 0 that cover at most {MAX_FIELD_OF_VIEW_DEG} degrees");
    let field_of_view = match (shape, has_focal_length) {
        (Some(FieldShape::Circle), true) => {
            let stop = table.required("field_stop_mm", &allowed_size, covers_allowed_angle);
            focal_length_mm
                .zip(stop)
                .map(|(focal_length_mm, stop)| FieldOfView::Circle { diameter_deg: angle_deg(stop.value, focal_length_mm) })
        }
        (Some(FieldShape::Circle), false) => {
            table.required("diameter_deg", &allowed_angle, is_allowed_angle).map(|d| FieldOfView::Circle { diameter_deg: d.value })
        }
        (Some(FieldShape::Rectangle), true) => {
            let allowed = format!("width and height in {allowed_size}");
            let sensor = table.required("sensor_mm", &allowed, |v: &[f64; 2]| v.iter().all(covers_allowed_angle));
            focal_length_mm.zip(sensor).map(|(focal_length_mm, sensor)| {
                let [width_deg, height_deg] = sensor.value.map(|mm| angle_deg(mm, focal_length_mm));
                FieldOfView::Rectangle { width_deg, height_deg }
            })
        }
        (Some(FieldShape::Rectangle), false) => {
            let width = table.required("width_deg", &allowed_angle, is_allowed_angle);
            let height = table.required("height_deg", &allowed_angle, is_allowed_angle);
            width.zip(height).map(|(w, h)| FieldOfView::Rectangle { width_deg: w.value, height_deg: h.value })
        }
        (None, _) => None,
    };
    let position_angle = table.optional("position_angle_deg", "degrees from -360 to 360", |x: &f64| x.abs() <= 360.0);
    // For readers of the file only.
    let _ = table.optional::<String>("source", "a string", |_| true);
    table.finish();
    Some(Instrument { name: name?.value, field_of_view: field_of_view?, position_angle_deg: position_angle.map_or(0.0, |a| a.value) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::Catalog;

    fn read(fields: &str) -> Result<Vec<Instrument>, String> {
        let text = format!("[[instrument]]\nname = \"own\"\n{fields}\n");
        let catalog = Catalog::with_files(&[("own.toml".to_owned(), text)]).map_err(|e| e.to_string())?;
        Ok(catalog.instruments().iter().filter(|i| i.name == "own").cloned().collect())
    }

    #[test]
    fn fields_are_read_in_degrees_and_by_focal_length() {
        assert_eq!(
            read("shape = \"circle\"\ndiameter_deg = 6.5").expect("read")[0].field_of_view,
            FieldOfView::Circle { diameter_deg: 6.5 }
        );
        // A sensor twice as wide as the focal length covers 90 degrees; 24 mm cover 2 atan(12/18).
        // 36 mm behind a 50 mm lens cover 39.6 degrees, the usual value for a normal lens.
        let wide =
            read("shape = \"rectangle\"\nfocal_length_mm = 18.0\nsensor_mm = [36.0, 24.0]\nposition_angle_deg = 30.0").expect("read");
        let FieldOfView::Rectangle { width_deg, height_deg } = wide[0].field_of_view else { panic!("{wide:?}") };
        assert!((width_deg - 90.0).abs() < 1e-12 && (height_deg - 67.380).abs() < 1e-3 && wide[0].position_angle_deg == 30.0);
        let normal = read("shape = \"rectangle\"\nfocal_length_mm = 50.0\nsensor_mm = [36.0, 24.0]").expect("read");
        assert!(matches!(normal[0].field_of_view, FieldOfView::Rectangle { width_deg, .. } if (width_deg - 39.6).abs() < 0.01));
        // Those of catalogs/instruments.toml.
        assert!(Catalog::embedded().instruments().len() >= 4);
    }

    /// Line 1 is the table's header, line 2 its name; a missing field is reported at the header.
    #[test]
    fn each_mistake_names_line_and_field() {
        for (fields, expected) in [
            ("shape = \"oval\"", "own.toml:3: instrument.shape"),
            ("shape = \"circle\"", "own.toml:1: instrument.diameter_deg is missing"),
            ("shape = \"circle\"\ndiameter_deg = 200.0", "own.toml:4: instrument.diameter_deg"),
            ("shape = \"circle\"\nfocal_length_mm = 0.0\nfield_stop_mm = 3.0", "own.toml:4: instrument.focal_length_mm"),
            ("shape = \"circle\"\nfocal_length_mm = 10.0", "own.toml:1: instrument.field_stop_mm is missing"),
            // More than 170 degrees, which diameter_deg may not have either.
            ("shape = \"circle\"\nfocal_length_mm = 1e-3\nfield_stop_mm = 3.0", "own.toml:5: instrument.field_stop_mm"),
            ("shape = \"rectangle\"\nfocal_length_mm = 1.0\nsensor_mm = [36.0, 1.0]", "own.toml:5: instrument.sensor_mm"),
            ("shape = \"rectangle\"\nfocal_length_mm = 10.0\nsensor_mm = [36.0]", "own.toml:5: instrument.sensor_mm"),
            ("shape = \"rectangle\"\nwidth_deg = 1.0\nheight_deg = 1.0\nrotation = 3.0", "own.toml:6: instrument.rotation"),
        ] {
            let why = read(fields).expect_err(fields);
            assert!(why.contains(expected), "{fields}: {why}");
        }
    }
}
