//! The difference between an image drawn in f32 and the same image drawn in f64, and its cause.
//!
//! In: a planned view, or images of both precisions. Out: the worst pixel, its difference, and as text the cause: the first named value of a shader module with
//! a large difference ([`first_large_difference`]). The GPU may draw the f32 image; named values are always those of the software renderer.

use super::{SweepResult, SweepSetup};
use crate::measure::{LinearImage, PlannedView, larger_or_nan, level_differences};
use crate::render::plan::PlanDraw;
use crate::render::software::{NamedValue, Precision};
use crate::session::SessionError;
use serde_json::Value;

/// Index and value of the greatest of numbers of at least 0; (0, 0.0) if none is positive. NaN counts as infinity and is returned as infinity.
pub(super) fn worst_of(values: &[f64]) -> (usize, f64) {
    let nan_as_infinity = |v: &f64| if v.is_nan() { f64::INFINITY } else { *v };
    let numbers = values.iter().map(nan_as_infinity).enumerate();
    numbers.fold((0, 0.0), |(worst_index, worst), (k, v)| if v > worst { (k, v) } else { (worst_index, worst) })
}

/// For each pixel of an f32 image, the least of its differences from the same pixel of several f64 images, which differ in the grid to which vertices snap. NaN
/// where all of its differences are NaN, or if there are no f64 images.
pub(super) fn least_differences<'a, T: 'a>(
    image: &[T],
    f64_images: impl Iterator<Item = &'a [T]>,
    difference: impl Fn(&T, &T) -> f64,
) -> Vec<f64> {
    let mut least = vec![f64::NAN; image.len()];
    for f64_image in f64_images {
        for ((least, a), b) in least.iter_mut().zip(image).zip(f64_image) {
            *least = least.min(difference(a, b));
        }
    }
    least
}

/// Index of the pixel with the greatest difference of two images, and that difference in display levels. A pixel that is not finite counts as an infinite
/// difference, even if it is so in both images.
pub(super) fn worst_pixel(a: &LinearImage, b: &LinearImage) -> (usize, f64) {
    let first_not_finite = |image: &LinearImage| image.light.iter().position(|pixel| !pixel.iter().all(|v| v.is_finite()));
    match first_not_finite(a).or_else(|| first_not_finite(b)) {
        Some(index) => (index, f64::INFINITY),
        None => worst_of(&level_differences(a, b)),
    }
}

/// Draws a view in both precisions and adds the difference of the worst pixel, in levels, to `found`. `case`: a JSON object that identifies the view; the worst
/// pixel is added to it.
pub(super) fn compare(setup: &SweepSetup<'_>, found: &mut SweepResult, view: &PlannedView, case: &Value) -> Result<(), SessionError> {
    let [single, double] = [setup.draw_linear(view, Precision::F32)?, setup.draw_linear(view, Precision::F64)?];
    let (worst_index, worst) = worst_pixel(&single, &double);
    let pixel = [worst_index as u32 % single.width, worst_index as u32 / single.width];
    found.add(worst, || {
        let mut case = case.clone();
        case["pixel"] = serde_json::json!(pixel);
        (case, describe_cause(setup, view, [single.width, single.height], pixel))
    });
    Ok(())
}

/// Names the draw of the scene whose colour at a pixel differs most between the precisions, and describes its [`first_large_difference`]. Draws without values
/// at the pixel are skipped, also those whose values cannot be computed. `size`: of the image, pixels.
pub(super) fn describe_cause(setup: &SweepSetup<'_>, view: &PlannedView, size: [u32; 2], pixel: [u32; 2]) -> String {
    let draws = view.plan.hdr_pass().map(|p| p.draws.as_slice()).unwrap_or_default();
    let values_of = |draw: &PlanDraw| {
        let values = |precision| {
            let renderer = setup.renderers.renderer(precision);
            renderer.pixel_values(draw, setup.session().library(), size, pixel).ok().flatten()
        };
        let (single, double) = (values(Precision::F32)?, values(Precision::F64)?);
        let difference = single.colour.iter().zip(&double.colour).map(|(a, b)| (a - b).abs()).fold(0.0, larger_or_nan);
        Some((difference, format!("{}: {}", draw.label, first_large_difference(&single.named, &double.named))))
    };
    // `total_cmp` ranks NaN as the greatest.
    let worst = draws.iter().filter_map(values_of).max_by(|(a, _), (b, _)| a.total_cmp(b));
    worst.map_or_else(|| "no draw has values at this pixel's centre".to_owned(), |(_, cause)| cause)
}

/// Whether two numbers count as the same: they are equal, or both are NaN.
fn agree(x: f64, y: f64) -> bool {
    x == y || x.is_nan() && y.is_nan()
}

/// Describes the difference of a value: its first number that is infinite or NaN in one precision and not the same in the other; else its relative difference.
fn difference_text(single: &NamedValue, double: &NamedValue, relative: f64) -> String {
    let mut numbers = single.numbers.iter().zip(&double.numbers).enumerate();
    let Some((k, (x, y))) = numbers.find(|(_, (x, y))| !(agree(**x, **y) || x.is_finite() && y.is_finite())) else {
        return format!("{} differs by a relative {relative:.1e}", single.name);
    };
    // The number that is not finite; of NaN and infinity, NaN. A value that the pixel's control flow does not reach is NaN.
    let (value, precision) = if x.is_nan() || y.is_finite() { (x, "f32") } else { (y, "f64") };
    let index = if single.numbers.len() > 1 { format!("[{k}]") } else { String::new() };
    format!("{}{index} is {} in {precision}", single.name, if value.is_nan() { "NaN or not assigned" } else { "infinite" })
}

/// Describes the first value, in the order of the module, with a number that is infinite or NaN in one precision and not the same in the other. If there is
/// none: the first whose relative difference is at least a tenth of the greatest, because later values may magnify the difference that causes theirs.
fn first_large_difference(single: &[NamedValue], double: &[NamedValue]) -> String {
    // The greatest difference of a value's numbers over their greatest magnitude; NaN if a number is infinite or NaN in one precision and another in the other.
    let relative = |a: &NamedValue, b: &NamedValue| {
        let (scale, difference) = a.numbers.iter().zip(&b.numbers).fold((0.0_f64, 0.0_f64), |(scale, difference), (x, y)| {
            (scale.max(x.abs()).max(y.abs()), if agree(*x, *y) { difference } else { larger_or_nan(difference, (x - y).abs()) })
        });
        if scale > 0.0 { difference / scale } else { difference }
    };
    let differences: Vec<f64> = single.iter().zip(double).map(|(a, b)| relative(a, b)).collect();
    let (_, greatest) = worst_of(&differences);
    let first = differences.iter().position(|v| v.is_nan() || *v > 0.0 && *v >= 0.1 * greatest);
    first.map_or_else(|| "all named values agree".to_owned(), |k| difference_text(&single[k], &double[k], differences[k]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pixel_counts_against_the_closest_image_and_nan_is_no_match() {
        let difference = |a: &f64, b: &f64| (a - b).abs();
        let image = [1.0, 2.0, f64::NAN, 4.0];
        let exact = [[1.0, 5.0, 3.0, f64::NAN], [9.0, 2.5, 3.0, 5.0]];
        let least = least_differences(&image, exact.iter().map(<[f64; 4]>::as_slice), difference);
        assert_eq!([least[0], least[1], least[3]], [0.0, 0.5, 1.0]);
        assert!(least[2].is_nan(), "{least:?}");
        assert!(least_differences(&image, std::iter::empty(), difference).iter().all(|v| v.is_nan()), "no image to compare with");
    }

    /// Where a pixel is not finite in either precision, the images do not differ, and yet it must not pass.
    #[test]
    fn a_pixel_that_is_not_finite_in_either_image_is_the_worst() {
        let image = |third: f32| LinearImage {
            width: 4,
            height: 1,
            light: [0.0, 0.5, third, 0.25].map(|v| [v, 0.1, 0.1, 1.0]).to_vec(),
            exposure_factor: 1.0,
        };
        assert_eq!(worst_pixel(&image(0.5), &image(0.5)).1, 0.0);
        for broken in [f32::NAN, f32::INFINITY] {
            assert_eq!(worst_pixel(&image(broken), &image(broken)), (2, f64::INFINITY), "{broken}");
        }
        assert_eq!(worst_of(&[0.0, f64::NAN, 3.0]), (1, f64::INFINITY));
    }

    #[test]
    fn the_first_value_that_differs_by_much_is_named() {
        let named = |name: &str, numbers: &[f64]| NamedValue { name: name.into(), numbers: numbers.to_vec() };
        let exact = [named("a", &[1.0]), named("b", &[2.0, 3.0]), named("c", &[f64::NAN]), named("d", &[5.0])];
        let mut rounded = exact.clone();
        assert_eq!(first_large_difference(&rounded, &exact), "all named values agree");
        rounded[0].numbers[0] += 1e-7;
        rounded[1].numbers[1] += 3e-3;
        rounded[3].numbers[0] += 1e-3;
        assert_eq!(first_large_difference(&rounded, &exact), "b differs by a relative 1.0e-3");
    }

    #[test]
    fn a_value_that_is_not_finite_is_named_with_its_precision() {
        let named = |name: &str, numbers: &[f64]| NamedValue { name: name.into(), numbers: numbers.to_vec() };
        let single = [named("a", &[1.0]), named("b", &[2.0, f64::NAN]), named("c", &[f64::INFINITY])];
        let double = [named("a", &[1.1]), named("b", &[2.0, 3.0]), named("c", &[f64::INFINITY])];
        assert_eq!(first_large_difference(&single, &double), "b[1] is NaN or not assigned in f32");
        assert_eq!(first_large_difference(&double, &single), "b[1] is NaN or not assigned in f64");
        assert_eq!(first_large_difference(&single[2..], &double[2..]), "all named values agree");
        assert_eq!(first_large_difference(&single[2..], &[named("c", &[4.0])]), "c is infinite in f32");
        assert_eq!(first_large_difference(&single[2..], &[named("c", &[f64::NAN])]), "c is NaN or not assigned in f64");
    }
}
