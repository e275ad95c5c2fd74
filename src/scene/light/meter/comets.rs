//! Meters the comas and tails of comets: of a comet that fills much of the frame or outshines its sky, head and tail are the subject of the image.
//!
//! In: the patches of light of the frame's comets. Out: one subject. Patches overlap, most of all in tails: at each of its samples a patch counts with its part
//! of the radiance there, so that together they count each place once. A head that is a point of light counts as little as a star: not at all.

use super::geometry::is_beside_frame;
use super::{AUTO_EXPOSED_MEAN, LogMean, MeteredFrame, MeteredSubject};
use crate::catalog::NaifId;
use crate::message::reason;
use crate::scene::camera::Camera;
use crate::scene::placed::PlacedBody;
use crate::scene::sky::comet_tails::LightPatch;
use crate::scene::sky::minor_planets::NEAR_AU;
use crate::units::KM_PER_AU;
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};

/// Rings and sectors into which a coma is divided. The innermost ring is the disc of its core; the others have radii in constant ratios.
const COMA_RINGS: u32 = 8;
const COMA_SECTORS: u32 = 8;

/// A patch in the camera's axes right, up and forward.
struct Ellipse<'p> {
    patch: &'p LightPatch,
    /// Unit vector.
    centre: DVec3,
    /// From the centre to the rim, perpendicular.
    axes: [DVec3; 2],
    /// In the brightest channel, at the centre.
    radiance: f64,
}

/// A part of a patch.
struct Part {
    /// In the camera's axes, of any length.
    direction: DVec3,
    /// The patch's radiance, integrated over the part's solid angle.
    light: f64,
}

impl<'p> Ellipse<'p> {
    fn of(patch: &'p LightPatch, camera: &Camera) -> Self {
        // A patch is in clip coordinates times view depth.
        let scale = camera.tan_half_fov.extend(1.0);
        Self {
            patch,
            centre: patch.centre.as_dvec3() * scale,
            axes: patch.axes.map(|axis| axis.as_dvec3() * scale),
            radiance: f64::from(patch.radiance * patch.colour.max_element()),
        }
    }

    fn radii(&self) -> DVec2 {
        self.patch.radii.as_dvec2()
    }

    /// Radiance in a direction.
    fn radiance_along(&self, direction: DVec3) -> f64 {
        let along = direction.dot(self.centre);
        if along <= 0.0 {
            return 0.0;
        }
        let radii = self.radii();
        let offset = DVec2::new(direction.dot(self.axes[0]), direction.dot(self.axes[1])) / (along * radii * radii);
        self.radiance * self.patch.profile(offset.length_squared())
    }

    /// The patch in parts of its own: a piece of a tail as a whole, a coma in rings and sectors.
    fn parts(&self) -> Vec<Part> {
        let (core, area_sr) = (f64::from(self.patch.core), PI * self.radii().element_product());
        if core <= 0.0 {
            // The integral of the profile (1 - r^2)^3 is a quarter of the area.
            return vec![Part { direction: self.centre, light: 0.25 * area_sr * self.radiance }];
        }
        // From 0 and the core's radius to the rim.
        let edge = |k: u32| if k == 0 { 0.0 } else { core.powf(1.0 - f64::from(k - 1) / f64::from(COMA_RINGS - 1)) };
        let part = |ring: u32, sector: u32| {
            let (inner, outer) = (edge(ring), edge(ring + 1));
            let radius = 0.5 * (inner + outer);
            let (sin, cos) = (TAU * (f64::from(sector) + 0.5) / f64::from(COMA_SECTORS)).sin_cos();
            Part {
                direction: self.centre + self.axes[0] * (radius * cos) + self.axes[1] * (radius * sin),
                light: (outer * outer - inner * inner) / f64::from(COMA_SECTORS)
                    * area_sr
                    * self.radiance
                    * self.patch.profile(radius * radius),
            }
        };
        (0..COMA_RINGS).flat_map(|ring| (0..COMA_SECTORS).map(move |sector| part(ring, sector))).collect()
    }
}

impl<'a> MeteredFrame<'_, 'a> {
    /// Meters the comas and tails in the frame; `None` without any.
    pub(super) fn comets(&self) -> Option<MeteredSubject> {
        let camera = self.meter.camera;
        let ellipses: Vec<Ellipse<'_>> = self.meter.comet_patches.iter().map(|patch| Ellipse::of(patch, camera)).collect();
        let frame_sr = 4.0 * camera.tan_half_fov.element_product();
        let (in_corner, outline_weight, no_disc) = (camera.tan_half_fov.length(), 0.0, 0.0);
        let before_sky: Vec<&PlacedBody<'a>> =
            self.resolved_bodies.iter().copied().filter(|o| !is_beside_frame(camera, &o.placement, in_corner)).collect();
        let mut mean = LogMean::default();
        for ellipse in &ellipses {
            let view_depth_km = NEAR_AU / f64::from(ellipse.patch.depth) * KM_PER_AU;
            let nearer: Vec<&PlacedBody<'a>> = before_sky.iter().copied().filter(|o| o.distance_km < view_depth_km).collect();
            let softness_rad = ellipse.radii().min_element();
            for Part { direction, light } in ellipse.parts() {
                let towards = camera.right * direction.x + camera.up * direction.y + camera.forward * direction.z;
                let position_weight = self.part_position_weight(towards, outline_weight, no_disc);
                if position_weight <= 0.0 {
                    continue;
                }
                let radiance: f64 = ellipses.iter().map(|e| e.radiance_along(direction)).sum();
                let share = light / (radiance * frame_sr) * Self::ray_visibility(&nearer, towards, softness_rad);
                mean.add_outside_highlights(share * position_weight, radiance, self.foreground_radiance(towards, NaifId::SUN));
            }
        }
        let no_body = None;
        mean.metered(reason!("subject-comets"), no_body, AUTO_EXPOSED_MEAN)
    }
}
