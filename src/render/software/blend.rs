//! Blends a fragment's colour with the target's colour.
//!
//! In: colours in the encoding of the target, linear or sRGB; for `Blend::PremultipliedOver` the fragment's colour is already multiplied by its alpha. Out: the
//! target's new colour.

use crate::render::plan::Blend;
use std::ops::{Add, Mul, Sub};

/// The new colour of the target at one pixel or sample. `source`: the fragment's colour; `target`: the old colour.
#[inline(always)]
pub(crate) fn blend_pixel<T>(blend: Blend, source: [T; 4], target: [T; 4]) -> [T; 4]
where
    T: Copy + From<f32> + Add<Output = T> + Sub<Output = T> + Mul<Output = T>,
{
    match blend {
        Blend::Replace => source,
        Blend::PremultipliedOver => {
            let transmittance = T::from(1.0_f32) - source[3];
            std::array::from_fn(|k| source[k] + target[k] * transmittance)
        }
        Blend::Add => std::array::from_fn(|k| source[k] + target[k]),
    }
}

/// The same arithmetic as [`blend_pixel`] for several pixels, one array per component.
#[inline(always)]
pub(crate) fn blend_lanes(blend: Blend, source: [&[f32]; 4], target: [&mut [f32]; 4]) {
    let alpha = source[3];
    for (from, to) in source.into_iter().zip(target) {
        match blend {
            Blend::Replace => to.copy_from_slice(from),
            Blend::PremultipliedOver => {
                for ((t, s), a) in to.iter_mut().zip(from).zip(alpha) {
                    *t = s + *t * (1.0 - a);
                }
            }
            Blend::Add => {
                for (t, s) in to.iter_mut().zip(from) {
                    *t += s;
                }
            }
        }
    }
}

/// As [`blend_lanes`] for target pixels that all have the colour `old_colour`; `target` receives the result and is not read.
#[inline(always)]
pub(crate) fn blend_onto_colour(blend: Blend, source: [&[f32]; 4], old_colour: [f32; 4], target: [&mut [f32]; 4]) {
    let alpha = source[3];
    for ((from, old), to) in source.into_iter().zip(old_colour).zip(target) {
        match blend {
            Blend::Replace => to.copy_from_slice(from),
            Blend::PremultipliedOver => {
                for ((t, s), a) in to.iter_mut().zip(from).zip(alpha) {
                    *t = s + old * (1.0 - a);
                }
            }
            Blend::Add => {
                for (t, s) in to.iter_mut().zip(from) {
                    *t = old + s;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOURCE: [f32; 4] = [0.25, 0.5, 0.125, 0.5];
    const TARGET: [f32; 4] = [1.0, 0.5, 0.25, 0.75];

    #[test]
    fn each_blend_mode_follows_its_equation() {
        assert_eq!(blend_pixel(Blend::Replace, SOURCE, TARGET), SOURCE);
        assert_eq!(blend_pixel(Blend::PremultipliedOver, SOURCE, TARGET), [0.75, 0.75, 0.25, 0.875]);
        assert_eq!(blend_pixel(Blend::Add, SOURCE, TARGET), [1.25, 1.0, 0.375, 1.25]);
    }

    #[test]
    fn blend_lanes_gives_the_same_bits_as_blend_pixel() {
        for blend in [Blend::Replace, Blend::PremultipliedOver, Blend::Add] {
            let mut target = TARGET.map(|v| vec![v; 5]);
            let source = SOURCE.map(|v| vec![v; 5]);
            let [r, g, b, a] = &mut target;
            blend_lanes(blend, [&source[0], &source[1], &source[2], &source[3]], [r, g, b, a]);
            let expected = blend_pixel(blend, SOURCE, TARGET);
            for k in 0..4 {
                assert!(target[k].iter().all(|v| v.to_bits() == expected[k].to_bits()));
            }
            let mut over_one_colour = TARGET.map(|_| vec![f32::NAN; 5]);
            let planes = over_one_colour.each_mut().map(|plane| plane.as_mut_slice());
            blend_onto_colour(blend, [&source[0], &source[1], &source[2], &source[3]], TARGET, planes);
            assert_eq!(over_one_colour, target);
        }
    }
}
