//! Recorded digests of modules, and why a module is no longer what was recorded.
//!
//! In: which modules. Out: a text of one line per fragment and per module (a name as how many of its parts the name before it has too, and
//! two letters for each part after: thousands of keys stay within 100 kB), and the list of changes between two such records, each
//! with its reason: a fragment that changed, the emitter, or naga. Every module is emitted, parsed, validated and lowered; those of the
//! covering sets are translated as well. Only digests are kept of it: the modules of all keys together would fill gigabytes. Not here: where
//! the record lies.

use super::fragments::{FRAGMENTS, Fragments};
use super::generator::{hex, naga_version};
use super::id::{SIMPLE_MODULES, probe_samples};
use super::key::{ShaderKey, covering};
use super::translate::{Language, translate};
use super::{Lowering, ModuleId, ShaderModule};
use rayon::prelude::*;
use sha2::{Digest, Sha256};
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

fn hash_of(parts: &[&str]) -> impl AsRef<[u8]> {
    let mut hash = Sha256::new();
    for part in parts {
        hash.update((part.len() as u64).to_le_bytes());
        hash.update(part);
    }
    hash.finalize()
}

fn short_digest(parts: &[&str]) -> String {
    hex(&hash_of(parts).as_ref()[..6])
}

/// Digests of one module.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Digests {
    /// Of the emitted text.
    wgsl: String,
    /// Of its translations to every other language; empty where it is not translated.
    translations: String,
}

/// Letters (of 64) kept of a module's digests: one change in 16 million of its text would be missed, one in 4096 of what naga makes of
/// it, and naga changes all modules at a time.
const WGSL_LETTERS: usize = 4;
const TRANSLATION_LETTERS: usize = 2;
const LETTERS: &[u8; 64] = b"0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_-";

/// A digest in letters, six bits each.
fn lettered(parts: &[&str]) -> String {
    hash_of(parts).as_ref().iter().take(WGSL_LETTERS).map(|b| char::from(LETTERS[usize::from(b % 64)])).collect()
}

impl Digests {
    fn of(wgsl: &str, translations: &str) -> Self {
        let first = |text: &str, letters: usize| text.chars().take(letters).collect();
        Self { wgsl: first(wgsl, WGSL_LETTERS), translations: first(translations, TRANSLATION_LETTERS) }
    }
}

/// Two letters for the part of that number.
fn code(number: usize) -> [char; 2] {
    [number / LETTERS.len() % LETTERS.len(), number % LETTERS.len()].map(|n| char::from(LETTERS[n]))
}

/// The number that a letter stands for.
fn number(letter: u8) -> Option<usize> {
    LETTERS.iter().position(|l| *l == letter)
}

/// A name from its short form: how many parts of the name before it starts with, then the numbers of the others.
fn name_of(short: &str, before: &str, parts: &[String]) -> Option<String> {
    let (&kept, rest) = short.as_bytes().split_first()?;
    let mut name: Vec<&str> = before.split('.').collect();
    let kept = number(kept).filter(|n| *n <= name.len() && rest.len() % 2 == 0)?;
    name.truncate(kept);
    for pair in rest.chunks_exact(2) {
        name.push(parts.get(number(pair[0])? * LETTERS.len() + number(pair[1])?)?);
    }
    Some(name.join("."))
}

/// Digests by fragment path and by module name.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Record {
    naga: String,
    fragments: BTreeMap<String, String>,
    modules: BTreeMap<String, Digests>,
}

/// A record's text cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line}: `{text}` is no line of a digest record; `orrery shader verify --update` records anew")]
pub struct RecordError {
    pub line: usize,
    pub text: String,
}

/// One difference from what was recorded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Change {
    pub module: String,
    pub what: String,
}

impl Record {
    /// An empty record of the fragments and the naga that this program has.
    pub fn new() -> Self {
        let fragments = FRAGMENTS.iter().map(|(name, text)| ((*name).to_owned(), short_digest(&[text]))).collect();
        Self { naga: naga_version().unwrap_or("unknown").to_owned(), fragments, modules: BTreeMap::new() }
    }

    pub fn len(&self) -> usize {
        self.modules.len()
    }
    pub fn is_empty(&self) -> bool {
        self.modules.is_empty()
    }

    /// The text form; reading it back gives an equal record.
    pub fn to_text(&self) -> String {
        let mut text = String::from(
            "# Digests of every generated module, of all reachable keys and the covering sets. `orrery shader verify` compares and\n\
             # explains; `orrery shader verify --update` records anew.\n\
             # fragment <path> <digest>\n\
             # part <part of a name>, numbered from 0\n\
             # <how many parts the name before has too, numbers of the other parts> <emitted WGSL> <all translations together, where done>\n",
        );
        let _ = writeln!(text, "naga {}", self.naga);
        for (name, digest) in &self.fragments {
            let _ = writeln!(text, "fragment {name} {digest}");
        }
        let distinct: BTreeSet<&str> = self.modules.keys().flat_map(|name| name.split('.')).collect();
        let numbers: BTreeMap<&str, usize> = distinct.into_iter().zip(0..).collect();
        for part in numbers.keys() {
            let _ = writeln!(text, "part {part}");
        }
        let mut before: Vec<&str> = Vec::new();
        for (name, d) in &self.modules {
            let parts: Vec<&str> = name.split('.').collect();
            let same = before.iter().zip(&parts).take_while(|(a, b)| a == b).count();
            text.push(char::from(LETTERS[same]));
            text.extend(parts[same..].iter().flat_map(|part| code(numbers[part])));
            let _ = writeln!(text, "{}", format!(" {} {}", d.wgsl, d.translations).trim_end());
            before = parts;
        }
        text
    }

    /// Reads the text form.
    pub fn parse(text: &str) -> Result<Self, RecordError> {
        let mut record = Self::default();
        let (mut before, mut parts) = (String::new(), Vec::new());
        for (line, content) in (1..).zip(text.lines()) {
            let words: Vec<&str> = content.split_whitespace().collect();
            match words[..] {
                [] => {}
                [first, ..] if first.starts_with('#') => {}
                ["naga", version] => version.clone_into(&mut record.naga),
                ["fragment", name, digest] => drop(record.fragments.insert(name.into(), digest.into())),
                ["part", part] => parts.push(part.to_owned()),
                [short, wgsl, ..] if words.len() <= 3 => {
                    let Some(name) = name_of(short, &before, &parts) else { return Err(RecordError { line, text: content.to_owned() }) };
                    before.clone_from(&name);
                    record.modules.insert(name, Digests::of(wgsl, words.get(2).copied().unwrap_or_default()));
                }
                _ => return Err(RecordError { line, text: content.to_owned() }),
            }
        }
        Ok(record)
    }

    /// What changed from this record to `now`, with reasons.
    pub fn changes(&self, now: &Verified) -> Vec<Change> {
        let (fragments_of, now) = (&now.fragments_of, &now.record);
        let mut changes = Vec::new();
        let mut push = |module: &str, what: String| changes.push(Change { module: module.to_owned(), what });
        for (name, digests) in &now.modules {
            let Some(old) = self.modules.get(name) else {
                push(name, "is new: it was not reachable or not covered before".into());
                continue;
            };
            if old.wgsl != digests.wgsl {
                let used = fragments_of.get(name).map(Vec::as_slice).unwrap_or_default();
                let changed: Vec<&str> =
                    used.iter().filter(|f| self.fragments.get(*f) != now.fragments.get(*f)).map(String::as_str).collect();
                push(
                    name,
                    if changed.is_empty() {
                        "has another text though its fragments are as recorded: the emitter or the key's features changed".into()
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
                push(name, format!("translates otherwise with the same text: {why}"));
            }
        }
        for name in self.modules.keys().filter(|n| !now.modules.contains_key(*n)) {
            push(name, "is gone: no catalog entry and no covering set asks for it".into());
        }
        changes
    }
}

/// The modules to record: the simple ones and the probes, the covering sets, and the reachable keys; true where translations are, too.
pub fn recorded_modules(reachable: &BTreeSet<ShaderKey>) -> Vec<(ModuleId, bool)> {
    let covered: BTreeSet<_> = covering(2).into_iter().chain(covering(3)).collect();
    let rest: Vec<_> = reachable.difference(&covered).map(|k| (ModuleId::Planet(*k), false)).collect();
    let named = SIMPLE_MODULES.iter().map(|n| ModuleId::Simple(n)).chain(probe_samples());
    named.chain(covered.into_iter().map(ModuleId::Planet)).map(|id| (id, true)).chain(rest).collect()
}

/// The record of modules that all hold, and which fragments each is made of.
#[derive(Clone, Debug)]
pub struct Verified {
    pub record: Record,
    fragments_of: BTreeMap<String, Vec<String>>,
}

impl Verified {
    /// Makes the modules on all cores, and translates those with `true`; `done` is called after each. All failures, if there is any.
    pub fn of(ids: &[(ModuleId, bool)], lowering: &Lowering, done: impl Fn() + Sync) -> Result<Self, Vec<String>> {
        Self::of_fragments(&Fragments::default(), ids, lowering, done)
    }

    /// The same from other fragments.
    pub fn of_fragments(
        fragments: &Fragments,
        ids: &[(ModuleId, bool)],
        lowering: &Lowering,
        done: impl Fn() + Sync,
    ) -> Result<Self, Vec<String>> {
        let one = |(id, translated): &(ModuleId, bool)| {
            let made = ShaderModule::build_with(fragments, id, lowering).map_err(|e| e.to_string()).and_then(|m| {
                let others = Language::ALL.into_iter().filter(|l| *translated && !l.is_for_reading());
                let texts = others.map(|l| translate(&m, l).map_err(|e| e.to_string())).collect::<Result<Vec<_>, _>>()?;
                let texts: Vec<&str> = texts.iter().map(String::as_str).collect();
                let translations = if texts.is_empty() { String::new() } else { lettered(&texts) };
                Ok((m.id.to_string(), Digests::of(&lettered(&[&m.wgsl]), &translations), m.source_map.fragments))
            });
            done();
            made
        };
        let made: Vec<_> = ids.par_iter().map(one).collect();
        let mut verified = Self { record: Record::new(), fragments_of: BTreeMap::new() };
        let mut failures = Vec::new();
        for result in made {
            match result {
                Ok((name, digests, fragments)) => {
                    verified.record.modules.insert(name.clone(), digests);
                    verified.fragments_of.insert(name, fragments);
                }
                Err(e) => failures.push(e),
            }
        }
        if failures.is_empty() { Ok(verified) } else { Err(failures) }
    }
}

/// Changes for a reader: one reason often covers many modules, so it is told once, with all of them.
pub fn changes_text(changes: &[Change]) -> String {
    let mut by_reason: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    changes.iter().for_each(|c| by_reason.entry(&c.what).or_default().push(&c.module));
    let mut text = String::new();
    for (what, names) in by_reason {
        let _ = writeln!(text, "{} x {what}", names.len());
        names.iter().for_each(|n| text.push_str(&format!("  {n}\n")));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(naga: &str, fragment: &str, wgsl: &str, translations: &str) -> Record {
        Record::parse(&format!("naga {naga}\nfragment a.wesl {fragment}\npart k\n000 {wgsl} {translations}\n")).expect("reads")
    }

    #[test]
    fn text_round_trips_and_bad_lines_are_named() {
        let r = record("1.2.3", "f", "w", "t");
        assert_eq!(Record::parse(&r.to_text()), Ok(r));
        assert_eq!(Record::parse("naga 1\n000\n").expect_err("short").line, 2);
        let untranslated = Record::parse("naga 1\npart k\n000 w\n").expect("reads");
        assert_eq!(Record::parse(&untranslated.to_text()), Ok(untranslated));
        let several = Record::parse("naga 1\npart lambert\npart sky\npart sun1\npart sun2\n00002 w t\n103 x u\n001 y v\n").expect("reads");
        assert_eq!(several.modules.keys().collect::<Vec<_>>(), ["lambert.sun1", "lambert.sun2", "sky"]);
        assert_eq!(Record::parse(&several.to_text()), Ok(several));
        for wrong in ["200 z", "009 z", "00 z", "0%% z"] {
            assert_eq!(Record::parse(&format!("part k\n000 w\n{wrong}\n")).expect_err(wrong).line, 3);
        }
    }

    #[test]
    fn each_kind_of_change_gets_its_reason() {
        let why = |old: &Record, new: &Record| {
            let fragments_of = [("k".to_owned(), vec!["a.wesl".to_owned()])].into();
            let new = Verified { record: new.clone(), fragments_of };
            old.changes(&new).iter().map(|c| format!("{} {}", c.module, c.what)).collect::<Vec<_>>()
        };
        let old = record("1", "f", "w", "t");
        assert!(why(&old, &old).is_empty());
        assert!(why(&old, &record("1", "F", "W", "T"))[0].contains("k has another text: shaders/a.wesl changed"));
        assert!(why(&old, &record("1", "f", "W", "T"))[0].contains("the emitter"));
        assert!(why(&old, &record("2", "f", "w", "T"))[0].contains("naga went from 1 to 2"));
        assert!(why(&old, &Record::default())[0].contains("is gone"));
        assert!(why(&Record::default(), &old)[0].contains("is new"));
    }
}
