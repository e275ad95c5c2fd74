//! Neighbouring keys: those that differ by one part added, removed or replaced.
//!
//! In: key texts, whose parts are separated by dots. Out: for each key its steps, sorted. Always: each step
//! has an inverse.

use std::collections::{BTreeMap, BTreeSet, HashMap};

/// A step from one key to another.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Step<'a> {
    /// `+clouds`, `-clouds` or `sun1 -> sun2`.
    pub change: String,
    pub to: &'a str,
}

fn without(parts: &[&str], k: usize) -> String {
    let rest: Vec<&str> = parts.iter().enumerate().filter(|(i, _)| *i != k).map(|(_, p)| *p).collect();
    rest.join(".")
}

/// The steps from each key to others of the set.
pub(crate) fn of<'a>(keys: impl IntoIterator<Item = &'a str>) -> BTreeMap<&'a str, Vec<Step<'a>>> {
    let keys: BTreeSet<&str> = keys.into_iter().collect();
    // Key texts with one part removed, and the keys and parts that they come from.
    let mut by_rest: HashMap<String, Vec<(&str, &str)>> = HashMap::new();
    for key in &keys {
        let parts: Vec<&str> = key.split('.').collect();
        for (k, part) in parts.iter().enumerate().filter(|_| parts.len() > 1) {
            by_rest.entry(without(&parts, k)).or_default().push((key, part));
        }
    }
    let mut steps: BTreeMap<&str, BTreeSet<Step<'_>>> = keys.iter().map(|k| (*k, BTreeSet::new())).collect();
    for (rest, with) in &by_rest {
        let shorter = keys.get(rest.as_str()).copied();
        for (key, part) in with {
            if let Some(shorter) = shorter {
                steps.entry(key).or_default().insert(Step { change: format!("-{part}"), to: shorter });
                steps.entry(shorter).or_default().insert(Step { change: format!("+{part}"), to: key });
            }
            for (other, its_part) in with.iter().filter(|(other, _)| other != key) {
                steps.entry(key).or_default().insert(Step { change: format!("{part} -> {its_part}"), to: other });
            }
        }
    }
    steps.into_iter().map(|(key, steps)| (key, steps.into_iter().collect())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_adds_removes_or_replaces_one_part() {
        let near = of(["a.sun1", "a.clouds.sun1", "a.sun2", "b.sun2"]);
        let changes = |key: &str| near[key].iter().map(|s| format!("{} {}", s.change, s.to)).collect::<Vec<_>>();
        assert_eq!(changes("a.sun1"), ["+clouds a.clouds.sun1", "sun1 -> sun2 a.sun2"]);
        assert_eq!(changes("a.clouds.sun1"), ["-clouds a.sun1"]);
        assert_eq!(changes("b.sun2"), ["b -> a a.sun2"]);
        for (key, steps) in &near {
            assert!(steps.iter().all(|s| near[s.to].iter().any(|back| back.to == *key)), "{key}");
        }
    }
}
