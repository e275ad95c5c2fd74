//! The telescope that the user has typed into the Effects panel.
//!
//! In: the fields of the panel, a view from a link. Out: a [`Telescope`]. Always: the numbers of eyepiece and sensor are both kept, so that the choice
//! between them loses none.

use crate::scene::request::Telescope;
use serde::{Deserialize, Serialize};

/// Focal lengths, the eyepiece and the sensor, as the settings keep them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct TelescopeSetup {
    /// Whether a camera is in the place of the eyepiece.
    pub has_camera: bool,
    pub focal_length_mm: f64,
    pub eyepiece_mm: f64,
    pub apparent_field_deg: f64,
    pub sensor_width_mm: f64,
    pub sensor_height_mm: f64,
}

impl Default for TelescopeSetup {
    fn default() -> Self {
        // A small telescope, the eyepiece that is sold with it, and a sensor of the size called APS-C.
        Self {
            has_camera: false,
            focal_length_mm: 1000.0,
            eyepiece_mm: 25.0,
            apparent_field_deg: 52.0,
            sensor_width_mm: 22.3,
            sensor_height_mm: 14.9,
        }
    }
}

impl TelescopeSetup {
    /// The telescope with the chosen eyepiece or camera.
    pub(crate) fn telescope(&self) -> Telescope {
        let focal_length_mm = self.focal_length_mm;
        if self.has_camera {
            Telescope::Camera { focal_length_mm, width_mm: self.sensor_width_mm, height_mm: self.sensor_height_mm }
        } else {
            Telescope::Eyepiece { focal_length_mm, eyepiece_mm: self.eyepiece_mm, apparent_field_deg: self.apparent_field_deg }
        }
    }

    /// Takes over the numbers of a view's telescope.
    pub(crate) fn set(&mut self, telescope: Telescope) {
        match telescope {
            Telescope::Eyepiece { focal_length_mm, eyepiece_mm, apparent_field_deg } => {
                *self = Self { has_camera: false, focal_length_mm, eyepiece_mm, apparent_field_deg, ..*self };
            }
            Telescope::Camera { focal_length_mm, width_mm, height_mm } => {
                *self = Self { has_camera: true, focal_length_mm, sensor_width_mm: width_mm, sensor_height_mm: height_mm, ..*self };
            }
        }
    }
}
