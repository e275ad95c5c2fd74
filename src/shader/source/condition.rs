//! The conditions of `@if` and `@elif`: features and predicates (named conditions, see `predicates`) joined by `!`, `&&` and `||`.
//!
//! In: the text between the parentheses. Out: [`Condition`], which is evaluated for a [`FeatureSet`]. Always: every name in it is a
//! feature or a predicate.

use super::predicates::PREDICATES;
use crate::shader::key::DIMENSIONS;
use crate::wording::did_you_mean;
use std::collections::HashMap;
use std::sync::LazyLock;
use wgsl_parse::syntax::{BinaryOperator, Expression, ExpressionNode, LiteralExpression, UnaryOperator};

/// The names of the features of all dimensions, each once. There are at most 128, the number of bits of [`FeatureSet`].
static FEATURE_NAMES: LazyLock<Vec<&'static str>> = LazyLock::new(|| {
    let mut all: Vec<&'static str> = Vec::new();
    for feature in DIMENSIONS.iter().flat_map(|d| d.feature_names).filter(|f| !f.is_empty()) {
        if !all.contains(feature) {
            all.push(feature);
        }
    }
    all
});

/// The meaning of each identifier in a condition.
static NAMES: LazyLock<HashMap<String, Condition>> = LazyLock::new(|| {
    let features = FEATURE_NAMES.iter().enumerate().map(|(index, name)| (wesl_identifier(name), Condition::Feature(index)));
    let predicates = PREDICATES.iter().enumerate().map(|(index, p)| (p.name.to_owned(), Condition::Predicate(index)));
    features.chain(predicates).collect()
});

/// The parsed conditions of [`PREDICATES`], in the same order.
static PREDICATE_CONDITIONS: LazyLock<Vec<Condition>> = LazyLock::new(|| {
    // An invalid condition in the table becomes a condition that never holds; the unit tests detect it.
    PREDICATES.iter().map(|p| Condition::parse(p.condition).unwrap_or(Condition::Constant(false))).collect()
});

/// Spelling of a feature in WESL: `air.pixel-8` is `air_pixel_8`.
pub fn wesl_identifier(feature: &str) -> String {
    feature.replace(['.', '-'], "_")
}

/// The features that a key switches on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FeatureSet(u128);

impl FeatureSet {
    /// The set of the features with these names; unknown names are ignored.
    pub fn of(names: &[&str]) -> Self {
        let mask = |name: &&str| FEATURE_NAMES.iter().position(|f| f == name).map_or(0, |index| 1_u128 << index);
        Self(names.iter().map(mask).fold(0, |all, mask| all | mask))
    }

    /// `index`: into [`FEATURE_NAMES`].
    fn has(self, index: usize) -> bool {
        self.0 & (1 << index) != 0
    }
}

/// Every name that a condition may use (features as WESL identifiers, and predicates), with its value for these features: the flags for another
/// WESL compiler.
pub fn values_of_names(features: FeatureSet) -> impl Iterator<Item = (&'static str, bool)> {
    NAMES.iter().map(move |(name, condition)| (name.as_str(), condition.holds(features)))
}

/// A condition over the features of a key.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Condition {
    Constant(bool),
    /// Index into `FEATURE_NAMES`.
    Feature(usize),
    /// Index into `PREDICATES`.
    Predicate(usize),
    Not(Box<Condition>),
    /// `&&`.
    And(Box<Condition>, Box<Condition>),
    /// `||`.
    Or(Box<Condition>, Box<Condition>),
}

impl Condition {
    /// # Errors
    /// A syntax error, or a name that is neither a feature nor a predicate.
    pub fn parse(text: &str) -> Result<Self, String> {
        // Most conditions are one name and need no parser.
        if let Some(known) = NAMES.get(text.trim()) {
            return Ok(known.clone());
        }
        let expression: Expression = text.parse().map_err(|e: wgsl_parse::Error| e.error.to_string())?;
        Self::of(&expression)
    }

    fn of(expression: &Expression) -> Result<Self, String> {
        let inner = |node: &ExpressionNode| Self::of(node.node()).map(Box::new);
        match expression {
            Expression::Literal(LiteralExpression::Bool(value)) => Ok(Self::Constant(*value)),
            Expression::Parenthesized(p) => Self::of(p.expression.node()),
            Expression::Unary(u) if u.operator == UnaryOperator::LogicalNegation => Ok(Self::Not(inner(&u.operand)?)),
            Expression::Binary(b) if b.operator == BinaryOperator::ShortCircuitAnd => Ok(Self::And(inner(&b.left)?, inner(&b.right)?)),
            Expression::Binary(b) if b.operator == BinaryOperator::ShortCircuitOr => Ok(Self::Or(inner(&b.left)?, inner(&b.right)?)),
            Expression::TypeOrIdentifier(t) if t.path.is_none() && t.template_args.is_none() => Self::named(&t.ident.name()),
            other => Err(format!("`{other}` is not a condition; use features, predicates, `!`, `&&`, `||` and parentheses")),
        }
    }

    fn named(name: &str) -> Result<Self, String> {
        NAMES.get(name).cloned().ok_or_else(|| {
            let near = did_you_mean(name, NAMES.keys().map(String::as_str)).map_or(String::new(), |near| format!("; {near}"));
            format!("`{name}` is neither a feature nor a predicate{near}")
        })
    }

    pub fn holds(&self, features: FeatureSet) -> bool {
        match self {
            Self::Constant(value) => *value,
            Self::Feature(index) => features.has(*index),
            Self::Predicate(index) => PREDICATE_CONDITIONS[*index].holds(features),
            Self::Not(c) => !c.holds(features),
            Self::And(a, b) => a.holds(features) && b.holds(features),
            Self::Or(a, b) => a.holds(features) || b.holds(features),
        }
    }

    /// Why the condition holds or fails, for the source map: the features that are on, then `not` and those that are off. Of the terms of `&&`, the first false
    /// one is the reason; if all hold, the last one, which by convention is the most specific. Of the terms of `||`, the first true one is the reason; if none
    /// holds, all of them.
    pub fn reason(&self, features: FeatureSet) -> String {
        let mut names = ReasonNames::default();
        self.add_names(features, &mut names);
        names.text()
    }

    /// Adds the names that explain why the condition holds or fails.
    fn add_names(&self, features: FeatureSet, names: &mut ReasonNames) {
        let holds = self.holds(features);
        let on_or_off = if holds { &mut names.on } else { &mut names.off };
        match self {
            Self::Constant(value) => on_or_off.push(constant_name(*value)),
            Self::Feature(index) => on_or_off.push(FEATURE_NAMES[*index]),
            Self::Predicate(index) => PREDICATE_CONDITIONS[*index].add_names(features, names),
            Self::Not(c) => c.add_names(features, names),
            Self::And(a, b) => if a.holds(features) { b } else { a }.add_names(features, names),
            Self::Or(a, b) if holds => if a.holds(features) { a } else { b }.add_names(features, names),
            Self::Or(a, b) => {
                a.add_names(features, names);
                b.add_names(features, names);
            }
        }
    }
}

fn constant_name(value: bool) -> &'static str {
    if value { "true" } else { "false" }
}

/// The names that explain why a condition holds or fails.
#[derive(Default)]
struct ReasonNames {
    /// Features that are on, and the constant `true`.
    on: Vec<&'static str>,
    /// Features that are off, and the constant `false`.
    off: Vec<&'static str>,
}

impl ReasonNames {
    /// The features that are on, then one `not` before all that are off: `a, b, not c, d`.
    fn text(&self) -> String {
        let off = if self.off.is_empty() { String::new() } else { format!("not {}", self.off.join(", ")) };
        let on = self.on.join(", ");
        if on.is_empty() || off.is_empty() { on + &off } else { format!("{on}, {off}") }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Adds the features of a condition and the predicates that it uses by name.
    fn collect_indices(condition: &Condition, features: &mut Vec<usize>, predicates: &mut Vec<usize>) {
        match condition {
            Condition::Constant(_) => {}
            Condition::Feature(index) => features.push(*index),
            Condition::Predicate(index) => predicates.push(*index),
            Condition::Not(c) => collect_indices(c, features, predicates),
            Condition::And(a, b) | Condition::Or(a, b) => {
                collect_indices(a, features, predicates);
                collect_indices(b, features, predicates);
            }
        }
    }

    #[test]
    fn every_predicate_is_a_condition_over_features_and_no_name_has_two_meanings() {
        for p in PREDICATES {
            let condition = Condition::parse(p.condition).unwrap_or_else(|e| panic!("{}: {e}", p.name));
            let (mut features, mut predicates) = (Vec::new(), Vec::new());
            collect_indices(&condition, &mut features, &mut predicates);
            assert!(predicates.is_empty(), "{} uses another predicate", p.name);
            assert!(features.len() > 1, "{} is a feature with another name", p.name);
        }
        let nested = Condition::parse("lights_1 && !(lights_2 || has_air)").expect("a condition");
        let (mut features, mut predicates) = (Vec::new(), Vec::new());
        collect_indices(&nested, &mut features, &mut predicates);
        assert_eq!((features.len(), predicates.len()), (2, 1), "a predicate deep in a condition is found");
        assert_eq!(NAMES.len(), FEATURE_NAMES.len() + PREDICATES.len(), "two names have the same WESL identifier");
        assert!(FEATURE_NAMES.len() <= 128, "{} features need more bits", FEATURE_NAMES.len());
    }

    #[test]
    fn conditions_have_the_precedence_of_wgsl() {
        let on = FeatureSet::of(&["lights.1", "air.pixel-8"]);
        for (text, holds) in [
            ("lights_1", true),
            ("!lights_1", false),
            ("!(lights_1 && air_table)", true),
            ("(lights_2 || air_pixel_8) && lights_1", true),
            ("lights_2 || (lights_1 && air_table)", false),
            ("has_air && !loses_sunlight", true),
            ("true && !false", true),
        ] {
            assert_eq!(Condition::parse(text).expect(text).holds(on), holds, "{text}");
        }
        // The last one: WGSL does not allow `||` beside `&&` without parentheses.
        for invalid in
            ["", "lights_9", "lights_1 + 2", "lights_1 &&", "f(lights_1)", "lights_1 == lights_2", "lights_1 || lights_2 && lights_3"]
        {
            assert!(Condition::parse(invalid).is_err(), "{invalid}");
        }
        assert!(Condition::parse("light_1").is_err_and(|e| e.contains("lights_1")), "the nearest name is suggested");
    }

    /// The reason of a condition that holds or, as for an `@else`, does not hold.
    fn reason(text: &str, holds: bool, names_on: &[&str]) -> String {
        let (condition, on) = (Condition::parse(text).expect(text), FeatureSet::of(names_on));
        assert_eq!(condition.holds(on), holds, "{text}");
        condition.reason(on)
    }

    #[test]
    fn a_condition_that_holds_names_its_reason() {
        // `has_air`: any model of the air. `has_ring_shadow`: `ring_shadow_point_sun || ring_shadow_penumbra`.
        let on = ["lights.1", "air.pixel-8"];
        for (text, expected) in [
            ("has_air", "air.pixel-8"),
            ("lights_1 && !has_ring_shadow", "not ring-shadow.point-sun, ring-shadow.penumbra"),
            ("lights_2 || air_pixel_8 || lights_1", "air.pixel-8"),
            ("!!lights_1", "lights.1"),
            ("!false", "not false"),
            ("true", "true"),
            ("!(lights_1 && air_table)", "not air.table"),
            ("!(lights_2 || !lights_1)", "lights.1, not lights.2"),
        ] {
            assert_eq!(reason(text, true, &on), expected, "{text}");
        }
    }

    #[test]
    fn a_condition_that_fails_names_its_false_terms() {
        // In lib/air/at_limb.wesl, before an `@else`.
        let coarse = "reads_coarse_air && !clouds_fill_gaps";
        assert_eq!(reason(coarse, false, &["air.pixel-8"]), "not air-pass.read, air-pass.read-with-clouds");
        assert_eq!(reason(coarse, false, &["air-pass.read-with-clouds", "surface.cloud"]), "surface.cloud");
        for (text, expected) in [
            ("!lights_1", "lights.1"),
            ("!!lights_2", "not lights.2"),
            ("false", "not false"),
            ("!true", "true"),
            ("lights_1 && lights_2", "not lights.2"),
            ("lights_2 && lights_3", "not lights.2"),
            ("lights_3 || !lights_1", "lights.1, not lights.3"),
        ] {
            assert_eq!(reason(text, false, &["lights.1"]), expected, "{text}");
        }
    }
}
