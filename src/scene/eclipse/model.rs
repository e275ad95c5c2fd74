//! The model by which the shadows of a receiver's occluders are computed.
//!
//! In: the occluders, and the model that the user requested, if any. Out: the model and the number of occluders, as the shader key holds them. The occluder
//! whose air refracts light becomes the first if the model includes refraction.

use crate::scene::draw::features::{Eclipse, EclipseModel, MAX_OCCLUDERS};
use crate::scene::eclipse::occluders::Occluder;
use crate::scene::eclipse::refraction;
use crate::scene::request::view_request::{Quality, ViewRequest};

/// The eclipse model that the user requested, or a default that depends on the quality.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EclipseModelChoice {
    Requested(EclipseModel),
    /// For drafts: the Sun as a uniform disc. If an occluder whose air refracts light has an umbra on the receiver, the model `Refracted`, because no other
    /// light reaches the umbra.
    Draft,
    /// The Sun with limb darkening. If an occluder whose air refracts light has an umbra on the receiver, the model `Refracted`.
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
            match occluders.iter().position(|o| refraction::refracts(o.body) && (o.has_umbra || requested_refracted)) {
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

/// The eclipse model that the user set, or the default of the quality.
pub(crate) fn eclipse_model_choice(request: &ViewRequest) -> EclipseModelChoice {
    match (request.effects.eclipse_model(), request.quality) {
        (Some(model), _) => EclipseModelChoice::Requested(model),
        (None, Quality::Draft) => EclipseModelChoice::Draft,
        (None, Quality::Standard | Quality::Reference) => EclipseModelChoice::Best,
    }
}
