//! The most expensive inputs of up to 1 MB, of each kind, are processed within 15 s of CPU time and 1 GB of memory.
//!
//! The goal is 5 s, and the slowest input took 3 s on a quiet machine (docs/reliability.md); tests that run in parallel slow down a
//! development build. The system enforces the limits (`ulimit -t`, `ulimit -v`): a program that exceeds them is killed, or aborts. The
//! limit of the address space leaves about 1 GB besides what the program maps with a harmless input.

use crate::support::sweep;
use orrery::units::GOLDEN_ANGLE_RAD;
use std::cell::Cell;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Output, Stdio};

const MEGABYTE: usize = 1_000_000;
const CPU_SECONDS: u32 = 15;
/// With one thread and a harmless input the program maps 0.1 GB (`ephemeris`, `compare`), 0.2 to 0.5 GB (`explain`, `render`) or 0.7 GB (`doctor`).
const ADDRESS_SPACE_KB: u32 = 1_600_000;

fn orrery(cache: &Path, args: &[&str], input: &[u8]) -> Output {
    let mut command = Command::new("bash");
    command.arg("-c").arg(format!("ulimit -c 0; ulimit -t {CPU_SECONDS}; ulimit -v {ADDRESS_SPACE_KB}; exec \"$@\"")).arg("bash");
    command.arg(crate::support::program::path()).args(["--renderer", "software", "--threads", "1", "--cache"]).arg(cache).args(args);
    command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
    let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("starts");
    let mut stdin = child.stdin.take().expect("a pipe");
    std::thread::scope(|scope| {
        // The program may end before it has read everything.
        scope.spawn(move || drop(stdin.write_all(input)));
        child.wait_with_output().expect("ends")
    })
}

/// Asserts that the program ended by itself, with a result or an error.
fn assert_terminates(cache: &Path, case: &str, args: &[&str], input: &[u8]) {
    let out = orrery(cache, args, input);
    let stderr_text = String::from_utf8_lossy(&out.stderr);
    let start: String = stderr_text.chars().take(400).collect();
    assert!(matches!(out.status.code(), Some(0..=2)) && !stderr_text.contains("panicked"), "{case}: {:?}: {start}", out.status);
}

/// As many items, numbered from 0, as fit into a megabyte.
fn fill_a_megabyte(item: impl Fn(usize) -> String) -> String {
    let mut text = String::new();
    for k in 0.. {
        let next = item(k);
        if text.len() + next.len() > MEGABYTE {
            break;
        }
        text.push_str(&next);
    }
    text
}

/// A megabyte of opening and closing brackets, all opening ones first.
fn nested(open: &str, close: &str) -> String {
    let depth = MEGABYTE / (open.len() + close.len());
    format!("{}{}", open.repeat(depth), close.repeat(depth))
}

/// A valid body of a catalog file.
fn body(id: usize, parent: &str) -> String {
    format!(
        "[[body]]\nid = {id}\nname = \"B{id}\"\nkind = \"moon\"\nparent = \"{parent}\"\nradii_km = [1, 1, 1]\ngeometric_albedo = 0.1\n\
         colour_linear_srgb = [1, 1, 1]\nphotometry = {{ model = \"lambert\" }}\nrotation = {{ model = \"synchronous\" }}\nmotion = {{ theory = \"planetary\" }}\n"
    )
}

#[test]
fn catalogs_of_a_megabyte_end_in_time() {
    let folder = tempfile::tempdir().expect("a folder");
    let first_id = 2_000_000;
    let dotted_key = vec!["a"; MEGABYTE / 2].join(".");
    let names = fill_a_megabyte(|k| format!("\"n{k}\","));
    let cases = [
        ("nothing", String::new()),
        (
            "a chain of parents",
            fill_a_megabyte(|k| body(first_id + k, &if k == 0 { "Sun".into() } else { format!("B{}", first_id + k - 1) })),
        ),
        // More than 2500 bodies fit; those beyond the circle have parents in it.
        ("a circle of 2500 parents", fill_a_megabyte(|k| body(first_id + k, &format!("B{}", first_id + (k + 1) % 2500)))),
        ("bodies without fields", fill_a_megabyte(|k| format!("[[body]]\nid = {}\n", first_id + k))),
        ("the same body again and again", fill_a_megabyte(|_| "[[body]]\nid = 401\n".into())),
        (
            "rings of unknown bodies",
            fill_a_megabyte(|k| format!("[[ring]]\nbody = \"mars{k}\"\nname = \"r\"\ninner_km = 4e3\nouter_km = 5e3\ntau_normal = 0.1\n")),
        ),
        (
            "rings of Mars",
            fill_a_megabyte(|k| format!("[[ring]]\nbody = \"Mars\"\nname = \"r{k}\"\ninner_km = 4e3\nouter_km = 5e3\ntau_normal = 0.1\n")),
        ),
        (
            "an atmosphere of many species",
            format!(
                "[[atmosphere]]\nbody = \"Mars\"\ntop_km = 80.0\n{}",
                fill_a_megabyte(|k| {
                    format!("[[atmosphere.species]]\nname = \"d{k}\"\nscale_height_km = 11.0\nscattering_per_km = [0.1, 0.2, 0.3]\n")
                })
            ),
        ),
        ("atmospheres", fill_a_megabyte(|k| format!("[[atmosphere]]\nbody = \"phobos{k}\"\ntop_km = 80.0\n"))),
        (
            "overlays",
            fill_a_megabyte(|k| {
                format!(
                    "[[overlay]]\nbody = \"Mars\"\nname = \"{k}\"\nfile = \"a\"\nprojection = \"equirectangular\"\nwest_deg = 0\neast_deg = 1\nsouth_deg = 0\nnorth_deg = 1\n"
                )
            }),
        ),
        (
            "moments",
            // Misspelt names, for which the message suggests similar ones.
            fill_a_megabyte(|k| {
                format!(
                    "[[moment]]\nname = \"m{k}\"\nkind = \"rings\"\nabout = \"a\"\ntime = \"2024-01-01\"\ntarget = \"marz{k}\"\nsource = \"a\"\nside = \"satrun{k}\"\nradii = 3.0\n"
                )
            }),
        ),
        ("unknown fields", format!("[[body]]\nid = 401\n{}", fill_a_megabyte(|k| format!("x{k} = 1\n")))),
        ("aliases", format!("[[body]]\nid = 401\naliases = [{names}]\n")),
        ("a long name", format!("[[body]]\nid = 401\nname = \"{}\"\n", "n".repeat(MEGABYTE))),
        ("lists in lists", format!("a = {}", nested("[", "]"))),
        ("tables in tables", format!("a = {}", nested("{a=", "}"))),
        ("a dotted key", format!("{dotted_key} = 1\n")),
        ("a dotted table header", format!("[{dotted_key}]\n")),
        ("table headers", fill_a_megabyte(|k| format!("[a{k}.b]\n"))),
        ("not TOML", "= = =\n".repeat(MEGABYTE / 6)),
        ("quotes", "\"".repeat(MEGABYTE)),
    ];
    for (k, (case, text)) in cases.into_iter().enumerate().filter(|(k, _)| sweep::runs(*k, 4)) {
        let catalog = folder.path().join(k.to_string());
        std::fs::create_dir(&catalog).expect("a folder");
        std::fs::write(catalog.join("a.toml"), text).expect("a file");
        let catalog = catalog.to_str().expect("a plain name");
        assert_terminates(
            folder.path(),
            case,
            &["ephemeris", "--body", "moon", "--center", "earth", "--time", "2024-01-01", "--catalogs", catalog],
            &[],
        );
        let image = folder.path().join("mars.png");
        let image = image.to_str().expect("a plain name");
        let view = ["render", "--target", "mars", "--time", "2024-01-01", "--size", "16x16", "--overwrite", "-o", image];
        assert_terminates(folder.path(), case, &[&view[..], &["--catalogs", catalog]].concat(), &[]);
        // `doctor` lists all bodies and all errors of the catalog.
        assert_terminates(folder.path(), case, &["doctor", "--catalogs", catalog], &[]);
    }
}

#[test]
fn fragments_of_a_megabyte_end_in_time() {
    let folder = tempfile::tempdir().expect("a folder");
    let (_, tone_map) = orrery::shader::fragments::FRAGMENTS.iter().find(|(name, _)| *name == "entry/tone_map.wesl").expect("a fragment");
    let in_function = |statements: String| tone_map.replace("    return displayed", &format!("{statements}\n    return displayed"));
    let cases = [
        ("nothing", (*tone_map).to_owned()),
        ("parentheses", in_function(format!("let a = {}1{};", "(".repeat(400_000), ")".repeat(400_000)))),
        ("a sum", in_function(format!("let a = 1.0{};", " + 1.0".repeat(150_000)))),
        ("signs", in_function(format!("let a = {}1;", "- ".repeat(400_000)))),
        ("members", in_function(format!("let a = radiance{};", ".x".repeat(400_000)))),
        ("indices", in_function(format!("let a = radiance{};", "[0]".repeat(300_000)))),
        ("calls", in_function(format!("let a = {}1.0{};", "abs(".repeat(200_000), ")".repeat(200_000)))),
        ("blocks", in_function(nested("{", "}"))),
        ("conditions", in_function(nested("if true {", "}"))),
        ("else", in_function(format!("if true {{}}{}", " else if true {}".repeat(60_000)))),
        ("types", format!("{tone_map}\nalias t = {}f32{};", "array<".repeat(100_000), ">".repeat(100_000))),
        ("less than", in_function(format!("let a = 1{};", " < 1".repeat(200_000)))),
        ("comments", format!("{tone_map}\n{}", nested("/*", "*/"))),
        ("alternatives", format!("{tone_map}\n{}", "@if(a) ".repeat(120_000))),
        ("names", format!("{tone_map}\n{}", fill_a_megabyte(|k| format!("const c{k} = 1;\n")))),
        ("functions", format!("{tone_map}\nfn g0() {{}}\n{}", fill_a_megabyte(|k| format!("fn g{}() {{ g{k}(); }}\n", k + 1)))),
        ("statements", in_function(fill_a_megabyte(|k| format!("let a{k} = {k};\n")))),
        ("attributes", format!("{tone_map}\n{}", "@a ".repeat(300_000))),
        ("zero bytes", "\u{0}".repeat(MEGABYTE)),
    ];
    for (k, (case, text)) in cases.into_iter().enumerate().filter(|(k, _)| sweep::runs(*k, 4)) {
        let shaders = folder.path().join(k.to_string());
        std::fs::create_dir_all(shaders.join("entry")).expect("a folder");
        std::fs::write(shaders.join("entry/tone_map.wesl"), text).expect("a file");
        assert_terminates(folder.path(), case, &["shader", "emit", "tone_map", "--shaders", shaders.to_str().expect("a plain name")], &[]);
        // `shader cost` also lowers the module for the software renderer.
        assert_terminates(folder.path(), case, &["shader", "cost", "tone_map", "--shaders", shaders.to_str().expect("a plain name")], &[]);
    }
}

#[test]
fn stars_heights_kernels_shapes_and_images_of_a_megabyte_end_in_time() {
    let folder = tempfile::tempdir().expect("a folder");
    let write_file = |name: &str, bytes: &[u8]| {
        std::fs::write(folder.path().join(name), bytes).expect("a file");
        folder.path().join(name).to_str().expect("a plain name").to_owned()
    };
    let view = ["explain", "--target", "phobos", "--time", "2024-01-01"];
    for (case, text) in [
        ("stars", format!("ra,dec,v\n{}", fill_a_megabyte(|k| format!("{},{},6\n", k % 360, k % 90)))),
        ("stars at one place", format!("ra_deg,dec,v\n{}", "0,0,1\n".repeat(MEGABYTE / 6))),
        ("many columns", format!("ra,dec,v{}\n", ",x".repeat(MEGABYTE / 2))),
        ("one long line", ",".repeat(MEGABYTE)),
        ("brackets", "(".repeat(MEGABYTE)),
        ("empty lines", "\n".repeat(MEGABYTE)),
    ] {
        assert_terminates(folder.path(), case, &[&view[..], &["--stars", &write_file("stars.csv", text.as_bytes())]].concat(), &[]);
    }
    let mut height_map = Vec::new();
    let mut writer = png::Encoder::new(&mut height_map, 7600, 3800);
    writer.set_color(png::ColorType::Grayscale);
    writer.set_depth(png::BitDepth::Sixteen);
    writer.write_header().and_then(|mut w| w.write_image_data(&vec![0x4e; 7600 * 3800 * 2])).expect("a PNG");
    assert!(height_map.len() < MEGABYTE, "{}", height_map.len());
    for (case, name, bytes) in [
        ("29 million equal heights", "moon.png", height_map),
        ("a label that repeats its first line", "moon.lbl", b"^IMAGE = \"a.img\"\n".repeat(MEGABYTE / 20)),
        ("a TIFF of directories", "moon.tif", [b"II*\0\x08\0\0\0".to_vec(), vec![1; MEGABYTE]].concat()),
    ] {
        assert_terminates(folder.path(), case, &[&view[..], &["--lunar-heights", &write_file(name, &bytes)]].concat(), &[]);
    }
    for (case, bytes) in [
        ("a kernel of zeros", vec![0; MEGABYTE]),
        ("a kernel that repeats its file record", orrery_catalogs::PLUTO_KERNEL[..1024].repeat(MEGABYTE / 1024)),
        ("a truncated kernel", orrery_catalogs::PLUTO_KERNEL.iter().copied().take(MEGABYTE / 2).collect()),
    ] {
        assert_terminates(folder.path(), case, &[&view[..], &["--kernel", &write_file("kernel.bsp", &bytes)]].concat(), &[]);
    }
    write_file("a.toml", b"[[body]]\nid = 401\nmesh = { file = \"a.obj\" }\n");
    let catalogs = folder.path().to_str().expect("a plain name").to_owned();
    let image = write_file("a.png", b"");
    let corners = "v 11 0 0\nv 0 11 0\nv 0 0 11\n";
    for (case, text) in [
        ("points", fill_a_megabyte(|k| format!("v {} 1 1\n", k % 11))),
        ("triangles on three points", format!("{corners}{}", "f 1 2 3\n".repeat(MEGABYTE / 8))),
        ("one face of many corners", format!("{corners}f{}\n", " 1 2 3".repeat(MEGABYTE / 6))),
        (
            "a ball of needles",
            fill_a_megabyte(|k| {
                let (a, b) = (k as f64 * 0.618, k as f64 * 0.382);
                format!(
                    "v {:.3} {:.3} {:.3}\nv {:.3} {:.3} {:.3}\nv 0.1 0 0\nf -1 -2 -3\n",
                    11.0 * a.cos(),
                    11.0 * a.sin(),
                    b.sin(),
                    11.0 * b.cos(),
                    a.sin(),
                    11.0 * b.sin()
                )
            }),
        ),
        ("slashes", "/".repeat(MEGABYTE)),
        ("joined lines", "\\\n".repeat(MEGABYTE / 2)),
    ] {
        write_file("a.obj", text.as_bytes());
        let args = [
            "render",
            "--target",
            "phobos",
            "--time",
            "2024-01-01",
            "--size",
            "16x16",
            "--overwrite",
            "--catalogs",
            &catalogs,
            "-o",
            &image,
        ];
        assert_terminates(folder.path(), case, &args, &[]);
    }
    for (case, bytes) in [
        ("zeros", vec![0; MEGABYTE]),
        ("signatures of PNG", b"\x89PNG\r\n\x1a\n".repeat(MEGABYTE / 8)),
        ("markers of JPEG", b"\xff\xd8\xff\xe0".repeat(MEGABYTE / 4)),
    ] {
        assert_terminates(folder.path(), case, &["compare", &write_file("b.png", &bytes), &write_file("c.png", &bytes)], &[]);
    }
}

#[test]
fn queries_views_and_long_arguments_end_in_time() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = |text: &str| {
        std::fs::write(folder.path().join("a.json"), text).expect("a file");
        folder.path().join("a.json").to_str().expect("a plain name").to_owned()
    };
    let texts = [
        ("lists", nested("[", "]")),
        ("objects", nested("{\"a\":", "}")),
        ("fields", format!("{{{}\"z\":0}}", fill_a_megabyte(|k| format!("\"x{k}\":0,")))),
        ("long names", format!("{{\"body\":\"{0}\",\"center\":\"{0}\",\"time\":\"{0}\"}}", "m".repeat(MEGABYTE / 3))),
        ("a long question", format!("{{\"q\":\"{}\"}}", "sunlight".repeat(MEGABYTE / 8))),
        ("a long number", format!("{{\"q\":{}}}", "1".repeat(MEGABYTE))),
        ("lines", "{}\n".repeat(2000)),
    ];
    for (case, text) in &texts {
        assert_terminates(folder.path(), case, &["probe", "--stdin"], text.as_bytes());
        assert_terminates(folder.path(), case, &["ephemeris", "--stdin"], text.as_bytes());
        let path = file(text);
        assert_terminates(folder.path(), case, &["explain", "--camera-json", &path], &[]);
        if crate::support::program::has_view() {
            assert_terminates(folder.path(), case, &["view", &path], &[]);
            assert_terminates(folder.path(), case, &["view", "--settings", &path], &[]);
        }
    }
    // Almost the longest argument that the system allows (128 KiB on Linux).
    for part in ["+rings,", "moon:+rings,moon:-rings,", "m:+rings,", "+eclipse=limb-darkened,", ","] {
        let effects = part.repeat(120_000 / part.len());
        assert_terminates(
            folder.path(),
            part,
            &["explain", "--target", "moon", "--time", "2024-01-01", &format!("--effects={effects}")],
            &[],
        );
    }
    let long = "lambert.".repeat(15_000);
    assert_terminates(folder.path(), "key", &["shader", "emit", &long], &[]);
    assert_terminates(folder.path(), "time", &["explain", "--target", "moon", "--time", &long], &[]);
    assert_terminates(folder.path(), "target", &["explain", "--target", &long, "--time", "2024-01-01"], &[]);
}

/// An image of one colour as a PNG, and the compressed bytes of its only data chunk.
fn blank_png(width: u32, height: u32) -> (Vec<u8>, Vec<u8>) {
    let mut bytes = Vec::new();
    let mut writer = png::Encoder::new(&mut bytes, width, height);
    writer.set_color(png::ColorType::Grayscale);
    writer.write_header().and_then(|mut w| w.write_image_data(&vec![0x4e; width as usize * height as usize])).expect("a PNG");
    let length_at = |at: usize| u32::from_be_bytes(bytes[at..at + 4].try_into().expect("four")) as usize;
    // Signature and IHDR chunk have 33 bytes; IDAT begins with its length and type, of 4 bytes each.
    let data = bytes[41..41 + length_at(33)].to_vec();
    (bytes, data)
}

/// A PNG of 16 x 8 pixels with this compressed colour profile, whose chunk is between IHDR and IDAT.
fn png_with_profile(compressed_profile: &[u8]) -> Vec<u8> {
    let (small, _) = blank_png(16, 8);
    // Chunk type, the profile's name `a`, its terminating zero, and the compression method 0.
    let chunk = [&b"iCCPa\0\0"[..], compressed_profile].concat();
    // CRC-32, as in the PNG specification.
    let mut crc = !0_u32;
    for byte in &chunk {
        crc ^= u32::from(*byte);
        (0..8).for_each(|_| crc = if crc & 1 == 1 { (crc >> 1) ^ 0xedb8_8320 } else { crc >> 1 });
    }
    let length = (chunk.len() as u32 - 4).to_be_bytes();
    [&small[..33], &length[..], &chunk, &(!crc).to_be_bytes(), &small[33..]].concat()
}

/// Inputs whose decoded form is far larger than the file, or whose cost grows faster than its length.
#[test]
fn maps_layers_shapes_and_surfaces_of_a_megabyte_end_in_time() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).to_str().expect("a plain name").to_owned();
    let write = |name: &str, bytes: &[u8]| {
        assert!(bytes.len() <= MEGABYTE, "{name}: {}", bytes.len());
        std::fs::create_dir_all(folder.path().join(name).parent().expect("a folder")).expect("a folder");
        std::fs::write(folder.path().join(name), bytes).expect("a file");
    };
    let image = path("a.png");
    let case_count = Cell::new(0);
    let assert_view_terminates = |case: &str, target: &str, args: &[&str]| {
        if !sweep::runs(case_count.replace(case_count.get() + 1), 4) {
            return;
        }
        let view = ["render", "--target", target, "--time", "2024-04-08T18:17:16Z", "--size", "32x32", "--overwrite", "-o", &image];
        assert_terminates(folder.path(), case, &[&view[..], args].concat(), &[]);
    };
    write("row/moon.jpg", &blank_png(60_000_000, 1).0);
    assert_view_terminates("a map of one row", "moon", &["--textures", &path("row")]);
    write("profile/moon.jpg", &png_with_profile(&blank_png(8000, 8000).1));
    assert_view_terminates("a colour profile of 64 MB", "moon", &["--textures", &path("profile")]);
    write("sky.png", &blank_png(11_300, 5650).0);
    assert_view_terminates("a sky of 64 megapixels", "moon", &["--sky", &path("sky.png")]);
    for face in ["px", "nx", "py", "ny", "pz", "nz"] {
        write(&format!("cube/{face}.png"), &blank_png(7000, 7000).0);
    }
    assert_view_terminates("a cube of 294 megapixels", "moon", &["--sky", &path("cube")]);
    // Some of the items are cut off below, to leave room for the text around them.
    let points = fill_a_megabyte(|k| format!("[{},{}],", (k * 179) % 360, (k * 89) % 90));
    let line =
        format!("{{\"type\":\"LineString\",\"coordinates\":[{}]}}", points[..points.len() - 100].rsplit_once(",[").expect("a place").0);
    write("line/a.toml", b"[[layer]]\nname = \"a\"\nfile = \"a.json\"\nbody = \"Earth\"\n");
    write("line/a.json", line.as_bytes());
    assert_view_terminates("a line thousands of times around the globe", "earth", &["--catalogs", &path("line")]);
    let layers = fill_a_megabyte(|k| format!("[[layer]]\nname = \"{k}\"\nfile = \"a.csv\"\nbody = \"Earth\"\n"));
    write("layers/a.toml", layers[..layers.len() - 200].rsplit_once("[[layer]]").expect("a layer").0.as_bytes());
    write("layers/a.csv", format!("lat_deg,lon_deg\n{}", "1,2\n".repeat(200_000)).as_bytes());
    assert_view_terminates("thousands of layers of one file", "earth", &["--catalogs", &path("layers")]);
    // Points of a Fibonacci lattice on a sphere, joined in an arbitrary order.
    let corner = |k: usize| {
        let (azimuth, polar) = (k as f64 * GOLDEN_ANGLE_RAD, (1.0 - (k as f64 + 0.5) / 1500.0).acos());
        format!("v {:.2} {:.2} {:.2}\n", 11.0 * polar.sin() * azimuth.cos(), 11.0 * polar.sin() * azimuth.sin(), 11.0 * polar.cos())
    };
    let corners: String = (0..3000).map(corner).collect();
    let face = |k: usize| format!("f {} {} {}\n", 1 + k * 7919 % 3000, 1 + k * 104_729 % 3000, 1 + (k * 1299 + 7) % 3000);
    let faces: String = (0..50_000).map(face).collect();
    write("tangle/a.toml", b"[[body]]\nid = 401\nmesh = { file = \"a.obj\" }\n");
    write("tangle/a.obj", format!("{corners}{faces}").as_bytes());
    assert_view_terminates("a tangle of triangles", "phobos", &["--catalogs", &path("tangle")]);
    let statements = fill_a_megabyte(|k| format!("a += sin(a + {k}.5);\n"));
    let surface = format!(
        "import package::lib::custom::surface_point::{{CustomSurface, SurfacePoint}};\nfn custom_surface(point: SurfacePoint) -> CustomSurface {{\nvar a = 0.0;\n{}return CustomSurface(vec3f(a), vec3f(0.0)); }}\n",
        &statements[..statements.len() - 1000].rsplit_once('\n').expect("a statement").0.to_owned()
    );
    write("a.wesl", surface.as_bytes());
    assert_view_terminates("a surface of thousands of statements", "mars", &["--surface", &format!("mars={}", path("a.wesl"))]);
}
