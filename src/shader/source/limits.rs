//! Limits for untrusted fragments (WESL files). Parsers, validators and lowerings recurse into nested syntax, and wgsl-parse 0.4 backtracks
//! at each `<`, so unlimited input could exhaust the stack or take forever.
//!
//! In: a fragment's text. Out: the first position that exceeds a limit. Always: the time is proportional to the text's length;
//! comments do not count. The shipped fragments stay far below the limits (brackets nest at most 7 deep; fewer than 200 bytes lie between two
//! separators). Not here: whether the text is WESL.

/// Maximum number of `<` without a matching `>` in a statement. At each `<`, wgsl-parse reads ahead to see whether it opens a template list. On the way it
/// does the same at each later `<`, so that every further `<` doubles the time.
const MAX_OPEN_ANGLES: usize = 12;
/// Maximum depth of nested brackets.
const MAX_DEPTH: usize = 64;
/// Maximum number of bytes, without blanks, of a part: the text between two separators (`;`, `,`, `{`, `}`). A sum of thousands of terms becomes a syntax tree
/// of that depth.
const MAX_PART_BYTES: usize = 4096;
/// Maximum number of bytes, without blanks, of the body of a function: the time that naga 30 takes grows with the square of the number of expressions,
/// to 20 s for a megabyte of statements.
const MAX_BODY_BYTES: usize = 1 << 17;
/// Maximum number of `else` that follow one `if`: the syntax tree nests each in the one before it.
const MAX_ELSE: usize = 64;

/// The text with its comments replaced by blanks of the same length.
fn without_comments(text: &str) -> Vec<u8> {
    // The line breaks of WGSL.
    let ends_line = |c: char| matches!(c, '\n' | '\u{b}' | '\u{c}' | '\r' | '\u{85}' | '\u{2028}' | '\u{2029}');
    let mut code = text.as_bytes().to_vec();
    let mut chars = text.char_indices().peekable();
    while let Some((start, c)) = chars.next() {
        // The second character of `//` or `/*`.
        let Some(second) = chars.peek().map(|(_, c)| *c).filter(|second| c == '/' && matches!(second, '/' | '*')) else { continue };
        chars.next();
        if second == '/' {
            while chars.next_if(|(_, c)| !ends_line(*c)).is_some() {}
        } else {
            // Block comments nest.
            let mut depth = 1;
            while depth > 0
                && let Some((_, c)) = chars.next()
            {
                match (c, chars.peek().map(|(_, c)| *c)) {
                    ('/', Some('*')) => depth += 1,
                    ('*', Some('/')) => depth -= 1,
                    _ => continue,
                }
                chars.next();
            }
        }
        let end = chars.peek().map_or(text.len(), |(end, _)| *end);
        code[start..end].fill(b' ');
    }
    code
}

/// The index of the first byte that exceeds a limit, and a message that names the limit; `None` if none is exceeded.
pub(super) fn first_exceeded_limit(text: &str) -> Option<(usize, String)> {
    let code = without_comments(text);
    let (mut open_angles, mut part_bytes, mut body_bytes) = (0, 0, 0);
    // Whether the outermost open bracket is `{`: that of a function or a structure.
    let mut in_body = false;
    // How many `else` the current chain of `if` and `else` has: outside all brackets, then in each open bracket, the innermost last. The length is the depth of
    // nesting plus 1.
    let mut else_counts = vec![0];
    for (position, byte) in code.iter().enumerate() {
        part_bytes = if byte.is_ascii_whitespace() { part_bytes } else { part_bytes + 1 };
        body_bytes = if byte.is_ascii_whitespace() { body_bytes } else { body_bytes + 1 };
        if else_counts.len() == 1 {
            (in_body, body_bytes) = (*byte == b'{', 0);
        }
        match byte {
            b'<' => open_angles += 1,
            b'>' => open_angles -= usize::from(open_angles > 0),
            b';' | b'{' | b'}' => (open_angles, part_bytes) = (0, 0),
            b',' => part_bytes = 0,
            _ => {}
        }
        match byte {
            b'(' | b'[' | b'{' => else_counts.push(0),
            b')' | b']' | b'}' if else_counts.len() > 1 => drop(else_counts.pop()),
            _ => {}
        }
        if *byte == b'}'
            && let Some(count) = else_counts.last_mut()
        {
            let else_follows = code[position + 1..].trim_ascii_start().starts_with(b"else");
            *count = if else_follows { *count + 1 } else { 0 };
        }
        let what = if open_angles > MAX_OPEN_ANGLES {
            format!("more than {MAX_OPEN_ANGLES} `<` are open in one statement")
        } else if else_counts.len() > MAX_DEPTH + 1 {
            format!("more than {MAX_DEPTH} brackets are nested")
        } else if part_bytes > MAX_PART_BYTES {
            format!("more than {MAX_PART_BYTES} bytes without a `;` or `,`")
        } else if in_body && body_bytes > MAX_BODY_BYTES {
            format!("more than {MAX_BODY_BYTES} bytes in one function")
        } else if else_counts.last().is_some_and(|count| *count > MAX_ELSE) {
            format!("more than {MAX_ELSE} `else` follow one `if`")
        } else {
            continue;
        };
        return Some((position, what));
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::fragments::FRAGMENTS;

    #[test]
    fn comments_do_not_count_and_hide_nothing() {
        let code = |text: &str| String::from_utf8(without_comments(text)).expect("UTF-8");
        assert_eq!(code("a // b\nc"), "a     \nc");
        assert_eq!(code("a/* b /* c */ d */e"), format!("a{}e", " ".repeat(17)));
        assert_eq!(code("a / b * c"), "a / b * c");
        // `é` has two bytes.
        assert_eq!(code("a //é\u{2028}b"), format!("a {}\u{2028}b", " ".repeat(4)));
        assert_eq!(code("a /* b"), "a     ");
        assert_eq!(code("/*/ a */b"), "        b");
        assert_eq!(code("//* a\nb"), "     \nb");
    }

    #[test]
    fn limits_are_exact() {
        // The position, and the third word of the message, which is the limit.
        let excess = |text: &str| {
            first_exceeded_limit(text).map(|(position, what)| (position, what.split_whitespace().nth(2).unwrap_or_default().to_owned()))
        };
        let number = |n: usize| n.to_string();
        for (unit, max) in [("(", MAX_DEPTH), ("f([", MAX_DEPTH / 2), ("{", MAX_DEPTH), ("vec2<", MAX_OPEN_ANGLES)] {
            assert_eq!(excess(&unit.repeat(max)), None, "{unit}");
            assert!(excess(&unit.repeat(max + 1)).is_some(), "{unit}");
            // Closing brackets inside comments do not count.
            assert!(excess(&format!("{unit}/* ))]]}}}}>> */").repeat(max + 1)).is_some(), "{unit}");
            assert!(excess(&format!("{unit}// ))]]}}>>\r").repeat(max + 1)).is_some(), "{unit}");
        }
        assert_eq!(excess(&"()[]{}".repeat(100_000)), None);
        assert_eq!(excess(&"x ".repeat(MAX_PART_BYTES)), None);
        assert_eq!(excess(&"x ".repeat(MAX_PART_BYTES + 1)), Some((2 * MAX_PART_BYTES, number(MAX_PART_BYTES))));
        assert_eq!(excess(&"x, ".repeat(100_000)), None);
        // `a;` has two bytes. Each function counts from 0.
        let function = |n: usize| format!("fn f() {{{}}}", "a; ".repeat(n));
        assert_eq!(excess(&function(MAX_BODY_BYTES / 2 - 1).repeat(3)), None);
        assert_eq!(excess(&function(MAX_BODY_BYTES / 2 + 1)).map(|(_, what)| what), Some(number(MAX_BODY_BYTES)));
        let chain = |n: usize| format!("if a {{}}{}", " else if b { if c {} }".repeat(n));
        assert_eq!(excess(&chain(MAX_ELSE)), None);
        assert!(excess(&chain(MAX_ELSE + 1)).is_some());
        assert_eq!(excess(&"if a {} else {}".repeat(1000)), None);
        for (name, text) in FRAGMENTS.iter() {
            assert_eq!(first_exceeded_limit(text), None, "{name}");
        }
    }
}
