//! Images laid over the ground: where they lie, what they leave unchanged, and the messages for faulty images.

use crate::support::session::session_over;
use glam::{DVec2, DVec3};
use orrery::FrameImages;
use orrery::catalog::{Catalog, NaifId};
use orrery::render::plan::SamplingQuality;
use orrery::scene::Scene;
use orrery::scene::draw::PixelView;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::{Axes, ExposureRequest, Position, ViewRequest};
use orrery::session::Session;
use orrery::time::Instant;
use std::sync::{Arc, Mutex};

const SIDE: u32 = 128;
const MOON: NaifId = NaifId::MOON;
const SATURN: NaifId = NaifId(699);
const AMALTHEA: NaifId = NaifId(505);

/// A folder with a catalog file and one-coloured images (name, RGBA), and a session that uses them.
struct UserOverlays {
    session: Session,
    messages: Arc<Mutex<Vec<String>>>,
    folder: tempfile::TempDir,
}

impl UserOverlays {
    fn new(catalog: &str, images: &[(&str, [u8; 4])]) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::write(folder.path().join("mine.toml"), catalog).expect("written");
        for (name, colour) in images {
            let file = std::fs::File::create(folder.path().join(name)).expect("a file");
            let mut encoder = png::Encoder::new(file, 16, 8);
            encoder.set_color(png::ColorType::Rgba);
            encoder.write_header().and_then(|mut w| w.write_image_data(&colour.repeat(16 * 8))).expect("written");
        }
        let (session, messages) = session_over(folder.path());
        Self { session, messages, folder }
    }

    /// A view from 3 radii above 0 N 0 E.
    fn draw(&self, body: NaifId, effects: &str, pixel_view: PixelView) -> (Scene, Vec<[f32; 4]>) {
        self.draw_square(body, effects, pixel_view, SIDE)
    }

    /// The same with another size, pixels.
    fn draw_square(&self, body: NaifId, effects: &str, pixel_view: PixelView, side: u32) -> (Scene, Vec<[f32; 4]>) {
        let radius_km = self.session.catalog().body(body).expect("a body").radii_km.x;
        let request = ViewRequest {
            position: Position::Offset { body, offset_km: DVec3::new(3.0 * radius_km, 0.0, 0.0), axes: Axes::BodyFixed },
            width: side,
            height: side,
            pixel_view,
            exposure: ExposureRequest::Stops(0.0),
            effects: EffectOverrides::parse(&format!("-rings,-ring-shadow,-ring-shine,-atmosphere,-eclipse,-planet-shine,{effects}"))
                .expect("effects"),
            ..ViewRequest::of(body, Instant::parse("2024-04-23T23:49:00Z").expect("a time"))
        };
        let drawn = self.session.draw(&request, SamplingQuality { samples: 1, anisotropy: 4 }, FrameImages::DisplayAndHdr).expect("drawn");
        (drawn.scene, drawn.frame.hdr)
    }
}

fn changed_pixels(a: &[[f32; 4]], b: &[[f32; 4]]) -> Vec<bool> {
    a.iter().zip(b).map(|(a, b)| a.map(f32::to_bits) != b.map(f32::to_bits)).collect()
}

/// The ground point under the centre of each pixel, kilometres, body axes.
fn ground_points(scene: &Scene, body: NaifId) -> Vec<Option<DVec3>> {
    ground_points_of_square(scene, body, SIDE)
}

/// The same for an image with another size, pixels.
fn ground_points_of_square(scene: &Scene, body: NaifId, side: u32) -> Vec<Option<DVec3>> {
    let placement = &scene.body(body).expect("a body").placement;
    let middle = |k: u32| DVec2::new(f64::from(k % side) + 0.5, f64::from(k / side) + 0.5);
    (0..side * side).map(|k| Some(scene.camera.surface_under_pixel(placement, middle(k))? * placement.radii_km)).collect()
}

/// Planetographic latitude and east longitude, degrees.
fn planetographic(ground_km: DVec3, radii_km: DVec3) -> [f64; 2] {
    let normal = ground_km / (radii_km * radii_km);
    [normal.z.atan2(normal.truncate().length()).to_degrees(), ground_km.y.atan2(ground_km.x).to_degrees()]
}

const REGION: &str = "projection = \"equirectangular\"\nwest_deg = -20.0\neast_deg = 25.0\nsouth_deg = 30.0\nnorth_deg = 50.0\n";

fn overlay_toml(body: &str, name: &str, file: &str, region: &str) -> String {
    format!("[[overlay]]\nbody = \"{body}\"\nname = \"{name}\"\nfile = \"{file}\"\n{region}\n")
}

#[test]
fn an_image_of_zero_alpha_changes_no_bit() {
    for (alpha, changes) in [(0, false), (128, true)] {
        let user_overlays = UserOverlays::new(&overlay_toml("Moon", "a", "a.png", REGION), &[("a.png", [255, 40, 90, alpha])]);
        for view in [PixelView::Final, PixelView::Albedo] {
            let (scene, with) = user_overlays.draw(MOON, "", view);
            assert_eq!(scene.draws[0].features.overlays, 1);
            let (scene, without) = user_overlays.draw(MOON, "-overlays", view);
            assert_eq!(scene.draws[0].features.overlays, 0);
            let count = changed_pixels(&with, &without).iter().filter(|c| **c).count();
            assert!(if changes { count > 100 } else { count == 0 }, "{view:?}, alpha {alpha}: {count} pixels");
        }
    }
}

/// On the oblate Saturn, planetographic latitudes of 30 and 50 degrees are planetocentric latitudes of 25.2 and 44.1.
#[test]
fn an_overlay_changes_only_its_region() {
    let user_overlays = UserOverlays::new(&overlay_toml("Saturn", "band", "red.png", REGION), &[("red.png", [255, 40, 90, 255])]);
    let (scene, with) = user_overlays.draw(SATURN, "", PixelView::Final);
    let (_, without) = user_overlays.draw(SATURN, "-overlays", PixelView::Final);
    let (_, albedo) = user_overlays.draw(SATURN, "", PixelView::Albedo);
    let radii_km = scene.body(SATURN).expect("Saturn").placement.radii_km;
    let (mut inside, mut outside) = (0, 0);
    for (k, ground) in ground_points(&scene, SATURN).into_iter().enumerate() {
        let Some([lat, lon]) = ground.map(|g| planetographic(g, radii_km)) else { continue };
        // Distance from the region in degrees, positive outside. A pixel spans half a degree here, and more towards the limb.
        let outside_deg = (30.0 - lat).max(lat - 50.0).max(-20.0 - lon).max(lon - 25.0);
        let differs = with[k].map(f32::to_bits) != without[k].map(f32::to_bits);
        if outside_deg > 2.5 {
            assert!(!differs, "{lat} N {lon} E is changed");
            outside += 1;
        } else if outside_deg < -2.5 {
            // An opaque overlay shows its own colour in linear light, as a map would: sRGB 40 and 90 are 0.021 and 0.102.
            let red = albedo[k][0];
            let (green, blue) = (albedo[k][1] / red, albedo[k][2] / red);
            assert!((green - 0.021_22).abs() < 1e-4 && (blue - 0.102_24).abs() < 1e-4, "{green} {blue}");
            // The albedo of a Lambert sphere is 3/2 of its geometric albedo.
            assert!((red - 1.5).abs() < 1e-3, "{red}");
            inside += 1;
        }
    }
    assert!(inside > 100 && outside > 3000, "{inside} {outside}");
}

/// On a body with three different axes the region is bounded by planetographic latitudes and planetocentric longitudes. The latitude of a spheroid, once
/// used, would put its edges elsewhere.
#[test]
fn an_overlay_on_a_triaxial_body_changes_only_its_region() {
    let side = 512;
    let user_overlays = UserOverlays::new(&overlay_toml("Amalthea", "band", "red.png", REGION), &[("red.png", [255, 40, 90, 255])]);
    let (scene, with) = user_overlays.draw_square(AMALTHEA, "", PixelView::Albedo, side);
    let (_, without) = user_overlays.draw_square(AMALTHEA, "-overlays", PixelView::Albedo, side);
    let radii_km = scene.body(AMALTHEA).expect("Amalthea").placement.radii_km;
    let (mut inside, mut outside, mut inside_by_spheroid) = (0, 0, 0);
    let changed = changed_pixels(&with, &without);
    for (ground, differs) in ground_points_of_square(&scene, AMALTHEA, side).into_iter().zip(changed) {
        let Some(ground) = ground else { continue };
        let [lat, lon] = planetographic(ground, radii_km);
        let outside_deg = |lat: f64| (30.0 - lat).max(lat - 50.0).max(-20.0 - lon).max(lon - 25.0);
        // A pixel spans one degree here, and more towards the limb.
        if outside_deg(lat) > 4.0 {
            assert!(!differs, "{lat} N {lon} E is changed");
            outside += 1;
            let on_sphere = ground / radii_km;
            let horizontal = on_sphere.x.hypot(on_sphere.y * radii_km.y / radii_km.x);
            let latitude_of_spheroid = (on_sphere.z * radii_km.x / radii_km.z).atan2(horizontal).to_degrees();
            inside_by_spheroid += u32::from(outside_deg(latitude_of_spheroid) < 0.0);
        } else if outside_deg(lat) < -4.0 {
            assert!(differs, "{lat} N {lon} E is not changed");
            inside += 1;
        }
    }
    assert!(inside > 1000 && outside > 20_000 && inside_by_spheroid > 50, "{inside} {outside} {inside_by_spheroid}");
}

#[test]
fn an_orthographic_overlay_covers_the_ground_below_it() {
    let region = "projection = \"orthographic\"\nlatitude_deg = 20.0\nlongitude_deg = -15.0\nwidth_km = 1200.0\nheight_km = 600.0\n";
    let user_overlays = UserOverlays::new(&overlay_toml("Moon", "seen", "green.png", region), &[("green.png", [10, 255, 10, 255])]);
    let (scene, with) = user_overlays.draw(MOON, "", PixelView::Albedo);
    let (_, without) = user_overlays.draw(MOON, "-overlays", PixelView::Albedo);
    let (lat, lon) = (20f64.to_radians(), (-15f64).to_radians());
    let up = DVec3::new(lat.cos() * lon.cos(), lat.cos() * lon.sin(), lat.sin());
    let east = DVec3::new(-lon.sin(), lon.cos(), 0.0);
    let north = up.cross(east);
    let (mut inside, mut outside) = (0, 0);
    for (k, ground) in ground_points(&scene, MOON).into_iter().enumerate() {
        let Some(ground) = ground else { continue };
        let outside_km = (ground.dot(east).abs() - 600.0).max(ground.dot(north).abs() - 300.0);
        let differs = with[k] != without[k];
        if outside_km > 60.0 {
            assert!(!differs, "{ground} is changed");
            outside += 1;
        } else if outside_km < -60.0 {
            assert!(differs && with[k][1] > 20.0 * with[k][0], "{ground}: {:?}", with[k]);
            inside += 1;
        }
    }
    assert!(inside > 100 && outside > 1000, "{inside} {outside}");
    // An overlay around the antipode must not show through the Moon.
    let on_far_side = UserOverlays::new(
        &overlay_toml("Moon", "seen", "green.png", &region.replace("-15.0", "165.0").replace("20.0", "-20.0")),
        &[("green.png", [10, 255, 10, 255])],
    );
    assert!(on_far_side.draw(MOON, "", PixelView::Albedo).1 == without);
}

/// On an oblate body the limb of an image is where the normal is perpendicular to the view, not where the position is. An image of the whole of Saturn from
/// above 45 N covers what faces that viewpoint; on the meridian of its middle it ends at 45 S, where by position it would end at 50.9 S.
#[test]
fn an_orthographic_image_of_an_oblate_body_ends_at_its_limb() {
    let region = "projection = \"orthographic\"\nlatitude_deg = 45.0\nlongitude_deg = 0.0\nwidth_km = 150000.0\nheight_km = 150000.0\n";
    let user_overlays = UserOverlays::new(&overlay_toml("Saturn", "seen", "green.png", region), &[("green.png", [10, 255, 10, 255])]);
    let (scene, with) = user_overlays.draw(SATURN, "", PixelView::Albedo);
    let (_, without) = user_overlays.draw(SATURN, "-overlays", PixelView::Albedo);
    let radii_km = scene.body(SATURN).expect("Saturn").placement.radii_km;
    let up = DVec3::new(1.0, 0.0, 1.0).normalize();
    let (mut facing, mut averted) = (0, 0);
    for (k, ground) in ground_points(&scene, SATURN).into_iter().enumerate() {
        let Some(ground) = ground else { continue };
        let sin_above_limb = (ground / (radii_km * radii_km)).normalize().dot(up);
        let differs = with[k] != without[k];
        // The limb of the image crosses the view where a pixel spans about a degree.
        if sin_above_limb > 0.02 {
            assert!(differs, "{ground} faces the image and is not covered");
            facing += 1;
        } else if sin_above_limb < -0.02 {
            assert!(!differs, "{ground} is behind the image's limb and is covered");
            averted += 1;
        }
    }
    assert!(facing > 2000 && averted > 100, "{facing} {averted}");
}

#[test]
fn the_second_overlay_covers_the_first_according_to_its_alpha() {
    let blended_albedo = |alpha: u8| {
        let catalog = overlay_toml("Moon", "low", "red.png", REGION) + &overlay_toml("Moon", "high", "blue.png", REGION);
        let user_overlays = UserOverlays::new(&catalog, &[("red.png", [255, 0, 0, 255]), ("blue.png", [0, 0, 255, alpha])]);
        let (scene, seen) = user_overlays.draw(MOON, "", PixelView::Albedo);
        assert_eq!(scene.draws[0].features.overlays, 2);
        let radii_km = scene.body(MOON).expect("the Moon").placement.radii_km;
        let points = ground_points(&scene, MOON);
        let is_middle = |ground: &Option<DVec3>| {
            ground.map(|g| planetographic(g, radii_km)).is_some_and(|[lat, lon]| (lat - 40.0).abs() < 3.0 && lon.abs() < 3.0)
        };
        let k = points.iter().position(is_middle).expect("the region's middle");
        [seen[k][0], seen[k][1], seen[k][2]]
    };
    let [red, _, blue] = blended_albedo(255);
    assert!(red == 0.0 && blue > 0.5, "the upper overlay must hide the lower one");
    // Alpha 51 is a fifth; a byte of premultiplied sRGB is accurate to 1 % there.
    let [red, green, mixed] = blended_albedo(51);
    assert!((red / blue - 0.8).abs() < 0.01 && (mixed / blue - 0.2).abs() < 0.01 && green == 0.0, "{red} {green} {mixed}");
}

#[test]
fn wrong_overlays_are_named_by_line_and_field() {
    let problems = |text: &str| match Catalog::with_files(&[("mine.toml".to_owned(), text.to_owned())]) {
        Ok(_) => Vec::new(),
        Err(e) => e.problems.iter().map(ToString::to_string).collect::<Vec<_>>(),
    };
    assert_eq!(problems(&overlay_toml("Moon", "a", "a.png", REGION)), Vec::<String>::new());
    let wrong = "[[overlay]]\nbody = \"Mooon\"\nname = \"a\"\nfile = \"../a.png\"\nopacity = 2\nprojection = \"equirectangular\"\nwest_deg = 10\n\
                 east_deg = 5.0\nsouth_deg = 30.0\nnorth_deg = 91.0\nwidth_km = 5.0\n";
    assert_eq!(
        problems(wrong),
        [
            "mine.toml:4: overlay.file = \"../a.png\": expected a file name without folders",
            "mine.toml:5: overlay.opacity = 2: expected a number from 0 to 1",
            "mine.toml:8: overlay.east_deg = 5.0: expected degrees above west_deg, by 360 at most",
            "mine.toml:10: overlay.north_deg = 91.0: expected degrees above south_deg, at most 90",
            "mine.toml:11: overlay.width_km is not a field here: allowed are body, name, file, gain, opacity, source, projection, west_deg, east_deg, \
             south_deg, north_deg",
        ]
    );
    let lunar_overlay = |n: &str| overlay_toml("moon", n, "a.png", REGION);
    let three = problems(&(lunar_overlay("a") + &lunar_overlay("b") + &lunar_overlay("c")));
    assert_eq!(three, ["mine.toml:22: Moon: overlay \"c\" is one too many: a body can have 2, and this one has \"a\" and \"b\""]);
    assert_eq!(
        problems(&(lunar_overlay("a") + &lunar_overlay("b") + &lunar_overlay("a"))),
        Vec::<String>::new(),
        "an overlay of the same name replaces the first"
    );
    assert_eq!(problems(&overlay_toml("Vulcan", "a", "a.png", REGION)), ["mine.toml:2: body \"Vulcan\" is not the name of a body"]);
    assert_eq!(
        problems("[[overlay]]\nbody = \"Moon\"\nname = \"a\"\nfile = \"a.png\"\nprojection = \"mercator\"\n"),
        ["mine.toml:5: overlay.projection = \"mercator\": expected one of \"equirectangular\", \"orthographic\""]
    );
}

#[test]
fn a_missing_or_tiny_overlay_is_left_out_and_reported() {
    let small = REGION.replace("25.0", "-19.9");
    let catalog = overlay_toml("Moon", "lost", "lost.png", REGION) + &overlay_toml("Moon", "small", "red.png", &small);
    let user_overlays = UserOverlays::new(&catalog, &[("red.png", [255, 0, 0, 255])]);
    let (scene, with) = user_overlays.draw(MOON, "", PixelView::Final);
    let messages = user_overlays.messages.lock().expect("a list").clone();
    assert!(
        messages.iter().filter(|l| l.contains("lost.png") && l.ends_with("drawn without it") && !l.contains('\n')).count() == 1,
        "{messages:?}"
    );
    let overlay_decisions: Vec<_> = scene.body(MOON).expect("the Moon").decisions.iter().filter(|d| d.effect == "overlays").collect();
    assert!(
        overlay_decisions.len() == 2 && overlay_decisions[0].reason.to_string().contains("lost.png could not be read"),
        "{overlay_decisions:?}"
    );
    assert!(
        !overlay_decisions[1].on && overlay_decisions[1].reason.to_string().contains("px across (threshold 0.5)"),
        "{overlay_decisions:?}"
    );
    assert!(with == user_overlays.draw(MOON, "-overlays", PixelView::Final).1);
}

/// A body whose colour map is unreadable is drawn in its mean colour. If another map is unreadable, the effect of that map is left out.
#[test]
fn the_message_about_an_unreadable_map_says_what_is_drawn_instead() {
    let user_overlays = UserOverlays::new(&overlay_toml("Moon", "a", "a.png", REGION), &[]);
    for file in ["earth_day.jpg", "earth_clouds.jpg", "earth_night.png", "earth_normal.jpg"] {
        std::fs::write(user_overlays.folder.path().join(file), "not an image").expect("written");
    }
    user_overlays.draw(NaifId::EARTH, "+clouds,+night", PixelView::Final);
    let messages = user_overlays.messages.lock().expect("a list").clone();
    let (colour, others): (Vec<&String>, Vec<&String>) = messages.iter().partition(|line| line.contains("earth_day.jpg"));
    assert!(colour.len() == 1 && colour[0].ends_with("drawn in its mean colour"), "{messages:?}");
    assert!(!others.is_empty() && others.iter().all(|line| line.ends_with("drawn without it")), "{messages:?}");
}
