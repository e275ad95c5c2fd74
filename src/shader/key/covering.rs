//! Sets of keys to test with: covering arrays over the nominal space, samples of it.
//!
//! The nominal space has some 10^10 combinations, so nothing here lists it. A combination of a few dimension values *can occur* when some
//! canonical features hold it; that is decided by completing it with [`skeletons`], the canonical features over the dimensions that rules look at.

use super::dimension::DIMENSIONS;
use super::{ShaderKey, canonical};
use crate::random::Random;
use crate::scene::draw::DrawFeatures;
use std::collections::BTreeSet;
use std::sync::OnceLock;

/// How many combinations of dimension values there are, meaningful or not.
pub fn nominal_size() -> u64 {
    DIMENSIONS.iter().map(|d| d.texts.len() as u64).product()
}

/// `count` combinations of dimension values drawn at random, meaningful or not; the same seed gives the same ones.
pub fn sample_features(seed: u64, count: usize) -> Vec<DrawFeatures> {
    let mut random = Random::new(seed);
    let one = |random: &mut Random| {
        let mut features = DrawFeatures::MINIMAL;
        DIMENSIONS.iter().for_each(|d| (d.set)(&mut features, random.below(d.texts.len())));
        features
    };
    (0..count).map(|_| one(&mut random)).collect()
}

/// `count` keys of combinations drawn at random; the same seed gives the same keys.
pub fn sample(seed: u64, count: usize) -> Vec<ShaderKey> {
    sample_features(seed, count).iter().map(ShaderKey::for_draw).collect()
}

/// Dimensions whose values decide what means something, each with the values that rules tell apart (the others behave like the last).
const DECIDING: [(&str, usize); 10] = [
    ("surface", 8),
    ("albedo", 2),
    ("lights", 3),
    ("occluders", 2),
    ("eclipse-model", 2),
    ("ring-shadow", 2),
    ("air", 2),
    ("shape", 3),
    ("alphatexture", 2),
    ("view", 10),
];

/// All canonical features over the deciding dimensions alone. Completing a combination with each of them decides whether it can occur.
fn skeletons() -> Vec<DrawFeatures> {
    let mut all = vec![DrawFeatures::MINIMAL];
    for (name, values) in DECIDING {
        let Some(dimension) = DIMENSIONS.iter().find(|d| d.name == name) else { continue };
        all = all
            .into_iter()
            .flat_map(|features| {
                (0..values).map(move |value| {
                    let mut with = features;
                    (dimension.set)(&mut with, value);
                    with
                })
            })
            .collect();
    }
    let distinct: BTreeSet<DrawFeatures> = all.iter().map(canonical).collect();
    distinct.into_iter().collect()
}

/// Some values, each with its dimension's number.
type Combination<'a> = [(usize, usize)];

fn with(mut features: DrawFeatures, values: &Combination<'_>) -> DrawFeatures {
    values.iter().for_each(|(d, value)| (DIMENSIONS[*d].set)(&mut features, *value));
    features
}

fn holds(features: &DrawFeatures, values: &Combination<'_>) -> bool {
    values.iter().all(|(d, value)| (DIMENSIONS[*d].get)(features) == *value)
}

/// Needs that hold these values and are canonical, from the first skeleton at or after `start` that allows it.
fn completed(skeletons: &[DrawFeatures], start: usize, values: &Combination<'_>) -> Option<DrawFeatures> {
    let (before, after) = skeletons.split_at(start);
    after.iter().chain(before).map(|s| with(*s, values)).find(|n| canonical(n) == *n)
}

/// Every choice of `t` dimensions out of `count`, ascending, with the place where its combinations start in one long list.
fn choices(count: usize, t: usize) -> (Vec<(Vec<usize>, usize)>, usize) {
    fn list(count: usize, t: usize) -> Vec<Vec<usize>> {
        if t == 0 {
            return vec![Vec::new()];
        }
        (t - 1..count)
            .flat_map(|last| {
                list(last, t - 1).into_iter().map(move |mut c| {
                    c.push(last);
                    c
                })
            })
            .collect()
    }
    let mut at = 0;
    let placed = list(count, t)
        .into_iter()
        .map(|c| {
            let start = at;
            at += c.iter().map(|d| DIMENSIONS[*d].texts.len()).product::<usize>();
            (c, start)
        })
        .collect();
    (placed, at)
}

/// Places of the combinations that these needs hold, one for each choice.
fn places<'a>(features: &DrawFeatures, choices: &'a [(Vec<usize>, usize)]) -> impl Iterator<Item = usize> + use<'a> {
    let values: Vec<usize> = DIMENSIONS.iter().map(|d| (d.get)(features)).collect();
    choices.iter().map(move |(c, start)| start + c.iter().fold(0, |place, d| place * DIMENSIONS[*d].texts.len() + values[*d]))
}

/// How many completions of a missing combination compete.
const TRIES: usize = 12;

/// Keys in which every combination of any `t` dimension values occurs that can occur in any key at all. In order; the same every time.
///
/// One combination after another (as AETG does, Cohen et al. 1997): of some random completions of the first that is missing, the one
/// that holds most missing ones is kept.
pub fn covering(t: usize) -> Vec<ShaderKey> {
    static KEPT: [OnceLock<Vec<ShaderKey>>; 4] = [const { OnceLock::new() }; 4];
    match KEPT.get(t) {
        Some(kept) => kept.get_or_init(|| covering_anew(t)).clone(),
        None => covering_anew(t),
    }
}

fn covering_anew(t: usize) -> Vec<ShaderKey> {
    let skeletons = skeletons();
    let mut random = Random::new(t as u64);
    let pairs = (t > 2).then(|| possible_pairs(&skeletons));
    let (choices, count) = choices(DIMENSIONS.len(), t.min(DIMENSIONS.len()));
    let mut covered = vec![false; count];
    let mut chosen = BTreeSet::new();
    for (choice, start) in &choices {
        let size: usize = choice.iter().map(|d| DIMENSIONS[*d].texts.len()).product();
        for offset in 0..size {
            if covered[start + offset] {
                continue;
            }
            let mut left = offset;
            let mut values: Vec<(usize, usize)> = Vec::new();
            for d in choice.iter().rev() {
                values.push((*d, left % DIMENSIONS[*d].texts.len()));
                left /= DIMENSIONS[*d].texts.len();
            }
            if pairs.as_ref().is_some_and(|possible| !possible(&values)) {
                continue;
            }
            let Some(features) =
                best_completion(&skeletons, &values, &mut random, |n| places(n, &choices).filter(|p| !covered[*p]).count())
            else {
                continue;
            };
            places(&features, &choices).for_each(|p| covered[p] = true);
            chosen.insert(ShaderKey { features });
        }
    }
    chosen.into_iter().collect()
}

/// Whether each two of some values can occur together: three that cannot pairwise cannot at all.
fn possible_pairs(skeletons: &[DrawFeatures]) -> impl Fn(&Combination<'_>) -> bool + use<> {
    let mut start = Vec::new();
    let mut count = 0;
    for d in DIMENSIONS {
        start.push(count);
        count += d.texts.len();
    }
    let mut possible = vec![true; count * count];
    for (a, da) in DIMENSIONS.iter().enumerate() {
        for b in 0..a {
            for va in 0..da.texts.len() {
                for vb in 0..DIMENSIONS[b].texts.len() {
                    let (i, j) = (start[a] + va, start[b] + vb);
                    let occurs = completed(skeletons, 0, &[(a, va), (b, vb)]).is_some();
                    (possible[i * count + j], possible[j * count + i]) = (occurs, occurs);
                }
            }
        }
    }
    move |values| {
        let index = |(d, v): &(usize, usize)| start[*d] + v;
        values.iter().enumerate().all(|(k, a)| values[..k].iter().all(|b| possible[index(a) * count + index(b)]))
    }
}

fn best_completion(
    skeletons: &[DrawFeatures],
    values: &Combination<'_>,
    random: &mut Random,
    adds: impl Fn(&DrawFeatures) -> usize,
) -> Option<DrawFeatures> {
    let mut best = completed(skeletons, random.below(skeletons.len()), values).map(|n| (adds(&n), n))?;
    for _ in 0..TRIES {
        let Some(mut features) = completed(skeletons, random.below(skeletons.len()), values) else { break };
        for d in DIMENSIONS.iter().filter(|d| !DECIDING.iter().any(|(name, _)| *name == d.name)) {
            (d.set)(&mut features, random.below(d.texts.len()));
        }
        // Among counts and models that rules do not tell apart, any will do.
        for (name, told_apart) in DECIDING {
            let Some(d) = DIMENSIONS.iter().find(|d| d.name == name) else { continue };
            if (d.get)(&features) + 1 == told_apart && d.texts.len() > told_apart {
                (d.set)(&mut features, told_apart - 1 + random.below(d.texts.len() + 1 - told_apart));
            }
        }
        let features = canonical(&with(features, values));
        if holds(&features, values) && adds(&features) > best.0 {
            best = (adds(&features), features);
        }
    }
    Some(best.1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn every_combination_that_any_sampled_key_holds_is_covered() {
        for t in [1, 2, 3] {
            let (choices, _) = choices(DIMENSIONS.len(), t);
            let set = covering(t);
            let covered: HashSet<usize> = set.iter().flat_map(|k| places(k.features(), &choices)).collect();
            for features in sample_features(40 + t as u64, 20_000).iter().map(canonical).chain(skeletons()) {
                assert!(places(&features, &choices).all(|p| covered.contains(&p)), "{features:?}");
            }
            assert!(set.iter().all(|k| canonical(k.features()) == *k.features()));
            assert_eq!(set, covering_anew(t));
        }
    }

    #[test]
    fn the_nominal_size_is_the_product_of_the_dimensions() {
        assert_eq!(nominal_size(), 8 * 64 * 5 * 3 * 4 * 25 * 2 * 3 * 2 * 3 * 24 * 3 * 8 * 10);
    }

    #[test]
    fn a_seed_fixes_the_sample() {
        assert_eq!(sample(7, 50), sample(7, 50));
        assert_ne!(sample(7, 50), sample(8, 50));
    }
}
