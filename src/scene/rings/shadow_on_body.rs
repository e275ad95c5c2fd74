//! The shadow of another body's rings on a drawn body: the grid of `shadow_grid`, cached from frame to frame, with the axes by which a shader finds a place in
//! it.
//!
//! In: the rings before the Sun of a lit body. Out: [`ShadowOnBody`] (shaders/lib/ring/shadow_on_moon.wesl). A grid takes up to a tenth of a second, and depends
//! only on the place of the body and of the Sun relative to the rings. [`ShadowGridCache`] keeps it while the camera turns, for the faces of a dome, and while
//! orbit and light time change that place by less than the grid shows. For this the place is rounded before the grid is computed, so that an image does not
//! depend on the images before it. Places in a grid are relative to the body's centre, so f32 suffices for the axes.
//!
//! Error of the rounding: it moves the shadow by up to 5.5 % of the spacing of places, sqrt(3) / 2 of a step for the place of the body, and as much for the
//! direction to the Sun. That changes the light at a place by up to 0.004 (docs/accuracy.md).

use crate::memo::Memo;
use crate::scene::camera::{narrow, narrow_scalar};
use crate::scene::draw::tables::RingShadowGrid;
use crate::scene::rings::ring_table::RingInterval;
use crate::scene::rings::rings_before_sun::{Beam, RingsBeforeSun};
use crate::scene::rings::shadow_grid::{ShadedSun, places_along_side};
use glam::{DMat3, DVec3, Vec4};
use std::sync::Arc;

/// The spacing of places divided by the largest step of the rounding.
const STEPS_PER_SPACING: f64 = 32.0;
/// Steps of the natural logarithm of the Sun's distance, which hardly changes the shadow.
const STEPS_OF_SUN_DISTANCE: f64 = 1e4;
/// Number of cached grids: those of the moons behind a planet's rings at one time, for both variants of the Compare panel. A grid takes up to 150 kB.
const CACHE_CAPACITY: usize = 8;

/// The body on which the shadow falls.
pub(crate) struct LitGlobe {
    pub body_from_icrf: DMat3,
    /// Equatorial radius, the unit of the shader's lengths.
    pub unit_km: f64,
    /// Radius of the disc that the Sun sees.
    pub disc_radius_km: f64,
    /// Largest distance of a lit point from the centre, with air and clouds.
    pub extent_km: f64,
}

/// The shadow, for a draw's uniforms.
pub(crate) struct ShadowOnBody {
    pub grid: Arc<RingShadowGrid>,
    /// As in `RingUniforms::shadow_grid_axes`.
    pub axes: [Vec4; 2],
    /// Smallest and largest fraction of green sunlight on the disc.
    pub range: [f64; 2],
}

impl ShadowOnBody {
    /// Whether the fraction varies over the disc by more than this part of it. If not, one factor serves the whole body.
    pub(crate) fn varies_by_more_than(&self, min_change: f64) -> bool {
        let [from, to] = self.range;
        to - from > min_change * to
    }
}

/// What a grid depends on, besides the rings. Axes and lengths as in [`Beam`], but turned by [`turn`].
#[derive(Clone, Copy, Debug, PartialEq)]
struct Lighting {
    beam: Beam,
    /// Semi-axes of the rings' owner.
    globe: DVec3,
    /// The Sun's.
    limb_darkening: (DVec3, DVec3),
    /// Half the grid's side, and the radius of the disc that the Sun sees.
    half_side: f64,
    disc_radius: f64,
}

/// A grid in the axes of [`Lighting`].
#[derive(Debug)]
struct Shadow {
    grid: Arc<RingShadowGrid>,
    /// Unit vectors along its rows and its columns.
    axes: [DVec3; 2],
    range: [f64; 2],
}

impl Shadow {
    fn of(intervals: &[RingInterval], lighting: Lighting) -> Option<Self> {
        let Lighting { beam, globe, limb_darkening, half_side, disc_radius } = lighting;
        let shaded = ShadedSun::of(beam, intervals, globe, limb_darkening, half_side)?;
        let side = shaded.side(intervals);
        let fractions = shaded.fractions(side);
        let on_disc = fractions.iter().enumerate().filter(|(k, _)| shaded.place(*k, side).length() <= disc_radius);
        let range = on_disc.fold([1.0_f64, 0.0_f64], |[from, to], (_, fraction)| [from.min(fraction.y), to.max(fraction.y)]);
        let texels = fractions.iter().flat_map(|fraction| narrow(*fraction).extend(0.0).to_array()).collect();
        Some(Self { grid: Arc::new(RingShadowGrid { side: side as u32, texels }), axes: [shaded.x, shaded.y], range })
    }
}

/// Turns the owner's axes about the rings' axis to the azimuth of the Sun: the rings look alike from all sides, and the owner's rotation shall not count. The
/// globe of an owner with three different axes does not look alike, so its axes are kept.
fn turn(to_sun: DVec3, globe: DVec3) -> DMat3 {
    if globe.x == globe.y { DMat3::from_rotation_z(-to_sun.y.atan2(to_sun.x)) } else { DMat3::IDENTITY }
}

/// A vector whose components are rounded to multiples of the largest power of two up to `max_step`. A power of two, because a step that changed a little with
/// every frame would change the result, too.
fn rounded(v: DVec3, max_step: f64) -> DVec3 {
    let step = max_step.log2().floor().exp2();
    (v / step).round() * step
}

/// A beam whose shadow differs by no more than a grid with this spacing shows. `reach`: distance from the body to the farthest part of the rings.
fn rounded_beam(beam: Beam, spacing: f64, reach: f64) -> Option<Beam> {
    let to_sun = beam.sun - beam.body;
    let distance = ((to_sun.length().ln() * STEPS_OF_SUN_DISTANCE).round() / STEPS_OF_SUN_DISTANCE).exp();
    let max_step = spacing / STEPS_PER_SPACING;
    let body = rounded(beam.body, max_step);
    let sunward = rounded(to_sun.try_normalize()?, max_step / reach).try_normalize()?;
    Some(Beam { body, sun: body + sunward * distance, ..beam })
}

/// The intervals of radius, as `RingTables` has them, and the light on them.
type Inputs = (Arc<Vec<RingInterval>>, Lighting);

/// Grids, cached from frame to frame; `None` for rings that take no visible part of the light.
#[derive(Debug)]
pub(crate) struct ShadowGridCache(Memo<Inputs, Option<Arc<Shadow>>>);

impl Default for ShadowGridCache {
    fn default() -> Self {
        Self(Memo::with_capacity(CACHE_CAPACITY))
    }
}

impl ShadowGridCache {
    /// The shadow of rings on a body; `None` if they take no visible part of the light. `intervals`: the rings. `limb_darkening`: the Sun's.
    pub(crate) fn shadow_on(
        &self,
        lit: &LitGlobe,
        rings: &RingsBeforeSun<'_>,
        intervals: &Arc<Vec<RingInterval>>,
        limb_darkening: (DVec3, DVec3),
    ) -> Option<ShadowOnBody> {
        let owner_unit_km = rings.owner.radii_km.x;
        let globe = rings.owner.radii_km / owner_unit_km;
        let (half_side, disc_radius) = (lit.extent_km / owner_unit_km, lit.disc_radius_km / owner_unit_km);
        let turn = turn(rings.beam.sun - rings.beam.body, globe);
        let beam = Beam { body: turn * rings.beam.body, sun: turn * rings.beam.sun, ..rings.beam };
        let outer_radius = beam.outer_radius(intervals)?;
        let spacing = 2.0 * half_side / (places_along_side(&beam, intervals, half_side) - 1) as f64;
        let beam = rounded_beam(beam, spacing, beam.body.length() + outer_radius)?;
        let lighting = Lighting { beam, globe, limb_darkening, half_side, disc_radius };
        let is_same = |cached: &Inputs, requested: &Inputs| Arc::ptr_eq(&cached.0, &requested.0) && cached.1 == requested.1;
        let compute = || Shadow::of(intervals, lighting).map(Arc::new);
        let shadow = self.0.get_compatible(is_same, (Arc::clone(intervals), lighting), compute)?;
        // From the turned axes and the radii of the owner to those of the body, and from lengths to places.
        let body_from_turned = lit.body_from_icrf * (turn * rings.owner_from_icrf).transpose();
        let last = f64::from(shadow.grid.side - 1);
        let places_per_length = last / (2.0 * half_side) * (lit.unit_km / owner_unit_km);
        let middle = narrow_scalar(0.5 * last);
        let axes = shadow.axes.map(|axis| narrow(body_from_turned * axis * places_per_length).extend(middle));
        Some(ShadowOnBody { grid: Arc::clone(&shadow.grid), axes, range: shadow.range })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::{Body, Catalog, NaifId};
    use crate::random::Random;
    use crate::scene::rings::ring_table::RingTables;
    use std::f64::consts::TAU;

    const LIMB_DARKENING: (DVec3, DVec3) = (DVec3::new(0.37, 0.47, 0.61), DVec3::new(0.24, 0.23, 0.21));
    /// Of Rhea, from Saturn's centre, and its radius.
    const DISTANCE_KM: f64 = 527_068.0;
    const RADIUS_KM: f64 = 764.0;

    /// Saturn's rings before the Sun of Rhea, in the axes of the ICRF. `elevation_deg`: the Sun's. `crossing_km`: radius at which the middle of the sunlight
    /// crosses the rings' plane.
    fn rings_before_rhea(saturn: &Body, elevation_deg: f64, crossing_km: f64, azimuth_rad: f64) -> RingsBeforeSun<'_> {
        let unit_km = saturn.radii_km.x;
        let (sin, cos) = elevation_deg.to_radians().sin_cos();
        let sunward = DVec3::new(cos, 0.0, sin);
        // Beside the globe.
        let crossing = DVec3::new(-0.5, 0.75_f64.sqrt(), 0.0) * (crossing_km / unit_km);
        let (along, distance) = (crossing.dot(sunward), DISTANCE_KM / unit_km);
        let body = crossing - sunward * (along + (along * along - crossing.length_squared() + distance * distance).sqrt());
        let turn = DMat3::from_rotation_z(azimuth_rad);
        let (body, sunward) = (turn * body, turn * sunward);
        let beam = Beam {
            body,
            body_radius: RADIUS_KM / unit_km,
            sun: body + sunward * (9.5 * 149_597_870.7 / unit_km),
            sun_radius: 695_700.0 / unit_km,
        };
        RingsBeforeSun { owner: saturn, fraction: DVec3::ONE, beam, owner_from_icrf: DMat3::IDENTITY }
    }

    fn moved(rings: RingsBeforeSun<'_>, offset: DVec3) -> RingsBeforeSun<'_> {
        let beam = Beam { body: rings.beam.body + offset, sun: rings.beam.sun + offset, ..rings.beam };
        RingsBeforeSun { beam, ..rings }
    }

    fn rhea() -> LitGlobe {
        LitGlobe { body_from_icrf: DMat3::IDENTITY, unit_km: RADIUS_KM, disc_radius_km: RADIUS_KM, extent_km: RADIUS_KM }
    }

    /// Largest difference of two grids of the same side.
    fn difference(a: &[f32], b: &[f32]) -> f32 {
        assert_eq!(a.len(), b.len());
        a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
    }

    /// The grid of rounded places against the grid of the places themselves, under a Sun from 0.001 to 25 degrees above the rings' plane. Negative control: the
    /// moon moved by a spacing.
    #[test]
    fn rounding_changes_the_light_by_less_than_its_stated_error() {
        let catalog = Catalog::embedded();
        let saturn = catalog.body(NaifId(699)).expect("in the catalog");
        let intervals = RingTables::default().intervals(saturn.rings.iter(), saturn.radii_km.x);
        let cache = ShadowGridCache::default();
        let mut random = Random::new(11);
        let (mut largest, mut of_control) = (0.0_f32, 0.0_f32);
        for _ in 0..12 {
            let (elevation_deg, crossing_km) = (10.0_f64.powf(random.between(-3.0, 1.4)), random.between(80_000.0, 138_000.0));
            let rings = rings_before_rhea(saturn, elevation_deg, crossing_km, random.between(0.0, TAU));
            let exact = |rings: &RingsBeforeSun<'_>| {
                let globe = saturn.radii_km / saturn.radii_km.x;
                let half_side = RADIUS_KM / saturn.radii_km.x;
                let lighting = Lighting { beam: rings.beam, globe, limb_darkening: LIMB_DARKENING, half_side, disc_radius: half_side };
                Shadow::of(&intervals, lighting).expect("a shadow")
            };
            let expected = exact(&rings);
            let found = cache.shadow_on(&rhea(), &rings, &intervals, LIMB_DARKENING).expect("a shadow");
            let side = found.grid.side;
            assert_eq!(side, expected.grid.side);
            largest = largest.max(difference(&found.grid.texels, &expected.grid.texels));
            // The axes are those of the grid that is not rounded.
            let places_per_radius = 0.5 * f64::from(side - 1);
            for (axis, expected) in found.axes.iter().zip(expected.axes) {
                assert!((axis.truncate().as_dvec3() / places_per_radius - expected).length() < 1e-6, "{axis}, {expected}");
                assert_eq!(f64::from(axis.w), places_per_radius);
            }
            let spacing = RADIUS_KM / saturn.radii_km.x / places_per_radius;
            let control = exact(&moved(rings, expected.axes[1] * spacing));
            if control.grid.side == side {
                of_control = of_control.max(difference(&control.grid.texels, &expected.grid.texels));
            }
        }
        println!("{largest:.5}, of the control {of_control:.3}");
        assert!(largest < 0.004, "{largest}");
        assert!(of_control > 0.03, "{of_control}");
    }

    /// A grid serves while the moon moves by a small part of a place, and while the rings' owner rotates; not after a larger move.
    #[test]
    fn a_grid_is_kept_while_its_shadow_stays() {
        const MOVES: u32 = 40;
        let catalog = Catalog::embedded();
        let saturn = catalog.body(NaifId(699)).expect("in the catalog");
        let intervals = RingTables::default().intervals(saturn.rings.iter(), saturn.radii_km.x);
        let cache = ShadowGridCache::default();
        let rings = rings_before_rhea(saturn, 0.1, 110_000.0, 1.0);
        let shadow_of = |rings: &RingsBeforeSun<'_>| cache.shadow_on(&rhea(), rings, &intervals, LIMB_DARKENING).expect("a shadow");
        let first = shadow_of(&rings);
        assert!(first.varies_by_more_than(0.1), "{:?}", first.range);
        assert!(Arc::ptr_eq(&first.grid, &shadow_of(&rings).grid), "of the same inputs");
        // Along the grid's rows only one component changes, so each step of the rounding, at least 1/64 of the spacing, begins a new grid.
        let spacing = 2.0 / f64::from(first.grid.side - 1) * (RADIUS_KM / saturn.radii_km.x);
        let along_rows = first.axes[0].truncate().as_dvec3().normalize();
        let move_by = |part: f64| moved(rings, along_rows * (part * spacing));
        let mut grids = vec![Arc::clone(&first.grid)];
        for k in 1..=MOVES {
            let grid = shadow_of(&move_by(0.08 * f64::from(k) / f64::from(MOVES))).grid;
            if grids.last().is_some_and(|last| !Arc::ptr_eq(last, &grid)) {
                grids.push(grid);
            }
        }
        assert!((2..=8).contains(&grids.len()), "{} grids in {MOVES} moves", grids.len());
        // The owner rotated: the same vectors in its new axes.
        let rotation = DMat3::from_rotation_z(0.7);
        let beam = Beam { body: rotation * rings.beam.body, sun: rotation * rings.beam.sun, ..rings.beam };
        let rotated = shadow_of(&RingsBeforeSun { beam, owner_from_icrf: rotation, ..rings });
        assert_eq!(rotated.grid.texels, first.grid.texels, "the owner's rotation counts");
        for (axis, expected) in rotated.axes.iter().zip(first.axes) {
            assert!((*axis - expected).length() < 1e-3, "{axis}, {expected}");
        }
    }
}
