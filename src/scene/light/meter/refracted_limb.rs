//! Meters the sunlight that the air at the limbs of bodies in front of the Sun refracts, such as the ring of the Earth's air seen from the eclipsed Moon.
//!
//! In: the segments into which `eclipse::refracted_limb` divides each limb. Out: one subject for the limbs of all bodies together.

use super::geometry::{area_px, entire_disc_weight, outline_position_weight};
use super::{LogMean, MeteredFrame, MeteredSubject, SUN_WEIGHT, far_weight};
use crate::catalog::NaifId;
use crate::message::reason;
use crate::scene::eclipse::refracted_limb;
use crate::scene::light::exposure::AUTO_EXPOSED_MEAN;
use crate::scene::request::effects::Effect;
use std::f64::consts::PI;

impl MeteredFrame<'_, '_> {
    /// Meters all refracted limbs of the frame, unless the user has switched them or the atmosphere off.
    pub(super) fn refracted_limbs(&self) -> Option<MeteredSubject> {
        let (camera, request) = (self.meter.camera, self.meter.context.request);
        let sun = self.meter.placed.iter().find(|p| p.body.id == NaifId::SUN)?;
        let frame_sr = 4.0 * camera.tan_half_fov.element_product();
        let (mut all, mut dominant, mut max_weight) = (LogMean::default(), None, 0.0);
        for p in self.meter.placed {
            if [Effect::Atmosphere, Effect::RefractedLimb].iter().any(|e| request.effects.override_of_body(p.body, *e) == Some(false)) {
                continue;
            }
            let segments = refracted_limb::segments(p, sun, camera.pixel_tangent());
            if segments.is_empty() {
                continue;
            }
            let mut mean = LogMean::default();
            // A limb seen from afar is a part of its body's image: it has the weight of the body's position, wherever on the limb the Sun's light is. If the
            // body reaches beyond the frame, each part of the limb has the weight of its own position instead.
            let diameter_px = 2.0 * (area_px(camera, p) / PI).sqrt();
            let disc_weight = far_weight(p) * entire_disc_weight(camera, p, diameter_px);
            let outline_weight = outline_position_weight(camera, p);
            let nearer = self.nearer_bodies(p, camera.pixel_tangent());
            for segment in segments {
                let weight_in_frame = self.part_position_weight(segment.direction, outline_weight, disc_weight);
                let visible_weight = weight_in_frame * Self::ray_visibility(&nearer, segment.direction, camera.pixel_tangent());
                mean.add(
                    visible_weight * segment.solid_angle / frame_sr,
                    segment.radiance,
                    self.foreground_radiance(segment.direction, Some(p.body.id)),
                );
            }
            // The limb counts as part of the target if the target is this body or the Sun.
            let is_target = [Some(p.body.id), Some(NaifId::SUN)].contains(&request.target);
            let weight = if is_target { SUN_WEIGHT } else { 1.0 };
            let mean = LogMean { weight: mean.weight * weight, log_sum: mean.log_sum * weight };
            if mean.weight > max_weight {
                (max_weight, dominant) = (mean.weight, Some(p.body));
            }
            all.merge(&mean);
        }
        let body = dominant?;
        all.metered(reason!("subject-refracted-limb", body = &body.name), Some(body.id), AUTO_EXPOSED_MEAN)
    }
}
