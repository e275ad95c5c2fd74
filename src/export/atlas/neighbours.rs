//! Neighbouring keys: pairs of keys that differ in one part, which is added, removed or replaced. Two texts of a single part each, such as the names of two
//! simple modules, are no neighbours.
//!
//! In: key texts, whose parts are separated by dots. Out: for each key its neighbours, sorted. Always: if one key is a neighbour of another,
//! the other is a neighbour of the first.

use std::collections::{BTreeMap, BTreeSet, HashMap};

/// A neighbouring key, and how to reach it.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Neighbour<'a> {
    /// The change that leads to the neighbouring key: `+clouds`, `-clouds` or `sun1 -> sun2`.
    pub change: String,
    /// The neighbouring key.
    pub key: &'a str,
}

/// The key text without part `k`.
fn joined_without(parts: &[&str], k: usize) -> String {
    let rest: Vec<&str> = parts.iter().enumerate().filter(|(i, _)| *i != k).map(|(_, p)| *p).collect();
    rest.join(".")
}

/// The neighbours of each key within the set.
pub(crate) fn find<'a>(keys: impl IntoIterator<Item = &'a str>) -> BTreeMap<&'a str, Vec<Neighbour<'a>>> {
    let keys: BTreeSet<&str> = keys.into_iter().collect();
    // For each key text without one of its parts: the keys that become this text, each with the part that is removed from it.
    let mut by_rest: HashMap<String, Vec<(&str, &str)>> = HashMap::new();
    for key in &keys {
        let parts: Vec<&str> = key.split('.').collect();
        for (k, part) in parts.iter().enumerate().filter(|_| parts.len() > 1) {
            by_rest.entry(joined_without(&parts, k)).or_default().push((key, part));
        }
    }
    let mut neighbours: BTreeMap<&str, BTreeSet<Neighbour<'_>>> = keys.iter().map(|k| (*k, BTreeSet::new())).collect();
    for (rest, keys_and_parts) in &by_rest {
        let shorter = keys.get(rest.as_str()).copied();
        for (key, part) in keys_and_parts {
            if let Some(shorter) = shorter {
                neighbours.entry(key).or_default().insert(Neighbour { change: format!("-{part}"), key: shorter });
                neighbours.entry(shorter).or_default().insert(Neighbour { change: format!("+{part}"), key });
            }
            for (other, other_part) in keys_and_parts.iter().filter(|(other, _)| other != key) {
                neighbours.entry(key).or_default().insert(Neighbour { change: format!("{part} -> {other_part}"), key: other });
            }
        }
    }
    neighbours.into_iter().map(|(key, neighbours_of_key)| (key, neighbours_of_key.into_iter().collect())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_neighbour_adds_removes_or_replaces_one_part() {
        let neighbours = find(["a.sun1", "a.clouds.sun1", "a.sun2", "b.sun2"]);
        let changes = |key: &str| neighbours[key].iter().map(|n| format!("{} {}", n.change, n.key)).collect::<Vec<_>>();
        assert_eq!(changes("a.sun1"), ["+clouds a.clouds.sun1", "sun1 -> sun2 a.sun2"]);
        assert_eq!(changes("a.clouds.sun1"), ["-clouds a.sun1"]);
        assert_eq!(changes("b.sun2"), ["b -> a a.sun2"]);
        for (key, neighbours_of_key) in &neighbours {
            assert!(neighbours_of_key.iter().all(|n| neighbours[n.key].iter().any(|back| back.key == *key)), "{key}");
        }
    }
}
