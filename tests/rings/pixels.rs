//! Light of rings in single pixels: it does not depend on which faint rings are drawn, and equals the mean of smaller pixels in the same
//! place; narrow rings are smooth lines. Also tested: when the globe's shadow on the rings is left out, refracted limbs that show no Sun, and
//! the rectangles around the two halves of the rings.

use crate::support::folds::larger;
use crate::support::session::SESSION;
use crate::support::sweep;
use glam::DVec3;
use orrery::FrameImages;
use orrery::catalog::{Catalog, NaifId};
use orrery::render::plan::SamplingQuality;
use orrery::scene::draw::BodyPart;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{Axes, ExposureRequest, Layers, Position, Purpose, ViewRequest};
use orrery::session::DrawnFrame;
use orrery::time::Instant;
use orrery::units::GOLDEN_ANGLE_RAD;

const EARTH: NaifId = NaifId::EARTH;
const TITAN: NaifId = NaifId(606);
const SATURN: NaifId = NaifId(699);
const URANUS: NaifId = NaifId(799);
const SINGLE_SAMPLE: SamplingQuality = SamplingQuality { samples: 1, anisotropy: 8 };
const SIDE: u32 = 32;

/// A small view of a body. The many-digit arguments below come from views that the random sweeps `orrery stability --sweep needs-display`
/// and `needs-linear` found.
fn view(body: NaifId, time: &str, distance_radii: f64, direction: [f64; 3], fov_deg: f64) -> ViewRequest {
    let catalog = Catalog::embedded();
    let radius_km = catalog.body(body).expect("a body").radii_km.max_element();
    ViewRequest {
        position: Position::Offset { body, offset_km: DVec3::from_array(direction) * distance_radii * radius_km, axes: Axes::Icrf },
        fov_deg: Some(fov_deg),
        width: SIDE,
        height: SIDE,
        layers: Layers { stars: false, ..Layers::default() },
        ..ViewRequest::of(body, Instant::parse(time).expect("a time"))
    }
}

/// The request at the exposure that the scene meters, with the given effects.
fn with_effects(request: &ViewRequest, effects: &str) -> ViewRequest {
    let stops = SESSION.scene(request).expect("a scene").exposure.stops;
    ViewRequest { exposure: ExposureRequest::Stops(stops), effects: EffectOverrides::parse(effects).expect("effects"), ..request.clone() }
}

fn greatest_difference_levels(a: &[[u8; 4]], b: &[[u8; 4]]) -> u8 {
    a.iter().zip(b).flat_map(|(a, b)| (0..3).map(move |c| a[c].abs_diff(b[c]))).max().unwrap_or(0)
}

fn saturn_views() -> [ViewRequest; 4] {
    [
        view(SATURN, "2037-09-25T05:55:00.345Z", 485.608, [0.633_916, -0.772_559, -0.036_087], 0.394_131),
        view(SATURN, "1964-08-12T13:48:27.695Z", 40.254_2, [-0.954_000, -0.063_082_6, 0.293_093], 9.135_09),
        view(SATURN, "1982-05-07T12:28:12.562Z", 2826.76, [-0.025_513_4, 0.979_060, 0.201_969], 0.074_010_9),
        // In this view the outer rings are ringlets narrower than a pixel, visible only together.
        view(SATURN, "2084-12-12T23:15:55.080Z", 2661.186, [0.965_302, 0.206_375, 0.160_007], 0.338_982),
    ]
}

/// Faint outer rings neither change the light of the dense rings nor disappear.
#[test]
fn a_pixel_looks_the_same_whichever_faint_rings_are_drawn() {
    let drawn = |request: &ViewRequest| SESSION.draw(request, SINGLE_SAMPLE, FrameImages::DisplayAndHdr).expect("drawn");
    let mut with_the_same_shadow = 0;
    for (k, request) in saturn_views().iter().enumerate() {
        let [automatic, all, none] = ["", "+rings", "-rings"].map(|effects| drawn(&with_effects(request, effects)));
        assert!(greatest_difference_levels(&automatic.frame.display, &none.frame.display) > 1, "view {k}: no rings are visible");
        let [automatic_unshadowed, all_unshadowed] =
            ["-body-shadow", "+rings,-body-shadow"].map(|effects| drawn(&with_effects(request, effects)));
        let difference_levels = greatest_difference_levels(&automatic_unshadowed.frame.display, &all_unshadowed.frame.display);
        assert!(difference_levels <= 1, "view {k} without the globe's shadow: {difference_levels} levels");
        // A drawn outer ring may require the better model of the globe's shadow. The models differ by the stated error of the simpler one.
        let shadow =
            |drawn: &DrawnFrame| drawn.scene.draws.iter().find(|d| d.part == BodyPart::RingInFront).map(|d| d.features.body_shadow);
        if shadow(&automatic) == shadow(&all) {
            let difference_levels = greatest_difference_levels(&automatic.frame.display, &all.frame.display);
            assert!(difference_levels <= 1, "view {k}: {difference_levels} levels");
            with_the_same_shadow += 1;
        }
    }
    assert!(with_the_same_shadow >= 1, "no view has the same model of the shadow in both frames");
}

/// From 2.4 radii, at 5 degrees per pixel, the pixels on the horizon of the ring plane show nothing nearer than a dozen radii. A ring
/// patch that extended from the pixel's middle as far towards the camera as away from it would include the dense rings, and add 38 levels
/// of light.
#[test]
fn a_pixel_on_the_horizon_of_the_plane_shows_no_nearer_rings() {
    let request = view(SATURN, "1901-07-06T17:29:57.323Z", 2.419_582_467, [-0.417_697_209, 0.392_843_927, 0.819_269_608], 150.0);
    let [automatic, all] = ["", "+rings"].map(|effects| {
        SESSION.draw(&with_effects(&request, effects), SINGLE_SAMPLE, FrameImages::DisplayAndHdr).expect("drawn").frame.display
    });
    let difference_levels = greatest_difference_levels(&automatic, &all);
    assert!(difference_levels <= 1, "{difference_levels} levels");
    assert!(automatic.iter().any(|p| p[0] > 100), "the dense rings and the globe are not in the image");
}

/// Compares the green light of each pixel with the mean of 64 pixels in its place. Measured difference, relative to the brightest pixel: at
/// most 0.16, in the mean 2e-3. In the three views a pixel covers 0.1 to 0.2 of the planet's radius across the line of sight, and 0.4 to 2.7
/// radii along it on the ring plane. Negative control: one of the 64 pixels in place of their mean.
#[test]
fn a_ring_pixel_has_the_light_of_the_smaller_pixels_in_its_place() {
    const FINER: u32 = 8;
    for (k, request) in saturn_views()[..3].iter().enumerate() {
        let request = with_effects(request, "+rings,+body-shadow");
        let drawn = |scale: u32| {
            let request = ViewRequest { width: SIDE * scale, height: SIDE * scale, ..request.clone() };
            SESSION.draw(&request, SINGLE_SAMPLE, FrameImages::DisplayAndHdr).expect("drawn").frame.hdr
        };
        let (coarse, fine) = (drawn(1), drawn(FINER));
        // The light of small pixel `n` of the 64 in the place of pixel `pixel`.
        let fine_light = |pixel: u32, n: u32| {
            let (x, y) = (pixel % SIDE * FINER + n % FINER, pixel / SIDE * FINER + n / FINER);
            f64::from(fine[(y * SIDE * FINER + x) as usize][1])
        };
        let mean_light = |pixel: u32| (0..FINER * FINER).map(|n| fine_light(pixel, n)).sum::<f64>() / f64::from(FINER * FINER);
        let reference: Vec<f64> = (0..SIDE * SIDE).map(mean_light).collect();
        let brightest = reference.iter().copied().fold(0.0, larger);
        let mean_and_worst_difference = |light: &[f64]| {
            let differences = light.iter().zip(&reference).map(|(light, expected)| (light - expected).abs() / brightest);
            let (sum, worst) = differences.fold((0.0, 0.0_f64), |(sum, worst), difference| (sum + difference, larger(worst, difference)));
            (sum / f64::from(SIDE * SIDE), worst)
        };
        let (mean, worst) = mean_and_worst_difference(&coarse.iter().map(|p| f64::from(p[1])).collect::<Vec<_>>());
        let near_middle: Vec<f64> = (0..SIDE * SIDE).map(|pixel| fine_light(pixel, FINER * FINER / 2 + FINER / 2)).collect();
        let (mean_of_single, worst_of_single) = mean_and_worst_difference(&near_middle);
        println!("view {k}: mean {mean:.2e}, worst {worst:.3}; of single small pixels {mean_of_single:.2e}, {worst_of_single:.3}");
        assert!(mean < 4e-3 && worst < 0.2, "view {k}: {mean} in the mean, {worst} at worst, of the brightest pixel");
        assert!(
            mean_of_single > 5e-3 && worst_of_single > 0.25,
            "view {k}: single small pixels would pass: {mean_of_single}, {worst_of_single}"
        );
    }
}

/// Seen from above the pole, Uranus's epsilon ring is a fifth of a pixel wide. In each column of pixels the mean row of its light is at most a quarter of a
/// pixel from the ring: each pixel takes the light of two spans of radius, which overlap those of its neighbours. Negative control: with one span, as in draft
/// quality, the light jumps from row to row.
#[test]
fn a_narrow_ring_is_a_smooth_line() {
    const SIDE: u32 = 240;
    const COLUMNS: std::ops::Range<u32> = 90..150;
    let catalog = Catalog::embedded();
    let body = catalog.body(URANUS).expect("Uranus");
    let ring = body.rings.iter().find(|r| r.name == "Epsilon").expect("the epsilon ring");
    let (ring_km, height_km) = (0.5 * (ring.inner_km + ring.outer_km), 1e6);
    let half_frame_km = 1.1 * ring_km;
    let request = ViewRequest {
        position: Position::Offset { body: URANUS, offset_km: DVec3::Z * height_km, axes: Axes::BodyFixed },
        fov_deg: Some(2.0 * (half_frame_km / height_km).atan().to_degrees()),
        width: SIDE,
        height: SIDE,
        layers: Layers::NONE,
        exposure: ExposureRequest::Stops(10.0),
        effects: EffectOverrides::parse("+rings").expect("effects"),
        ..ViewRequest::of(URANUS, Instant::parse("2028-04-01T00:00:00Z").expect("a time"))
    };
    let km_per_px = 2.0 * half_frame_km / f64::from(SIDE);
    assert!((0.1..0.3).contains(&((ring.outer_km - ring.inner_km) / km_per_px)), "the ring's width in pixels");
    let greatest_offset_px = |anisotropy: u8| {
        let sampling = SamplingQuality { anisotropy, ..SINGLE_SAMPLE };
        let light = SESSION.draw(&request, sampling, FrameImages::DisplayAndHdr).expect("drawn").frame.hdr;
        let offset_px = |column: u32| {
            let x_km = (f64::from(column) + 0.5 - 0.5 * f64::from(SIDE)) * km_per_px;
            let row = 0.5 * f64::from(SIDE) - (ring_km * ring_km - x_km * x_km).sqrt() / km_per_px - 0.5;
            let (mut sum, mut moment) = (0.0, 0.0);
            for near in (row - 2.0).round() as u32..=(row + 2.0).round() as u32 {
                let green = f64::from(light[(near * SIDE + column) as usize][1]);
                sum += green;
                moment += green * (f64::from(near) - row);
            }
            assert!(sum > 0.0, "the ring is not in column {column}");
            (moment / sum).abs()
        };
        COLUMNS.map(offset_px).fold(0.0, larger)
    };
    let (two_spans, one_span) = (greatest_offset_px(8), greatest_offset_px(1));
    println!("greatest distance from the ring: {two_spans:.2} pixels, with one span {one_span:.2}");
    assert!(two_spans < 0.25 && one_span > 0.42, "{two_spans} and {one_span} pixels");
}

/// Whether any ray from a point of the ring plane to the Sun's disc, edge included, meets an ellipsoid of equatorial radius 1. `sun`: the
/// Sun's direction. `sun_tangent`: the tangent of the Sun's angular radius.
fn meets_globe(point: DVec3, sun: DVec3, sun_tangent: f64, polar_radius: f64) -> bool {
    let semi_axes = DVec3::new(1.0, 1.0, polar_radius);
    let (x, y) = sun.any_orthonormal_pair();
    // Half of the rays go to the edge, the others to a spiral over the disc.
    (0..4096).any(|k| {
        let (sin, cos) = (f64::from(k) * GOLDEN_ANGLE_RAD).sin_cos();
        let distance_on_disc = if k % 2 == 0 { 1.0 } else { (f64::from(k) / 4096.0).sqrt() };
        let (p, d) = (point / semi_axes, (sun + sun_tangent * distance_on_disc * (cos * x + sin * y)) / semi_axes);
        p.dot(d) < 0.0 && p.cross(d).length_squared() <= d.length_squared()
    })
}

/// The globe's shadow on the rings is left out if r sin(h) > 1 + r tan(s), where r is the radius of the innermost ring in equatorial radii,
/// h the Sun's altitude above the ring plane, and s the Sun's angular radius. At this bound no ray from a ring of radius r or more to the
/// Sun meets the globe, round or oblate; halfway into the penumbra some ray does.
#[test]
fn no_ray_meets_the_globe_where_its_shadow_is_left_out() {
    let mut cases = 0;
    for sun_tangent in [2.4e-4, 5e-4, 5e-3] {
        for inner in [1.1_f64, 1.5, 2.3] {
            cases += 1;
            if !sweep::runs(cases, 3) {
                continue;
            }
            let some_ray_meets = |penumbra_fraction: f64, polar_radius: f64, radius: f64| {
                let sine = (1.0 + penumbra_fraction * inner * sun_tangent) / inner;
                let sun = DVec3::new((1.0 - sine * sine).sqrt(), 0.0, sine);
                (0..720).any(|k| {
                    let (sin, cos) = (f64::from(k) * std::f64::consts::TAU / 720.0).sin_cos();
                    meets_globe(DVec3::new(radius * cos, radius * sin, 0.0), sun, sun_tangent, polar_radius)
                })
            };
            for polar_radius in [1.0, 0.977, 0.902] {
                for radius in [inner, 1.2 * inner, 4.0 * inner] {
                    assert!(
                        !some_ray_meets(1.0, polar_radius, radius),
                        "tangent {sun_tangent}, inner {inner}, polar radius {polar_radius}, radius {radius}"
                    );
                }
            }
            // The sine of the altitude of the Sun's lower edge is smaller by `sun_tangent` times this cosine. At half of
            // that the ring is in the penumbra.
            let cosine = (1.0 - inner.powi(-2)).sqrt();
            assert!(
                some_ray_meets(0.5 * cosine, 1.0, inner),
                "a bound without the penumbra would pass: tangent {sun_tangent}, inner {inner}"
            );
        }
    }
}

/// On a day when only the penumbra of Uranus reaches its innermost ring, the shadow is drawn. A few days later not even the penumbra
/// reaches it, and a frame with the shadow equals the frame without.
#[test]
fn the_penumbra_of_the_globe_is_drawn() {
    let catalog = Catalog::embedded();
    let uranus = catalog.body(URANUS).expect("Uranus");
    let inner_radii =
        uranus.rings.iter().filter(|r| r.tau_normal > 0.0).map(|r| r.inner_km).fold(f64::INFINITY, f64::min) / uranus.radii_km.x;
    let request_at = |jd: f64| ViewRequest {
        purpose: Purpose::LINEAR,
        width: SIDE,
        height: SIDE,
        position: Position::AboveTarget { towards: None, distance_radii: Some(20.0) },
        fov_deg: Some(14.0),
        layers: Layers { stars: false, ..Layers::default() },
        ..ViewRequest::of(URANUS, Instant::from_jd_tdb(jd))
    };
    // Distance of the shadow's axis from the innermost ring, where it is least.
    let axis_distance_radii = |jd: f64| {
        let scene = SESSION.scene(&request_at(jd)).expect("a scene");
        inner_radii * scene.body(URANUS).and_then(|b| b.sub_solar).expect("a Sun").lat_centric_deg.to_radians().sin().abs()
    };
    // Between the equinox of 2007 and the solstice of 2030 the Sun's latitude only increases.
    let jd_with_axis_distance = |distance_radii: f64| {
        let (mut from, mut to) = (2_455_000.0, 2_462_000.0);
        for _ in 0..40 {
            let middle = 0.5 * (from + to);
            if axis_distance_radii(middle) < distance_radii { from = middle } else { to = middle }
        }
        to
    };
    let shadow_decision = |jd: f64| {
        let scene = SESSION.scene(&request_at(jd)).expect("a scene");
        let body = scene.bodies.iter().find(|b| b.id == URANUS).expect("Uranus");
        body.decisions.iter().find(|d| d.effect == "body-shadow").map(|d| d.on)
    };
    // The tangent of the Sun's angular radius at Uranus is 2.4e-4: between the two values below.
    assert_eq!(shadow_decision(jd_with_axis_distance(1.0 + 1e-4 * inner_radii)), Some(true));
    let beyond_penumbra = jd_with_axis_distance(1.0 + 4e-4 * inner_radii);
    assert_eq!(shadow_decision(beyond_penumbra), Some(false));
    let drawn = |effects: &str| {
        SESSION
            .draw(&with_effects(&request_at(beyond_penumbra), effects), SINGLE_SAMPLE, FrameImages::DisplayAndHdr)
            .expect("drawn")
            .frame
            .hdr
    };
    assert!(drawn("") == drawn("+body-shadow"), "a shadow was drawn");
    assert!(drawn("") != drawn("-rings"), "no ring is visible");
}

/// Where the Sun is next to a body's air but not refracted by it, switching the refracted limb on changes nothing: a pixel that the limb
/// crosses keeps its sunlight.
#[test]
fn a_refracted_limb_that_shows_no_sun_changes_nothing() {
    for (body, time, distance_radii, direction, fov_deg) in [LIMB_OF_TITAN, LIMB_OF_THE_EARTH] {
        let request = ViewRequest { purpose: Purpose::LINEAR, ..view(body, time, distance_radii, direction, fov_deg) };
        let drawn =
            |effects: &str| SESSION.draw(&with_effects(&request, effects), SINGLE_SAMPLE, FrameImages::DisplayAndHdr).expect("drawn");
        let (automatic, requested) = (drawn(""), drawn("+refracted-limb"));
        assert!(automatic.frame.hdr == requested.frame.hdr && requested.scene.refracted_limbs.is_empty(), "{time}");
    }
    // The Moon in the Earth's umbra, 2022-11-08: here the refracted limb shows the Sun.
    let eclipsed = ViewRequest {
        position: Position::Centre(NaifId::MOON),
        fov_deg: Some(2.4),
        width: SIDE,
        height: SIDE,
        ..ViewRequest::of(EARTH, Instant::from_jd_tdb(2_459_891.959))
    };
    assert_eq!(SESSION.scene(&eclipsed).expect("a scene").refracted_limbs.len(), 1);
}

/// The arguments of [`view`].
type ViewParameters = (NaifId, &'static str, f64, [f64; 3], f64);
const LIMB_OF_TITAN: ViewParameters =
    (TITAN, "1907-03-03T21:00:04.984Z", 1.35582057813112, [0.6310031291403511, -0.7307680924764921, -0.2604093816154758], 150.0);
const LIMB_OF_THE_EARTH: ViewParameters = (
    EARTH,
    "2036-03-19T23:35:25.733Z",
    2.440509283969137,
    [-0.94840914608703, 0.3142874916884562, -0.041754810341436244],
    144.19445295133494,
);

/// The rectangle of each half of the rings contains that half. Less than a third of the points are in both rectangles, so each is smaller
/// than a rectangle around all rings.
#[test]
fn each_half_of_the_rings_lies_in_its_own_rectangle() {
    let (mut tested, mut in_both) = (0, 0);
    let directions = [[0.7, -0.6, 0.3], [0.1, 0.98, -0.15], [-0.9, 0.3, 0.9]];
    for (direction, distance_radii) in directions.into_iter().zip([5.0, 3.0, 40.0]) {
        // The frame contains the rings, except those nearest to a camera at 3 radii. In so large a frame the padding of the rectangles is narrow.
        let fov_deg = 2.0 * f64::atan(2.8 / distance_radii).to_degrees();
        let request = view(SATURN, "2017-05-17T00:00:00Z", distance_radii, direction, fov_deg);
        let scene = SESSION.scene(&ViewRequest { width: 2000, height: 2000, ..request }).expect("a scene");
        let placement = &scene.body(SATURN).expect("Saturn").placement;
        let viewer = placement.body_from_icrf * -placement.centre_km;
        let rect = |part: BodyPart| {
            let draw = scene.draws.iter().find(|d| d.body == SATURN && d.part == part).expect("a half of the rings");
            draw.uniforms.rect_in_clip
        };
        let [behind, front] = [BodyPart::RingBehind, BodyPart::RingInFront].map(rect);
        for k in 0..4000 {
            // Points in a spiral, at steps of the golden angle, from the C ring to beyond the A ring.
            let (angle, radius_km) = (f64::from(k) * GOLDEN_ANGLE_RAD, 75_000.0 + 16.0 * f64::from(k));
            let ring_point = DVec3::new(angle.cos(), angle.sin(), 0.0) * radius_km;
            let direction = placement.centre_km + placement.body_from_icrf.transpose() * ring_point;
            let Some(clip) = scene.camera.clip(direction).filter(|c| c.abs().max_element() < 1.0) else { continue };
            let is_in = |rect: glam::Vec4| {
                let [x, y] = [(rect.x, rect.z), (rect.y, rect.w)].map(|(a, b)| f64::from(a.min(b))..=f64::from(a.max(b)));
                x.contains(&clip.x) && y.contains(&clip.y)
            };
            let is_front = ring_point.dot(ring_point - viewer) < 0.0;
            let (own, other) = if is_front { (front, behind) } else { (behind, front) };
            assert!(is_in(own), "{clip} in front of the globe: {is_front}, from {distance_radii} radii");
            tested += 1;
            in_both += i32::from(is_in(other));
        }
    }
    assert!(tested > 11_000, "{tested} of 12000 points are in the frame");
    assert!(3 * in_both < tested, "{in_both} of {tested} points are in both rectangles: these are no smaller than one around all rings");
}
