//! Meters the sunlight that the air at the limbs of bodies in front of the Sun lets through, such as the ring of the Earth's air seen from the eclipsed Moon.
//!
//! In: the segments into which `eclipse::refracted_limb` divides each limb. Out: one subject for the limbs of all bodies together, with the light that
//! refraction alone brings there; and the part of the Sun's disc that is seen through air, which is metered with the Sun.

use super::geometry::{area_px, entire_disc_weight, outline_position_weight, visible_fraction_behind_body};
use super::{LogMean, Meter, MeteredFrame, MeteredSubject, SUN_WEIGHT, far_weight, sun_half_weight_share};
use crate::catalog::NaifId;
use crate::message::reason;
use crate::scene::atmosphere::air;
use crate::scene::eclipse::refracted_limb::{LimbLight, limb_light};
use crate::scene::light::exposure::AUTO_EXPOSED_MEAN;
use crate::scene::placed::PlacedBody;
use crate::scene::request::effects::Effect;
use glam::FloatExt;
use std::f64::consts::PI;

impl<'a> Meter<'_, 'a> {
    /// The bodies with refracted limbs, unless the user has switched them or the atmosphere off.
    pub(super) fn limb_lights(&self, sun: &PlacedBody<'_>) -> Vec<(&PlacedBody<'a>, LimbLight)> {
        let effects = &self.context.request.effects;
        let is_off = |p: &PlacedBody<'_>| {
            [Effect::Atmosphere, Effect::RefractedLimb].iter().any(|e| effects.override_of_body(p.body, *e) == Some(false))
        };
        let pixel_rad = self.camera.pixel_tangent();
        self.placed.iter().filter(|p| !is_off(p)).filter_map(|p| Some((p, limb_light(p, sun, pixel_rad)?))).collect()
    }
}

impl MeteredFrame<'_, '_> {
    /// Of the part of the Sun's disc that no body hides: the fraction that is seen through the air at a limb, and the transmittance of this air. `limb_lights`:
    /// see [`Meter::limb_lights`].
    pub(super) fn sun_behind_air(&self, sun: &PlacedBody<'_>, limb_lights: &[(&PlacedBody<'_>, LimbLight)]) -> (f64, f64) {
        let (towards, radius_rad) = (sun.placement.centre_km / sun.distance_km, sun.angular_radius_rad());
        let (mut clear, mut log_transmittance) = (1.0_f64, 0.0_f64);
        for (p, limb) in limb_lights {
            let Some(top) = air::shell(p.body, &p.placement) else { continue };
            let beside_body = visible_fraction_behind_body(&p.placement, towards, radius_rad);
            let behind_air = (1.0 - visible_fraction_behind_body(&top, towards, radius_rad) / beside_body.max(1e-300)).clamp(0.0, 1.0);
            if behind_air > 0.0 {
                clear *= 1.0 - behind_air;
                log_transmittance += 1.0_f64.lerp(limb.transmittance, limb.drawn_fraction).max(1e-300).ln();
            }
        }
        (1.0 - clear, log_transmittance.exp())
    }

    /// Meters all refracted limbs of the frame; `None` if none of them counts.
    pub(super) fn refracted_limbs(&self, limb_lights: &[(&PlacedBody<'_>, LimbLight)]) -> Option<MeteredSubject> {
        let (camera, request) = (self.meter.camera, self.meter.context.request);
        let frame_sr = 4.0 * camera.tan_half_fov.element_product();
        let (mut all, mut dominant, mut max_weight) = (LogMean::default(), None, 0.0);
        for (p, limb) in limb_lights {
            let mut mean = LogMean::default();
            // A limb seen from afar is a part of its body's image: it has the weight of the body's position, wherever on the limb the Sun's light is. If the
            // body reaches beyond the frame, each part of the limb has the weight of its own position instead.
            let diameter_px = 2.0 * (area_px(camera, p) / PI).sqrt();
            let disc_weight = far_weight(p) * entire_disc_weight(camera, p, diameter_px);
            let outline_weight = outline_position_weight(camera, p);
            let nearer = self.nearer_bodies(p, camera.pixel_tangent());
            for segment in &limb.segments {
                let weight_in_frame = self.part_position_weight(segment.direction, outline_weight, disc_weight);
                let visible_weight = weight_in_frame * Self::ray_visibility(&nearer, segment.direction, camera.pixel_tangent());
                mean.add(
                    visible_weight * segment.bent_fraction * segment.solid_angle / frame_sr,
                    segment.radiance,
                    self.foreground_radiance(segment.direction, p.body.id),
                );
            }
            // The limb counts as part of the target if the target is this body or the Sun. An image of the Sun on a short arc is a source of light, as a small
            // Sun is, and not the subject.
            let is_target = [Some(p.body.id), Some(NaifId::SUN)].contains(&request.target);
            let arc_disc_share = limb.arc_disc_sr / frame_sr;
            let weight_as_subject = arc_disc_share / (arc_disc_share + sun_half_weight_share(is_target));
            let weight = limb.drawn_fraction * weight_as_subject * if is_target { SUN_WEIGHT } else { 1.0 };
            let mean = mean.times(weight);
            if mean.weight > max_weight {
                (max_weight, dominant) = (mean.weight, Some(p.body));
            }
            all.merge(&mean);
        }
        let body = dominant?;
        all.metered(reason!("subject-refracted-limb", body = &body.name), Some(body.id), AUTO_EXPOSED_MEAN)
    }
}
