//! Parses a Wavefront OBJ file.
//!
//! In: the file's text. Out: its positions, texture coordinates, normals, colours and faces, with faces triangulated as fans and every index checked; or
//! the first wrong line, with its text and the allowed form. Supported are `v x y z`, `v x y z r g b`, `vt u v` (a third word is ignored), `vn x y z`
//! and `f`. Groups, materials, smoothing, lines and points are ignored; any other keyword is an error, so that a truncated file, or one in another format, is
//! not mistaken for a small shape. Not supported: curves, `v` with a weight, lines continued by a backslash.

use crate::wording::without_byte_order_mark;
use glam::{DVec2, DVec3};

/// Maximum number of positions, of texture coordinates, of normals and of triangles in one file: 4 million triangles take some 0.5 GB while the mesh is built.
pub(crate) const MAX_COUNT: usize = 4_000_000;
/// Maximum number of corners of a face; most files have 3 or 4.
pub(crate) const MAX_CORNERS: usize = 64;

/// A corner of a triangle: indices in the lists of [`Obj`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Corner {
    /// Index in [`Obj::positions`], and in [`Obj::colours`] if there are colours.
    pub position: u32,
    /// Index in [`Obj::texture_coordinates`], if the file gives one.
    pub texture: Option<u32>,
    /// Index in [`Obj::normals`], if the file gives one.
    pub normal: Option<u32>,
}

/// The content of a file. Lengths are in the file's own unit.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Obj {
    /// Vertex positions.
    pub positions: Vec<DVec3>,
    /// Vertex colours, sRGB, 0 to 1: one for each position, or none at all.
    pub colours: Vec<DVec3>,
    /// Texture coordinates: u to the right and v up from the map's lower left corner, 0 to 1 over the map.
    pub texture_coordinates: Vec<DVec2>,
    /// Vertex normals: unit vectors.
    pub normals: Vec<DVec3>,
    /// The faces, split into triangles; corners in the order of the file.
    pub triangles: Vec<[Corner; 3]>,
}

/// The first wrong line.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{line}: {message}")]
pub struct ObjError {
    /// Line number, starting at 1.
    pub line: usize,
    /// What is wrong, and what is allowed.
    pub message: String,
}

/// Keywords that do not affect the shape.
const IGNORED: [&str; 7] = ["o", "g", "s", "usemtl", "mtllib", "l", "p"];

/// Longest quotation of a line or word in a message, characters.
const MAX_QUOTED_CHARS: usize = 60;

/// A line or word, shortened for a message.
fn shortened(text: &str) -> String {
    let mut start: String = text.chars().take(MAX_QUOTED_CHARS).collect();
    if start.len() < text.len() {
        start.push('…');
    }
    start
}

/// Numbers of a valid file are smaller in magnitude. The limit is far above any length or texture coordinate, and far below what overflows in f32.
const NUMBER_LIMIT: f64 = 1e12;

/// Parses exactly `N` numbers of magnitude below [`NUMBER_LIMIT`]; `None` for any other words.
fn parse_numbers<const N: usize>(words: &[&str]) -> Option<[f64; N]> {
    let mut all = [0.0; N];
    if words.len() != N {
        return None;
    }
    for (number, word) in all.iter_mut().zip(words) {
        *number = word.parse::<f64>().ok().filter(|x| x.abs() < NUMBER_LIMIT)?;
    }
    Some(all)
}

/// Converts an index of the file (from 1, or negative from the end of a list of `length`) to an index from 0; `None` outside the list.
fn parse_index(word: &str, length: usize) -> Option<u32> {
    let n: i64 = word.parse().ok()?;
    let index = if n < 0 { i64::try_from(length).ok()? + n } else { n - 1 };
    usize::try_from(index).ok().filter(|index| *index < length && n != 0).and_then(|index| u32::try_from(index).ok())
}

impl Obj {
    /// Parses a corner of a face, such as `1/2/3`: its position, texture coordinate and normal. An empty texture coordinate counts as none, as in `1//3`.
    fn parse_corner(&self, word: &str) -> Result<Corner, String> {
        let mut parts = word.split('/');
        let lists = [("v", self.positions.len()), ("vt", self.texture_coordinates.len()), ("vn", self.normals.len())];
        let mut found = [None; 3];
        for (k, (name, length)) in lists.into_iter().enumerate() {
            found[k] = match parts.next() {
                None => None,
                Some("") if name == "vt" => None,
                Some(part) => Some(parse_index(part, length).ok_or_else(|| match length {
                    0 => format!("corner `{}` refers to a `{name}` that no earlier line defines", shortened(word)),
                    _ => format!("corner `{}`: expected a `{name}` from 1 to {length}, or from -{length} to -1", shortened(word)),
                })?),
            };
        }
        match (found, parts.next()) {
            ([Some(position), texture, normal], None) => Ok(Corner { position, texture, normal }),
            _ => Err(format!("corner `{}`: expected v, v/vt, v//vn or v/vt/vn", shortened(word))),
        }
    }

    /// Parses one line and adds what it defines. `rest`: the words after the keyword. `line`: the line without its comment, for messages.
    fn parse_line(&mut self, keyword: &str, rest: &[&str], line: &str) -> Result<(), String> {
        let expected = |what: &str| format!("`{}`: expected {what}", shortened(line));
        let check_count = |length: usize, what: &str| match length < MAX_COUNT {
            true => Ok(()),
            false => Err(format!("more than {MAX_COUNT} {what}, the most that are read")),
        };
        match keyword {
            "v" => {
                check_count(self.positions.len(), "`v`")?;
                let has_colour = rest.len() == 6;
                let position_words = if has_colour { &rest[..3] } else { rest };
                let position = parse_numbers::<3>(position_words)
                    .ok_or_else(|| expected(&format!("v x y z, or v x y z r g b, below {NUMBER_LIMIT:e}")))?;
                let others_have_colour = !self.colours.is_empty();
                if !self.positions.is_empty() && has_colour != others_have_colour {
                    return Err(expected("a colour at each `v` or at none"));
                }
                if has_colour {
                    let colour = parse_numbers::<3>(&rest[3..]).filter(|c| c.iter().all(|x| (0.0..=1.0).contains(x)));
                    self.colours.push(DVec3::from_array(colour.ok_or_else(|| expected("colours from 0 to 1"))?));
                }
                self.positions.push(DVec3::from_array(position));
            }
            "vt" => {
                check_count(self.texture_coordinates.len(), "`vt`")?;
                let uv_words = if rest.len() == 3 { &rest[..2] } else { rest };
                self.texture_coordinates.push(DVec2::from_array(parse_numbers::<2>(uv_words).ok_or_else(|| expected("vt u v"))?));
            }
            "vn" => {
                check_count(self.normals.len(), "`vn`")?;
                let normal = parse_numbers::<3>(rest).map(DVec3::from_array).and_then(DVec3::try_normalize);
                self.normals.push(normal.ok_or_else(|| expected("vn x y z, not all 0"))?);
            }
            "f" => {
                if !(3..=MAX_CORNERS).contains(&rest.len()) {
                    return Err(expected(&format!("a face of 3 to {MAX_CORNERS} corners")));
                }
                let corners = rest.iter().map(|w| self.parse_corner(w)).collect::<Result<Vec<_>, _>>()?;
                for pair in corners[1..].windows(2) {
                    check_count(self.triangles.len(), "triangles")?;
                    self.triangles.push([corners[0], pair[0], pair[1]]);
                }
            }
            _ if IGNORED.contains(&keyword) => {}
            _ => return Err(expected("v, vt, vn, f, o, g, s, usemtl, mtllib, l, p or a comment that starts with #")),
        }
        Ok(())
    }
}

/// Parses the text of a file.
///
/// # Errors
/// The first wrong line, or the last line if the file has no face.
pub fn parse(text: &str) -> Result<Obj, ObjError> {
    let mut obj = Obj::default();
    let mut last_line = 1;
    for (k, line) in without_byte_order_mark(text).lines().enumerate() {
        last_line = k + 1;
        let statement = line.split('#').next().unwrap_or_default().trim();
        let words: Vec<&str> = statement.split_whitespace().collect();
        if let Some((keyword, rest)) = words.split_first() {
            obj.parse_line(keyword, rest, statement).map_err(|message| ObjError { line: last_line, message })?;
        }
    }
    if obj.triangles.is_empty() {
        return Err(ObjError { line: last_line, message: "the file ends without a face: expected at least one `f`".into() });
    }
    Ok(obj)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_of_every_form_are_read() {
        let text = "# a square\nmtllib none.mtl\no it\nv 0 0 0 1 0.5 0\nv 1 0 0 1 1 1 # corner\n\nv 1 1 0 0 0 0\nv 0 1 0 0 1 0\nvt 0 0\nvt 1 0 0\n\
                    vn 0 0 2\ng part\ns off\nusemtl red\nf 1/1/1 2/2/1 3//1 -1\nf 1 2 3\nf 1//-1 2/-1 3\nl 1 2\np 1\n";
        let obj = parse(text).expect("reads");
        assert_eq!((obj.positions.len(), obj.colours.len(), obj.texture_coordinates.len(), obj.normals.len()), (4, 4, 2, 1));
        assert_eq!(parse(&format!("\u{feff}{text}")).as_ref(), Ok(&obj), "a byte order mark does not count");
        assert_eq!(obj.normals[0], DVec3::Z, "its length does not count");
        assert_eq!(obj.triangles.len(), 4, "a face of four corners gives two triangles, two of three give one each");
        let corner = |position, texture, normal| Corner { position, texture, normal };
        assert_eq!(obj.triangles[0], [corner(0, Some(0), Some(0)), corner(1, Some(1), Some(0)), corner(2, None, Some(0))]);
        assert_eq!(obj.triangles[1], [corner(0, Some(0), Some(0)), corner(2, None, Some(0)), corner(3, None, None)]);
        assert_eq!(obj.triangles[3], [corner(0, None, Some(0)), corner(1, Some(1), None), corner(2, None, None)]);
    }

    #[test]
    fn each_wrong_line_is_named_with_what_is_allowed() {
        let start = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
        let why = |line: &str| parse(&format!("{start}{line}\nf 1 2 3\n")).expect_err(line);
        for (line, says) in [
            ("v 1 2", "expected v x y z, or v x y z r g b"),
            ("v 1 2 3 1", "expected v x y z, or v x y z r g b"),
            ("v 1 2 nan", "expected v x y z, or v x y z r g b"),
            ("v 1 2 1e300", "expected v x y z, or v x y z r g b"),
            ("v 1 2 3 0 0 0", "a colour at each `v` or at none"),
            ("vt 1", "expected vt u v"),
            ("vn 0 0 0", "expected vn x y z, not all 0"),
            ("f 1 2", "expected a face of 3 to 64 corners"),
            ("f 1 2 4", "corner `4`: expected a `v` from 1 to 3, or from -3 to -1"),
            ("f 1 2 0", "corner `0`: expected a `v` from 1 to 3"),
            ("f 1 2 -4", "corner `-4`: expected a `v` from 1 to 3"),
            ("f 1/1 2 3", "refers to a `vt` that no earlier line defines"),
            ("f 1//1 2 3", "refers to a `vn` that no earlier line defines"),
            ("f 1/ 2 3/x", "refers to a `vt` that no earlier line defines"),
            // The first fault counts: the third part, here empty, must be a `vn`.
            ("f 1///2 2 3", "refers to a `vn` that no earlier line defines"),
            ("f / 2 3", "expected a `v` from 1 to 3"),
            ("curv 1 2", "expected v, vt, vn, f, o, g, s"),
            ("<html>", "expected v, vt, vn, f, o, g, s"),
        ] {
            let e = why(line);
            assert_eq!(e.line, 4, "{line}: {e}");
            assert!(e.message.contains(says) && !e.message.contains('\n'), "{line}: {e}");
        }
        assert!(parse("v 0 0 0 0.5 0.5 2\n").expect_err("a colour").message.contains("colours from 0 to 1"));
        assert_eq!(
            parse(start).expect_err("no face"),
            ObjError { line: 3, message: "the file ends without a face: expected at least one `f`".into() }
        );
        let long = why(&"x".repeat(500));
        // 60 characters of the line and about as many of the expected keywords.
        assert!(long.message.len() < 250, "{long}");
        assert_eq!(parse("").expect_err("empty").line, 1);
    }
}
