//! The conditions of `@if` and `@elif`: features and predicates joined by `!`, `&&` and `||`.
//!
//! In: the text between the parentheses. Out: [`Condition`], which is evaluated for a [`FeatureSet`]. Always: every name in it is a
//! feature or a predicate.

use super::predicates::PREDICATES;
use crate::shader::key::DIMENSIONS;
use crate::wording::did_you_mean;
use std::collections::HashMap;
use std::sync::LazyLock;
use wgsl_parse::syntax::{BinaryOperator, Expression, ExpressionNode, LiteralExpression, UnaryOperator};

/// The names of the features of all dimensions, each once. At most 128, the bits of [`FeatureSet`].
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
    let features = FEATURE_NAMES.iter().enumerate().map(|(bit, name)| (identifier(name), Condition::Feature(bit)));
    let predicates = PREDICATES.iter().enumerate().map(|(k, p)| (p.name.to_owned(), Condition::Predicate(k)));
    features.chain(predicates).collect()
});

static PREDICATE_CONDITIONS: LazyLock<Vec<Condition>> = LazyLock::new(|| {
    // An invalid condition in the table becomes a condition that never holds; the unit tests detect it.
    PREDICATES.iter().map(|p| Condition::parse(p.condition).unwrap_or(Condition::Constant(false))).collect()
});

/// Spelling of a feature in WESL: `air.pixel-8` is `air_pixel_8`.
pub fn identifier(feature: &str) -> String {
    feature.replace(['.', '-'], "_")
}

/// The features that a key switches on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FeatureSet(u128);

impl FeatureSet {
    /// The set of the features with these names; unknown names are ignored.
    pub fn of(names: &[&str]) -> Self {
        let bit = |name: &&str| FEATURE_NAMES.iter().position(|f| f == name).map_or(0, |bit| 1_u128 << bit);
        Self(names.iter().map(bit).fold(0, |all, bit| all | bit))
    }

    fn has(self, bit: usize) -> bool {
        self.0 & (1 << bit) != 0
    }
}

/// Every name (features as identifiers, and predicates), and whether it holds for these features, in the form that a WESL compiler takes.
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
    All(Box<Condition>, Box<Condition>),
    /// `||`.
    Any(Box<Condition>, Box<Condition>),
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
            Expression::Binary(b) if b.operator == BinaryOperator::ShortCircuitAnd => Ok(Self::All(inner(&b.left)?, inner(&b.right)?)),
            Expression::Binary(b) if b.operator == BinaryOperator::ShortCircuitOr => Ok(Self::Any(inner(&b.left)?, inner(&b.right)?)),
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
            Self::Feature(bit) => features.has(*bit),
            Self::Predicate(k) => PREDICATE_CONDITIONS[*k].holds(features),
            Self::Not(c) => !c.holds(features),
            Self::All(a, b) => a.holds(features) && b.holds(features),
            Self::Any(a, b) => a.holds(features) || b.holds(features),
        }
    }

    /// The feature to which the source map attributes a condition that holds: that of the last term of `&&`, of the first true term of `||`.
    pub fn reason(&self, features: FeatureSet) -> String {
        match self {
            Self::Constant(value) => value.to_string(),
            Self::Feature(bit) => FEATURE_NAMES[*bit].to_owned(),
            Self::Predicate(k) => PREDICATE_CONDITIONS[*k].reason(features),
            Self::Not(c) => c.reason_against(),
            Self::All(_, b) => b.reason(features),
            Self::Any(a, b) => if a.holds(features) { a } else { b }.reason(features),
        }
    }

    /// The text to which the source map attributes a condition that does not hold: all its features.
    pub fn reason_against(&self) -> String {
        let mut names = Vec::new();
        self.collect_feature_names(&mut names);
        format!("not {}", names.join(", "))
    }

    fn collect_feature_names(&self, names: &mut Vec<&'static str>) {
        match self {
            Self::Constant(_) => {}
            Self::Feature(bit) => names.push(FEATURE_NAMES[*bit]),
            Self::Predicate(k) => PREDICATE_CONDITIONS[*k].collect_feature_names(names),
            Self::Not(c) => c.collect_feature_names(names),
            Self::All(a, b) | Self::Any(a, b) => {
                a.collect_feature_names(names);
                b.collect_feature_names(names);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_predicate_is_a_condition_over_features_and_no_name_has_two_meanings() {
        for p in PREDICATES {
            let condition = Condition::parse(p.condition).unwrap_or_else(|e| panic!("{}: {e}", p.name));
            let mut names = Vec::new();
            condition.collect_feature_names(&mut names);
            assert!(names.len() > 1, "{} is a feature with another name", p.name);
            assert!(!matches!(condition, Condition::Predicate(_)), "{}", p.name);
        }
        assert_eq!(NAMES.len(), FEATURE_NAMES.len() + PREDICATES.len(), "two names are written alike");
        assert!(FEATURE_NAMES.len() <= 128, "{} features need more bits", FEATURE_NAMES.len());
    }

    #[test]
    fn conditions_have_the_precedence_of_wgsl_and_name_their_reason() {
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
        let reason = |text: &str| Condition::parse(text).expect(text).reason(on);
        assert_eq!(reason("has_air"), "air.pixel-8");
        assert_eq!(reason("lights_1 && !has_ring_shadow"), "not ring-shadow.point-sun, ring-shadow.penumbra");
        for invalid in
            ["", "lights_9", "lights_1 + 2", "lights_1 &&", "f(lights_1)", "lights_1 == lights_2", "lights_1 || lights_2 && lights_3"]
        {
            assert!(Condition::parse(invalid).is_err(), "{invalid}");
        }
        assert!(Condition::parse("light_1").is_err_and(|e| e.contains("lights_1")), "the nearest name is suggested");
    }
}
