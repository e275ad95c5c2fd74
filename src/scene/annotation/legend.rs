//! The legend of an image: one line of text for the file's metadata that says what the colours mean.
//!
//! In: the pixel view, the exposure and the tone map. Out: a text with the quantity of each channel, its unit, and the values of black and
//! white. EXR files hold the numbers in that unit; PNG files hold them times 2^stops, tone-mapped or clipped to at most 1, and encoded as sRGB.

use crate::scene::body_report::InventedData;
use crate::scene::draw::{INSTRUCTIONS_PER_READ, PixelView};
use crate::scene::finished::Scene;
use crate::scene::light::exposure::Exposure;
use crate::scene::request::ToneMap;

/// The legend of an image, followed by what it shows that is invented, not measured: maps, shapes and procedural detail.
pub(crate) fn legend_of(scene: &Scene) -> String {
    let mut text = legend(scene.pixel_view, &scene.exposure, scene.tone_map);
    for body in &scene.bodies {
        for InventedData { source, how_made } in &body.invented {
            text.push_str(&format!("; invented: {source} of {}, {how_made}", body.name));
        }
    }
    text
}

/// The legend of a pixel view.
pub(crate) fn legend(view: PixelView, exposure: &Exposure, tone_map: ToneMap) -> String {
    let white = exposure.white();
    let range = |unit: &str| format!("linear; black 0, white {white:.6} {unit}");
    match view {
        PixelView::Final => format!(
            "final: radiance in red, green, blue; linear; black 0, white {white:.6}; {}; 1 is a white plane facing the Sun at 1 au",
            match tone_map {
                ToneMap::Filmic => "filmic shoulder above 0.8 of white",
                ToneMap::Clipped => "clipped at white",
            }
        ),
        PixelView::Depth => format!(
            "depth: grey; position along the line from the camera to the body's centre: 1 the body's nearest point, 0.5 its centre, \
             0 its farthest point; {}",
            range("(no unit, the body's own extent; of a ring, the ring's)")
        ),
        PixelView::Normal => {
            "normal: red, green, blue are 0.5 + 0.5 (x, y, z) of the unit normal in body-fixed axes, x to the prime meridian, z \
            to the north pole, relief included; linear; black -1, white 1 (no unit)"
                .into()
        }
        PixelView::Albedo => format!(
            "albedo: factor of the surface's photometric model in red, green, blue; of a ring, its particles' albedo times its opacity; {}",
            range("(no unit)")
        ),
        PixelView::Uv => {
            "uv: red is the map's u, 0 at the left edge, growing eastwards; green is v, 0 at the north pole, 1 at the south pole; of a \
            ring, red is the radius from its inner to its outer edge, green the longitude; linear; black 0, white 1 (no unit)"
                .into()
        }
        PixelView::Sunlight => {
            format!(
                "sunlight: irradiance on the surface by the Sun, bodies and rings that shine on it; {}",
                range("of the Sun's at 1 au on a facing plane")
            )
        }
        PixelView::Eclipse => {
            format!(
                "eclipse: fraction of the Sun's light that passes the occluders, in red, green, blue; {}",
                range("(no unit; 1 no eclipse)")
            )
        }
        PixelView::Ring => {
            format!("ring: transmittance of the ring towards the Sun; on the ring its opacity along the view; {}", range("(no unit)"))
        }
        PixelView::OpticalDepth => format!(
            "optical-depth: of the air along the view to the ground or to space in red, green, blue; of a ring along the view; {}",
            range("(natural logarithm)")
        ),
        PixelView::Cost => format!(
            "cost: red is what the software renderer ran for the pixel, in instructions of its tape (operations fused into one count once, loops count \
             each iteration, all draws are added up), green texture reads times {INSTRUCTIONS_PER_READ}; {}; full green {} reads",
            range("instructions"),
            white / INSTRUCTIONS_PER_READ
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::message::Reason;
    use crate::scene::light::exposure::COST_STOPS;

    #[test]
    fn each_view_says_what_it_shows_and_what_white_is() {
        // White is the radiance 2^2.
        let stops = -2.0;
        let exposure = Exposure::of(stops, Reason::default());
        for view in PixelView::ALL {
            let text = legend(view, &exposure, ToneMap::Filmic);
            assert!(text.starts_with(&format!("{}: ", view.name())) && text.contains("white") && !text.contains('\n'), "{text}");
        }
        assert!(legend(PixelView::OpticalDepth, &exposure, ToneMap::Filmic).contains("white 4.000000"));
        assert!(legend(PixelView::Cost, &Exposure::of(COST_STOPS, Reason::default()), ToneMap::Filmic).contains("white 16384"));
        assert!(legend(PixelView::Final, &exposure, ToneMap::Filmic).contains("white 4.000000; filmic shoulder"));
        let clipped = legend(PixelView::Final, &exposure, ToneMap::Clipped);
        assert!(clipped.contains("clipped at white") && !clipped.contains("filmic"), "{clipped}");
    }
}
