//! A telescope with an eyepiece or a camera, whose field of view is outlined in the middle of the image.
//!
//! In: lengths and angles, or a text such as `1000/25/52`. Out: [`Telescope`] and its field of view. Lenses and mirrors are taken as free of distortion; the
//! true field of an eyepiece is its apparent field divided by the magnification, as its makers give it, which agrees with its field stop to some percent.

use crate::catalog::{FieldOfView, MAX_FIELD_OF_VIEW_DEG, angle_deg};
use crate::message::TextLanguage;
use crate::scene::error::{OutOfRange, RequestValue, SceneError};
use crate::wording::echo;
use serde::{Deserialize, Serialize};
use std::ops::RangeInclusive;

/// Lengths that a telescope may have, millimetres: from the height of a small sensor to the longest focal lengths.
pub const TELESCOPE_LENGTH_RANGE_MM: RangeInclusive<f64> = 0.1..=1e6;
/// Apparent fields that an eyepiece may have, degrees.
pub const APPARENT_FIELD_RANGE_DEG: RangeInclusive<f64> = 1.0..=120.0;

/// A telescope with an eyepiece or a camera.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub enum Telescope {
    /// With an eyepiece: a circular field.
    Eyepiece {
        /// Focal length of the telescope.
        focal_length_mm: f64,
        /// Focal length of the eyepiece.
        eyepiece_mm: f64,
        /// Apparent field of the eyepiece.
        apparent_field_deg: f64,
    },
    /// With a camera: a rectangular field.
    Camera {
        /// Focal length of the telescope.
        focal_length_mm: f64,
        /// Width of the sensor.
        width_mm: f64,
        /// Height of the sensor.
        height_mm: f64,
    },
}

impl Telescope {
    /// The telescope of a text: focal length, focal length of the eyepiece, apparent field (`1000/25/52`); or focal length and sensor (`1000/22.3x14.9`).
    ///
    /// # Errors
    /// A text of another form, or numbers outside their ranges.
    pub fn parse(text: &str) -> Result<Self, SceneError> {
        let number = |text: &str, unit: &str| -> Option<f64> {
            let text = text.trim();
            text.strip_suffix(unit).unwrap_or(text).trim_end().parse().ok()
        };
        let parts: Vec<&str> = text.split('/').collect();
        let telescope = match parts.as_slice() {
            [focal_length, eyepiece, field] => {
                let apparent_field_deg = number(field, "deg").or_else(|| number(field, "°"));
                number(focal_length, "mm").zip(number(eyepiece, "mm")).zip(apparent_field_deg).map(
                    |((focal_length_mm, eyepiece_mm), apparent_field_deg)| Self::Eyepiece {
                        focal_length_mm,
                        eyepiece_mm,
                        apparent_field_deg,
                    },
                )
            }
            [focal_length, sensor] => sensor.split_once(['x', 'X']).and_then(|(width, height)| {
                Some(Self::Camera {
                    focal_length_mm: number(focal_length, "mm")?,
                    width_mm: number(width, "mm")?,
                    height_mm: number(height, "mm")?,
                })
            }),
            _ => None,
        };
        let telescope = telescope.ok_or_else(|| {
            SceneError::Request(format!(
                "telescope `{}`: write focal length/eyepiece/apparent field, as 1000/25/52, or focal length/sensor, as 1000/22.3x14.9 (mm, degrees)",
                echo(text)
            ))
        })?;
        telescope.check().map(|()| telescope)
    }

    /// The text from which [`Self::parse`] makes this telescope.
    pub fn to_text(self) -> String {
        match self {
            Self::Eyepiece { focal_length_mm, eyepiece_mm, apparent_field_deg } => {
                format!("{focal_length_mm}/{eyepiece_mm}/{apparent_field_deg}")
            }
            Self::Camera { focal_length_mm, width_mm, height_mm } => format!("{focal_length_mm}/{width_mm}x{height_mm}"),
        }
    }

    /// Rejects numbers outside their ranges, and fields of more than 170 degrees.
    ///
    /// # Errors
    /// The message names the value and its range.
    pub fn check(self) -> Result<(), SceneError> {
        let lengths = match self {
            Self::Eyepiece { focal_length_mm, eyepiece_mm, .. } => [focal_length_mm, eyepiece_mm, eyepiece_mm],
            Self::Camera { focal_length_mm, width_mm, height_mm } => [focal_length_mm, width_mm, height_mm],
        };
        let outside = |what: RequestValue, value: f64, range: &RangeInclusive<f64>, unit: &str| {
            let allowed = format!("{} to {} {unit}", range.start(), range.end());
            Err(OutOfRange { what, given: format!("{value:?} {unit}"), allowed }.into())
        };
        if let Some(length_mm) = lengths.into_iter().find(|length_mm| !TELESCOPE_LENGTH_RANGE_MM.contains(length_mm)) {
            return outside(RequestValue::TelescopeLength, length_mm, &TELESCOPE_LENGTH_RANGE_MM, "mm");
        }
        if let Self::Eyepiece { apparent_field_deg, .. } = self
            && !APPARENT_FIELD_RANGE_DEG.contains(&apparent_field_deg)
        {
            return outside(RequestValue::ApparentField, apparent_field_deg, &APPARENT_FIELD_RANGE_DEG, "degrees");
        }
        let [width_deg, height_deg] = self.size_deg();
        if width_deg.max(height_deg) > MAX_FIELD_OF_VIEW_DEG {
            return Err(SceneError::Request(format!(
                "telescope: its field is {:.0} degrees, more than {MAX_FIELD_OF_VIEW_DEG}",
                width_deg.max(height_deg)
            )));
        }
        Ok(())
    }

    /// The magnification; `None` with a camera.
    pub fn magnification(self) -> Option<f64> {
        match self {
            Self::Eyepiece { focal_length_mm, eyepiece_mm, .. } => Some(focal_length_mm / eyepiece_mm),
            Self::Camera { .. } => None,
        }
    }

    /// Width and height of the field of view, degrees.
    pub fn size_deg(self) -> [f64; 2] {
        match self {
            Self::Eyepiece { focal_length_mm, eyepiece_mm, apparent_field_deg } => [apparent_field_deg * eyepiece_mm / focal_length_mm; 2],
            Self::Camera { focal_length_mm, width_mm, height_mm } => {
                [width_mm, height_mm].map(|side_mm| angle_deg(side_mm, focal_length_mm))
            }
        }
    }

    /// Shape and size of the field of view.
    pub(crate) fn field_of_view(self) -> FieldOfView {
        let [width_deg, height_deg] = self.size_deg();
        match self {
            Self::Eyepiece { .. } => FieldOfView::Circle { diameter_deg: width_deg },
            Self::Camera { .. } => FieldOfView::Rectangle { width_deg, height_deg },
        }
    }

    /// The text at the outline: magnification and field, or width and height of the field.
    pub(crate) fn label(self, language: TextLanguage) -> String {
        let [width, height] = self.size_deg().map(|deg| if deg < 0.995 { format!("{:.1}'", 60.0 * deg) } else { format!("{deg:.2}°") });
        language.number(&match self.magnification() {
            Some(magnification) => format!("{magnification:.0}x, {width}"),
            None => format!("{width} x {height}"),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_give_fields_and_are_restored() {
        // 25 mm at 1000 mm magnifies 40 times: 52 degrees become 1.3. A full frame at 50 mm covers 39.6 degrees, as any lens of this length.
        for (text, size_deg, label) in [
            ("1000/25/52", [1.3, 1.3], "40x, 1.30°"),
            (" 1000mm / 25 mm / 52deg ", [1.3, 1.3], "40x, 1.30°"),
            ("2000/10/50°", [0.25, 0.25], "200x, 15.0'"),
            ("50/36x24", [39.598, 26.991], "39.60° x 26.99°"),
        ] {
            let telescope = Telescope::parse(text).expect(text);
            let found = telescope.size_deg();
            assert!((found[0] - size_deg[0]).abs() < 1e-3 && (found[1] - size_deg[1]).abs() < 1e-3, "{text}: {found:?}");
            assert_eq!(telescope.label(TextLanguage::English), label);
            assert_eq!(Telescope::parse(&telescope.to_text()).expect(text), telescope);
        }
        for wrong in ["", "1000", "1000/25", "1000/25/52/3", "1000/ax3", "1/3000x1", "1/20/52"] {
            let why = Telescope::parse(wrong).expect_err(wrong).to_string();
            assert!(why.starts_with("telescope") && !why.contains('\n'), "{wrong}: {why}");
        }
        for (wrong, what, expected) in [
            ("0/25/52", RequestValue::TelescopeLength, "telescope length 0.0 mm: must be 0.1 to 1000000 mm"),
            ("1000/-1x3", RequestValue::TelescopeLength, "telescope length -1.0 mm: must be 0.1 to 1000000 mm"),
            ("inf/25/52", RequestValue::TelescopeLength, "telescope length inf mm: must be 0.1 to 1000000 mm"),
            ("1000/25/200", RequestValue::ApparentField, "apparent field of the eyepiece 200.0 degrees: must be 1 to 120 degrees"),
        ] {
            let error = Telescope::parse(wrong).expect_err(wrong);
            assert_eq!(error.to_string(), expected);
            assert!(matches!(error, SceneError::OutOfRange(e) if e.what == what), "{wrong}");
        }
    }
}
