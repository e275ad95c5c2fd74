//! Recorded images of the views of tests/support/views.rs, of user data and of the Moon's beads, redrawn and compared.
//!
//! The software renderer uses the portable kernels, whose bits do not depend on the machine's vector unit. Only the last bit of the
//! system's sine and cosine may differ. That changes a pixel at an edge by far less than a level, and rarely makes a sample read the
//! neighbouring texel. Hence the bounds: a mean of 0.3 levels of 255, and 3 levels for 99.9 % of the values.
//!
//! Record intended changes with `ORRERY_RECORD_GOLDEN=1 cargo test --test main render::golden`; look at the images before committing. A recording writes the
//! images of which any pixel changed, and names them (with `-- --nocapture`).

use crate::support::views::views;
use glam::DVec3;
use orrery::catalog::lunar_heights::HeightMap;
use orrery::image::{Difference, DisplayImage};
use orrery::render::plan::SamplingQuality;
use orrery::render::software::kernels::KernelClass;
use orrery::render::software::{Options, SoftwareRenderer};
use orrery::scene::Scene;
use orrery::scene::request::{Axes, ExposureRequest, Look, Position, ViewRequest};
use orrery::session::Session;
use orrery::{Catalog, Ephemeris, FrameImages, Instant, NaifId};
use std::path::{Path, PathBuf};
use std::sync::Arc;

const MEAN_LEVELS: f64 = 0.3;
const P999_LEVELS: u8 = 3;
/// Limit for the size of all recorded images together. Raise it when it is short: new light changes the size of the files by some percent.
const MAX_BYTES: u64 = 620_000;

/// The shared session, and the renderer whose bits are the same on every machine.
struct GoldenRenderer {
    session: &'static Session,
    renderer: SoftwareRenderer,
}

impl GoldenRenderer {
    fn open() -> Self {
        let options = Options { kernel_class: KernelClass::Portable, ..Options::default() };
        Self { session: &crate::support::session::SESSION, renderer: SoftwareRenderer::new(options).expect("starts") }
    }

    fn draw(&self, request: &ViewRequest) -> DisplayImage {
        self.draw_in(self.session, request)
    }

    fn draw_in(&self, session: &Session, request: &ViewRequest) -> DisplayImage {
        let (_, plan) = session.plan(request, SamplingQuality { samples: 4, anisotropy: 8 }).expect("a plan");
        let (frame, _) = self.renderer.render(&plan, session.library(), FrameImages::Display).expect("drawn");
        DisplayImage { width: frame.width, height: frame.height, rgba: frame.display }
    }
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden")
}

/// Opaque images are stored without alpha, with the best PNG compression.
fn save(image: &DisplayImage, path: &Path) {
    use image::codecs::png::{CompressionType, FilterType, PngEncoder};
    let rgb: Vec<u8> = image.rgba.iter().flat_map(|p| [p[0], p[1], p[2]]).collect();
    let mut bytes = Vec::new();
    let encoder = PngEncoder::new_with_quality(&mut bytes, CompressionType::Best, FilterType::Adaptive);
    image::ImageEncoder::write_image(encoder, &rgb, image.width, image.height, image::ExtendedColorType::Rgb8).expect("encodes");
    std::fs::write(path, bytes).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
}

/// The view that draws a user's data files.
const USER_DATA: &str = "own-data";

/// Points, outlines and an image supplied by a user, on the Earth and in the sky next to it.
fn draw_user_data(renderer: &GoldenRenderer) -> DisplayImage {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).expect("written");
    write(
        "layers.toml",
        b"[[layer]]\nname = \"field\"\nfile = \"field.geojson\"\nbody = \"Earth\"\ncolour = \"#ffff40\"\n\
          [[layer]]\nname = \"track\"\nfile = \"track.kml\"\nbody = \"Earth\"\ncolour = \"#ff4040\"\n\
          [[layer]]\nname = \"points\"\nfile = \"points.vot\"\nbody = \"Earth\"\nsize_px = 40.0\n\
          [[layer]]\nname = \"image\"\nfile = \"image.fits\"\nbody = \"Earth\"\ncolour_map = \"viridis\"\npercentiles = [0.0, 100.0]\n\
          [[layer]]\nname = \"sky\"\nfile = \"sky.fits\"\ncolour_map = \"heat\"\npercentiles = [0.0, 100.0]\n",
    );
    write(
        "field.geojson",
        br#"{"type":"Polygon","coordinates":[[[-20,10],[20,10],[20,50],[-20,50],[-20,10]],[[-10,20],[0,40],[10,20],[-10,20]]]}"#,
    );
    write(
        "track.kml",
        b"<kml><Placemark><LineString><coordinates>-80,-40 -40,-20 0,0 40,20 80,40</coordinates></LineString></Placemark></kml>",
    );
    write(
        "points.vot",
        b"<VOTABLE><RESOURCE><TABLE><FIELD name=\"lat\"/><FIELD name=\"lon\"/><DATA><TABLEDATA><TR><TD>-20</TD><TD>-40</TD></TR>\
          <TR><TD>20</TD><TD>40</TD></TR></TABLEDATA></DATA></TABLE></RESOURCE></VOTABLE>",
    );
    let fits = |cards: &[&str]| {
        let size = ["SIMPLE  = T", "BITPIX  = 8", "NAXIS   = 2", "NAXIS1  = 8", "NAXIS2  = 8"];
        let cards = size.iter().chain(cards).chain(&["END"]).map(|card| format!("{card:<80}")).collect::<String>();
        let mut bytes = format!("{cards:<2880}").into_bytes();
        bytes.extend((0..64_u8).map(|k| 4 * k));
        bytes.resize(2 * 2880, 0);
        bytes
    };
    let plate_carree = [
        "CTYPE1  = 'EALN-CAR'",
        "CTYPE2  = 'EALT-CAR'",
        "CRVAL1  = 0.0",
        "CRPIX1  = 4.5",
        "CRPIX2  = 8.5",
        "CDELT1  = 5.0",
        "CDELT2  = 5.0",
    ];
    write("image.fits", &fits(&plate_carree));
    let request = ViewRequest {
        position: Position::AboveTarget { towards: Some(NaifId::SUN), distance_radii: Some(3.6) },
        width: 128,
        height: 128,
        ..ViewRequest::of(NaifId::EARTH, Instant::parse("2024-03-20T12:07:00Z").expect("a time"))
    };
    // To the upper right of the limb, as seen from the Sun's direction.
    let tangent = [
        "CTYPE1  = 'RA---TAN'",
        "CTYPE2  = 'DEC--TAN'",
        "CRVAL1  = 165.0",
        "CRVAL2  = 14.0",
        "CRPIX1  = 4.5",
        "CRPIX2  = 4.5",
        "CDELT1  = -0.9",
        "CDELT2  = 0.9",
    ];
    write("sky.fits", &fits(&tangent));
    let (session, _) = crate::support::session::session_over(folder.path());
    renderer.draw_in(&session, &request)
}

fn exceeds_bounds(d: &Difference) -> bool {
    d.mean > MEAN_LEVELS || d.p999 > P999_LEVELS
}

fn recorded(name: &str) -> Result<DisplayImage, String> {
    let bytes = std::fs::read(folder().join(format!("{name}.png"))).map_err(|e| format!("{name}: no recorded image ({e})"))?;
    DisplayImage::decode(name, &bytes, orrery::image::DEFAULT_MAX_MEGAPIXELS).map_err(|e| e.to_string())
}

/// In a recording: writes the image, unless the recorded one has the same pixels. The old image goes to the folder of temporary files.
fn record_if_changed(name: &str, drawn: &DisplayImage) {
    if std::env::var_os("ORRERY_RECORD_GOLDEN").is_none_or(|v| v != "1") {
        return;
    }
    let old = recorded(name).ok().and_then(|golden| golden.difference(drawn).ok().map(|difference| (golden, difference)));
    if old.as_ref().is_some_and(|(_, difference)| difference.max == 0) {
        return;
    }
    std::fs::create_dir_all(folder()).expect("the folder of recorded images");
    save(drawn, &folder().join(format!("{name}.png")));
    match old {
        Some((golden, difference)) => {
            let old_path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}.old.png"));
            save(&golden, &old_path);
            println!("{name}: recorded (mean {:.3}, greatest {}; before: {})", difference.mean, difference.max, old_path.display());
        }
        None => println!("{name}: recorded"),
    }
}

/// The difference from the recorded image. `Err` describes a difference beyond the bounds and gives the path of the new image.
fn compared(name: &str, drawn: &DisplayImage) -> Result<Difference, String> {
    let golden = recorded(name)?;
    let difference = golden.difference(drawn).map_err(|e| format!("{name}: {e}"))?;
    if !exceeds_bounds(&difference) {
        return Ok(difference);
    }
    let scratch = Path::new(env!("CARGO_TARGET_TMPDIR"));
    save(drawn, &scratch.join(format!("{name}.png")));
    save(&golden.difference_image(drawn).expect("one size"), &scratch.join(format!("{name}.difference.png")));
    let numbers = format!("mean {:.3}, 99.9 % {}, greatest {}", difference.mean, difference.p999, difference.max);
    Err(format!("{name} is not as recorded ({numbers}); see {name}.png and {name}.difference.png in {}", scratch.display()))
}

#[test]
fn views_look_as_recorded() {
    let renderer = GoldenRenderer::open();
    let mut failures = Vec::new();
    let drawn = views().into_iter().map(|(name, request)| (name, renderer.draw(&request)));
    for (name, drawn) in drawn.chain([(USER_DATA, draw_user_data(&renderer))]) {
        let lit = drawn.rgba.iter().filter(|p| p[..3].iter().any(|v| *v > 30)).count();
        assert!(lit > 0, "{name}: the image is black");
        record_if_changed(name, &drawn);
        match compared(name, &drawn) {
            Ok(difference) => {
                println!("{name}: mean {:.4}, 99.9 % {}, greatest {}, {lit} pixels lit", difference.mean, difference.p999, difference.max)
            }
            Err(e) => failures.push(e),
        }
    }
    assert!(
        failures.is_empty(),
        "{}\nto record intended changes: ORRERY_RECORD_GOLDEN=1 cargo test --test main render::golden",
        failures.join("\n")
    );

    // The comparison must be able to fail: Jupiter rotates by 36 degrees an hour, and an image that was never recorded is an error.
    let (_, mut request) = views().into_iter().find(|(name, _)| *name == "jupiter").expect("in the table");
    request.time = request.time.plus_seconds(3600.0);
    let later = renderer.draw(&request);
    assert!(compared("jupiter", &later).is_err_and(|e| e.contains("not as recorded")));
    assert!(compared("never-recorded", &later).is_err_and(|e| e.contains("no recorded image")));
}

/// A map of heights that depend only on the position angle around the axis towards the Earth, so that ridges and valleys run along the line
/// of sight at the limb.
fn generated_heights() -> Arc<HeightMap> {
    const COLUMNS: usize = 720;
    let height = |row: usize, column: usize| {
        let cell_centre = |k: usize, count: usize, span: f64| (k as f64 + 0.5) / count as f64 * span;
        let colatitude = cell_centre(row, COLUMNS / 2, std::f64::consts::PI);
        let longitude = cell_centre(column, COLUMNS, std::f64::consts::TAU);
        let position_angle = (colatitude.sin() * longitude.sin()).atan2(colatitude.cos());
        let waves = [(1.2, 47.0, 0.0), (0.8, 113.0, 1.0), (0.5, 301.0, 2.0), (0.4, 11.0, 0.0)];
        waves.iter().map(|(km, frequency, phase): &(f64, f64, f64)| km * (frequency * position_angle + phase).sin()).sum::<f64>() as f32
    };
    let km = (0..COLUMNS / 2).flat_map(|row| (0..COLUMNS).map(move |column| height(row, column))).collect();
    Arc::new(HeightMap::new("made", COLUMNS, km, 0.0, 1737.4).expect("a map"))
}

/// The last crescent at Dallas, five seconds before the second contact of the mean limb, broken up by hills and valleys; a pixel is an
/// arcsecond.
fn beads() -> ViewRequest {
    let (ra, dec) = (17.7_f64.to_radians(), 7.717_f64.to_radians());
    ViewRequest {
        position: Position::Ground { body: NaifId::EARTH, latitude_deg: 32.78, longitude_deg: -96.80, height_km: 0.0017 },
        look: Look::Along { direction: DVec3::new(dec.cos() * ra.cos(), dec.cos() * ra.sin(), dec.sin()), axes: Axes::Icrf },
        target: None,
        fov_deg: Some(0.035),
        width: 320,
        height: 128,
        exposure: ExposureRequest::Stops(-10.0),
        ..ViewRequest::of(NaifId::MOON, Instant::parse("2024-04-08T18:40:36Z").expect("a time"))
    }
}

#[test]
fn beads_look_as_recorded() {
    let options = Options { kernel_class: KernelClass::Portable, ..Options::default() };
    let renderer = SoftwareRenderer::new(options).expect("starts");
    let draw = |catalog: Catalog| {
        let ephemeris = Ephemeris::embedded(&catalog).expect("the shipped ephemeris");
        let scene = Scene::build(&catalog, &ephemeris, &beads()).expect("a scene");
        let plan = orrery::render::plan::plan(&scene, &*crate::support::session::SESSION, SamplingQuality { samples: 4, anisotropy: 8 })
            .expect("a plan");
        let (frame, _) = renderer.render(&plan, crate::support::session::SESSION.library(), FrameImages::Display).expect("drawn");
        DisplayImage { width: frame.width, height: frame.height, rgba: frame.display }
    };
    let drawn = draw(Catalog::embedded().with_lunar_heights(Some(generated_heights())));
    record_if_changed("beads", &drawn);
    let difference = compared("beads", &drawn).unwrap_or_else(|e| panic!("{e}"));
    println!("beads: mean {:.4}, 99.9 % {}, greatest {}", difference.mean, difference.p999, difference.max);
    // With the mean limb, the crescent is unbroken.
    assert!(compared("beads", &draw(Catalog::embedded())).is_err());
}

#[test]
fn the_folder_contains_only_the_views_and_stays_small() {
    let names: Vec<String> = views().iter().map(|(name, _)| *name).chain(["beads", USER_DATA]).map(|name| format!("{name}.png")).collect();
    let mut bytes = 0;
    for entry in std::fs::read_dir(folder()).expect("tests/golden") {
        let entry = entry.expect("an entry");
        assert!(names.contains(&entry.file_name().to_string_lossy().into_owned()), "{:?} is not a view of the table", entry.file_name());
        bytes += entry.metadata().expect("metadata").len();
    }
    println!("{bytes} bytes");
    assert!(bytes <= MAX_BYTES, "{bytes} bytes, at most {MAX_BYTES}: if new light changed the images, raise MAX_BYTES");
}
