//! Clips triangles in homogeneous coordinates.
//!
//! In: three clip-space vertices with x and y in pixels times w. Out: nothing; or that the triangle is entirely visible; or a convex polygon of at most ten
//! corners whose w is positive, whose depth is in 0..=1 and whose pixel coordinates stay within the guard band. Varyings are not clipped: their planes are
//! computed from the unclipped triangle, so new corners need no interpolated values.

/// Triangles are clipped to this distance from the target's top-left corner along each axis. The largest target is 16384 pixels wide; edge functions of
/// positions inside the band, in fixed-point steps (`STEPS_PER_PIXEL`), fit into i64.
pub(crate) const GUARD_BAND_PX: f64 = 65536.0;
/// Smallest w that is kept, divided by the triangle's greatest w: positive, because coordinates are divided by w, and far above the rounding of f64.
const MIN_W_RATIO: f64 = 1.0e-12;

/// A vertex in homogeneous pixel coordinates: pixel = (x / w, y / w), reversed depth = z / w.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ClipVertex {
    pub x: f64,
    pub y: f64,
    pub z: f64,
    pub w: f64,
}

impl ClipVertex {
    /// From clip space (y up) to pixels (y down).
    pub(crate) fn from_clip(clip_position: [f64; 4], width: u32, height: u32) -> Self {
        let [x, y, z, w] = clip_position;
        Self { x: 0.5 * (x + w) * f64::from(width), y: 0.5 * (w - y) * f64::from(height), z, w }
    }

    fn is_finite(&self) -> bool {
        self.x.is_finite() && self.y.is_finite() && self.z.is_finite() && self.w.is_finite()
    }

    /// The point between this vertex (`t` = 0) and the other (`t` = 1).
    fn interpolate(&self, other: &Self, t: f64) -> Self {
        let mix = |a: f64, b: f64| a + t * (b - a);
        Self { x: mix(self.x, other.x), y: mix(self.y, other.y), z: mix(self.z, other.z), w: mix(self.w, other.w) }
    }
}

/// A convex polygon whose corners wind like those of the triangle.
#[derive(Clone, Debug)]
pub(crate) struct Polygon {
    /// There is room for twelve, because rounding may make a thin polygon cross a plane more than twice; a convex polygon has at most ten.
    corners: [ClipVertex; 12],
    /// Number of corners.
    count: usize,
}

/// The visible part of a triangle.
#[derive(Clone, Debug)]
pub(crate) enum VisiblePart {
    /// The triangle itself.
    Whole,
    Clipped(Box<Polygon>),
}

impl Polygon {
    pub(crate) fn corners(&self) -> &[ClipVertex] {
        &self.corners[..self.count]
    }
}

const CLIP_PLANES: usize = 7;

/// Distances to the clip planes (smallest w, near, far, left, right, top, bottom), not negative inside. Depth is reversed: nearer than the near
/// plane is z > w. Their scales differ, but only their signs and ratios of distances to one plane are used.
fn distances(c: &ClipVertex, min_w: f64) -> [f64; CLIP_PLANES] {
    let guard = GUARD_BAND_PX * c.w;
    [c.w - min_w, c.w - c.z, c.z, c.x + guard, guard - c.x, c.y + guard, guard - c.y]
}

/// The visible part of a triangle; `None` if there is no visible part or a coordinate is not finite.
pub(crate) fn clip(triangle: &[ClipVertex; 3]) -> Option<VisiblePart> {
    if !triangle.iter().all(ClipVertex::is_finite) {
        return None;
    }
    let max_w = triangle.iter().fold(0.0_f64, |m, c| m.max(c.w));
    if max_w <= 0.0 {
        return None;
    }
    let min_w = max_w * MIN_W_RATIO;
    let vertex_distances = triangle.map(|c| distances(&c, min_w));
    if vertex_distances.as_flattened().iter().all(|distance| *distance >= 0.0) {
        return Some(VisiblePart::Whole);
    }
    let mut polygon = Polygon { corners: [triangle[0]; 12], count: 3 };
    polygon.corners[..3].copy_from_slice(triangle);
    // What is left of the triangle lies within it, so a plane that does not cut the triangle does not cut the rest either.
    for plane in 0..CLIP_PLANES {
        if vertex_distances.iter().all(|d| d[plane] < 0.0) {
            return None;
        }
        if vertex_distances.iter().all(|d| d[plane] >= 0.0) {
            continue;
        }
        let unclipped = polygon.clone();
        polygon.count = 0;
        for i in 0..unclipped.count {
            let (a, b) = (unclipped.corners[i], unclipped.corners[(i + 1) % unclipped.count]);
            let (distance_a, distance_b) = (distances(&a, min_w)[plane], distances(&b, min_w)[plane]);
            if distance_a >= 0.0 {
                polygon.push(a);
            }
            if (distance_a >= 0.0) != (distance_b >= 0.0) {
                // Interpolate from the inner corner to the outer one, so that two triangles that share the edge are cut at bit-identical points.
                polygon.push(if distance_a >= 0.0 {
                    a.interpolate(&b, distance_a / (distance_a - distance_b))
                } else {
                    b.interpolate(&a, distance_b / (distance_b - distance_a))
                });
            }
        }
        if polygon.count < 3 {
            return None;
        }
    }
    Some(VisiblePart::Clipped(Box::new(polygon)))
}

impl Polygon {
    fn push(&mut self, c: ClipVertex) {
        // Always true for a convex polygon: seven planes add at most one corner each, so there are at most ten.
        if self.count < self.corners.len() {
            self.corners[self.count] = c;
            self.count += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner(x: f64, y: f64, z: f64, w: f64) -> ClipVertex {
        ClipVertex { x, y, z, w }
    }

    fn clipped(triangle: &[ClipVertex; 3]) -> Box<Polygon> {
        match clip(triangle) {
            Some(VisiblePart::Clipped(polygon)) => polygon,
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn a_triangle_in_view_is_untouched() {
        let t = [corner(0.0, 0.0, 0.5, 1.0), corner(9.0, 0.0, 0.5, 1.0), corner(0.0, 9.0, 0.5, 1.0)];
        assert!(matches!(clip(&t), Some(VisiblePart::Whole)));
    }

    #[test]
    fn a_triangle_behind_the_camera_is_dropped() {
        let t = [corner(0.0, 0.0, 0.5, -1.0), corner(9.0, 0.0, 0.5, -1.0), corner(0.0, 9.0, 0.5, -2.0)];
        assert!(clip(&t).is_none());
    }

    #[test]
    fn a_triangle_nearer_than_the_near_plane_is_dropped() {
        let t = [corner(0.0, 0.0, 2.0, 1.0), corner(9.0, 0.0, 2.0, 1.0), corner(0.0, 9.0, 3.0, 1.0)];
        assert!(clip(&t).is_none());
    }

    #[test]
    fn crossing_the_near_plane_leaves_a_quadrilateral_at_depth_one() {
        // Depths 0.25, 0.25 and 4.
        let t = [corner(0.0, 0.0, 1.0, 4.0), corner(40.0, 0.0, 1.0, 4.0), corner(0.0, 4.0, 1.0, 0.25)];
        let p = clipped(&t);
        assert_eq!(p.corners().len(), 4);
        let nearest = p.corners().iter().map(|c| c.z / c.w).fold(0.0, f64::max);
        assert!((nearest - 1.0).abs() < 1e-12, "{nearest}");
    }

    #[test]
    fn no_corner_leaves_the_guard_band_and_w_stays_positive() {
        let t = [corner(-1.0e9, 5.0, 0.0, 1.0), corner(1.0e9, -1.0e8, 0.0, 1.0), corner(3.0, 1.0e12, 0.0, 0.5)];
        let p = clipped(&t);
        // Clipping an edge to a vertex 2e12 pixels away rounds by a fraction of a pixel.
        for c in p.corners() {
            assert!(c.w > 0.0);
            assert!((c.x / c.w).abs() <= GUARD_BAND_PX + 1.0, "{c:?}");
            assert!((c.y / c.w).abs() <= GUARD_BAND_PX + 1.0, "{c:?}");
        }
    }

    #[test]
    fn triangles_that_are_not_finite_are_dropped() {
        assert!(clip(&[corner(f64::NAN, 0.0, 0.0, 1.0), corner(1.0, 0.0, 0.0, 1.0), corner(0.0, 1.0, 0.0, 1.0)]).is_none());
        assert!(clip(&[corner(0.0, 0.0, 0.0, f64::INFINITY), corner(1.0, 0.0, 0.0, 1.0), corner(0.0, 1.0, 0.0, 1.0)]).is_none());
    }
}
