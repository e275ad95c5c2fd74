//! Sets of keys to test with: the nominal space, covering arrays over it, samples of it.

use super::dimension::DIMENSIONS;
use super::{ShaderKey, canonical};
use crate::scene::draw::{Flags, MapSet, Needs, PixelView, Shape, Surface};
use std::collections::{BTreeSet, HashSet};

/// How many combinations of dimension values there are, meaningful or not.
pub fn nominal_size() -> u64 {
    DIMENSIONS.iter().map(|d| d.texts.len() as u64).product()
}

/// Combination number `index` of the nominal space, mixed-radix over the table.
fn nominal(mut index: u64) -> Needs {
    let mut needs = Needs {
        surface: Surface::Lambert,
        maps: MapSet::default(),
        lights: 0,
        shape: Shape::Sphere,
        flags: Flags::default(),
        view: PixelView::Shaded,
    };
    for d in DIMENSIONS {
        let radix = d.texts.len() as u64;
        (d.set)(&mut needs, (index % radix) as usize);
        index /= radix;
    }
    needs
}

/// Every combination of dimension values.
pub fn nominal_needs() -> impl Iterator<Item = Needs> {
    (0..nominal_size()).map(nominal)
}

/// Every combination that some combination reduces to, each once, in order.
pub fn canonical_needs() -> BTreeSet<Needs> {
    nominal_needs().map(|n| canonical(&n)).collect()
}

/// `count` keys of combinations drawn at random; the same seed gives the same keys.
pub fn sample(seed: u64, count: usize) -> Vec<ShaderKey> {
    // SplitMix64 (Steele, Lea, Flood 2014).
    let mut state = seed;
    let mut next = move || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    };
    (0..count).map(|_| ShaderKey::for_draw(&nominal(next() % nominal_size()))).collect()
}

/// Every choice of `t` dimensions out of `count`, ascending.
fn choices(count: usize, t: usize) -> Vec<Vec<usize>> {
    if t == 0 {
        return vec![Vec::new()];
    }
    (t - 1..count)
        .flat_map(|last| {
            choices(last, t - 1).into_iter().map(move |mut c| {
                c.push(last);
                c
            })
        })
        .collect()
}

/// The combinations of `t` dimension values in these needs, as (choice number, values).
fn combinations(needs: &Needs, choices: &[Vec<usize>]) -> Vec<(u32, u64)> {
    let values: Vec<u64> = DIMENSIONS.iter().map(|d| (d.get)(needs) as u64).collect();
    choices.iter().enumerate().map(|(i, c)| (i as u32, c.iter().fold(0, |packed, d| packed << 8 | values[*d]))).collect()
}

/// Keys in which every combination of any `t` dimension values occurs that occurs in any key at all.
///
/// Greedy: the key with the most combinations still missing comes next, the least of equals; so the set is the same every time. All canonical
/// keys are candidates, which is exact while they can be listed (some thousand today).
pub fn covering(t: usize) -> Vec<ShaderKey> {
    let choices = choices(DIMENSIONS.len(), t.min(DIMENSIONS.len()));
    let candidates: Vec<(Needs, Vec<(u32, u64)>)> = canonical_needs().into_iter().map(|n| (n, combinations(&n, &choices))).collect();
    let mut missing: HashSet<(u32, u64)> = candidates.iter().flat_map(|(_, c)| c.iter().copied()).collect();
    // What a candidate adds only shrinks, so an old count is an upper bound: recount the most promising until it stays on top.
    let mut queue: std::collections::BinaryHeap<(usize, std::cmp::Reverse<usize>)> =
        candidates.iter().enumerate().map(|(i, (_, c))| (c.len(), std::cmp::Reverse(i))).collect();
    let mut chosen = BTreeSet::new();
    while !missing.is_empty() {
        let Some((promised, std::cmp::Reverse(i))) = queue.pop() else { break };
        let adds = candidates[i].1.iter().filter(|c| missing.contains(c)).count();
        if adds == promised && adds > 0 {
            candidates[i].1.iter().for_each(|c| {
                missing.remove(c);
            });
            chosen.insert(ShaderKey { needs: candidates[i].0 });
        } else if adds > 0 {
            queue.push((adds, std::cmp::Reverse(i)));
        }
    }
    chosen.into_iter().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nominal_space_holds_each_combination_once() {
        let all: BTreeSet<Needs> = nominal_needs().collect();
        assert_eq!(all.len() as u64, nominal_size());
        assert_eq!(nominal_size(), 5 * 16 * 4 * 3 * 8 * 6, "surfaces, maps, lights, shapes, flags, views");
    }

    #[test]
    fn every_pair_and_triple_occurs() {
        for t in [1, 2, 3] {
            let choices = choices(DIMENSIONS.len(), t);
            let set = covering(t);
            let covered: HashSet<_> = set.iter().flat_map(|k| combinations(k.needs(), &choices)).collect();
            for needs in canonical_needs() {
                assert!(combinations(&needs, &choices).iter().all(|c| covered.contains(c)), "{needs:?}");
            }
            assert!(set.len() < canonical_needs().len(), "a covering set is smaller than all");
            assert_eq!(set, covering(t));
        }
    }

    #[test]
    fn a_seed_fixes_the_sample() {
        assert_eq!(sample(7, 50), sample(7, 50));
        assert_ne!(sample(7, 50), sample(8, 50));
    }
}
