//! Values of a body's ground on the grid of an equirectangular map, for the light meter.
//!
//! In: one value for each texel. Out: [`GroundGrid`], the value at each point of the ground. Always: the value is continuous.

use crate::catalog::Body;
use crate::scene::camera::narrow_scalar;
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};

/// Values on the grid of a map.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct GroundGrid {
    width: usize,
    height: usize,
    values: Vec<f32>,
    /// [`Body::map_stretch`]: the factors on y (`stretch.x`) and on z (`stretch.y`) that turn a unit-sphere point into a direction with the map's longitude and
    /// latitude.
    stretch: DVec2,
}

impl GroundGrid {
    /// `values`: rows from north to south. `None` if their number is wrong.
    pub(crate) fn new(body: &Body, width: usize, height: usize, values: impl Iterator<Item = f64>) -> Option<Self> {
        let values: Vec<f32> = values.map(narrow_scalar).collect();
        let is_complete = width > 0 && height > 0 && values.len() == width * height;
        is_complete.then(|| Self { width, height, values, stretch: body.map_stretch() })
    }

    /// The value at a point of the ground (unit-sphere frame), bilinearly interpolated.
    pub(crate) fn at(&self, point: DVec3) -> f64 {
        let direction = (point * DVec3::new(1.0, self.stretch.x, self.stretch.y)).normalize();
        let u = 0.5 + direction.y.atan2(direction.x) / TAU;
        let v = 0.5 - direction.z.clamp(-1.0, 1.0).asin() / PI;
        // In texels, from the middle of the first.
        let (x, y) = (u * self.width as f64 - 0.5, (v * self.height as f64 - 0.5).clamp(0.0, self.height as f64 - 1.0));
        let (left, upper) = (x.floor(), y.floor());
        let texel = |column: f64, row: f64| {
            let column = (column as i64).rem_euclid(self.width as i64) as usize;
            f64::from(self.values[(row as usize).min(self.height - 1) * self.width + column])
        };
        let between_columns = |row: f64| texel(left, row) + (x - left) * (texel(left + 1.0, row) - texel(left, row));
        between_columns(upper) + (y - upper) * (between_columns(upper + 1.0) - between_columns(upper))
    }
}
