//! Finds minor planets and comets by what people and other programs call them.
//!
//! In: a name, a number, or a designation, packed or not (the Minor Planet Center's "Packed Provisional and Permanent Designations"). Out: the body of the
//! catalog or of its tables, or an error that suggests another name. Case does not matter, except in packed designations; nor whether a space, hyphen or
//! underscore separates words. Not here: barycentres and NAIF codes of the catalog's bodies (`Catalog::find_body_or_barycenter`).

use super::SmallBody;
use crate::catalog::{Catalog, NaifId, UnknownName, normalized_name};
use crate::wording::{did_you_mean, echo};

/// Something whose position is known: a body or barycentre of the catalog, or a minor planet or comet of its tables.
#[derive(Clone, Debug, PartialEq)]
pub enum NamedTarget {
    /// A body or barycentre of the catalog.
    Body(NaifId),
    /// A minor planet or a comet that is no body of the catalog.
    SmallBody(Box<SmallBody>),
}

/// Maximum number of bodies that a message about an ambiguous name lists.
const MAX_LISTED: usize = 5;

/// Value of a digit of the numbers in packed designations: 0 to 9, A (10) to Z, a (36) to z.
fn base_62(c: char) -> Option<u32> {
    match c {
        '0'..='9' => c.to_digit(10),
        'A'..='Z' => Some(u32::from(c) - u32::from('A') + 10),
        'a'..='z' => Some(u32::from(c) - u32::from('a') + 36),
        _ => None,
    }
}

/// The year and half-month of a packed provisional designation: `K07T` is 2007 T.
fn unpacked_half_month(packed: &str) -> Option<String> {
    let (year, half_month) = packed.split_at_checked(3)?;
    let (century, year) = year.split_at_checked(1)?;
    let century = base_62(century.chars().next()?).filter(|c| (18..=20).contains(c))?;
    let is_valid = year.bytes().all(|b| b.is_ascii_digit()) && half_month.len() == 1 && half_month.bytes().all(|b| b.is_ascii_uppercase());
    is_valid.then(|| format!("{century}{year} {half_month}"))
}

/// The number of an order within a half-month, from its two packed digits; the first may be a letter. It is left out if it is 0.
fn unpacked_order(packed: &str) -> Option<u32> {
    let mut digits = packed.chars();
    let (tens, ones) = (base_62(digits.next()?)?, digits.next()?.to_digit(10)?);
    Some(10 * tens + ones)
}

/// The plain form of a packed designation: `K07Tf8A` is 2007 TA418, `PLS2040` 2040 P-L, `A0001` 100001, `0001P` 1P, `CJ95O010` C/1995 O1. `None` for other
/// texts.
fn unpacked(text: &str) -> Option<String> {
    if !text.is_ascii() {
        return None;
    }
    let without_zeros = |digits: &str| digits.parse::<u32>().ok().filter(|_| digits.bytes().all(|b| b.is_ascii_digit()));
    match text.len() {
        // A number: of a minor planet, whose first digit may be a letter, or of a comet, with its type; four digits in base 62 after `~` count from 620 000.
        5 => {
            let (head, tail) = text.split_at(4);
            if let (Some(number), "P" | "D" | "I") = (without_zeros(head), tail) {
                return Some(format!("{number}{tail}"));
            }
            if let Some(digits) = text.strip_prefix('~') {
                let offset = digits.chars().try_fold(0, |sum, c| Some(62 * sum + base_62(c)?))?;
                return Some((620_000 + offset).to_string());
            }
            let (first, digits) = text.split_at(1);
            let first = first.chars().next().filter(char::is_ascii_alphabetic)?;
            Some((10_000 * base_62(first)? + without_zeros(digits)?).to_string())
        }
        7 => {
            let (head, tail) = text.split_at(3);
            if let (Some(survey), Some(_)) = (head.strip_suffix('S'), without_zeros(tail)) {
                // The surveys of Palomar and Leiden: P-L, T-1, T-2, T-3.
                return matches!(survey, "PL" | "T1" | "T2" | "T3").then(|| format!("{tail} {}-{}", &survey[..1], &survey[1..]));
            }
            let (order, letter) = (unpacked_order(&text[4..6])?, &text[6..]);
            let order = if order == 0 { String::new() } else { order.to_string() };
            let half_month = unpacked_half_month(&text[..4])?;
            letter.bytes().all(|b| b.is_ascii_uppercase()).then(|| format!("{half_month}{letter}{order}"))
        }
        // A comet with a provisional designation; the last place is 0 or the letter of a fragment.
        8 => {
            let (kind, order, fragment) = (&text[..1], unpacked_order(&text[5..7])?, &text[7..]);
            let half_month = unpacked_half_month(&text[1..5])?;
            let fragment = match fragment {
                "0" => String::new(),
                letter if letter.bytes().all(|b| b.is_ascii_lowercase()) => format!("-{}", letter.to_uppercase()),
                _ => return None,
            };
            matches!(kind, "C" | "P" | "D" | "X" | "A" | "I").then(|| format!("{kind}/{half_month}{order}{fragment}"))
        }
        _ => None,
    }
}

/// The number of a minor planet that is written so that it cannot be mistaken for the NAIF code of a planet: `(4)`, `(4) Vesta`, or as its own NAIF code,
/// 2000004 or 20000004.
fn unambiguous_number(name: &str) -> Option<u32> {
    let number = |digits: &str| digits.trim().parse::<u32>().ok();
    if let Some((bracketed, _)) = name.trim().strip_prefix('(').and_then(|rest| rest.split_once(')')) {
        return number(bracketed);
    }
    match number(name)? {
        code @ 2_000_001..=2_999_999 => Some(code - 2_000_000),
        code @ 20_000_001..=29_999_999 => Some(code - 20_000_000),
        _ => None,
    }
}

/// The form in which names are compared: a packed designation unpacked, brackets around a number dropped, leading zeros of a number alone dropped.
fn comparable(name: &str) -> String {
    let name = name.trim();
    if let Some(plain) = unpacked(name) {
        return normalized_name(&plain);
    }
    if !name.is_empty() && name.bytes().all(|b| b.is_ascii_digit()) {
        return name.trim_start_matches('0').to_owned();
    }
    match name.strip_prefix('(').and_then(|rest| rest.split_once(')')) {
        Some((number, rest)) if number.bytes().all(|b| b.is_ascii_digit()) => normalized_name(&format!("{number} {rest}")),
        _ => normalized_name(name),
    }
}

/// The words of a name: hyphens and underscores separate them, too.
fn words(name: &str) -> impl Iterator<Item = &str> {
    name.split(|c: char| c.is_whitespace() || c == '_' || c == '-').filter(|word| !word.is_empty())
}

/// Whether these words, in any case, are those of a name as [`comparable`] returns it.
fn are_words_of<'n>(mut found: impl Iterator<Item = &'n str>, wanted: &str) -> bool {
    let mut wanted = wanted.split(' ');
    let is_same = |a: &str, b: &str| a.chars().flat_map(char::to_lowercase).eq(b.chars());
    loop {
        match (found.next(), wanted.next()) {
            (None, None) => return true,
            (Some(a), Some(b)) if is_same(a, b) => {}
            _ => return false,
        }
    }
}

/// The parts of a name before its first bracket and within it; the second is empty without a bracket.
fn bracket_parts(name: &str) -> (&str, &str) {
    name.split_once('(').map_or((name.trim(), ""), |(before, rest)| (before.trim(), rest.trim_end().trim_end_matches(')').trim()))
}

/// Whether a body is called so. `wanted`: from [`comparable`]. It allocates nothing, because a table may have over a million bodies.
fn is_called(body: &SmallBody, wanted: &str) -> bool {
    let is = |name: &str| match unpacked(name) {
        Some(plain) => are_words_of(words(&plain), wanted),
        None => are_words_of(words(name), wanted),
    };
    let (designation, name) = (body.designation.as_str(), body.name.as_str());
    let is_number = !designation.is_empty() && designation.bytes().all(|b| b.is_ascii_digit());
    if is(designation) || is(name) || (is_number && designation.trim_start_matches('0') == wanted) {
        return true;
    }
    if are_words_of(words(designation).chain(words(name)), wanted) {
        return true;
    }
    // The parts of `1P/Halley`, `C/1995 O1 (Hale-Bopp)` and `433 Eros (A898 PA)`.
    let (before_bracket, in_brackets) = bracket_parts(name);
    let (before_slash, after_slash) = before_bracket.split_once('/').unwrap_or((before_bracket, ""));
    let number_and_name = before_bracket.split_once(' ').filter(|(number, _)| number.bytes().all(|b| b.is_ascii_digit()));
    let (number, bare_name) = number_and_name.unwrap_or_default();
    // The letter before the slash of `C/1995 O1` is no name.
    let has_number = before_slash.len() > 1;
    is(before_bracket) || is(in_brackets) || is(after_slash) || (has_number && is(before_slash)) || is(number) || is(bare_name)
}

impl SmallBody {
    /// The name without number and designation: `Pallas`, `Halley` of `1P/Halley`, `Hale-Bopp` of `C/1995 O1 (Hale-Bopp)`; empty without one.
    pub fn short_name(&self) -> &str {
        let (before_bracket, in_brackets) = bracket_parts(&self.name);
        match before_bracket.split_once('/') {
            Some(_) if !in_brackets.is_empty() => in_brackets,
            Some((number, name)) if number.len() > 1 => name,
            // A designation of a comet alone, such as `C/1995 O1`.
            Some(_) => "",
            // A provisional designation is in brackets, too, as in `433 Eros (A898 PA)`.
            None => before_bracket.trim_start_matches(|c: char| c.is_ascii_digit()).trim(),
        }
    }
}

/// Whether a name begins with `wanted` (from [`normalized_name`]); case does not matter, nor does a hyphen or underscore in place of a space.
#[cfg(feature = "view")]
fn begins_with(name: &str, wanted: &str) -> bool {
    let mut plain = name.chars().map(|c| if matches!(c, '-' | '_') { ' ' } else { c }).flat_map(char::to_lowercase);
    wanted.chars().all(|c| plain.next() == Some(c))
}

/// Fewest characters of a text that is looked up as the beginning of a name, and largest list in which all forms of a name are compared for each typed letter.
#[cfg(feature = "view")]
const MIN_LETTERS: usize = 3;
#[cfg(feature = "view")]
const MAX_COMPARED: usize = 20_000;

#[cfg(feature = "view")]
impl Catalog {
    /// Minor planets and comets for a search field, at most `max_count`: those that are called so, then those whose name or designation begins so, comets
    /// first.
    pub(crate) fn small_bodies_matching(&self, text: &str, max_count: usize) -> Vec<SmallBody> {
        let all = self.small_bodies();
        let count = all.minor_planets.len() + all.comets.len();
        let mut found = if count <= MAX_COMPARED { self.small_bodies_called(text) } else { Vec::new() };
        let wanted = normalized_name(text);
        if wanted.chars().count() >= MIN_LETTERS {
            let begins_so = |b: &&SmallBody| {
                [b.short_name(), b.name.as_str(), b.designation.as_str()].into_iter().any(|name| begins_with(name, &wanted))
            };
            let matching = all.comets.iter().chain(&all.minor_planets).filter(begins_so).take(max_count + found.len());
            let others: Vec<SmallBody> = matching.filter(|b| !found.contains(b)).cloned().collect();
            found.extend(others);
        }
        found.truncate(max_count);
        found
    }
}

impl Catalog {
    /// The minor planets and comets that are called so; usually at most one.
    fn small_bodies_called(&self, name: &str) -> Vec<SmallBody> {
        // Negative numbers are the NAIF codes of spacecraft; a minus sign is otherwise compared as a space.
        if name.trim().parse::<i64>().is_ok_and(|code| code < 0) {
            return Vec::new();
        }
        let wanted = match unambiguous_number(name) {
            Some(number) if !name.contains('(') => number.to_string(),
            _ => comparable(name),
        };
        let all = self.small_bodies();
        all.minor_planets.iter().chain(&all.comets).filter(|body| is_called(body, &wanted)).cloned().collect()
    }

    /// The body or barycentre of the catalog, or the minor planet or comet of its tables, with a name, number or designation. A number from 0 to 9, or one that
    /// is a body's NAIF code, is that code; `(4)` is always the minor planet.
    ///
    /// # Errors
    /// The name is unknown (the error suggests another), or it is that of several small bodies.
    pub fn target_named(&self, name: &str) -> Result<NamedTarget, UnknownName> {
        let bracketed = unambiguous_number(name).filter(|_| name.contains('('));
        match bracketed {
            // `1 Ceres` is an alias of Ceres.
            Some(number) => {
                let alias_start = format!("{number} ");
                let is_number = |alias: &String| alias.starts_with(&alias_start);
                if let Some(body) = self.bodies().iter().find(|b| b.aliases.iter().any(is_number)) {
                    return Ok(NamedTarget::Body(body.id));
                }
            }
            None => {
                if let Some(id) = self.find_body_or_barycenter(name) {
                    return Ok(NamedTarget::Body(id));
                }
            }
        }
        let mut found = self.small_bodies_called(name);
        let shown = echo(name.trim());
        match found.len() {
            0 => Err(self.unknown_target(&shown, name)),
            1 => Ok(NamedTarget::SmallBody(Box::new(found.remove(0)))),
            count => {
                let mut names: Vec<String> = found.iter().take(MAX_LISTED).map(SmallBody::full_name).collect();
                names.extend((count > MAX_LISTED).then(|| format!("and {} more", count - MAX_LISTED)));
                Err(UnknownName(format!("`{shown}` is the name of several: {}; give number or designation", names.join(", "))))
            }
        }
    }

    /// The error for an unknown name; it suggests names of bodies, minor planets and comets.
    fn unknown_target(&self, shown: &str, name: &str) -> UnknownName {
        let small = self.small_bodies();
        let of_small = small.minor_planets.iter().chain(&small.comets).flat_map(|b| {
            let short_name = b.short_name();
            // The name of most minor planets is short as it is; it is not compared twice.
            [b.name.as_str(), if short_name == b.name { "" } else { short_name }]
        });
        let of_catalog = self.bodies().iter().flat_map(|b| std::iter::once(&b.name).chain(&b.aliases)).map(String::as_str);
        // A suggestion differs by at most three edits, or continues the name: other lengths need not be compared. `nearest` ignores what is too long.
        let letters = name.trim().chars().count();
        let is_near = |known: &str| !known.is_empty() && known.chars().count() + 3 >= letters && (letters > 2 || known.len() < 6);
        let known = of_catalog.chain(of_small).filter(|known| is_near(known));
        let hint = did_you_mean(name.trim(), known).unwrap_or_else(|| "`orrery doctor` lists all bodies of the catalog".into());
        UnknownName(format!("no body, barycentre, minor planet or comet is called `{shown}`; {hint}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::small_bodies::SmallBodies;

    /// The examples of the Minor Planet Center's page on packed designations, and a comet with a fragment.
    #[test]
    fn packed_designations_are_unpacked() {
        for (packed, plain) in [
            ("J95X00A", "1995 XA"),
            ("J95X01L", "1995 XL1"),
            ("J95F13B", "1995 FB13"),
            ("J98SA8Q", "1998 SQ108"),
            ("J98SC7V", "1998 SV127"),
            ("J98SG2S", "1998 SS162"),
            ("K99AJ3Z", "2099 AZ193"),
            ("K08Aa0A", "2008 AA360"),
            ("K07Tf8A", "2007 TA418"),
            ("PLS2040", "2040 P-L"),
            ("T1S3138", "3138 T-1"),
            ("A0345", "100345"),
            ("a0017", "360017"),
            ("~0000", "620000"),
            ("~000z", "620061"),
            ("0001P", "1P"),
            ("CJ95O010", "C/1995 O1"),
            ("DI94R04b", "D/1894 R4-B"),
        ] {
            assert_eq!(unpacked(packed).as_deref(), Some(plain), "{packed}");
        }
        for other in ["Ceres", "Pallas", "Hygiea", "Minerva", "12345", "2001 FH", "Émile", "", "K07Tf8a", "Z07T18A", "Hale-Bop"] {
            assert_eq!(unpacked(other), None, "{other}");
        }
    }

    fn full_name(catalog: &Catalog, name: &str) -> String {
        match catalog.target_named(name) {
            Ok(NamedTarget::Body(id)) => format!("body {}", id.0),
            Ok(NamedTarget::SmallBody(body)) => body.full_name(),
            Err(e) => panic!("{name}: {e}"),
        }
    }

    #[test]
    fn small_bodies_are_found_by_name_number_and_designation() {
        let catalog = Catalog::embedded();
        for name in ["Pallas", "2 pallas", "(2)", "(2) Pallas", "2000002", "20000002"] {
            assert_eq!(full_name(&catalog, name), "2 Pallas", "{name}");
        }
        for name in ["433", "00433", "eros", "(433) Eros"] {
            assert_eq!(full_name(&catalog, name), "433 Eros", "{name}");
        }
        // A packed number, whose first digit may be a letter.
        assert_eq!(full_name(&catalog, "D6199"), full_name(&catalog, "136199"));
        for name in ["1P", "1p/halley", "Halley", "0001P"] {
            assert_eq!(full_name(&catalog, name), "1P/Halley", "{name}");
        }
        for name in ["C/1995 O1", "c/1995 o1 (hale-bopp)", "Hale-Bopp", "hale bopp", "1995 O1", "CJ95O010"] {
            assert_eq!(full_name(&catalog, name), "C/1995 O1 (Hale-Bopp)", "{name}");
        }
        // Bodies of the catalog come first: Europa is the moon, 2 the barycentre of Venus, 1 that of Mercury.
        for (name, id) in
            [("Ceres", 2_000_001), ("(1)", 2_000_001), ("(1) Ceres", 2_000_001), ("2000004", 2_000_004), ("Europa", 502), ("2", 2)]
        {
            assert_eq!(full_name(&catalog, name), format!("body {id}"), "{name}");
        }
        assert_eq!(full_name(&catalog, "52 Europa"), "52 Europa");
    }

    #[test]
    fn unknown_and_ambiguous_names_are_errors_in_one_line() {
        let catalog = Catalog::embedded();
        let error = |name: &str| catalog.target_named(name).expect_err(name).to_string();
        assert!(error("palas").contains("did you mean ") && error("palas").contains("`Pallas`"), "{}", error("palas"));
        assert!(error("haley").contains("`Halley`"), "{}", error("haley"));
        let panstarrs = error("PANSTARRS");
        assert!(panstarrs.contains("C/2011 L4 (PANSTARRS), C/2017 K2 (PANSTARRS)"), "{panstarrs}");
        for name in ["nibiru\n", "", "()", "(", "C", "P"] {
            let message = error(name);
            assert!(message.starts_with("no body") && !message.contains('\n'), "{message}");
        }
    }

    #[cfg(feature = "view")]
    #[test]
    fn a_search_field_finds_small_bodies_by_the_beginnings_of_their_names() {
        let catalog = Catalog::embedded();
        let found = |text: &str| -> Vec<String> { catalog.small_bodies_matching(text, 4).iter().map(SmallBody::full_name).collect() };
        for (text, name) in [
            ("hale-b", "C/1995 O1 (Hale-Bopp)"),
            ("Hale bopp", "C/1995 O1 (Hale-Bopp)"),
            ("halley", "1P/Halley"),
            ("1p", "1P/Halley"),
            ("c/2020 f", "C/2020 F3 (NEOWISE)"),
            ("palla", "2 Pallas"),
            ("433", "433 Eros"),
        ] {
            assert_eq!(found(text).first().map(String::as_str), Some(name), "{text}: {:?}", found(text));
        }
        // Comets first; no more than asked for, and none twice.
        assert_eq!(found("panstarrs"), ["C/2011 L4 (PANSTARRS)", "C/2017 K2 (PANSTARRS)"]);
        assert_eq!(found("halley").iter().filter(|name| *name == "1P/Halley").count(), 1);
        assert!(found("her").len() <= 4 && found("ha").is_empty() && found("").is_empty() && found("zz 9").is_empty());
        // Europa is a moon and a minor planet, Ceres a body of the catalog.
        assert_eq!((found("europa"), found("ceres")), (vec!["52 Europa".to_owned()], Vec::new()));
    }

    /// Names as JPL writes them in full: with the number, or with a designation in brackets.
    #[test]
    fn the_short_part_of_a_full_name_is_suggested() {
        let template = SmallBodies::embedded().minor_planets[0].clone();
        for (full, short, misspelt) in [
            ("99999 Erewhon (A898 PA)", "Erewhon", "erewhom"),
            ("C/1999 Z9 ( Nowhere )", "Nowhere", "nowhare"),
            ("999P/Utopia", "Utopia", "utopja"),
        ] {
            let body = SmallBody { designation: String::new(), name: full.into(), ..template.clone() };
            assert_eq!(body.short_name(), short, "{full}");
            let catalog = Catalog::embedded().with_small_bodies(Some(SmallBodies { minor_planets: vec![body], comets: Vec::new() }));
            assert_eq!(full_name(&catalog, short), full);
            let error = catalog.target_named(misspelt).expect_err(misspelt).to_string();
            assert!(error.contains(&format!("`{short}`")), "{error}");
        }
    }

    /// A table of MPCORB has packed designations where the readable one is missing.
    #[test]
    fn a_stored_packed_designation_is_found_by_its_plain_form() {
        let template = SmallBodies::embedded().minor_planets[0].clone();
        let packed = SmallBody { designation: "K07Tf8A".into(), name: String::new(), ..template };
        let supplied = SmallBodies { minor_planets: vec![packed], comets: Vec::new() };
        let catalog = Catalog::embedded().with_small_bodies(Some(supplied));
        for name in ["K07Tf8A", "2007 TA418", "2007 ta418"] {
            assert_eq!(full_name(&catalog, name), "K07Tf8A", "{name}");
        }
    }
}
