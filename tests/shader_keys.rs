//! Every canonical key: emitted, parsed, validated, reflected; failures gathered.

use orrery::shader::fragments::SIMPLE_MODULES;
use orrery::shader::key::{ShaderKey, canonical_needs};
use orrery::shader::{Lowering, ModuleId, ShaderModule};
use rayon::prelude::*;

fn failures(keys: &[ShaderKey]) -> Vec<String> {
    keys.par_iter().filter_map(|k| ShaderModule::build(&ModuleId::Planet(*k), &Lowering::none()).err().map(|e| e.to_string())).collect()
}

#[test]
fn every_canonical_key_is_valid() {
    let keys: Vec<ShaderKey> = canonical_needs().iter().map(ShaderKey::for_draw).collect();
    assert!(keys.len() > 500, "{}", keys.len());
    let failures = failures(&keys);
    assert!(failures.is_empty(), "{} of {} keys failed:\n{}", failures.len(), keys.len(), failures[..failures.len().min(20)].join("\n"));
}

#[test]
fn simple_modules_are_valid() {
    for name in SIMPLE_MODULES {
        ShaderModule::build(&ModuleId::Simple(name), &Lowering::none()).unwrap_or_else(|e| panic!("{e}"));
    }
    assert!(ShaderModule::build(&ModuleId::Simple("no such"), &Lowering::none()).is_err());
}
