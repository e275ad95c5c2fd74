//! Compares emitted modules with those that WESL's reference compiler makes of the same fragments.

use orrery::shader::ModuleId;
use orrery::shader::emit::{emit_fragment, emit_module};
use orrery::shader::fragments::FRAGMENTS;
use orrery::shader::id::{SIMPLE_MODULES, probe_samples};
use orrery::shader::key::{covering_keys, feature_names};
use orrery::shader::source::condition::{FeatureSet, values_of_names};
use rayon::prelude::*;
use wesl::syntax::{ModulePath, PathOrigin};
use wesl::{CompileOptions, Feature, NoMangler, VirtualResolver};

fn module_path(fragment: &str) -> ModulePath {
    let stem = fragment.strip_suffix(".wesl").expect("a fragment's extension");
    ModulePath::new(PathOrigin::Absolute, stem.split('/').map(str::to_owned).collect())
}

/// The module that the reference compiler makes of an entry fragment, with these features on.
fn by_reference(entry: &str, features_on: &[&str]) -> String {
    let mut resolver = VirtualResolver::new();
    for (path, text) in FRAGMENTS.iter() {
        resolver.add_module(module_path(path), (*text).into());
    }
    let flags = values_of_names(FeatureSet::of(features_on)).map(|(name, is_on)| (name.to_owned(), Feature::from(is_on))).collect();
    let options = CompileOptions {
        // Imported modules are included completely, as by `emit_module`; they contain the vertex stages.
        strip: false,
        lazy: false,
        validate: false,
        features: wesl::Features { default: Feature::Error, flags },
        ..CompileOptions::default()
    };
    let compiled = wesl::compile(&module_path(entry), &resolver, &NoMangler, &options);
    compiled.unwrap_or_else(|e| panic!("shaders/{entry} with {features_on:?}: {e}")).to_string()
}

/// The declarations of a module, sorted, all printed by the same printer. Blanks and parentheses are ignored, because the reference
/// compiler adds parentheses.
fn declarations(wgsl: &str) -> Vec<String> {
    let syntax = wgsl_parse::parse_str(wgsl).unwrap_or_else(|e| panic!("{e}\n{wgsl}"));
    let normalised = |text: String| text.chars().filter(|c| !c.is_whitespace() && !"()".contains(*c)).collect();
    let mut all: Vec<String> = syntax.global_declarations.iter().map(|d| normalised(d.node().to_string())).collect();
    all.sort();
    all
}

fn entry_and_features(id: &ModuleId) -> (String, Vec<&'static str>) {
    match id {
        ModuleId::Keyed(key) => ("entry/planet.wesl".to_owned(), feature_names(key.features())),
        ModuleId::Probe(name, key) => (format!("entry/{name}.wesl"), feature_names(key.features())),
        ModuleId::Simple(name) => (format!("entry/{name}.wesl"), Vec::new()),
    }
}

#[test]
fn modules_equal_those_of_the_reference_compiler() {
    let simple = SIMPLE_MODULES.iter().map(|n| ModuleId::Simple(n));
    // Every pair of values of two dimensions occurs in some key.
    let pairwise = covering_keys(2).into_iter().map(ModuleId::Keyed);
    let ids: Vec<ModuleId> = simple.chain(probe_samples()).chain(pairwise).collect();
    ids.par_iter().for_each(|id| {
        let (entry, features_on) = entry_and_features(id);
        let emitted = emit_module(id).unwrap_or_else(|e| panic!("{e}"));
        assert!(declarations(&emitted.wgsl) == declarations(&by_reference(&entry, &features_on)), "{id}");
    });
    // A difference in a single feature is detected.
    let features_on = ["surface.lambert", "lights.1", "shape.sphere", "view.shaded"];
    let with_second_light = [&features_on[..], &["lights.2"]].concat();
    let emitted = emit_fragment("entry/planet.wesl", "planet", &features_on).expect("emits");
    assert_eq!(declarations(&emitted.wgsl), declarations(&by_reference("entry/planet.wesl", &features_on)));
    assert_ne!(declarations(&emitted.wgsl), declarations(&by_reference("entry/planet.wesl", &with_second_light)));
}
