//! What is fuzzed: each parser of bytes from outside as a function of those bytes, with inputs to begin from.
//!
//! Always: a target takes any bytes and only returns. A panic, or a run longer than the loop's patience, is a finding. The functions are what a coverage-guided fuzzer calls, too.

use orrery::image::{TexelFormat, Texture, exr_head_text, is_whole_exr, is_whole_png, png_head_text};
use orrery::probe::Prober;
use orrery::render::software::lower::{check_bytes, programs_from_bytes};
use orrery::render::software::{Options, SoftwareRenderer};
use orrery::scene::effects::EffectOverrides;
use orrery::scene::request::CameraFile;
use orrery::shader::fragments::FRAGMENTS;
use orrery::shader::key::{ShaderKey, sample};
use orrery::shader::library::decode;
use orrery::shader::record::DigestRecord;
use orrery::shader::{Library, ModuleId};
use orrery::view::link::restored;
use orrery::{Catalog, Fragments, Instant, Session, ShaderModule, Sources, lowering};
use sha2::{Digest, Sha256};
use std::sync::LazyLock;

/// A parser under attack.
pub struct Target {
    pub name: &'static str,
    pub run: fn(&[u8]),
    /// Sound inputs, which mutations begin from.
    pub seeds: fn() -> Vec<Vec<u8>>,
    /// Words of its language.
    pub words: &'static [&'static str],
}

/// One session for all targets that need a sky.
static SESSION: LazyLock<Session> = LazyLock::new(|| {
    let cache = tempfile::tempdir().expect("a folder").keep();
    Session::open(&Sources { cache: Some(cache), threads: Some(1), ..Sources::default() }, |_| {}).expect("a session")
});
static RENDERER: LazyLock<SoftwareRenderer> =
    LazyLock::new(|| SoftwareRenderer::new(Options { threads: 1, ..Options::default() }).expect("a renderer"));
static POINT: LazyLock<ShaderModule> =
    LazyLock::new(|| ShaderModule::build(&"point".parse().expect("a name"), &lowering()).expect("a module"));

fn text(bytes: &[u8]) -> std::borrow::Cow<'_, str> {
    String::from_utf8_lossy(bytes)
}

fn texts(all: &[&str]) -> Vec<Vec<u8>> {
    all.iter().map(|t| t.as_bytes().to_vec()).collect()
}

fn epoch() -> Instant {
    Instant::from_tdb_seconds_past_j2000(7.6e8)
}

/// One body with its ring, air, overlay and moment: a whole catalog file is too long to be changed often.
const CATALOG: &str = r#"[[body]]
id = 401
name = "Phobos"
aliases = ["fear"]
parent = "Mars"
radii_km = [13.0, 11.4, 9.1]
photometry = { model = "lunar-lambert", lunar_weight = 0.5 }
rotation = { model = "fixed", pole_ra_deg = 1.0, pole_dec_deg = 2.0, w0_deg = 3.0, w_deg_day = 4.0 }
[[ring]]
body = "Mars"
name = "dust"
inner_km = 4e3
outer_km = 5e3
tau_normal = 0.1
[[atmosphere]]
body = "Mars"
top_km = 80.0
[[atmosphere.species]]
name = "dust"
scale_height_km = 11.0
scattering_per_km = [0.1, 0.2, 0.3]
[[overlay]]
body = "Mars"
name = "map"
file = "a.png"
west_deg = -10.0
east_deg = 10.0
south_deg = -5.0
north_deg = 5.0
[[moment]]
name = "then"
kind = "transit"
about = "There."
time = "2024-04-08T18:17:16Z"
target = "Mars"
source = "none"
side = "Sun"
radii = 3.0
"#;

/// Every target.
pub static TARGETS: &[Target] = &[
    Target {
        name: "catalog",
        run: |bytes| drop(Catalog::with_files(&[("a.toml".into(), text(bytes).into_owned())])),
        seeds: || texts(&[CATALOG]),
        words: &[
            "[[body]]",
            "[[ring]]",
            "[[overlay]]",
            "[body.motion]",
            "parent",
            "nan",
            "inf",
            "-1e308",
            "0",
            "\"\"",
            "[",
            "{",
            "\\u001b",
            "1979-05-27",
        ],
    },
    Target {
        name: "kernel",
        run: |bytes| drop(orrery::ephemeris::spk::Spk::parse("a.bsp", bytes).map(|spk| spk.state(399, 3, 0.0))),
        // The first records of a kernel that ships: heads and some coefficients.
        seeds: || vec![orrery_catalogs::PLUTO_KERNEL[..16_384].to_vec(), orrery_catalogs::PLUTO_KERNEL.to_vec()],
        words: &["DAF/SPK ", "LTL-IEEE", "BIG-IEEE"],
    },
    Target {
        name: "image",
        run: |bytes| drop(Texture::decode("a", bytes, TexelFormat::Rgba8Srgb)),
        seeds: || {
            let mut smallest: Vec<&[u8]> = orrery_textures::MAPS.iter().map(|(_, bytes)| *bytes).collect();
            smallest.sort_by_key(|bytes| bytes.len());
            smallest.truncate(2);
            smallest.into_iter().map(<[u8]>::to_vec).chain([small_png()]).collect()
        },
        words: &["IHDR", "IDAT", "PLTE", "tRNS", "iCCP", "acTL", "\u{89}PNG"],
    },
    Target {
        name: "picture-heads",
        run: |bytes| {
            drop((png_head_text(bytes, "Request"), exr_head_text(bytes)));
            drop((is_whole_png(bytes, (4, 4)), is_whole_exr(bytes)));
        },
        seeds: || vec![small_png(), b"\x76\x2f\x31\x01\x02\x00\x00\x00comments\0string\0\x04\0\0\0four\0".to_vec()],
        words: &["iTXt", "Request", "chlist"],
    },
    Target {
        name: "shape-model",
        run: |bytes| drop(orrery::mesh::obj::parse(&text(bytes))),
        seeds: || texts(&["v 1 0 0\nv 0 1 0 0.5 0.5 0.5\nv 0 0 1\nvt 0 0\nvn 0 0 1\nf 1/1/1 2//1 3\nf -1 -2 -3\n"]),
        words: &["f ", "v ", "vt ", "-1", "4294967296", "nan", "1e309", "\\\n", "/"],
    },
    Target {
        name: "link",
        run: |bytes| drop(restored(&format!("orrery://view?{}", text(bytes)), &SESSION, epoch())),
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
        run: |bytes| drop(restored(&text(bytes), &SESSION, epoch())),
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
        name: "question",
        run: |bytes| drop(Prober { session: &SESSION, renderer: &RENDERER }.answer(&text(bytes))),
        seeds: || {
            let all = orrery::probe::questions_text();
            all.lines().filter(|l| l.trim().starts_with("{\"q\"")).map(|l| l.trim().as_bytes().to_vec()).collect()
        },
        words: &["0", "-1", "1e-308", "1e308", "null", "[]", "\"model\"", "\"saturn\"", "0.999999"],
    },
    Target {
        name: "words",
        run: |bytes| {
            let text = text(bytes);
            drop((Instant::parse(&text), EffectOverrides::parse(&text), text.parse::<ModuleId>(), text.parse::<ShaderKey>()));
            drop((DigestRecord::parse(&text), SESSION.catalog().place(&text)));
        },
        seeds: || {
            texts(&[
                "2024-04-08T18:17:16Z",
                "jd_tdb:2460409.262",
                "+eclipse=limb-darkened,moon:-rings",
                "lambert.albedo-normal.sun1.ellipsoid",
            ])
        },
        words: &["moon:", "+", "-", "=", "T", "Z", "60", "99999", "jd_tdb:", "sun3", ".", "é"],
    },
    Target {
        name: "fragment",
        run: |bytes| {
            let fragments = Fragments::with_files(vec![("entry/tone_map.wesl".into(), text(bytes).into_owned())]);
            drop(ShaderModule::build_with(&fragments, &"tone_map".parse().expect("a name"), &lowering()));
        },
        seeds: || FRAGMENTS.iter().filter(|(name, _)| *name == "entry/tone_map.wesl").map(|(_, t)| t.as_bytes().to_vec()).collect(),
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
            let library = Library::open(folder.path(), lowering(), |_| {});
            library.get(&POINT.id).expect("a module");
            vec![std::fs::read(library.entry_path(&POINT.id).expect("a path")).expect("an entry")]
        },
        words: &[],
    },
    Target {
        name: "key",
        // Any eight bytes are a key of the nominal space: it is emitted, validated and lowered, and its tape checked.
        run: |bytes| {
            let seed = bytes.iter().take(8).fold(0_u64, |seed, byte| seed << 8 | u64::from(*byte));
            for key in sample(seed, 1) {
                let module = ShaderModule::build(&ModuleId::Planet(key), &lowering()).expect("a key of the nominal space has a module");
                check_bytes(&module.module, &module.tape).expect("its own tape");
            }
        },
        seeds: || vec![vec![0; 8]],
        words: &[],
    },
];

fn small_png() -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 4, 4);
    encoder.set_color(png::ColorType::Rgba);
    encoder.add_itxt_chunk("Request".into(), "{}".into()).expect("a chunk");
    let mut writer = encoder.write_header().expect("a head");
    writer.write_image_data(&[127; 64]).expect("pixels");
    writer.finish().expect("an end");
    bytes
}

/// An entry with its checksum put right, as someone would who means it.
fn library_entry(bytes: &[u8]) {
    let mut entry = bytes.to_vec();
    if let (Some(content), 40..) = (bytes.get(40..), bytes.len()) {
        entry[8..40].copy_from_slice(&Sha256::digest(content));
    }
    static GENERATOR: LazyLock<std::sync::Arc<str>> = LazyLock::new(|| Library::in_memory(lowering()).generator());
    drop(decode(&GENERATOR, &POINT.id, &entry, &lowering()));
}
