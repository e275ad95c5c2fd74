//! Warp meshes: the mapping from an image to a projector's (often curved) screen, in the text format of Paul Bourke.
//!
//! In: the text. Out: a [`WarpMesh`], or an error with the first invalid line. The format (<http://paulbourke.net/dataformats/meshwarp/>, 2006): a line
//! with the type, 2 rectangular or 1 polar; a line with the numbers of columns and rows; then, row by row, one node per line: `x y u v i`. x runs from
//! minus to plus the screen's aspect ratio and y from -1 (bottom) to 1 (top); u and v are 0 to 1 from the image's lower left corner; i is the
//! brightness, 0 to 1, and negative where nothing is drawn. Always: all cells that are drawn are convex and have the same orientation, so that no fold
//! lights a part of the screen twice; in a polar mesh the last column is joined to the first. Not supported: the binary form.

use crate::wording::without_byte_order_mark;
use glam::DVec2;

/// Maximum number of nodes of a mesh.
const MAX_NODES: usize = 1 << 20;

/// A node of the mesh: a position on the screen, and the position in the image that is shown there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WarpNode {
    /// Position on the screen: x in half heights from the middle (-aspect to aspect), y -1 to 1 upwards.
    pub screen: DVec2,
    /// Position in the image, 0 to 1 from its lower left corner.
    pub image: DVec2,
    /// Factor on the light; negative if the cells around the node are not drawn.
    pub brightness: f64,
}

/// A valid mesh: its nodes, and two triangles for each cell that is drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct WarpMesh {
    columns: usize,
    /// Row by row.
    nodes: Vec<WarpNode>,
    /// Indices into `nodes`, three per triangle.
    triangles: Vec<u32>,
}

/// An error in a mesh file, with the first invalid line.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{file}:{line}: {what}")]
pub struct WarpError {
    /// The file's name as given to [`WarpMesh::parse`].
    pub file: String,
    /// Line number, starting at 1.
    pub line: usize,
    /// What is wrong, and what is allowed.
    pub what: String,
}

/// Twice the area of a triangle, positive counter-clockwise.
fn twice_area(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

impl WarpMesh {
    /// Reads a mesh; `file` is named in error messages.
    ///
    /// # Errors
    /// The first invalid line.
    pub fn parse(file: &str, text: &str) -> Result<Self, WarpError> {
        let error_at = |line: usize, what: String| WarpError { file: file.to_owned(), line, what };
        let text = without_byte_order_mark(text);
        let mut lines = text.lines().enumerate().map(|(k, l)| (k + 1, l.trim())).filter(|(_, l)| !l.is_empty());
        let last_line = text.lines().count().max(1);
        let (line, kind) =
            lines.next().ok_or_else(|| error_at(last_line, "empty; the first line is the type, 2 rectangular or 1 polar".into()))?;
        let is_polar = match kind {
            "1" => true,
            "2" => false,
            _ => return Err(error_at(line, "the first line is the mesh's type, 2 rectangular or 1 polar".into())),
        };
        let (line, size) = lines.next().ok_or_else(|| error_at(last_line, "the second line is missing: columns and rows".into()))?;
        let size: Vec<Option<usize>> = size.split_whitespace().map(|word| word.parse().ok()).collect();
        let &[Some(columns), Some(rows)] = &size[..] else {
            return Err(error_at(line, "write the numbers of columns and rows, as 40 30".into()));
        };
        if columns < 2 || rows < 2 || columns.checked_mul(rows).is_none_or(|n| n > MAX_NODES) {
            return Err(error_at(line, format!("{columns} columns, {rows} rows: each at least 2, together at most {MAX_NODES} nodes")));
        }
        let mut nodes = Vec::with_capacity(columns * rows);
        let mut line_of_node = Vec::with_capacity(columns * rows);
        for (line, node_text) in lines {
            if nodes.len() == columns * rows {
                return Err(error_at(line, format!("one line too many: {columns} columns and {rows} rows have {} nodes", nodes.len())));
            }
            nodes.push(parse_node(node_text).map_err(|what| error_at(line, what))?);
            line_of_node.push(line);
        }
        if nodes.len() < columns * rows {
            let (rows_read, rest) = (nodes.len() / columns, nodes.len() % columns);
            let what = format!("ends after {rows_read} rows and {rest} nodes; {rows} rows of {columns} nodes were announced");
            return Err(error_at(last_line, what));
        }
        let mut triangles = Vec::new();
        let mut is_counter_clockwise: Option<bool> = None;
        let cells_per_row = if is_polar { columns } else { columns - 1 };
        for (row, column) in (0..rows - 1).flat_map(|r| (0..cells_per_row).map(move |c| (r, c))) {
            let next = (column + 1) % columns;
            let cell = [row * columns + column, row * columns + next, (row + 1) * columns + next, (row + 1) * columns + column];
            let [a, b, c, d] = cell.map(|k| nodes[k].screen);
            if cell.iter().any(|k| nodes[*k].brightness < 0.0) {
                continue;
            }
            // At all corners of a convex cell the outline turns to the same side. In the middle of a polar mesh a whole row of nodes is at one point, so
            // the cells there are triangles, and some of the corner areas are 0.
            let corner_areas = [twice_area(a, b, c), twice_area(b, c, d), twice_area(c, d, a), twice_area(d, a, b)];
            let (turns_left, turns_right) = (corner_areas.iter().any(|t| *t > 0.0), corner_areas.iter().any(|t| *t < 0.0));
            // Turns to both sides, to none, or to another side than in the other cells.
            let is_folded = turns_left == turns_right || is_counter_clockwise.is_some_and(|of_others| of_others != turns_left);
            if is_folded {
                let (row, column) = (row + 1, column + 1);
                let what = format!(
                    "the mesh folds: the cell of row {row}, column {column} overlaps a neighbour or has no area; correct its x and y"
                );
                return Err(error_at(line_of_node[cell[0]], what));
            }
            is_counter_clockwise = Some(turns_left);
            let [a, b, c, d] = cell.map(|k| k as u32);
            triangles.extend(if turns_left { [a, b, c, a, c, d] } else { [a, c, b, a, d, c] });
        }
        if triangles.is_empty() {
            return Err(error_at(last_line, "nothing is drawn: every cell has a node of brightness below 0".into()));
        }
        Ok(Self { columns, nodes, triangles })
    }

    /// The nodes, row by row.
    pub fn nodes(&self) -> &[WarpNode] {
        &self.nodes
    }

    /// Indices of nodes, three per triangle, counter-clockwise on the screen.
    pub fn triangles(&self) -> &[u32] {
        &self.triangles
    }

    /// Derivatives of the image position with respect to screen x and to screen y, in this order, at each node: the mean over the triangles around it; 0 where
    /// no triangle is.
    pub fn gradients(&self) -> Vec<[DVec2; 2]> {
        let mut sums = vec![([DVec2::ZERO; 2], 0.0); self.nodes.len()];
        for corners in self.triangles.chunks_exact(3) {
            let [a, b, c] = [corners[0], corners[1], corners[2]].map(|k| self.nodes[k as usize]);
            let [screen_b, screen_c] = [b.screen - a.screen, c.screen - a.screen];
            let [image_b, image_c] = [b.image - a.image, c.image - a.image];
            let determinant = screen_b.perp_dot(screen_c);
            if determinant == 0.0 {
                continue;
            }
            let derivatives =
                [(image_b * screen_c.y - image_c * screen_b.y) / determinant, (image_c * screen_b.x - image_b * screen_c.x) / determinant];
            for k in corners {
                let (sum, count) = &mut sums[*k as usize];
                *sum = [sum[0] + derivatives[0], sum[1] + derivatives[1]];
                *count += 1.0;
            }
        }
        sums.into_iter().map(|(s, n)| s.map(|v| if n > 0.0 { v / n } else { DVec2::ZERO })).collect()
    }

    /// The position in the image that is shown at a position on the screen; `None` outside the mesh.
    pub fn image_of_screen(&self, screen: DVec2) -> Option<DVec2> {
        self.map_point(screen, |n| n.screen, |n| n.image)
    }

    /// The position on the screen that shows a position in the image; `None` if there is none. If there are several, the first triangle of the mesh decides.
    pub fn screen_of_image(&self, image: DVec2) -> Option<DVec2> {
        self.map_point(image, |n| n.image, |n| n.screen)
    }

    /// Finds the first triangle that contains a point in the source space, and maps the point by its barycentric coordinates to the target space. `in_source`,
    /// `in_target`: a node's position in these spaces, of which one is the screen and the other the image.
    fn map_point(&self, point: DVec2, in_source: fn(&WarpNode) -> DVec2, in_target: fn(&WarpNode) -> DVec2) -> Option<DVec2> {
        self.triangles.chunks_exact(3).find_map(|corners| {
            let nodes = [corners[0], corners[1], corners[2]].map(|k| self.nodes[k as usize]);
            let [a, b, c] = [0, 1, 2].map(|k| in_source(&nodes[k]));
            let area = twice_area(a, b, c);
            let weights = [twice_area(point, b, c), twice_area(a, point, c), twice_area(a, b, point)].map(|w| w / area);
            // With this tolerance a point on an edge is in at least one of both triangles despite rounding. A triangle without area has infinite
            // weights.
            let is_inside = weights.iter().all(|w| *w >= -1e-9 && w.is_finite());
            is_inside.then(|| weights.iter().zip(&nodes).map(|(w, n)| in_target(n) * *w).sum())
        })
    }

    /// Image heights per screen unit where the screen magnifies the image most; the caller chooses the image's size by it. At each node, the magnitude of the
    /// derivative of the image position with respect to screen x or y, whichever is smaller, in image heights per screen unit. Result: the tenth percentile
    /// over the nodes with a magnitude above 0, and at least 0.001. Without such nodes 0.5, as in an undistorted mesh: the image's height over the screen's 2
    /// units. `aspect`: the image's width divided by its height.
    pub fn tenth_percentile_derivative(&self, aspect: f64) -> f64 {
        let smaller =
            |derivatives: [DVec2; 2]| derivatives.map(|v| (v * DVec2::new(aspect, 1.0)).length()).into_iter().fold(f64::MAX, f64::min);
        let mut all: Vec<f64> = self.gradients().into_iter().map(smaller).filter(|magnitude| *magnitude > 0.0).collect();
        all.sort_by(f64::total_cmp);
        all.get(all.len() / 10).copied().unwrap_or(0.5).max(1e-3)
    }

    /// A digest for provenance: FNV-1a over the nodes and the numbers of columns and triangles. By the number of triangles a polar mesh differs from a
    /// rectangular mesh of the same nodes.
    pub fn digest(&self) -> String {
        let numbers = self.nodes.iter().flat_map(|n| [n.screen.x, n.screen.y, n.image.x, n.image.y, n.brightness]);
        let counts = [self.columns as u64, (self.triangles.len() / 3) as u64];
        let bytes = counts.into_iter().flat_map(u64::to_le_bytes).chain(numbers.flat_map(f64::to_le_bytes));
        format!("{:016x}", bytes.fold(0xcbf2_9ce4_8422_2325_u64, |h, b| (h ^ u64::from(b)).wrapping_mul(0x100_0000_01b3)))
    }
}

/// Reads the line `x y u v i` of a node.
fn parse_node(text: &str) -> Result<WarpNode, String> {
    const FIELDS: [&str; 5] = ["x", "y", "u", "v", "i"];
    let mut numbers = [0.0; 5];
    let words: Vec<&str> = text.split_whitespace().collect();
    if words.len() != FIELDS.len() {
        return Err(format!("{} numbers; a node has five: x y u v i", words.len()));
    }
    for ((number, word), field) in numbers.iter_mut().zip(&words).zip(FIELDS) {
        *number = word.parse().ok().filter(|n: &f64| n.is_finite()).ok_or_else(|| {
            let shown: String = word.chars().filter(|c| !c.is_control()).take(20).collect();
            format!("field {field}: `{shown}` is not a number")
        })?;
    }
    let [x, y, u, v, brightness] = numbers;
    if brightness >= 0.0 && !((0.0..=1.0).contains(&u) && (0.0..=1.0).contains(&v)) {
        return Err(format!("fields u {u}, v {v}: must be 0 to 1"));
    }
    if brightness > 1.0 {
        return Err(format!("field i {brightness}: must be at most 1"));
    }
    // Far beyond any screen.
    if x.abs().max(y.abs()) > 1e3 {
        return Err(format!("fields x {x}, y {y}: must be within -1000 to 1000"));
    }
    Ok(WarpNode { screen: DVec2::new(x, y), image: DVec2::new(u, v), brightness })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A rectangular mesh file whose nodes are spaced evenly in the image. `place`: screen position of the node at an image position, both -1 to 1 if the mesh
    /// is undistorted.
    fn text(columns: usize, rows: usize, place: impl Fn(f64, f64) -> (f64, f64)) -> String {
        let mut text = format!("2\n{columns} {rows}\n");
        for (r, c) in (0..rows).flat_map(|r| (0..columns).map(move |c| (r, c))) {
            let (u, v) = (c as f64 / (columns - 1) as f64, r as f64 / (rows - 1) as f64);
            let (x, y) = place(2.0 * u - 1.0, 2.0 * v - 1.0);
            text.push_str(&format!("{x} {y} {u} {v} 1\n"));
        }
        text
    }

    #[test]
    fn a_mesh_is_read_and_its_gradients_are_those_of_its_map() {
        // The mesh is stretched horizontally and sheared.
        let mesh = WarpMesh::parse("m", &text(5, 4, |x, y| (1.5 * x + 0.2 * y, y))).expect("a mesh");
        // Each of the 4 x 3 cells has two triangles, hence six indices.
        assert_eq!((mesh.nodes().len(), mesh.triangles().len()), (20, 4 * 3 * 6));
        for [per_x, per_y] in mesh.gradients() {
            // u = (x - 0.2 y) / 3 + 1/2, v = y / 2 + 1/2.
            assert!((per_x - DVec2::new(1.0 / 3.0, 0.0)).length() < 1e-6 && (per_y - DVec2::new(-0.2 / 3.0, 0.5)).length() < 1e-6);
        }
        // Mirrored meshes, as used for rear projection, are not folds.
        assert!(WarpMesh::parse("m", &text(5, 4, |x, y| (-x, y))).is_ok());
        assert!(WarpMesh::parse("m", &format!("\u{feff}{}", text(5, 4, |x, y| (x, y)))).is_ok(), "a byte order mark does not count");
    }

    /// Four nodes on each of two circles. The rectangular mesh lacks the cell between the last column and the first: three cells of six indices, not four.
    #[test]
    fn a_polar_mesh_and_a_rectangular_mesh_of_the_same_nodes_differ_in_their_digests() {
        let nodes = "0.5 0 0 0 1\n0 0.5 0 0 1\n-0.5 0 0 0 1\n0 -0.5 0 0 1\n1 0 0 0 1\n0 1 0 0 1\n-1 0 0 0 1\n0 -1 0 0 1\n";
        let [polar, rectangular] = ["1", "2"].map(|kind| WarpMesh::parse("m", &format!("{kind}\n4 2\n{nodes}")).expect("a mesh"));
        assert_eq!((polar.nodes(), polar.triangles().len(), rectangular.triangles().len()), (rectangular.nodes(), 24, 18));
        assert_ne!(polar.digest(), rectangular.digest());
    }

    #[test]
    fn each_mistake_names_its_line() {
        let error_text = |text: &str| WarpMesh::parse("dome.data", text).expect_err("a mistake").to_string();
        let good = text(3, 3, |x, y| (x, y));
        assert!(error_text("").starts_with("dome.data:1: empty"));
        assert!(error_text("3\n2 2\n").starts_with("dome.data:1: the first line"));
        for size in ["2 two", "40 30 abc", "40 30 1.5", "40"] {
            assert!(error_text(&format!("2\n{size}\n")).starts_with("dome.data:2: write the numbers"), "{size}");
        }
        assert!(error_text("2\n1 9\n").starts_with("dome.data:2: 1 columns"));
        // Two lines precede the nine nodes; the last one that is left is the seventh.
        let cut: Vec<&str> = good.lines().take(9).collect();
        assert!(error_text(&cut.join("\n")).contains("dome.data:9: ends after 2 rows and 1 nodes; 3 rows of 3"));
        assert!(error_text(&format!("{good}0 0 0 0 1\n")).contains("dome.data:12: one line too many"));
        // The node in the middle of the image is the fifth.
        assert!(error_text(&good.replace("0.5 0.5 1", "0.5 x 1")).contains("dome.data:7: field v: `x` is not a number"));
        assert!(error_text(&good.replace("0.5 0.5 1", "0.5 1.5 1")).contains("dome.data:7: fields u 0.5, v 1.5"));
        assert!(error_text(&good.replace("0.5 0.5 1", "0.5 0.5")).contains("dome.data:7: 4 numbers"));
        // The middle node is moved beyond its right neighbour, so that the second cell of the first row is no longer convex.
        let folded = text(3, 3, |x, y| if (x, y) == (0.0, 0.0) { (1.4, 0.0) } else { (x, y) });
        assert!(error_text(&folded).contains("the mesh folds: the cell of row 1, column"), "{}", error_text(&folded));
        // The last column lies at x = 0, so the third cell folds back over the second. The cell's first node is on line 5.
        let turned = text(4, 2, |x, y| if x > 0.9 { (0.0, y) } else { (x, y) });
        assert!(error_text(&turned).contains("dome.data:5: the mesh folds: the cell of row 1, column 3"), "{}", error_text(&turned));
    }
}
