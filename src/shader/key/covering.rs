//! Sets of keys for tests: covering arrays and random samples of all combinations of dimension values.
//!
//! In: `t`, the number of dimensions whose combinations are to be covered, or a seed. Out: keys. All dimensions together have 4.2 * 10^12 combinations of
//! values ([`count_combinations`]), too many to list. Features are canonical if [`canonical()`], which removes what has no effect on the image, leaves them
//! unchanged; keys have only such features. A combination of values of a few dimensions is *possible* if some canonical features have these values; such
//! features are a *completion* of the combination. To find one, the values are set in each of the [`base_features`]: all canonical features that differ from
//! [`DrawFeatures::MINIMAL`] only in dimensions on which the canonical rules depend. The combination is possible if one of the results is canonical.

use super::dimension::DIMENSIONS;
use super::{ShaderKey, canonical};
use crate::random::Random;
use crate::scene::draw::DrawFeatures;
use std::collections::BTreeSet;
use std::sync::OnceLock;

/// Number of combinations of values of all dimensions, canonical or not.
pub fn count_combinations() -> u64 {
    DIMENSIONS.iter().map(|d| d.texts.len() as u64).product()
}

/// Number of values of the dimension with this index.
fn value_count(dimension: usize) -> usize {
    DIMENSIONS[dimension].texts.len()
}

/// `count` random combinations of values of all dimensions, canonical or not; the same seed gives the same combinations.
pub fn random_features(seed: u64, count: usize) -> Vec<DrawFeatures> {
    let mut random = Random::new(seed);
    let combination = |random: &mut Random| {
        let mut features = DrawFeatures::MINIMAL;
        DIMENSIONS.iter().for_each(|d| (d.set)(&mut features, random.below(d.texts.len())));
        features
    };
    (0..count).map(|_| combination(&mut random)).collect()
}

/// The keys of `count` random combinations, each reduced to its canonical features; the same seed gives the same keys.
pub fn random_keys(seed: u64, count: usize) -> Vec<ShaderKey> {
    random_features(seed, count).iter().map(ShaderKey::for_draw).collect()
}

/// The dimensions on which the canonical rules of other dimensions depend, each with a number of base values. These are its first values; only they occur in
/// [`base_features`], because the rules treat all further values like the last base value. The exception is the fifth value of `air-pass`, `coarsesunlight`,
/// which has rules of its own: [`completion`] finds features with it by setting it in base features without an air pass.
const RULE_DIMENSIONS: [(&str, usize); 12] = [
    ("surface", 8),
    ("albedo", 2),
    ("cloudshadow", 2),
    ("lights", 3),
    ("occluders", 2),
    ("eclipse-model", 2),
    ("ring-shadow", 2),
    ("air", 3),
    ("air-pass", 4),
    ("shape", 3),
    ("alphatexture", 2),
    ("view", 10),
];

/// All canonical features in which only [`RULE_DIMENSIONS`] vary, over their base values. A combination is possible if setting its values in one of them gives
/// canonical features.
fn base_features() -> Vec<DrawFeatures> {
    let mut all = vec![DrawFeatures::MINIMAL];
    for (name, base_value_count) in RULE_DIMENSIONS {
        let Some(dimension) = DIMENSIONS.iter().find(|d| d.name == name) else { continue };
        all = all
            .into_iter()
            .flat_map(|features| {
                (0..base_value_count).map(move |value| {
                    let mut extended = features;
                    (dimension.set)(&mut extended, value);
                    extended
                })
            })
            .collect();
    }
    let distinct: BTreeSet<DrawFeatures> = all.iter().map(canonical).collect();
    distinct.into_iter().collect()
}

/// A combination of values of some dimensions: pairs of an index into [`DIMENSIONS`] and a value of that dimension.
type Combination = [(usize, usize)];

fn with_values(mut features: DrawFeatures, values: &Combination) -> DrawFeatures {
    values.iter().for_each(|(d, value)| (DIMENSIONS[*d].set)(&mut features, *value));
    features
}

fn has_values(features: &DrawFeatures, values: &Combination) -> bool {
    values.iter().all(|(d, value)| (DIMENSIONS[*d].get)(features) == *value)
}

/// A completion of a combination: sets the combination's values in one of the base features after another, and returns the first result that is canonical. The
/// search begins at index `start` and wraps around. `None` if the combination is not possible.
fn completion(base_features: &[DrawFeatures], start: usize, values: &Combination) -> Option<DrawFeatures> {
    let (before, after) = base_features.split_at(start);
    after.iter().chain(before).map(|base| with_values(*base, values)).find(|f| canonical(f) == *f)
}

/// `t` of the dimensions, whose combinations of values are to be covered. Consecutive numbers, from 0, identify the combinations of all choices: first those of
/// the first choice.
struct Choice {
    /// Indices into [`DIMENSIONS`].
    dimensions: Vec<usize>,
    /// Number of the choice's first combination.
    first_number: usize,
}

impl Choice {
    /// Number of combinations of values of the chosen dimensions.
    fn combination_count(&self) -> usize {
        self.dimensions.iter().map(|d| value_count(*d)).product()
    }
}

/// Every choice of `t` of the first `count` dimensions, and the number of combinations of all choices.
fn choices(count: usize, t: usize) -> (Vec<Choice>, usize) {
    fn subsets(count: usize, t: usize) -> Vec<Vec<usize>> {
        if t == 0 {
            return vec![Vec::new()];
        }
        (t - 1..count)
            .flat_map(|last| {
                subsets(last, t - 1).into_iter().map(move |mut subset| {
                    subset.push(last);
                    subset
                })
            })
            .collect()
    }
    let mut next_number = 0;
    let choices = subsets(count, t)
        .into_iter()
        .map(|dimensions| {
            let choice = Choice { dimensions, first_number: next_number };
            next_number += choice.combination_count();
            choice
        })
        .collect();
    (choices, next_number)
}

/// Numbers of the combinations that these features contain, one for each choice.
fn combinations_of<'a>(features: &DrawFeatures, choices: &'a [Choice]) -> impl Iterator<Item = usize> + use<'a> {
    let values: Vec<usize> = DIMENSIONS.iter().map(|d| (d.get)(features)).collect();
    let offset = move |choice: &Choice| choice.dimensions.iter().fold(0_usize, |offset, d| offset * value_count(*d) + values[*d]);
    choices.iter().map(move |choice| choice.first_number + offset(choice))
}

/// Number of random completions with which the first completion of a combination is compared. More tries give fewer keys, but take longer.
const TRIES: usize = 12;

/// Keys that contain every possible combination of values of any `t` dimensions, sorted; the result is deterministic.
///
/// A greedy algorithm, like AETG (Cohen et al. 1997): of several random completions of the first uncovered combination, the one that covers
/// the most new combinations is chosen.
pub fn covering_keys(t: usize) -> Vec<ShaderKey> {
    // The index is `t`. Sets for t above 3 are not cached, because the program uses none.
    static COVERINGS: [OnceLock<Vec<ShaderKey>>; 4] = [const { OnceLock::new() }; 4];
    match COVERINGS.get(t) {
        Some(covering) => covering.get_or_init(|| compute_covering(t)).clone(),
        None => compute_covering(t),
    }
}

fn compute_covering(t: usize) -> Vec<ShaderKey> {
    let base_features = base_features();
    let mut random = Random::new(t as u64);
    // A search for a completion that finds none tries all base features; this test, a table of pairs, excludes combinations without a search.
    let test_of_pairs = (t > 2).then(|| pair_test(&base_features));
    let (choices, combination_count) = choices(DIMENSIONS.len(), t.min(DIMENSIONS.len()));
    let mut covered = vec![false; combination_count];
    let mut chosen = BTreeSet::new();
    for choice in &choices {
        for offset in 0..choice.combination_count() {
            if covered[choice.first_number + offset] {
                continue;
            }
            // The values are the digits of the combination's offset in a mixed radix, as in `combinations_of`.
            let mut rest = offset;
            let mut values: Vec<(usize, usize)> = Vec::new();
            for d in choice.dimensions.iter().rev() {
                values.push((*d, rest % value_count(*d)));
                rest /= value_count(*d);
            }
            if test_of_pairs.as_ref().is_some_and(|test| !test(&values)) {
                continue;
            }
            let Some(features) = best_completion(&base_features, &values, &mut random, |f| {
                combinations_of(f, &choices).filter(|number| !covered[*number]).count()
            }) else {
                // Not possible.
                continue;
            };
            combinations_of(&features, &choices).for_each(|number| covered[number] = true);
            chosen.insert(ShaderKey { features });
        }
    }
    chosen.into_iter().collect()
}

/// Returns a test of whether every pair of values in a combination is possible. A combination can be possible only if this holds.
fn pair_test(base_features: &[DrawFeatures]) -> impl Fn(&Combination) -> bool + use<> {
    // The values of all dimensions are numbered from 0, dimension after dimension; `first_number`: by dimension, the number of its first value.
    let mut first_number = Vec::new();
    let mut count = 0;
    for d in DIMENSIONS {
        first_number.push(count);
        count += d.texts.len();
    }
    let mut possible = vec![true; count * count];
    for (a, dimension_a) in DIMENSIONS.iter().enumerate() {
        for b in 0..a {
            for value_a in 0..dimension_a.texts.len() {
                for value_b in 0..value_count(b) {
                    let (i, j) = (first_number[a] + value_a, first_number[b] + value_b);
                    let occurs = completion(base_features, 0, &[(a, value_a), (b, value_b)]).is_some();
                    (possible[i * count + j], possible[j * count + i]) = (occurs, occurs);
                }
            }
        }
    }
    move |values| {
        let number = |(d, v): &(usize, usize)| first_number[*d] + v;
        values.iter().enumerate().all(|(k, a)| values[..k].iter().all(|b| possible[number(a) * count + number(b)]))
    }
}

/// Of several random completions of a combination, the one with the greatest `count_new`: the number of combinations that no earlier key covers. `None` if the
/// combination is not possible.
fn best_completion(
    base_features: &[DrawFeatures],
    values: &Combination,
    random: &mut Random,
    count_new: impl Fn(&DrawFeatures) -> usize,
) -> Option<DrawFeatures> {
    let mut best = completion(base_features, random.below(base_features.len()), values)?;
    let mut best_count = count_new(&best);
    for _ in 0..TRIES {
        // The first search found a completion, so this one does too.
        let Some(mut features) = completion(base_features, random.below(base_features.len()), values) else { break };
        for d in DIMENSIONS.iter().filter(|d| !RULE_DIMENSIONS.iter().any(|(name, _)| *name == d.name)) {
            (d.set)(&mut features, random.below(d.texts.len()));
        }
        // The rules do not distinguish a rule dimension's last base value from the further values, so one of all these is chosen.
        for (name, base_value_count) in RULE_DIMENSIONS {
            let Some(d) = DIMENSIONS.iter().find(|d| d.name == name) else { continue };
            if (d.get)(&features) + 1 == base_value_count && d.texts.len() > base_value_count {
                (d.set)(&mut features, base_value_count - 1 + random.below(d.texts.len() + 1 - base_value_count));
            }
        }
        let features = canonical(&with_values(features, values));
        if has_values(&features, values) && count_new(&features) > best_count {
            best_count = count_new(&features);
            best = features;
        }
    }
    Some(best)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn every_combination_in_a_sampled_key_is_covered() {
        for t in [1, 2, 3] {
            let (choices, _) = choices(DIMENSIONS.len(), t);
            let set = covering_keys(t);
            let covered: HashSet<usize> = set.iter().flat_map(|k| combinations_of(k.features(), &choices)).collect();
            for features in random_features(40 + t as u64, 20_000).iter().map(canonical).chain(base_features()) {
                assert!(combinations_of(&features, &choices).all(|number| covered.contains(&number)), "{features:?}");
            }
            assert!(set.iter().all(|k| canonical(k.features()) == *k.features()));
            assert_eq!(set, compute_covering(t));
        }
    }

    #[test]
    fn the_number_of_combinations_is_the_product_of_the_dimensions() {
        // Surface; five maps; detail; custom surface; overlays; lights; occluders and eclipse model; limb heights and thin limb; ring shadow; ring-shine; body
        // shadow; air model, mie and absorption; air pass; shape; three flags; view.
        assert_eq!(count_combinations(), 8 * 32 * 4 * 5 * 3 * 4 * 25 * 4 * 4 * 2 * 3 * 24 * 5 * 3 * 8 * 10);
    }

    #[test]
    fn a_seed_fixes_the_sample() {
        assert_eq!(random_keys(7, 50), random_keys(7, 50));
        assert_ne!(random_keys(7, 50), random_keys(8, 50));
    }
}
