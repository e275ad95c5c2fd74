//! The three exports: the report (compares two revisions of the shader library), the atlas (a static site with a page for each module) and
//! the corpus (conformance cases for other implementations of WGSL). Tests their contents, and that the files of the corpus suffice to draw
//! its cases.

#[cfg(feature = "gpu")]
use crate::support::gpu::gpu;
use orrery::FrameImages;
use orrery::export::report::Report;
use orrery::export::{Revision, RevisionError, atlas, corpus};
use orrery::image::{Level, TexelFormat, Texture};
use orrery::render::plan::{
    AddressMode, Attribute, Blend, ColourFormat, Cull, DepthState, FrontFace, Instances, ModuleProvider, Pass, Plan, PlanDraw,
    SamplerBinding, SamplerState, ShadingRate, TextureBinding, TextureSource, Vertices,
};
use orrery::render::software::{Options, SoftwareRenderer, lowering};
use orrery::shader::fragments::Fragments;
use orrery::shader::key::ShaderKey;
use orrery::shader::{Emitted, ModuleId, ShaderError, ShaderLibrary, ShaderModule, SourceMap};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

const LAMBERT: &str = "lib/photometry/lambert.wesl";

fn ids(texts: &[&str]) -> Vec<ModuleId> {
    texts.iter().map(|t| t.parse().unwrap_or_else(|e| panic!("{t}: {e}"))).collect()
}

fn keys(texts: &[&str]) -> Vec<ShaderKey> {
    texts.iter().map(|t| t.parse().unwrap_or_else(|e| panic!("{t}: {e}"))).collect()
}

/// `default_modules`: those that are compared where a revision is a set of fragments, not a library with entries of its own.
fn compare_revisions(first: &Revision, second: &Revision, default_modules: &[ModuleId]) -> Report {
    let (on_start, on_module_done) = (|_| (), || ());
    Report::of([first, second], default_modules, &lowering(), on_start, on_module_done).expect("a renderer")
}

/// The shipped fragments with one of them edited.
fn edited(edit: impl Fn(&str) -> String) -> Revision {
    let text = Fragments::default().text(LAMBERT).expect("a fragment").to_owned();
    let new = edit(&text);
    assert_ne!(new, text);
    Revision::of_fragments("edited", Fragments::with_files([(LAMBERT.to_owned(), new)]))
}

#[test]
fn a_report_names_the_fragment_that_changed_and_its_effect_on_the_image() {
    let modules = ids(&["lambert.sun1.sphere", "lambert.albedo.sun2.ellipsoid", "lommel-seeliger.sun1.sphere", "tone_map"]);
    let built_in = Revision::built_in();
    assert!(compare_revisions(&built_in, &Revision::built_in(), &modules).is_equal());

    let comment = compare_revisions(&built_in, &edited(|t| format!("// A comment.\n{t}")), &modules);
    assert_eq!(comment.changed.len(), 2, "modules contain the comments of their fragments");
    assert!(comment.changed.iter().all(|c| c.image.is_some_and(|p| p.max_levels == 0.0)), "a comment changes an image");

    let darker = edited(|t| t.replacen("return ", "return 0.9 * ", 1));
    let report = compare_revisions(&built_in, &darker, &modules);
    let changed: Vec<&str> = report.changed.iter().map(|c| c.module.as_str()).collect();
    assert_eq!(
        changed,
        ["lambert.sun1.sphere", "lambert.albedo.sun2.ellipsoid"].map(|k| k.parse::<ModuleId>().expect("a key").to_string())
    );
    assert_eq!((report.equal, report.failures.len()), (2, 0));
    for change in &report.changed {
        assert_eq!(change.causes.iter().map(|c| c.what.as_str()).collect::<Vec<_>>(), [LAMBERT]);
        assert_eq!((change.causes[0].removed, change.causes[0].added), (1, 1));
        let light = change.second.mean_luminance.expect("light") / change.first.mean_luminance.expect("light");
        assert!((light - 0.9).abs() < 1e-5, "{}: {light}", change.module);
        // Display levels, of 255.
        assert!(change.image.expect("an image").max_levels > 3.0);
        assert!(change.second.operations > change.first.operations, "the product is not counted");
    }
}

/// Libraries are compared by the modules stored in them, not by what this program would emit; modules that one revision lacks are reported.
#[test]
fn libraries_are_compared_by_their_entries() {
    let (old, new) = (tempfile::tempdir().expect("temp"), tempfile::tempdir().expect("temp"));
    let write_library = |folder: &Path, texts: &[&str]| {
        let library = ShaderLibrary::open(folder, lowering(), |line| panic!("{line}"));
        assert!(library.warm(&ids(texts), || ()).is_empty());
    };
    write_library(old.path(), &["lambert.sun1.sphere", "tone_map", "point"]);
    write_library(new.path(), &["lambert.sun1.sphere", "tone_map", "emissive.sun0.sphere"]);
    let open = |folder: &Path| Revision::open(folder);
    let report = compare_revisions(&open(old.path()).expect("a library"), &open(new.path()).expect("a library"), &[]);
    assert_eq!((report.equal, report.changed.len()), (2, 0));
    assert_eq!((report.only_first, report.only_second), (vec!["point".to_owned()], vec!["emissive.sun0.sphere".to_owned()]));
    // `doctor` names the folder `orrery` in the cache folder.
    assert_eq!(open(&old.path().join("orrery")).expect("a library").ids().map(|ids| ids.len()), Some(3));

    // A library has a folder for each generator, named by a digest of fragments, emitter and lowering. With two such folders the path alone
    // does not say which revision is meant.
    let root = old.path().join("orrery/shaders");
    let generator_folder = std::fs::read_dir(&root).expect("a root").next().expect("a folder").expect("an entry").path();
    std::fs::create_dir(root.join("other")).expect("made");
    let entry = std::fs::read_dir(&generator_folder).expect("entries").next().expect("one").expect("an entry").path();
    std::fs::copy(&entry, root.join("other").join(entry.file_name().expect("a name"))).expect("copied");
    assert!(matches!(open(old.path()), Err(RevisionError::Several { found, .. }) if found.len() == 2));
    assert_eq!(open(&generator_folder).expect("the folder of one").ids().map(|ids| ids.len()), Some(3));
    // A damaged entry is an error that names its file; it does not count as an equal module.
    let bytes = std::fs::read(&entry).expect("read");
    std::fs::write(&entry, &bytes[..bytes.len() / 2]).expect("written");
    let damaged = compare_revisions(&open(&generator_folder).expect("a folder"), &open(&generator_folder).expect("a folder"), &[]);
    assert_eq!((damaged.equal, damaged.failures.len()), (2, 1));
    assert!(damaged.failures[0].1.contains("checksum"), "{:?}", damaged.failures);

    let empty = tempfile::tempdir().expect("temp");
    assert!(matches!(open(empty.path()), Err(RevisionError::Nothing(_))));
    assert!(matches!(open(&empty.path().join("none")), Err(RevisionError::Folder { .. })));
}

/// A word of a key may be one that only another version of the program knows. Such modules are not left out as if both libraries were equal.
#[test]
fn modules_with_unknown_names_are_reported() {
    use sha2::{Digest, Sha256};
    let [cache, old, new] = [(); 3].map(|()| tempfile::tempdir().expect("temp"));
    let id: ModuleId = "tone_map".parse().expect("a name");
    let library = ShaderLibrary::open(cache.path(), lowering(), |line| panic!("{line}"));
    library.get(&id).expect("a module");
    let entry = std::fs::read(library.entry_path(&id).expect("on disk")).expect("an entry");
    // A magic number of 8 bytes, a checksum of 32, and the content, in which the name is a text of the same length.
    let at = entry.windows(8).position(|bytes| bytes == b"tone_map").expect("the name");
    let mut renamed = entry.clone();
    renamed[at..at + 8].copy_from_slice(b"tone_xyz");
    let checksum = Sha256::digest(&renamed[40..]);
    renamed[8..40].copy_from_slice(&checksum);
    for folder in [old.path(), new.path()] {
        std::fs::write(folder.join("tone_map.shader"), &entry).expect("written");
    }
    let open = |folder: &Path| Revision::open(folder).expect("a library");
    assert!(compare_revisions(&open(old.path()), &open(new.path()), &[]).is_equal());
    std::fs::write(old.path().join("tone_xyz.shader"), &renamed).expect("written");
    let report = compare_revisions(&open(old.path()), &open(new.path()), &[]);
    assert_eq!(report.only_first, ["tone_xyz"]);
    assert_eq!((report.only_second.len(), report.equal), (0, 1));
    assert!(!report.is_equal());
    std::fs::write(new.path().join("tone_xyz.shader"), &renamed).expect("written");
    let report = compare_revisions(&open(old.path()), &open(new.path()), &[]);
    assert_eq!((report.failures.len(), report.failures[0].0.as_str(), report.only_first.len()), (1, "tone_xyz", 0));
    assert!(!report.is_equal());
    // Libraries without any known module are not compared as if they were fragments, which can emit the default modules.
    for folder in [old.path(), new.path()] {
        std::fs::remove_file(folder.join("tone_map.shader")).expect("removed");
    }
    let report = compare_revisions(&open(old.path()), &open(new.path()), &[id]);
    assert_eq!((report.failures.len(), report.equal, report.only_second.len()), (1, 0, 0));
}

fn files_below(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = BTreeMap::new();
    let mut pending = vec![folder.to_owned()];
    while let Some(next) = pending.pop() {
        for entry in std::fs::read_dir(next).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                pending.push(path);
            } else {
                let name = path.strip_prefix(folder).expect("inside").display().to_string();
                files.insert(name, std::fs::read(&path).expect("read"));
            }
        }
    }
    files
}

#[test]
fn an_atlas_has_a_page_for_each_module_and_no_dead_link() {
    let (first, second) = (tempfile::tempdir().expect("temp"), tempfile::tempdir().expect("temp"));
    let ids = ids(&["lambert.sun1.sphere", "lambert.albedo.sun1.sphere", "lambert.sun2.sphere", "tone_map"]);
    for folder in [&first, &second] {
        atlas::write(folder.path(), &Revision::built_in(), &ids, &lowering(), || ()).expect("an atlas");
    }
    let files = files_below(first.path());
    assert!(files == files_below(second.path()), "the same modules gave other bytes");
    assert_eq!(files.keys().filter(|f| f.starts_with("pages/")).count(), ids.len());
    assert_eq!(
        files.keys().filter(|f| f.starts_with("pictures/")).count(),
        3,
        "a picture for each module but the tone map, which draws no body"
    );
    for (name, bytes) in files.iter().filter(|(name, _)| name.ends_with(".html")) {
        let html = String::from_utf8(bytes.clone()).expect("text");
        let folder = Path::new(name).parent().expect("a folder");
        for attribute in ["href=\"", "src=\""] {
            for link in html.split(attribute).skip(1).map(|rest| rest.split('"').next().unwrap_or_default()) {
                let path = folder.join(link);
                let path = if let Ok(from_root) = path.strip_prefix("pages/..") { from_root.to_owned() } else { path };
                assert!(files.contains_key(&path.display().to_string()), "{name}: {link} leads nowhere");
            }
        }
    }
    // Links to the neighbouring keys: with one part added, and with one replaced.
    let page = String::from_utf8(files["pages/lambert.sun1.sphere.html"].clone()).expect("text");
    assert!(page.contains("lambert.albedo.sun1.sphere.html\">+albedo") && page.contains("lambert.sun2.sphere.html\">sun1 -&gt; sun2"));
}

/// A case of the corpus as read from its files alone, without the catalog and the sample body of `corpus::write`.
struct Case {
    module: Arc<ShaderModule>,
    plan: Plan,
    expected: Vec<[f32; 4]>,
    tolerance: f64,
}

impl ModuleProvider for Case {
    fn module(&self, _: &ModuleId) -> Result<Arc<ShaderModule>, ShaderError> {
        Ok(Arc::clone(&self.module))
    }
}

fn floats(bytes: &[u8]) -> Vec<f32> {
    bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()
}

fn number(value: &Value) -> u32 {
    u32::try_from(value.as_u64().unwrap_or_else(|| panic!("{value} is no number"))).expect("small")
}

fn list(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

fn read_case(folder: &Path, case: &str, edit: impl Fn(String) -> String) -> Case {
    let text = |name: &str| std::fs::read_to_string(folder.join(case).join(name)).expect("a file");
    let json: Value = serde_json::from_str(&text("case.json")).expect("JSON");
    let data = |name: &Value| std::fs::read(folder.join(name.as_str().expect("a name"))).expect("data");
    let id: ModuleId = json["module"].as_str().expect("a name").parse().expect("a key");
    let wgsl = edit(text("module.wgsl"));
    let source_map = SourceMap::default();
    let module = ShaderModule::from_emitted(&id, Emitted { wgsl, source_map }, &lowering()).expect("a module");
    let texture = |t: &Value| {
        let bytes = data(&t["data"]);
        let (format, texel_bytes) = match t["format"].as_str() {
            Some("rgba8unorm") => (TexelFormat::Rgba8Unorm, 4),
            Some("rgba8unorm-srgb") => (TexelFormat::Rgba8Srgb, 4),
            Some("rgba32float") => (TexelFormat::Rgba32Float, 16),
            other => panic!("{other:?}"),
        };
        let mut offset = 0;
        let level = |size: &Value| {
            let (width, height) = (number(&size[0]), number(&size[1]));
            let end = offset + (width * height) as usize * texel_bytes;
            let bytes = bytes[offset..end].to_vec();
            offset = end;
            Level::new(width, height, bytes)
        };
        let levels = list(&t["levels"]).iter().map(level).collect();
        TextureBinding { binding: number(&t["binding"]), source: TextureSource::Image(Arc::new(Texture { format, levels })) }
    };
    let sampler = |s: &Value| {
        let mode = |name: &Value| if name == "repeat" { AddressMode::Repeat } else { AddressMode::ClampToEdge };
        let state =
            SamplerState { address_u: mode(&s["address_u"]), address_v: mode(&s["address_v"]), is_trilinear: s["filter"] == "linear" };
        SamplerBinding { binding: number(&s["binding"]), state }
    };
    let vertices = match json["vertices"].get("indices") {
        None => Vertices::Count(number(&json["vertices"]["count"])),
        Some(indices) => Vertices::Mesh {
            attributes: list(&json["vertices"]["attributes"])
                .iter()
                .map(|a| Attribute { components: number(&a["components"]), values: Arc::new(floats(&data(&a["data"]))) })
                .collect(),
            indices: Arc::new(data(indices).chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()),
        },
    };
    let [width, height] = ["width", "height"].map(|side| number(&json["target"][side]));
    let draw = PlanDraw {
        label: case.into(),
        module: id,
        uniform_bytes: data(&json["uniforms"]["data"]),
        textures: list(&json["textures"]).iter().map(texture).collect(),
        samplers: list(&json["samplers"]).iter().map(sampler).collect(),
        vertices,
        instances: Instances { count: 1, attributes: Vec::new() },
        blend: Blend::Replace,
        shading_rate: ShadingRate::PerPixel,
        cull: Cull::None,
        front_face: FrontFace::default(),
        depth: DepthState { test: true, write: true },
        scissor: [0, 0, width, height],
        extent: None,
    };
    let pass =
        Pass { name: "case", width, height, format: ColourFormat::Hdr, samples: 1, clear: [0.0; 4], has_depth: true, draws: vec![draw] };
    let expected = floats(&data(&json["expected"])).chunks_exact(4).map(|p| [p[0], p[1], p[2], p[3]]).collect();
    Case {
        module: Arc::new(module),
        plan: Plan { passes: vec![pass] },
        expected,
        tolerance: json["tolerance"].as_f64().expect("a tolerance"),
    }
}

impl Case {
    /// Number of pixels with a channel that is off by more than the tolerance.
    fn pixels_off(&self, light: &[[f32; 4]]) -> usize {
        assert_eq!(light.len(), self.expected.len());
        let differs = |(x, y): (&f32, &f32)| x.is_nan() || f64::from((x - y).abs()) > self.tolerance;
        let is_off = |(a, b): (&[f32; 4], &[f32; 4])| a.iter().zip(b).any(differs);
        light.iter().zip(&self.expected).filter(|(a, b)| is_off((a, b))).count()
    }
}

/// Cases drawn from their files alone are within their tolerance: every pixel in software (f32), on a GPU all but 1 in 500. With a tenth
/// less albedo, more than 100 pixels are outside it.
#[test]
fn a_corpus_can_be_drawn_from_its_files_alone() {
    let folder = tempfile::tempdir().expect("temp");
    let key_texts = [
        "lambert.albedo-normal.sun1.ellipsoid",
        "lambert.albedo.sun1.ringshadow-penumbra.ellipsoid",
        "lambert.sun1.eclipse2-limb-darkened.sphere",
        "ring.sun1.bodyshadow-ellipsoid-penumbra.sphere",
        "lambert.sun1.mesh",
    ];
    assert_eq!(
        corpus::write(folder.path(), &Revision::built_in(), &keys(&key_texts), &lowering(), || ()).expect("a corpus"),
        key_texts.len()
    );
    let manifest: Value = serde_json::from_slice(&std::fs::read(folder.path().join(corpus::MANIFEST)).expect("a manifest")).expect("JSON");
    let software = SoftwareRenderer::new(Options { threads: 1, ..Options::default() }).expect("a renderer");
    #[cfg(feature = "gpu")]
    let gpu = gpu();
    assert_eq!(list(&manifest["cases"]).len(), key_texts.len());
    for case in list(&manifest["cases"]).iter().filter_map(Value::as_str) {
        let unedited = read_case(folder.path(), case, |wgsl| wgsl);
        let (frame, _timings) = software.render(&unedited.plan, &unedited, FrameImages::DisplayAndHdr).expect("drawn");
        // The edited module of the negative control has the same id, so that the renderer would draw the cached one.
        software.forget_modules();
        assert_eq!(unedited.pixels_off(&frame.hdr), 0, "{case} in software");
        #[cfg(feature = "gpu")]
        if let Some(gpu) = &gpu {
            let (frame, _timings) = gpu.render(&unedited.plan, &unedited, FrameImages::DisplayAndHdr).expect("drawn");
            gpu.forget_modules();
            let (off, count) = (unedited.pixels_off(&frame.hdr), frame.hdr.len());
            assert!(off <= count / 500, "{case} on the GPU: {off} of {count} pixels");
        }
        let darker = read_case(folder.path(), case, |wgsl| {
            let position = wgsl.find("draw.albedo").unwrap_or_else(|| panic!("{case} has no albedo"));
            format!("{}0.9 * {}", &wgsl[..position], &wgsl[position..])
        });
        let (frame, _timings) = software.render(&darker.plan, &darker, FrameImages::DisplayAndHdr).expect("drawn");
        software.forget_modules();
        assert!(darker.pixels_off(&frame.hdr) > 100, "{case}: a tenth less albedo is within the tolerance");
    }
}
