//! The fuzz targets: a function of bytes for each parser of text or bytes from outside, with seeds.
//!
//! In: any bytes. Out: nothing. Always: a target returns within the limits of main.rs; a panic or a longer run is a finding. Two programs call the targets:
//! the loop in main.rs, and libFuzzer (fuzz_targets/any.rs).

use glam::DVec3;
use orrery::catalog::DataLayer;
use orrery::catalog::lunar_heights::{HeightMap, HeightRange};
use orrery::catalog::small_bodies::SmallBodies;
use orrery::catalog::stars::StarCatalog;
use orrery::ephemeris::orientation::Pck;
use orrery::image::{
    MapStore, StoredMaps, TexelFormat, Texture, exr_text_in_head, gif_text_in_head, png_text_in_head, read_panorama, verify_exr, verify_png,
};
use orrery::mesh::{Mesh, ShapeParameters, obj};
use orrery::probe::Prober;
use orrery::render::software::lower::{check_bytes, programs_from_bytes};
use orrery::render::software::{Options, SoftwareRenderer};
use orrery::scene::draw::DrawFeatures;
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::CameraFile;
use orrery::scene::request::warp_mesh::WarpMesh;
use orrery::session::{SAMPLE_HALF_SIDE_WITH_LIMB, sample_body_plan};
use orrery::shader::key::{DIMENSIONS, ShaderKey};
use orrery::shader::library::decode;
use orrery::shader::record::DigestRecord;
use orrery::shader::{ModuleId, ShaderLibrary};
use orrery::view::app::civil_time::ShownTimeZone;
use orrery::view::app::search::suggestions;
use orrery::view::app::settings::Settings;
use orrery::view::app::tour::Tour;
use orrery::view::app::viewer::{SelectableBody, Viewer};
use orrery::view::link::view_from_text;
use orrery::{Catalog, Fragments, FrameImages, Instant, NaifId, Session, ShaderModule, Sources, lowering};
use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use twox_hash::XxHash3_128;

mod seeds;

/// One target.
pub struct Target {
    pub name: &'static str,
    pub run: fn(&[u8]),
    /// Valid inputs, which are mutated.
    pub seeds: fn() -> Vec<Vec<u8>>,
    /// Words that mutations insert: keywords of the format, and extreme values.
    pub words: &'static [&'static str],
}

/// One session for all targets that need a catalog and an ephemeris.
static SESSION: LazyLock<Session> = LazyLock::new(|| {
    let cache = tempfile::tempdir().expect("a folder").keep();
    Session::open(&Sources { cache: Some(cache), threads: Some(1), ..Sources::default() }, |_| {}).expect("a session")
});
/// A renderer with one thread, for all targets that draw.
static RENDERER: LazyLock<SoftwareRenderer> =
    LazyLock::new(|| SoftwareRenderer::new(Options { threads: 1, ..Options::default() }).expect("a renderer"));
/// The module `point`, to which the inputs of `tape` and `library-entry` claim to belong.
static POINT: LazyLock<ShaderModule> =
    LazyLock::new(|| ShaderModule::build(&"point".parse().expect("a name"), &lowering()).expect("a module"));

/// The bytes as text; invalid UTF-8 is replaced.
fn text(bytes: &[u8]) -> std::borrow::Cow<'_, str> {
    String::from_utf8_lossy(bytes)
}

/// Texts as seeds.
fn texts(all: &[&str]) -> Vec<Vec<u8>> {
    all.iter().map(|t| t.as_bytes().to_vec()).collect()
}

/// The current time that views without a time assume: 31 January 2024.
fn fixed_now() -> Instant {
    Instant::from_tdb_seconds_past_j2000(7.6e8)
}

/// A catalog file, added to the smallest catalog to which its entries can refer.
fn catalog(bytes: &[u8]) {
    drop(Catalog::of_files_alone(&[("base.toml", seeds::BASE), ("a.toml", &text(bytes))]));
}

/// A file of a data layer. Its first byte chooses the format, and whether the layer belongs to a body or to the sky.
fn data_layer(bytes: &[u8]) {
    let Some((first, content)) = bytes.split_first() else { return };
    let file = ["a.csv", "a.vot", "a.geojson", "a.kml", "a.fits"][usize::from(*first) % 5];
    let body = (*first < 128).then_some(NaifId(499));
    let layer = DataLayer { body, ..DataLayer::new("a".into(), file.into()) };
    if let Ok(layer) = layer.with_content(file, content) {
        let is_in_range = |[lat_deg, lon_deg]: &[f64; 2]| lat_deg.abs() <= 90.0 && lon_deg.abs() <= 360.0;
        assert!(layer.lines.iter().all(|l| l.vertices.len() > 1 && l.vertices.iter().all(is_in_range)));
        assert!(layer.points.iter().all(|p| is_in_range(&[p.lat_deg, p.lon_deg])));
        assert!(layer.image.is_none_or(|i| i.rgba.len() == 4 * i.width as usize * i.height as usize));
    }
}

/// A text typed into the search field of the window.
fn search(bytes: &[u8]) {
    thread_local! {
        static VIEWER: Viewer = {
            let view = view_from_text("orrery://view?target=Earth", &SESSION, fixed_now()).expect("a view");
            Viewer::new(SESSION.catalog().bodies().iter().map(SelectableBody::of).collect(), view, fixed_now)
        };
    }
    VIEWER.with(|viewer| assert!(suggestions(&text(bytes), viewer, SESSION.catalog(), ShownTimeZone::Utc, 8).len() <= 8));
}

/// A folder for the inputs of targets that read files.
static FILES: LazyLock<PathBuf> = LazyLock::new(|| tempfile::tempdir().expect("a folder").keep());

/// A lunar height map. The first byte chooses the format. For a PDS image, the second byte is the label's length in units of 4 bytes; label and image follow.
fn lunar_heights(bytes: &[u8]) {
    let Some(([first, label_length_in_fours], rest)) = bytes.split_first_chunk() else { return };
    if *first % 3 == 0 {
        let (label, image) = rest.split_at(rest.len().min(4 * usize::from(*label_length_in_fours)));
        drop((HeightMap::image_of_label("a.lbl", &text(label)), HeightMap::of_pds("a.lbl", &text(label), image)));
    } else {
        let range = HeightRange { black_km: -9.0, white_km: 11.0 };
        drop(HeightMap::of_image("a", rest, (*first % 3 == 1).then_some(range)));
    }
}

/// The disk cache's entry of a map of 4 x 4 pixels.
static STORED_MAP: LazyLock<PathBuf> = LazyLock::new(|| {
    std::fs::write(FILES.join("a.png"), seeds::small_png()).expect("written");
    read_stored(&FILES);
    let entries = std::fs::read_dir(FILES.join("orrery").join("maps")).expect("a folder");
    entries.flatten().next().expect("an entry").path()
});

/// All texels of the map whose entry is in the folder's disk cache.
fn read_stored(folder: &Path) -> Vec<u8> {
    let maps = MapStore::new(Some(folder.to_owned())).with_disk_cache(Some(StoredMaps::new(folder)));
    let map = maps.get("a.png", TexelFormat::Rgba8Srgb).expect("a map");
    map.levels.iter().flat_map(|level| level.bytes().to_vec()).collect()
}

/// An entry of the disk cache with a correct checksum, as an attacker would write it. From an invalid entry the map is decoded anew, so that its size stays.
fn stored_map(bytes: &[u8]) {
    // Bytes before the checksum, which covers them: 32 of magic, key, width and height, and 17 for each of three levels.
    const COVERED: usize = 32 + 3 * 17;
    let mut entry = bytes.to_vec();
    if let Some((covered, rest)) = entry.split_at_mut_checked(COVERED)
        && let Some(sum) = rest.first_chunk_mut::<16>()
    {
        *sum = XxHash3_128::oneshot(covered).to_le_bytes();
    }
    std::fs::write(&*STORED_MAP, &entry).expect("written");
    assert_eq!(read_stored(&FILES).len(), 4 * (16 + 4 + 1), "four bytes for each texel of three levels");
}

/// Every target.
pub static TARGETS: &[Target] = &[
    Target {
        name: "catalog",
        run: catalog,
        seeds: || texts(&[seeds::BODY]),
        words: &["[[body]]", "[[ring]]", "[body.motion]", "parent", "nan", "inf", "-1e308", "0", "\"\"", "[", "{", "\\u001b", "1979-05-27"],
    },
    Target {
        name: "overlay",
        run: catalog,
        seeds: || texts(&seeds::OVERLAYS),
        words: &[
            "[[overlay]]",
            "\"..\"",
            "\"a/b\"",
            "nan",
            "inf",
            "-1e308",
            "360",
            "\"Sun\"",
            "\"\"",
            "[",
            "\"orthographic\"",
            "opacity = 2",
        ],
    },
    Target {
        name: "moment",
        run: catalog,
        seeds: || texts(&seeds::MOMENTS),
        words: &[
            "[[moment]]",
            "away_from",
            "over",
            "from",
            "side",
            "nan",
            "inf",
            "1e308",
            "\"Sun\"",
            "\"Mars\"",
            "jd_tdb:",
            "9999-12-31",
            "[",
        ],
    },
    Target {
        name: "kernel",
        run: |bytes| {
            if let Ok(spk) = orrery::ephemeris::spk::Spk::parse("a.bsp", bytes) {
                // The targets of the seed, too: otherwise no record would be evaluated.
                for target in spk.targets() {
                    std::hint::black_box((spk.state_and_center(target, 0.0), spk.state(target, 0, 0.0)));
                }
            }
        },
        // An embedded kernel, and its first records alone: headers and some coefficients.
        seeds: || vec![orrery_catalogs::PLUTO_KERNEL[..16_384].to_vec(), orrery_catalogs::PLUTO_KERNEL.to_vec()],
        words: &["DAF/SPK ", "LTL-IEEE", "BIG-IEEE"],
    },
    Target {
        name: "image",
        run: |bytes| drop(Texture::decode("a", bytes, TexelFormat::Rgba8Srgb)),
        seeds: || vec![seeds::small_png(), seeds::small_jpeg()],
        words: &["IHDR", "IDAT", "PLTE", "tRNS", "iCCP", "acTL", "\u{89}PNG"],
    },
    Target {
        name: "data-layer",
        run: data_layer,
        seeds: seeds::layers,
        words: &[
            "<TR>",
            "</TABLE>",
            "&#0;",
            "<![CDATA[",
            "<!DOCTYPE",
            "TABLEDATA",
            "coordinates",
            "\"type\":\"Polygon\"",
            "[[",
            "1e309",
            "NAXIS1  =",
            "BITPIX  = ",
            "CD1_1   = ",
            "lat,lon",
        ],
    },
    Target {
        name: "stars",
        run: |bytes| drop(StarCatalog::parse("a.csv", &text(bytes))),
        seeds: || texts(&seeds::STARS),
        words: &["ra_deg", "dec_deg", "v_mag", "J2016.0", ",", "\n", "nan", "1e309", "-0", "(", "#"],
    },
    Target {
        name: "pole-kernel",
        run: |bytes| drop(Pck::parse(&text(bytes)).map(|pck| pck.pole_and_meridian(NaifId(499), 1e9))),
        seeds: || texts(&[seeds::PCK]),
        words: &["\\begindata", "\\begintext", "BODY4_MAX_PHASE_DEGREE = ", "+=", "'", "@", "1D308", "nan", "-1"],
    },
    Target {
        name: "image-heads",
        run: |bytes| {
            drop((png_text_in_head(bytes, "Request"), gif_text_in_head(bytes, "Request"), exr_text_in_head(bytes)));
            drop((verify_png(bytes, (4, 4)), verify_exr(bytes)));
        },
        seeds: || {
            vec![
                seeds::small_png(),
                seeds::exr(2, 2, Some("{}")),
                b"GIF89a\x04\0\x04\0\0\0\0!\xfe\x0bRequest: {}\0".to_vec(),
                b"\x76\x2f\x31\x01\x02\x00\x00\x00comments\0string\0\x04\0\0\0four\0".to_vec(),
            ]
        },
        words: &["iTXt", "Request", "chlist"],
    },
    Target {
        name: "shape-model",
        run: |bytes| {
            let shape = ShapeParameters { radii_km: DVec3::ONE, scale_km: 1.0, map_stretch: glam::DVec2::ONE, two_sided: false };
            if let Ok(model) = obj::parse(&text(bytes)).map(|obj| Mesh::of(&obj, &shape)) {
                const SUN_RADIUS_RAD: f64 = 0.005;
                drop(model.map(|m| m.sun_altitudes(DVec3::X, SUN_RADIUS_RAD)));
            }
        },
        seeds: || texts(&["v 1 0 0\nv 0 1 0 0.5 0.5 0.5\nv 0 0 1\nvt 0 0\nvn 0 0 1\nf 1/1/1 2//1 3\nf -1 -2 -3\n"]),
        words: &["f ", "v ", "vt ", "-1", "4294967296", "nan", "1e309", "\\\n", "/"],
    },
    Target {
        name: "link",
        run: |bytes| drop(view_from_text(&format!("orrery://view?{}", text(bytes)), &SESSION, fixed_now())),
        seeds: || {
            texts(&[
                "target=599&eye.kind=orbit&eye.body=599&time=2015-01-24T06:45:00Z",
                "eye.kind=ground&eye.latitude_deg=1&eye.longitude_deg=2",
            ])
        },
        words: &["eye.", "%", "%00", "&", "=", "[", "null", "1e308", "-0", "effects"],
    },
    Target {
        name: "view-file",
        run: |bytes| drop(view_from_text(&text(bytes), &SESSION, fixed_now())),
        seeds: || texts(&[r#"{"target":"saturn","eye":{"kind":"orbit","body":699},"time":"2024-01-01T00:00:00Z","fov_deg":20}"#]),
        words: &["{", "}", "[", "null", "1e400", "-1", "\"eye\"", "\"kind\":\"free\""],
    },
    Target {
        name: "camera-file",
        run: |bytes| drop(CameraFile::parse("a.json", &text(bytes))),
        seeds: || texts(&[r#"{"position":{"body":"earth","km":[9e3,0,0]},"look":{"at":"sun"},"up":"north","fov_deg":30}"#]),
        words: &["{", "[", "null", "1e400", "\"axes\"", "\"lat\""],
    },
    Target {
        name: "settings",
        run: |bytes| drop(serde_json::from_slice::<Settings>(bytes)),
        seeds: || texts(&[seeds::SETTINGS]),
        words: &["{", "[", "null", "1e400", "\"place\"", "\"sight\"", "-1"],
    },
    Target {
        name: "question",
        run: |bytes| drop(Prober { session: &SESSION, renderer: &RENDERER }.answer(&text(bytes))),
        seeds: seeds::probe_queries,
        words: &["0", "-1", "1e-308", "1e308", "null", "[]", "\"model\"", "\"saturn\"", "0.999999"],
    },
    Target {
        name: "time",
        run: |bytes| drop(Instant::parse(&text(bytes))),
        seeds: || texts(&["2024-04-08T18:17:16Z", "jd_tdb:2460409.262", "-4712-01-01"]),
        words: &["-", "T", "Z", "60", "99999", "jd_tdb:", "jd_utc:", "nan", "1e308", ".", "é"],
    },
    Target {
        name: "effects",
        run: |bytes| drop(EffectOverrides::parse(&text(bytes))),
        seeds: || texts(&["+eclipse=limb-darkened,moon:-rings", "-night,saturn:+ring-shadow"]),
        words: &["moon:", "+", "-", "=", ",", "eclipse", "é"],
    },
    Target {
        name: "key-text",
        run: |bytes| drop((text(bytes).parse::<ModuleId>(), text(bytes).parse::<ShaderKey>())),
        seeds: || texts(&["lambert.albedo-normal.sun1.ellipsoid", "probe_scatter.sky.sun1.air-pixel-16-mie.sphere", "tone_map"]),
        words: &["sun3", ".", "-", "eclipse4-refracted", "depth", "é"],
    },
    Target {
        name: "digest-record",
        run: |bytes| drop(DigestRecord::parse(&text(bytes))),
        seeds: || texts(&["# orrery\npoint 0123456789abcdef\n"]),
        words: &["\n", " ", "naga", "0123456789abcdef"],
    },
    Target {
        name: "body-name",
        run: |bytes| drop(SESSION.catalog().body_or_barycenter(&text(bytes))),
        seeds: || texts(&["saturn barycenter", "phobos"]),
        words: &["barycentre", " ", "_", "é", "earth"],
    },
    Target {
        name: "fragment",
        run: |bytes| {
            let fragments = Fragments::with_files(vec![("entry/tone_map.wesl".into(), text(bytes).into_owned())]);
            drop(ShaderModule::build_with(&fragments, &"tone_map".parse().expect("a name"), &lowering()));
        },
        seeds: || seeds::fragment("entry/tone_map.wesl"),
        words: &[
            "@if(",
            "import package::",
            "loop {",
            "array<f32, 4294967295>",
            "fn f() { f(); }",
            "1u << 40",
            "struct",
            "/*",
            "vec4f(",
            "};",
        ],
    },
    Target {
        name: "tape",
        run: |bytes| {
            drop(check_bytes(&POINT.module, bytes));
            if let Ok(programs) = programs_from_bytes(bytes) {
                programs.iter().for_each(|p| drop(orrery::render::software::exec::Executor::<f32>::new(p)));
            }
        },
        seeds: || vec![POINT.tape.clone()],
        words: &[],
    },
    Target {
        name: "library-entry",
        run: library_entry,
        seeds: || {
            let folder = tempfile::tempdir().expect("a folder");
            let library = ShaderLibrary::open(folder.path(), lowering(), |_| {});
            library.get(&POINT.id).expect("a module");
            vec![std::fs::read(library.entry_path(&POINT.id).expect("a path")).expect("an entry")]
        },
        words: &[],
    },
    Target {
        name: "minor-planets",
        run: |bytes| drop(SmallBodies::parse("a", &text(bytes))),
        seeds: || texts(&seeds::MINOR_PLANETS),
        words: &["name", "epoch_mjd", "full_name", "per.y", "null", "nan", "1e309", "-1", "\"\"", ",", "K239D", "{", "[", "fields"],
    },
    Target {
        name: "tour",
        run: |bytes| drop(Tour::parse(&text(bytes), &SESSION, fixed_now())),
        seeds: || texts(&[seeds::TOUR]),
        words: &["{", "[", "null", "1e400", "-1", "\"stops\"", "\"view\"", "\"time_rate\"", "\"hold_s\"", "\"saturn\""],
    },
    Target {
        name: "search",
        run: search,
        seeds: || {
            texts(&["8 April 2024", "eclipse 2027", "51.5, -0.1", "jupiter", "-ring-shadow", "lambert.albedo.sun1.sphere", "München"])
        },
        words: &["2024", "-", ".", ",", "°", "S", "eclipse ", "+", "é", "tycho", "1e308", "nan"],
    },
    Target {
        name: "warp-mesh",
        run: |bytes| drop(WarpMesh::parse("a", &text(bytes))),
        seeds: || {
            texts(&[
                "2\n2 2\n-1 -1 0 0 1\n1 -1 1 0 1\n-1 1 0 1 0.5\n1 1 1 1 1\n",
                "2\n3 2\n-1 -1 0 0 1\n0 -1 0.5 0 1\n1 -1 1 0 1\n-1 1 0 1 0\n0 1 0.5 1 1\n1 1 1 1 1\n",
            ])
        },
        words: &["1", "2", "-1", "nan", "1e309", "999999999", " ", "\n"],
    },
    Target {
        name: "lunar-heights",
        run: lunar_heights,
        seeds: seeds::lunar_heights,
        words: &["LINES", "LINE_SAMPLES", "SAMPLE_BITS", "= 16", "END", "SCALING_FACTOR", "II*\0", "MM\0*", "-32768", "KM"],
    },
    Target {
        name: "custom-surface",
        run: |bytes| {
            let fragments = Fragments::with_files(vec![("lib/custom/surface_1.wesl".into(), text(bytes).into_owned())]);
            let key = ShaderKey::for_draw(&DrawFeatures { custom_surface: 1, lights: 1, ..DrawFeatures::MINIMAL });
            drop(ShaderModule::build_with(&fragments, &ModuleId::Keyed(key), &lowering()));
        },
        seeds: || seeds::fragment("lib/custom/surface_1.wesl"),
        words: &[
            "@if(",
            "import package::",
            "loop {",
            "while true {",
            "array<f32, 4294967295>",
            "fn f() { f(); }",
            "point.",
            "vec3f(",
            "};",
        ],
    },
    Target {
        name: "sky-image",
        run: |bytes| {
            let path = FILES.join("sky");
            std::fs::write(&path, bytes).expect("written");
            drop(read_panorama(&path, Some(1)));
        },
        seeds: || vec![seeds::exr(8, 4, None), seeds::small_jpeg()],
        words: &["compression", "dataWindow", "chlist", "tiles", "lineOrder", "IHDR"],
    },
    Target { name: "stored-map", run: stored_map, seeds: || vec![std::fs::read(&*STORED_MAP).expect("an entry")], words: &["ORRMAP02"] },
    Target { name: "key", run: key, seeds: || vec![vec![0; DIMENSIONS.len()], (0..DIMENSIONS.len() as u8).collect()], words: &[] },
];

/// The path from a key to pixels. Each byte is the value of one dimension. The key's module is emitted, validated, lowered and drawn in a small image, in which
/// every value must be finite.
fn key(bytes: &[u8]) {
    let mut features = DrawFeatures::MINIMAL;
    for (dimension, byte) in DIMENSIONS.iter().zip(bytes) {
        (dimension.set)(&mut features, usize::from(*byte) % dimension.texts.len());
    }
    let key = ShaderKey::for_draw(&features);
    assert_eq!(key.to_string().parse(), Ok(key), "the text form of a key must parse to that key");
    let library = ShaderLibrary::in_memory(lowering());
    const SIDE_PX: u32 = 12;
    let plan = sample_body_plan(&library, &key, SIDE_PX, SAMPLE_HALF_SIDE_WITH_LIMB).expect("a key has a module");
    let (frame, _) = RENDERER.render(&plan, &library, FrameImages::DisplayAndHdr).expect("a module is drawn");
    RENDERER.forget_modules();
    assert!(frame.hdr.iter().flatten().all(|value| value.is_finite()), "{key}: a pixel is not finite");
}

/// An entry of the shader library with a correct checksum, as an attacker would write it.
fn library_entry(bytes: &[u8]) {
    let mut entry = bytes.to_vec();
    // Bytes 8 to 40 are the digest of the content, which follows.
    if let (Some(content), 40..) = (bytes.get(40..), bytes.len()) {
        entry[8..40].copy_from_slice(&Sha256::digest(content));
    }
    static GENERATOR: LazyLock<std::sync::Arc<str>> = LazyLock::new(|| ShaderLibrary::in_memory(lowering()).generator_digest());
    drop(decode(&GENERATOR, &POINT.id, &entry, &lowering()));
}
