//! The digest record: digests of modules and fragments, which show when and why emitted modules change.
//!
//! In: module ids. Out: a text with one line per fragment and per module, sorted by name, and the changes between two such records, each with its reason: a
//! changed fragment, the emitter (`shader::emit`), or naga. Every module is emitted; every text among them is parsed, validated and lowered to a tape
//! (`shader::module`); simple shaders, probes and the covering sets are also translated. The record contains only digests, because the modules of all keys
//! together would fill gigabytes. Not here: the file that holds the record.

use super::emit::{Emitted, emit_module_with};
use super::fragments::{FRAGMENTS, Fragments};
use super::generator::{hex, naga_version};
use super::id::{SIMPLE_MODULES, probe_samples};
use super::key::{ShaderKey, covering_keys};
use super::translate::{Language, translate};
use super::{Lowering, ModuleId, ShaderModule};
use rayon::prelude::*;
use sha2::{Digest, Sha256};
use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::fmt::Write;

/// The first 64 bits of SHA-256 over the length and text of each part, as 16 hexadecimal digits.
fn digest_of(parts: &[&str]) -> String {
    let mut hash = Sha256::new();
    for part in parts {
        hash.update((part.len() as u64).to_le_bytes());
        hash.update(part);
    }
    hex(&hash.finalize()[..DIGITS / 2])
}

/// Number of hexadecimal digits of a recorded digest.
const DIGITS: usize = 16;

fn is_digest(word: &str) -> bool {
    word.len() == DIGITS && word.bytes().all(|b| matches!(b, b'0'..=b'9' | b'a'..=b'f'))
}

/// Digests of one module.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Digests {
    /// Digest of the emitted text.
    wgsl: String,
    /// Digest of all recorded translations of the module together; `None` if the module is not translated.
    translations: Option<String>,
}

/// The digests of all fragments and modules in one state of the program.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DigestRecord {
    /// Version of naga with which the modules were translated.
    naga: String,
    /// Digest of each fragment, by its path below shaders/.
    fragments: BTreeMap<String, String>,
    /// By the module's name.
    modules: BTreeMap<String, Digests>,
}

/// A line of a record that cannot be parsed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: `{text}` is not a line of a digest record; `orrery shader verify --update` records anew")]
pub struct RecordError {
    /// From 1.
    pub line: usize,
    /// The line itself.
    pub text: String,
}

/// One module that differs from the record.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Change {
    /// The module's name.
    pub module: String,
    /// What changed, and why; follows the module's name in a sentence.
    pub what: String,
}

impl DigestRecord {
    /// A record without modules, with the fragments and the naga version of this program.
    pub fn new() -> Self {
        let fragments = FRAGMENTS.iter().map(|(name, text)| ((*name).to_owned(), digest_of(&[text]))).collect();
        Self { naga: naga_version().unwrap_or("unknown").to_owned(), fragments, modules: BTreeMap::new() }
    }

    pub fn len(&self) -> usize {
        self.modules.len()
    }
    pub fn is_empty(&self) -> bool {
        self.modules.is_empty()
    }

    /// The text form; [`DigestRecord::parse`] gives back an equal record.
    pub fn to_text(&self) -> String {
        let mut text = String::from(
            "# Digests of every generated module, of all reachable keys and the covering sets. `orrery shader verify` compares and\n\
             # explains; `orrery shader verify --update` records anew.\n\
             # fragment <path> <digest>\n\
             # <module> <digest of the emitted WGSL> <digest of all translations together, where the module is translated>\n",
        );
        let _ = writeln!(text, "naga {}", self.naga);
        for (name, digest) in &self.fragments {
            let _ = writeln!(text, "fragment {name} {digest}");
        }
        for (name, d) in &self.modules {
            let _ = writeln!(text, "{}", [name.as_str(), &d.wgsl, d.translations.as_deref().unwrap_or_default()].join(" ").trim_end());
        }
        text
    }

    /// Reads the text form.
    pub fn parse(text: &str) -> Result<Self, RecordError> {
        let mut record = Self::default();
        for (line, content) in (1..).zip(text.lines()) {
            let words: Vec<&str> = content.split_whitespace().collect();
            match words[..] {
                [] => {}
                [first, ..] if first.starts_with('#') => {}
                ["naga", version] => version.clone_into(&mut record.naga),
                ["fragment", path, digest] if is_digest(digest) => drop(record.fragments.insert(path.into(), digest.into())),
                [name, wgsl, ref translations @ ..] if translations.len() <= 1 && words[1..].iter().all(|w| is_digest(w)) => {
                    let translations = translations.first().map(|d| (*d).to_owned());
                    record.modules.insert(name.to_owned(), Digests { wgsl: wgsl.to_owned(), translations });
                }
                _ => return Err(RecordError { line, text: content.to_owned() }),
            }
        }
        Ok(record)
    }

    /// This record with only the entries of these modules, where it has them, and all fragments.
    #[must_use]
    pub fn only(&self, modules: &[RecordedModule]) -> Self {
        let found = |m: &RecordedModule| self.modules.get_key_value(&m.id.to_string()).map(|(name, d)| (name.clone(), d.clone()));
        Self { modules: modules.iter().filter_map(found).collect(), ..self.clone() }
    }

    /// The modules that differ between this record, the older one, and `built`, each with the reason.
    pub fn changes(&self, built: &BuiltRecord) -> Vec<Change> {
        let (fragments_of, now) = (&built.fragments_of, &built.record);
        let mut changes = Vec::new();
        let mut push = |module: &str, what: String| changes.push(Change { module: module.to_owned(), what });
        for (name, digests) in &now.modules {
            let Some(old) = self.modules.get(name) else {
                push(name, "is new: it was not reachable or not covered before".into());
                continue;
            };
            if old.wgsl != digests.wgsl {
                let used_fragments = fragments_of.get(name).map(Vec::as_slice).unwrap_or_default();
                let changed: Vec<&str> =
                    used_fragments.iter().filter(|f| self.fragments.get(*f) != now.fragments.get(*f)).map(String::as_str).collect();
                push(
                    name,
                    if changed.is_empty() {
                        "has another text though its shader sources are as recorded: the emitter or the key's features changed".into()
                    } else {
                        format!("has another text: shaders/{} changed", changed.join(", shaders/"))
                    },
                );
            } else if old.translations != digests.translations {
                let why = if self.naga == now.naga {
                    "naga's version is the same, so the options of the translation changed".to_owned()
                } else {
                    format!("naga went from {} to {}", self.naga, now.naga)
                };
                push(name, format!("translates differently although its text is the same: {why}"));
            }
        }
        for name in self.modules.keys().filter(|n| !now.modules.contains_key(*n)) {
            push(name, "is gone: no catalog entry and no covering set asks for it".into());
        }
        changes
    }
}

/// A module to record.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RecordedModule {
    pub id: ModuleId,
    /// Whether its translations are recorded, too.
    pub is_translated: bool,
}

/// The modules to record: simple shaders, probes, the covering sets and the reachable keys (those of the catalog's bodies).
pub fn recorded_modules(reachable: &BTreeSet<ShaderKey>) -> Vec<RecordedModule> {
    let recorded = |id: ModuleId, is_translated: bool| RecordedModule { id, is_translated };
    // Every combination of the values of two and of three dimensions.
    let covered: BTreeSet<_> = covering_keys(2).into_iter().chain(covering_keys(3)).collect();
    let not_covered: Vec<_> = reachable.difference(&covered).map(|k| recorded(ModuleId::Keyed(*k), false)).collect();
    let simple_and_probes = SIMPLE_MODULES.iter().map(|n| ModuleId::Simple(n)).chain(probe_samples());
    simple_and_probes.chain(covered.into_iter().map(ModuleId::Keyed)).map(|id| recorded(id, true)).chain(not_covered).collect()
}

/// The record of modules that this program has just built without a failure, and the paths of the fragments of each.
#[derive(Clone, Debug)]
pub struct BuiltRecord {
    pub record: DigestRecord,
    /// By the module's name; paths below shaders/.
    fragments_of: BTreeMap<String, Vec<String>>,
}

impl BuiltRecord {
    /// Builds the modules on all cores, each text once, and translates those whose translations are recorded; `done` is called after each module. The error
    /// lists all failures.
    pub fn of(modules: &[RecordedModule], lowering: &Lowering, done: impl Fn() + Sync) -> Result<Self, Vec<String>> {
        Self::of_fragments(&Fragments::default(), modules, lowering, done)
    }

    /// As [`BuiltRecord::of`], with the given fragments.
    pub fn of_fragments(
        fragments: &Fragments,
        modules: &[RecordedModule],
        lowering: &Lowering,
        done: impl Fn() + Sync,
    ) -> Result<Self, Vec<String>> {
        // Half of the modules have the text of another one, which is emitted, but parsed, validated and lowered only once.
        let emit = |RecordedModule { id, .. }: &RecordedModule| {
            let Emitted { wgsl, source_map } = emit_module_with(fragments, id).map_err(|e| e.to_string())?;
            Ok::<_, String>((digest_of(&[&wgsl]), source_map.fragments))
        };
        let emitted: Vec<_> = modules.par_iter().map(emit).collect();
        let mut texts = HashSet::new();
        let is_first_of_text: Vec<bool> = emitted.iter().map(|e| e.as_ref().is_ok_and(|(wgsl, _)| texts.insert(wgsl.clone()))).collect();
        let build = |((RecordedModule { id, is_translated }, emitted), is_first): ((&RecordedModule, _), bool)| {
            let (wgsl, fragments_of) = emitted?;
            let mut translations = None;
            if is_first || *is_translated {
                let module = ShaderModule::build_with(fragments, id, lowering).map_err(|e| e.to_string())?;
                let languages = Language::ALL.into_iter().filter(|l| *is_translated && l.is_recorded());
                let texts = languages.map(|l| translate(&module, l).map_err(|e| e.to_string())).collect::<Result<Vec<_>, _>>()?;
                let texts: Vec<&str> = texts.iter().map(String::as_str).collect();
                translations = is_translated.then(|| digest_of(&texts));
            }
            Ok::<_, String>((id.to_string(), Digests { wgsl, translations }, fragments_of))
        };
        let built = modules.par_iter().zip(emitted).zip(is_first_of_text).map(|module| {
            let result = build(module);
            done();
            result
        });
        let results: Vec<_> = built.collect();
        let mut built = Self { record: DigestRecord::new(), fragments_of: BTreeMap::new() };
        let mut failures = Vec::new();
        for result in results {
            match result {
                Ok((name, digests, fragments)) => {
                    built.record.modules.insert(name.clone(), digests);
                    built.fragments_of.insert(name, fragments);
                }
                Err(e) => failures.push(e),
            }
        }
        if failures.is_empty() { Ok(built) } else { Err(failures) }
    }
}

/// Lists the changes, grouped by [`Change::what`], each with all its modules.
pub fn changes_text(changes: &[Change]) -> String {
    let mut modules_by_what: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    changes.iter().for_each(|c| modules_by_what.entry(&c.what).or_default().push(&c.module));
    let mut text = String::new();
    for (what, names) in modules_by_what {
        let _ = writeln!(text, "{} x {what}", names.len());
        names.iter().for_each(|n| text.push_str(&format!("  {n}\n")));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A digest that consists of one repeated digit.
    fn digest(digit: char) -> String {
        digit.to_string().repeat(DIGITS)
    }

    /// A record of the fragment `a.wesl` and the module `k`. Each `char` is the digit that is repeated in a digest.
    fn record(naga: &str, fragment: char, wgsl: char, translations: char) -> DigestRecord {
        let [fragment, wgsl, translations] = [fragment, wgsl, translations].map(digest);
        DigestRecord::parse(&format!("naga {naga}\nfragment a.wesl {fragment}\nk {wgsl} {translations}\n")).expect("reads")
    }

    #[test]
    fn text_round_trips_and_bad_lines_are_named() {
        let r = record("1.2.3", 'f', 'a', 'b');
        assert_eq!(DigestRecord::parse(&r.to_text()), Ok(r));
        let (a, b) = (digest('a'), digest('b'));
        let several = DigestRecord::parse(&format!("naga 1\nsky {a} {b}\nlambert.sun1 {b}\n")).expect("reads");
        assert_eq!(several.modules.keys().collect::<Vec<_>>(), ["lambert.sun1", "sky"]);
        assert_eq!(several.modules["lambert.sun1"].translations, None);
        assert_eq!(DigestRecord::parse(&several.to_text()), Ok(several));
        for invalid in
            ["sky".to_owned(), format!("sky {}", &a[1..]), format!("sky {a}0"), format!("sky {}", digest('A')), format!("sky {a} {b} {b}")]
        {
            assert_eq!(DigestRecord::parse(&format!("naga 1\n{invalid}\n")).expect_err(&invalid).line, 2);
        }
    }

    #[test]
    fn digests_depend_on_each_text_and_on_where_texts_are_split() {
        assert!(is_digest(&digest_of(&["a"])));
        assert_ne!(digest_of(&["ab", "c"]), digest_of(&["a", "bc"]));
        // SHA-256 of eight zero bytes: the length 0 of the one part, as a u64.
        assert_eq!(digest_of(&[""]), "af5570f5a1810b7a");
    }

    #[test]
    fn each_kind_of_change_gets_its_reason() {
        let why = |old: &DigestRecord, new: &DigestRecord| {
            let fragments_of = [("k".to_owned(), vec!["a.wesl".to_owned()])].into();
            let new = BuiltRecord { record: new.clone(), fragments_of };
            old.changes(&new).iter().map(|c| format!("{} {}", c.module, c.what)).collect::<Vec<_>>()
        };
        let old = record("1", 'f', 'a', 'b');
        assert!(why(&old, &old).is_empty());
        assert!(why(&old, &record("1", 'e', 'c', 'd'))[0].contains("k has another text: shaders/a.wesl changed"));
        assert!(why(&old, &record("1", 'f', 'c', 'd'))[0].contains("the emitter"));
        assert!(why(&old, &record("2", 'f', 'a', 'd'))[0].contains("naga went from 1 to 2"));
        assert!(why(&old, &DigestRecord::default())[0].contains("is gone"));
        assert!(why(&DigestRecord::default(), &old)[0].contains("is new"));
    }
}
