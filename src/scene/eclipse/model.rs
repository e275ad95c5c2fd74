//! The model by which the shadows of a receiver's occluders are computed.
//!
//! In: the occluders, and the model that the user requested, if any. Out: the model and the number of occluders, as the shader key holds them. The occluder
//! whose air refracts light becomes the first if the model includes refraction. Also: what models and numbers are possible for a body.

use crate::catalog::{Body, NaifId};
use crate::scene::draw::features::{Eclipse, EclipseModel, MAX_OCCLUDERS};
use crate::scene::eclipse::occluders::Occluder;
use crate::scene::eclipse::refraction::{self, BentLight};
use crate::scene::request::view_request::{Quality, ViewRequest};

/// The eclipse model that the user requested, or a default that depends on the quality.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EclipseModelChoice {
    Requested(EclipseModel),
    /// For drafts: the Sun as a uniform disc. If light may reach the receiver through the air of an occluder, the model `Refracted`, because no other light
    /// reaches the umbra.
    Draft,
    /// The Sun with limb darkening. If light may reach the receiver through the air of an occluder, the model `Refracted`.
    Best,
}

/// Chooses the model. If it includes refraction, the occluder whose air refracts light becomes the first. `Refracted` without such an occluder becomes
/// `LimbDarkened`.
pub fn choose_eclipse_model(occluders: &mut [Occluder<'_>], model_choice: EclipseModelChoice) -> Eclipse {
    let count = u8::try_from(occluders.len()).unwrap_or(MAX_OCCLUDERS);
    let requested_refracted = model_choice == EclipseModelChoice::Requested(EclipseModel::Refracted);
    let model = match model_choice {
        _ if count == 0 => EclipseModel::None,
        EclipseModelChoice::Requested(EclipseModel::Refracted) | EclipseModelChoice::Best | EclipseModelChoice::Draft => {
            let bends_light =
                |o: &Occluder<'_>| o.bent_light == BentLight::Reaches || requested_refracted && o.bent_light == BentLight::Misses;
            match occluders.iter().position(bends_light) {
                Some(k) => {
                    occluders[..=k].rotate_right(1);
                    EclipseModel::Refracted
                }
                None if model_choice == EclipseModelChoice::Draft => EclipseModel::UniformDisc,
                None => EclipseModel::LimbDarkened,
            }
        }
        EclipseModelChoice::Requested(model) => model,
    };
    Eclipse { occluders: count, model }
}

/// Largest number of occluders that a body of the catalog can have at once, and whether one of them has air that refracts light. Counts the other bodies of its
/// system and, from Saturn outwards and for asteroids, one planet of another system. Nearer to the Sun, only rare transits would count.
pub fn max_occluders<'a>(bodies: &'a [Body], receiver: &'a Body) -> (u8, bool) {
    let mut others = bodies.iter().filter(|b| b.id != receiver.id && b.id != NaifId::SUN && b.system_planet() == receiver.system_planet());
    // NAIF codes from 100 to 599: the systems of the planets from Mercury to Jupiter.
    let other_planets = usize::from(!(100..600).contains(&receiver.id.0));
    let count = (others.clone().count() + other_planets).min(usize::from(MAX_OCCLUDERS)) as u8;
    (if receiver.id == NaifId::SUN { 0 } else { count }, others.any(refraction::refracts))
}

/// The eclipse model that the user set, or the default of the quality.
pub(crate) fn eclipse_model_choice(request: &ViewRequest) -> EclipseModelChoice {
    match (request.effects.eclipse_model(), request.quality) {
        (Some(model), _) => EclipseModelChoice::Requested(model),
        (None, Quality::Draft) => EclipseModelChoice::Draft,
        (None, Quality::Standard | Quality::Reference) => EclipseModelChoice::Best,
    }
}
