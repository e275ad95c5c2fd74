//! Splits a line of comma-separated values (RFC 4180, without line breaks in values), and finds columns by name, for all tables that users give.
//!
//! In: the line; the names of the columns. Out: its values as text; the columns of the caller's fields. Not here: the meaning of columns.

use std::borrow::Cow;

/// The values of a line, without their quotes and without spaces around them. Within quotes, a doubled quote means one quote. A quote inside an unquoted value
/// is an ordinary character.
pub(super) fn values(line: &str) -> Result<Vec<String>, String> {
    let (mut all, mut value, mut in_quotes) = (Vec::new(), String::new(), false);
    let mut chars = line.chars().peekable();
    while let Some(c) = chars.next() {
        match c {
            '"' if in_quotes && chars.peek() == Some(&'"') => {
                chars.next();
                value.push('"');
            }
            '"' if in_quotes => in_quotes = false,
            '"' if value.trim().is_empty() => in_quotes = true,
            ',' if !in_quotes => all.push(std::mem::take(&mut value).trim().to_owned()),
            _ => value.push(c),
        }
    }
    if in_quotes {
        return Err("a quoted value does not end on this line".to_owned());
    }
    all.push(value.trim().to_owned());
    Ok(all)
}

/// As [`values`]; those of a line without quotes are borrowed.
pub(super) fn borrowed_values(line: &str) -> Result<Vec<Cow<'_, str>>, String> {
    if line.contains('"') {
        return Ok(values(line)?.into_iter().map(Cow::Owned).collect());
    }
    // The exact capacity, because a table of stars has thousands of lines.
    let mut all = Vec::with_capacity(line.bytes().filter(|byte| *byte == b',').count() + 1);
    all.extend(line.split(',').map(|value| Cow::Borrowed(value.trim())));
    Ok(all)
}

/// A column's name in the form in which names are compared: only letters and digits, in lower case.
pub(super) fn comparable_name(name: &str) -> String {
    name.chars().filter(char::is_ascii_alphanumeric).map(|c| c.to_ascii_lowercase()).collect()
}

/// The index of each field's column; `None` if the table has none of the field's names. `names`: those of all columns. `accepted`: those of each field,
/// preferred ones first. The first that is in `names` is taken; of several columns of this name, the first. All names are in the form of
/// [`comparable_name`].
pub(super) fn columns_of_fields<const N: usize>(names: &[String], accepted: [&[&str]; N]) -> [Option<usize>; N] {
    accepted.map(|accepted| accepted.iter().find_map(|wanted| names.iter().position(|name| name == wanted)))
}

/// The index of the first column whose name a later column of the table has, too; only `columns` (indices of the fields' columns) are examined. `names`:
/// those of all columns.
pub(super) fn first_repeated(names: &[String], columns: &[Option<usize>]) -> Option<usize> {
    columns.iter().flatten().copied().find(|column| names[column + 1..].contains(&names[*column]))
}

/// Like [`columns_of_fields`], but an error if several columns have the name that is taken for a field, because it is unknown which of them is meant.
pub(super) fn unique_columns_of_fields<const N: usize>(names: &[String], accepted: [&[&str]; N]) -> Result<[Option<usize>; N], String> {
    let columns = columns_of_fields(names, accepted);
    first_repeated(names, &columns).map_or(Ok(columns), |column| Err(repeated_column(&names[column])))
}

/// The error message for a table in which several columns have this name.
pub(super) fn repeated_column(name: &str) -> String {
    format!("two columns are named `{name}` (only letters and digits count); leave one out")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_that_two_columns_have_is_an_error_if_it_is_taken() {
        let find = |names: &[&str]| {
            let names: Vec<String> = names.iter().map(|name| (*name).to_owned()).collect();
            unique_columns_of_fields(&names, [&["radeg", "ra"][..], &["vmag", "v"]])
        };
        assert_eq!(find(&["v", "ra", "radeg", "x", "x"]), Ok([Some(2), Some(0)]));
        assert_eq!(find(&["ra", "radeg", "ra"]), Ok([Some(1), None]), "`ra` does not count beside `radeg`");
        assert_eq!(find(&["radeg", "vmag", "v", "vmag"]), Err(repeated_column("vmag")));
    }

    #[test]
    fn only_a_quote_at_the_start_of_a_value_quotes_it() {
        for (line, expected) in [
            (r#""a, b",1"#, &["a, b", "1"][..]),
            (r#" "say ""hi""" , 2 "#, &[r#"say "hi""#, "2"]),
            (r#""",3"#, &["", "3"]),
            (r#"a 5" telescope,4"#, &[r#"a 5" telescope"#, "4"]),
        ] {
            assert_eq!(values(line).expect("values"), expected, "{line}");
        }
    }
}
