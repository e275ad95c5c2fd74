//! The modules of all reachable keys, of the covering sets, and of a random sample that differs in each run: each is emitted, parsed, validated,
//! reflected and lowered. One failure does not hide the others.

use crate::support::{random, sweep};
use orrery::catalog::Catalog;
use orrery::scene::draw::Surface;
use orrery::scene::effects::possible_features;
use orrery::shader::compare::{difference, ir_cost};
use orrery::shader::emit::{emit_fragment, emit_module};
use orrery::shader::fragments::FRAGMENTS;
use orrery::shader::id::{SIMPLE_MODULES, probe_samples};
use orrery::shader::key::{ShaderKey, covering_keys, feature_names, keys_of, random_keys};
use orrery::shader::record::{BuiltRecord, DigestRecord, RecordedModule, changes_text, recorded_modules};
use orrery::shader::translate::{Language, translate};
use orrery::shader::{Lowering, ModuleId, ShaderModule, emit, generator};
use std::collections::BTreeSet;
use std::hash::{Hash, Hasher};

fn lowering() -> Lowering {
    orrery::render::software::lowering()
}

fn reachable() -> BTreeSet<ShaderKey> {
    keys_of(possible_features(&Catalog::embedded()))
}

/// Builds the modules, and translates those whose translations are recorded; panics with the first failures.
fn build_all(modules: &[RecordedModule]) -> BuiltRecord {
    BuiltRecord::of(modules, &lowering(), || {}).unwrap_or_else(|e| {
        panic!("{} of {} modules failed; the first of them:\n{}", e.len(), modules.len(), e[..e.len().min(20)].join("\n"))
    })
}

#[test]
fn reachable_and_covering_modules_are_valid_and_as_recorded() {
    let reachable = reachable();
    assert!(reachable.len() > 100, "{} reachable keys", reachable.len());
    let surfaces: BTreeSet<_> = reachable.iter().map(|k| k.features().surface).collect();
    let photometric_models =
        Catalog::embedded().bodies().iter().map(|b| std::mem::discriminant(&b.photometry)).fold(Vec::new(), |mut all, d| {
            if !all.contains(&d) {
                all.push(d);
            }
            all
        });
    let (other_surfaces, grounds): (BTreeSet<_>, BTreeSet<_>) =
        surfaces.into_iter().partition(|s| matches!(s, Surface::Cloud | Surface::Ring | Surface::Sky));
    // In views that do not show the surface, Lambert represents all surfaces, so it may occur without a body that uses it.
    assert!(grounds.len() == photometric_models.len() || grounds.len() == photometric_models.len() + 1, "{grounds:?}");
    assert_eq!(other_surfaces.len(), 3, "{other_surfaces:?}");
    assert!(covering_keys(3).len() > covering_keys(2).len() && covering_keys(2).len() >= 10 * 8, "`view` has 10 values and `surface` 8");
    let modules = recorded_modules(&reachable);
    let text = include_str!("../shader_digests.txt");
    let record = DigestRecord::parse(text).expect("the record reads");
    // All modules take five minutes on two cores, so only a full run (ORRERY_FULL_SWEEPS=1, as in .ci/run) builds them all and stores the record as
    // proof. Any other run builds a part, chosen by its process id, or none if there is a proof with the same record, generator, lowering and keys.
    let proof_path = proof_file(&modules);
    if !sweep::in_full() {
        assert_eq!(
            (record.len(), record.only(&modules).len()),
            (modules.len(), modules.len()),
            "`orrery shader verify --update` records these modules"
        );
        if std::fs::read_to_string(&proof_path).is_ok_and(|earlier| earlier == text) {
            println!("{} modules were proven by an earlier run: {}", modules.len(), proof_path.display());
            return;
        }
        let first = std::process::id() as usize % PARTS;
        println!("modules {first}, {}, {} and so on of {}", first + PARTS, first + 2 * PARTS, modules.len());
        let part: Vec<_> = modules.into_iter().skip(first).step_by(PARTS).collect();
        return compare_with(&record.only(&part), &part);
    }
    compare_with(&record, &modules);
    std::fs::write(&proof_path, text).expect("target/tmp can be written");
}

/// A run that is not full builds one in this many modules.
const PARTS: usize = 64;

/// Builds the modules and checks that their digests equal those of the record.
fn compare_with(record: &DigestRecord, modules: &[RecordedModule]) {
    let now = build_all(modules);
    assert_eq!(now.record.len(), modules.len());
    let changes = record.changes(&now);
    assert!(changes.is_empty(), "`orrery shader verify --update` records these:\n{}", changes_text(&changes));
}

/// The file in which a full run stores the record that it found correct. Its name depends on everything that determines the WGSL and the tapes, and
/// on the list of modules.
fn proof_file(modules: &[RecordedModule]) -> std::path::PathBuf {
    let mut hash = std::hash::DefaultHasher::new();
    for RecordedModule { id, is_translated } in modules {
        (id.to_string(), is_translated).hash(&mut hash);
    }
    // These files decide what is recorded, but not what a module is, so that the digest below does not cover them.
    [include_str!("../../src/shader/translate.rs"), include_str!("../../src/shader/record.rs")].hash(&mut hash);
    let name = format!("proven-{}-{:016x}", generator::digest(&lowering().digest), hash.finish());
    std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(name)
}

#[test]
fn a_new_random_sample_is_valid() {
    let seed = random::seed();
    println!("ORRERY_SEED={seed}");
    let module = |key| RecordedModule { id: ModuleId::Keyed(key), is_translated: true };
    build_all(&random_keys(seed, 200).into_iter().map(module).collect::<Vec<_>>());
}

/// Each fragment is self-contained: it parses together with the fragments that it imports, without the fragments that import it.
#[test]
fn every_fragment_parses_with_its_imports() {
    let (mut parsed, mut texts) = (BTreeSet::new(), BTreeSet::new());
    let with_features = |id: ModuleId| match &id {
        ModuleId::Keyed(key) | ModuleId::Probe(_, key) => (id.clone(), feature_names(key.features())),
        ModuleId::Simple(_) => (id, Vec::new()),
    };
    let simple = SIMPLE_MODULES.iter().map(|n| ModuleId::Simple(n)).chain(probe_samples()).map(with_features);
    for (id, on) in simple.chain(covering_keys(2).into_iter().map(|k| (ModuleId::Keyed(k), feature_names(k.features())))) {
        for path in emit_module(&id).expect("emits").source_map.fragments {
            // "fragment" stands for the lines that depend on no feature.
            let emitted = emit_fragment(&path, "fragment", &on).expect("emits");
            if texts.insert(emitted.wgsl.clone()) {
                naga::front::wgsl::parse_str(&emitted.wgsl).unwrap_or_else(|e| panic!("shaders/{path} for {id}: {}", e.message()));
            }
            parsed.insert(path);
        }
    }
    assert_eq!(parsed.len(), FRAGMENTS.len(), "{parsed:?}");
}

#[test]
fn every_line_of_every_fragment_is_in_some_module() {
    let mut emitted_lines = BTreeSet::new();
    let simple = SIMPLE_MODULES.iter().map(|n| ModuleId::Simple(n));
    for id in simple.chain(probe_samples()).chain(covering_keys(3).into_iter().map(ModuleId::Keyed)) {
        let map = emit_module(&id).expect("emits").source_map;
        for line in 1..=map.lines.len() {
            let (fragment, number) = map.origin_of(line).expect("mapped");
            emitted_lines.insert((fragment.to_owned(), number));
        }
    }
    for (path, text) in FRAGMENTS.iter() {
        for (number, line) in (1u32..).zip(text.lines()) {
            let line = line.trim();
            // Lines that need not appear in a module: conditions on a line of their own, imports, blank lines.
            let may_be_missing = line.is_empty()
                || line.starts_with("@if(")
                || line.starts_with("@elif(")
                || line == "@else"
                || line.starts_with("import ")
                || line.starts_with("@else import ");
            assert!(
                may_be_missing || emitted_lines.contains(&((*path).to_owned(), number)),
                "shaders/{path}:{number} is in no module: {line}"
            );
        }
    }
}

#[test]
fn the_source_map_names_a_feature_of_the_key_for_every_line() {
    for key in covering_keys(2) {
        let emitted = emit(&key).expect("emits");
        let on = feature_names(key.features());
        let map = &emitted.source_map;
        assert_eq!(map.lines.len(), emitted.wgsl.lines().count());
        for (number, text) in (1..).zip(emitted.wgsl.lines()) {
            let feature = map.feature_of(number).expect("mapped");
            // "planet" stands for the lines that depend on no feature.
            assert!(feature == "planet" || on.contains(&feature) || feature.starts_with("not "), "{key}: {feature}");
            let (fragment, line) = map.origin_of(number).expect("mapped");
            let (_, source) = FRAGMENTS.iter().find(|(name, _)| *name == fragment).expect("a fragment");
            // Identical except for a condition in front of the line.
            let original = source.lines().nth(line as usize - 1).expect("a line of the fragment");
            assert!(original.ends_with(text.trim_start()), "{key}: line {number}: {original} became {text}");
        }
    }
}

#[test]
fn emission_is_deterministic_and_differences_name_their_feature() {
    let key = |t: &str| t.parse::<ShaderKey>().expect(t);
    let (smooth, relief) = (emit(&key("lambert.sun1.sphere")).expect("a"), emit(&key("lambert.normal.sun1.sphere")).expect("b"));
    assert_eq!(smooth, emit(&key("lambert.sun1.sphere")).expect("again"));
    assert!(difference(&smooth, &smooth).is_empty());
    let difference = difference(&smooth, &relief);
    let features: Vec<_> = difference.iter().map(|d| d.feature.as_str()).collect();
    assert!(features.contains(&"maps.normal"), "{features:?}");
    // The module without relief has no lines of its own except those under the condition that there is no relief.
    assert!(difference.iter().all(|d| d.only_first.is_empty() || d.feature.starts_with("not ")), "{difference:?}");
}

#[test]
fn a_module_is_translated_into_every_language_and_its_cost_counted() {
    let id: ModuleId = "oren-nayar.albedo-normal-specular-night.sun3.ellipsoid".parse().expect("key");
    let module = ShaderModule::build(&id, &lowering()).expect("builds");
    for language in Language::ALL {
        let text = translate(&module, language).unwrap_or_else(|e| panic!("{e}"));
        assert!(text.len() > 1000, "{language}: {} bytes", text.len());
    }
    // The disassembly lists every instruction of the binary once. The binary begins with a header of five words; the upper half of an instruction's
    // first word is its length in words.
    let words: Vec<u32> =
        translate(&module, Language::Spirv).expect("words").lines().map(|l| u32::from_str_radix(l, 16).expect("hex")).collect();
    let instructions =
        std::iter::successors(Some(5), |at| Some(at + (words.get(*at)? >> 16) as usize)).take_while(|at| *at < words.len()).count();
    let text = translate(&module, Language::Assembly).expect("text");
    assert_eq!(text.lines().filter(|l| !l.starts_with(';') && l.contains("Op")).count(), instructions);
    assert!(text.contains("OpEntryPoint Fragment") && text.contains("OpTypeFloat 32"), "{}", &text[..800]);
    let cost = ir_cost(&module);
    assert_eq!(cost.texture_reads, 4 * 2 * (4 * 2), "4 maps; 2 kinds of reads, filtered and smooth; 4 texels of 2 levels");
    assert_eq!(cost.uniform_bytes, module.layout.uniform_size);
}

#[test]
fn modules_of_selected_keys_are_as_recorded() {
    for text in [
        "glow",
        "point",
        "tone_map",
        "emissive.albedo.sun0.sphere",
        "lambert.sun1.sphere",
        "lambert.albedo.sun1.ellipsoid",
        "lommel-seeliger.albedo.sun1.ellipsoid",
        "lunar-lambert.albedo-normal.sun2.sphere",
        "oren-nayar.albedo-normal.sun1.ellipsoid",
        "lambert.albedo-specular-night.sun1.ellipsoid",
        "oren-nayar.albedo-normal.sun3.mesh.twosided-alphatexture-vertexcolour",
        "lambert.sun0.sphere.depth",
        "lambert.normal.sun1.ellipsoid.sunlight",
    ] {
        let id: ModuleId = text.parse().unwrap_or_else(|e| panic!("{e}"));
        let module = ShaderModule::build(&id, &lowering()).unwrap_or_else(|e| panic!("{e}"));
        insta::with_settings!({ prepend_module_to_snapshot => false, omit_expression => true }, {
            insta::assert_snapshot!(text, module.wgsl);
        });
    }
}
