//! The CPU painter: rasterises egui's triangles into a window's pixels, without Vulkan, GL or any other graphics driver.
//!
//! In: tessellated meshes in points, textures as egui provides them. Out: opaque pixels, 0x00RRGGBB, row by row. Always: colours are
//! blended as egui specifies (premultiplied, in gamma space, `dst = src + dst (1 - a)`); vertices are rounded to 1/256 pixel and edges
//! follow the top-left rule, so that triangles with a common edge neither overlap nor leave gaps; the result does not depend on the number of
//! threads.

use crate::view::window::painter_texture::{OpaqueRows, PainterTexture, TexelPair, WideTexel};
use egui::epaint::{ImageDelta, Mesh, Primitive, Vertex};
use egui::{Color32, TextureId};
use rayon::prelude::*;
use std::collections::HashMap;

/// Number of pixel rows in a band, which one task paints.
const BAND_ROWS: usize = 64;
/// Vertex positions are in fixed point, with this number of subpixels per pixel.
const SUBPIXELS: i64 = 256;
/// Distance of a pixel's centre from its left or upper edge, subpixels.
const HALF_PX: i64 = SUBPIXELS / 2;
/// Vertices farther from the origin are clamped to this distance, pixels, so that products of two subpixel distances fit into an i64.
const MAX_COORDINATE_PX: f32 = 1_048_576.0;

/// Stores the interface's textures, and paints meshes with them.
#[derive(Default)]
pub struct Painter {
    textures: HashMap<TextureId, PainterTexture>,
}

/// The pixels to paint, `width * height` of them, row by row; each is 0x00RRGGBB.
pub struct Canvas<'a> {
    pub width: usize,
    pub height: usize,
    pub pixels: &'a mut [u32],
}

/// A rectangle of pixels outside which a mesh is not painted; right and bottom are exclusive.
#[derive(Clone, Copy)]
pub(crate) struct PixelBounds {
    pub left: usize,
    pub right: usize,
    pub top: usize,
    pub bottom: usize,
}

impl PixelBounds {
    /// The pixels of a clip rectangle in points, within a canvas of `width * height` pixels.
    pub(crate) fn of(rect: egui::Rect, pixels_per_point: f32, width: usize, height: usize) -> Self {
        let to_px = |v: f32, max: usize| ((v * pixels_per_point).round().max(0.0) as usize).min(max);
        Self {
            left: to_px(rect.min.x, width),
            right: to_px(rect.max.x, width),
            top: to_px(rect.min.y, height),
            bottom: to_px(rect.max.y, height),
        }
    }

    /// The part within the rows `first..end`; `None` if it is empty.
    fn within_rows(self, first: usize, end: usize) -> Option<Self> {
        let part = Self { top: self.top.max(first), bottom: self.bottom.min(end), ..self };
        (part.left < part.right && part.top < part.bottom).then_some(part)
    }
}

impl Painter {
    /// Stores a texture, or updates a part of a stored texture. An update that exceeds the texture is ignored.
    pub fn set_texture(&mut self, id: TextureId, delta: ImageDelta) {
        if delta.pos.is_none() {
            self.textures.insert(id, PainterTexture::new(delta));
        } else if let Some(texture) = self.textures.get_mut(&id) {
            texture.update(&delta);
        }
    }

    pub(crate) fn texture(&self, id: TextureId) -> Option<&PainterTexture> {
        self.textures.get(&id)
    }

    pub fn free_texture(&mut self, id: TextureId) {
        self.textures.remove(&id);
    }

    /// Paints the primitives over a black background. Primitives whose texture is unknown are skipped.
    pub fn paint(&self, canvas: &mut Canvas<'_>, pixels_per_point: f32, primitives: &[egui::ClippedPrimitive]) {
        let (width, height) = (canvas.width, canvas.height);
        if width == 0 || height == 0 {
            return;
        }
        let meshes: Vec<(PixelBounds, &Mesh, &PainterTexture)> = primitives
            .iter()
            .filter_map(|p| match &p.primitive {
                Primitive::Mesh(m) => {
                    Some((PixelBounds::of(p.clip_rect, pixels_per_point, width, height), m, self.textures.get(&m.texture_id)?))
                }
                Primitive::Callback(_) => None,
            })
            .collect();
        canvas.pixels.par_chunks_mut(BAND_ROWS * width).enumerate().for_each(|(index, rows)| {
            let first_row = index * BAND_ROWS;
            // Each task clears its own rows, so that they are in its core's cache.
            rows.fill(0);
            let mut band = Band { width, first_row, rows, columns: Vec::new(), row_texels: Vec::new(), opaque_rows: OpaqueRows::default() };
            let end_row = first_row + band.rows.len() / width;
            for (bounds, mesh, texture) in &meshes {
                if let Some(bounds) = bounds.within_rows(first_row, end_row) {
                    band.paint_mesh(bounds, mesh, texture, pixels_per_point);
                }
            }
        });
    }
}

/// Consecutive rows of the canvas, painted by one task.
struct Band<'a> {
    width: usize,
    /// Index of the first row in the canvas.
    first_row: usize,
    rows: &'a mut [u32],
    // Buffers for the rectangle that is being painted; they are fields so that their memory is reused.
    /// For each column of pixels, the two texel columns between which its pixels are interpolated.
    columns: Vec<TexelPair>,
    /// For the current row of pixels, the texels interpolated vertically (not yet horizontally), with more than 8 bits per channel.
    row_texels: Vec<WideTexel>,
    /// For an opaque texture without a tint: texel rows interpolated horizontally (not yet vertically).
    opaque_rows: OpaqueRows,
}

impl Band<'_> {
    fn paint_mesh(&mut self, bounds: PixelBounds, mesh: &Mesh, texture: &PainterTexture, pixels_per_point: f32) {
        // The vertex with an index, at its position in pixels.
        let vertex = |i: u32| mesh.vertices.get(i as usize).map(|v| Vertex { pos: (v.pos.to_vec2() * pixels_per_point).to_pos2(), ..*v });
        let mut triangles = mesh.indices.chunks_exact(3).peekable();
        while let Some(first) = triangles.next() {
            let (Some(a), Some(b), Some(c)) = (vertex(first[0]), vertex(first[1]), vertex(first[2])) else { continue };
            // egui emits glyphs and images as two consecutive triangles that form an axis-aligned rectangle.
            let second = triangles.peek().map(|t| (vertex(t[0]), vertex(t[1]), vertex(t[2])));
            if let Some((Some(d), Some(e), Some(f))) = second
                && let Some((min, max)) = axis_aligned_rectangle([a, b, c], [d, e, f])
            {
                triangles.next();
                self.paint_rectangle(bounds, min, max, texture);
                continue;
            }
            self.paint_triangle(bounds, [a, b, c], texture);
        }
    }

    /// The pixels `left..right` of a row of the canvas.
    fn row(&mut self, y: usize, left: usize, right: usize) -> &mut [u32] {
        let start = (y - self.first_row) * self.width;
        &mut self.rows[start + left..start + right]
    }

    /// Paints a rectangle whose four vertices have the same colour and whose texture is axis-aligned. `min`, `max`: the upper left and the lower right
    /// vertex.
    fn paint_rectangle(&mut self, bounds: PixelBounds, min: Vertex, max: Vertex, texture: &PainterTexture) {
        // The first pixel whose centre is at or after a position, which is rounded to subpixels.
        let subpixels = SUBPIXELS as f32;
        let first_pixel = |px: f32| ((px * subpixels).round() / subpixels - 0.5).ceil().max(0.0) as usize;
        let (left, top) = (first_pixel(min.pos.x).max(bounds.left), first_pixel(min.pos.y).max(bounds.top));
        let (right, bottom) = (first_pixel(max.pos.x).min(bounds.right), first_pixel(max.pos.y).min(bounds.bottom));
        if left >= right || top >= bottom || texture.texels.is_empty() {
            return;
        }
        let u_per_px = (max.uv.x - min.uv.x) / (max.pos.x - min.pos.x);
        let v_per_px = (max.uv.y - min.uv.y) / (max.pos.y - min.pos.y);
        let single_colour = (min.uv == max.uv).then(|| modulate(min.color, texture.sample(min.uv.x, min.uv.y)));
        if let Some(colour) = single_colour {
            for y in top..bottom {
                blend_span(colour, self.row(y, left, right));
            }
            return;
        }
        // Bilinear filtering is separable. The texel columns of each pixel column are found once for all rows. For each pixel row, texels are interpolated
        // first vertically, once for all pixels of the row, then horizontally.
        let (mut columns, mut row_texels) = (std::mem::take(&mut self.columns), std::mem::take(&mut self.row_texels));
        columns.clear();
        columns.extend((left..right).map(|x| texture.texel_pair(min.uv.x + (x as f32 + 0.5 - min.pos.x) * u_per_px, texture.width)));
        let pair_of_row = |y: usize| texture.texel_pair(min.uv.y + (y as f32 + 0.5 - min.pos.y) * v_per_px, texture.height);
        if min.color == Color32::WHITE && texture.is_opaque() {
            let mut opaque_rows = std::mem::take(&mut self.opaque_rows);
            opaque_rows.start(texture, &columns);
            for y in top..bottom {
                opaque_rows.write_row(texture, &columns, pair_of_row(y), self.row(y, left, right));
            }
            (self.columns, self.row_texels, self.opaque_rows) = (columns, row_texels, opaque_rows);
            return;
        }
        // The range of texel columns that the rectangle needs.
        let first_column = columns.iter().map(|c| c.first.min(c.second)).min().unwrap_or(0);
        let end_column = columns.iter().map(|c| c.first.max(c.second)).max().unwrap_or(0) + 1;
        row_texels.resize(end_column - first_column, WideTexel::default());
        let is_white = min.color == Color32::WHITE;
        for y in top..bottom {
            let row_pair = pair_of_row(y);
            let texels_of = |row: usize| &texture.texels[row * texture.width + first_column..row * texture.width + end_column];
            for ((mixed, first), second) in row_texels.iter_mut().zip(texels_of(row_pair.first)).zip(texels_of(row_pair.second)) {
                *mixed = row_pair.interpolate(*first, *second);
            }
            for (pixel, column) in self.row(y, left, right).iter_mut().zip(&columns) {
                let texel = column.interpolate_wide(row_texels[column.first - first_column], row_texels[column.second - first_column]);
                *pixel = composite_over(if is_white { texel } else { modulate(min.color, texel) }, *pixel);
            }
        }
        (self.columns, self.row_texels) = (columns, row_texels);
    }

    /// Paints a triangle; positions of the vertices are in pixels.
    fn paint_triangle(&mut self, bounds: PixelBounds, [a, mut b, mut c]: [Vertex; 3], texture: &PainterTexture) {
        let to_subpixels = |px: f32| (px.clamp(-MAX_COORDINATE_PX, MAX_COORDINATE_PX) * SUBPIXELS as f32).round() as i64;
        let fixed_point = |v: &Vertex| [v.pos.x, v.pos.y].map(to_subpixels);
        let (pa, mut pb, mut pc) = (fixed_point(&a), fixed_point(&b), fixed_point(&c));
        let mut doubled_area = cross(pa, pb, pc);
        if doubled_area == 0 {
            return;
        }
        // The corners in clockwise order, for which the area and the edge functions at points inside are positive.
        if doubled_area < 0 {
            (b, c, pb, pc, doubled_area) = (c, b, pc, pb, -doubled_area);
        }
        // The last pixel whose centre is at or before a coordinate in subpixels.
        let last_pixel = |subpixel: i64| (subpixel - HALF_PX).div_euclid(SUBPIXELS);
        // The first pixel and the end of a range that contains every pixel whose centre is between the least and the greatest of three coordinates, and at
        // most one more pixel at each end.
        let pixel_range = |coordinates: [i64; 3]| {
            let [least, greatest] = [coordinates.into_iter().min(), coordinates.into_iter().max()].map(|c| c.unwrap_or(0));
            (last_pixel(least), last_pixel(greatest) + 2)
        };
        let (x_start, x_end) = pixel_range([pa[0], pb[0], pc[0]]);
        let (y_start, y_end) = pixel_range([pa[1], pb[1], pc[1]]);
        let (left, right) = (x_start.max(bounds.left as i64), x_end.min(bounds.right as i64));
        let has_one_colour = a.color == b.color && b.color == c.color;
        let single_colour = (has_one_colour && a.uv == b.uv && b.uv == c.uv).then(|| modulate(a.color, texture.sample(a.uv.x, a.uv.y)));
        let single_texel = (a.uv == b.uv && b.uv == c.uv).then(|| texture.sample(a.uv.x, a.uv.y));
        // Top-left rule: a pixel centre on an edge (edge function 0) belongs to the triangle of which the edge is a top or left edge.
        // `min_edge_value`: the smallest value of an edge's function at pixel centres that belong to the triangle: 0 for a left edge, which leads up the screen
        // because the corners are clockwise, and for a top edge, which leads to the right; 1 for any other edge.
        let min_edge_value = |p: [i64; 2], q: [i64; 2]| i64::from(!(q[1] < p[1] || (q[1] == p[1] && q[0] > p[0])));
        let min_values = [min_edge_value(pb, pc), min_edge_value(pc, pa), min_edge_value(pa, pb)];
        // Change of the three edge functions from one pixel to the next in a row.
        let increments = [(pb, pc), (pc, pa), (pa, pb)].map(|(p, q)| (p[1] - q[1]) * SUBPIXELS);
        for y in y_start.max(bounds.top as i64)..y_end.min(bounds.bottom as i64) {
            let first_centre = [left * SUBPIXELS + HALF_PX, y * SUBPIXELS + HALF_PX];
            // The three edge functions at the centre of the first pixel, later at the centre of the current pixel.
            let mut edges = [cross(pb, pc, first_centre), cross(pc, pa, first_centre), cross(pa, pb, first_centre)];
            // The covered pixels of the row, counted from `left`.
            let Some((first, end)) = span_within(edges, increments, min_values, right - left) else { continue };
            let pixels = self.row(y as usize, (left + first) as usize, (left + end) as usize);
            if let Some(colour) = single_colour {
                blend_span(colour, pixels);
                continue;
            }
            // The edge functions this number of pixels farther right.
            let advanced = |edges: [i64; 3], pixels: i64| [0, 1, 2].map(|i| edges[i] + increments[i] * pixels);
            edges = advanced(edges, first);
            for pixel in pixels {
                let weights = edges.map(|e| e as f32 / doubled_area as f32);
                let colour = interpolated_colour([a.color, b.color, c.color], weights);
                let mix = |p: f32, q: f32, r: f32| p * weights[0] + q * weights[1] + r * weights[2];
                let texel = single_texel.unwrap_or_else(|| texture.sample(mix(a.uv.x, b.uv.x, c.uv.x), mix(a.uv.y, b.uv.y, c.uv.y)));
                *pixel = composite_over(modulate(colour, texel), *pixel);
                edges = advanced(edges, 1);
            }
        }
    }
}

/// Twice the signed area of a triangle, square subpixels; positive if the corners are clockwise on the screen. As a function of `c`, this is the edge
/// function of the edge from `a` to `b`.
fn cross(a: [i64; 2], b: [i64; 2], c: [i64; 2]) -> i64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// The half-open range of k in `0..count` for which `starts[i] + k * increments[i]` is at least `minima[i]` for every i; `None` if it is empty.
fn span_within(starts: [i64; 3], increments: [i64; 3], minima: [i64; 3], count: i64) -> Option<(i64, i64)> {
    let (mut first, mut end) = (0, count);
    for i in 0..3 {
        let deficit = minima[i] - starts[i];
        match increments[i] {
            0 if deficit > 0 => return None,
            0 => {}
            // k is at least deficit / increment, rounded up.
            increment if increment > 0 => first = first.max(-(-deficit).div_euclid(increment)),
            // k is at most deficit / increment, rounded down.
            increment => end = end.min((-deficit).div_euclid(-increment) + 1),
        }
    }
    (first < end).then_some((first, end))
}

/// If two triangles form an axis-aligned rectangle of one colour with an axis-aligned texture, its upper left and its lower right vertex.
fn axis_aligned_rectangle(first: [Vertex; 3], second: [Vertex; 3]) -> Option<(Vertex, Vertex)> {
    let all = [first[0], first[1], first[2], second[0], second[1], second[2]];
    let is_upper_left = |v: &&Vertex| all.iter().all(|other| v.pos.x <= other.pos.x && v.pos.y <= other.pos.y);
    let is_lower_right = |v: &&Vertex| all.iter().all(|other| v.pos.x >= other.pos.x && v.pos.y >= other.pos.y);
    let (min, max) = (all.iter().find(is_upper_left)?, all.iter().find(is_lower_right)?);
    let is_corner = |v: &Vertex| {
        (v.pos.x == min.pos.x && v.uv.x == min.uv.x || v.pos.x == max.pos.x && v.uv.x == max.uv.x)
            && (v.pos.y == min.pos.y && v.uv.y == min.uv.y || v.pos.y == max.pos.y && v.uv.y == max.uv.y)
            && v.color == min.color
    };
    // The triangles share a diagonal if each of them has one of the two remaining corners.
    let remaining_corner = |t: &[Vertex; 3]| t.iter().find(|v| v.pos != min.pos && v.pos != max.pos).map(|v| v.pos);
    let share_diagonal = matches!((remaining_corner(&first), remaining_corner(&second)), (Some(p), Some(q)) if p != q);
    (share_diagonal && min.pos.x < max.pos.x && min.pos.y < max.pos.y && all.iter().all(is_corner)).then_some((*min, *max))
}

/// The colour at a point of a triangle with these colours at its corners. `weights`: the point's barycentric coordinates.
fn interpolated_colour(colours: [Color32; 3], weights: [f32; 3]) -> Color32 {
    let [a, b, c] = colours.map(|c| c.to_array());
    let channel = |i: usize| (f32::from(a[i]) * weights[0] + f32::from(b[i]) * weights[1] + f32::from(c[i]) * weights[2] + 0.5) as u8;
    Color32::from_rgba_premultiplied(channel(0), channel(1), channel(2), channel(3))
}

/// `a * b / 255` to the nearest integer, exact for all bytes.
fn multiplied(a: u8, b: u8) -> u8 {
    let product = u32::from(a) * u32::from(b) + 128;
    ((product + (product >> 8)) >> 8) as u8
}

/// A texel multiplied by the vertex colour.
fn modulate(colour: Color32, texel: Color32) -> Color32 {
    let (c, t) = (colour.to_array(), texel.to_array());
    Color32::from_rgba_premultiplied(multiplied(c[0], t[0]), multiplied(c[1], t[1]), multiplied(c[2], t[2]), multiplied(c[3], t[3]))
}

/// A premultiplied colour composited over an opaque pixel; `background` and result are 0x00RRGGBB.
fn composite_over(source: Color32, background: u32) -> u32 {
    let [r, g, b, a] = source.to_array();
    if a == 255 {
        return u32::from_be_bytes([0, r, g, b]);
    }
    let [_, background_r, background_g, background_b] = background.to_be_bytes();
    let inverse_alpha = 255 - a;
    u32::from_be_bytes([
        0,
        r.saturating_add(multiplied(background_r, inverse_alpha)),
        g.saturating_add(multiplied(background_g, inverse_alpha)),
        b.saturating_add(multiplied(background_b, inverse_alpha)),
    ])
}

/// Blends a single colour over a row of pixels.
fn blend_span(colour: Color32, pixels: &mut [u32]) {
    if colour.a() == 255 {
        pixels.fill(composite_over(colour, 0));
    } else {
        pixels.iter_mut().for_each(|pixel| *pixel = composite_over(colour, *pixel));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::{ClippedPrimitive, ColorImage, Pos2, Rect, TextureOptions, pos2};

    const WHITE: TextureId = TextureId::Managed(0);

    fn painter() -> Painter {
        let mut painter = Painter::default();
        painter.set_texture(WHITE, ImageDelta::full(ColorImage::filled([1, 1], Color32::WHITE), TextureOptions::LINEAR));
        painter
    }

    /// The pixels of a square canvas with a mesh.
    fn drawn(painter: &Painter, mesh: Mesh, side: usize) -> Vec<u32> {
        let mut pixels = vec![0; side * side];
        let clip_rect = Rect::from_min_max(Pos2::ZERO, pos2(side as f32, side as f32));
        let primitives = [ClippedPrimitive { clip_rect, primitive: Primitive::Mesh(mesh) }];
        painter.paint(&mut Canvas { width: side, height: side, pixels: &mut pixels }, 1.0, &primitives);
        pixels
    }

    /// A convex polygon as triangles that share the first corner.
    fn fan(corners: &[(f32, f32)], colour: Color32) -> Mesh {
        let vertices = corners.iter().map(|&(x, y)| Vertex { pos: pos2(x, y), uv: Pos2::ZERO, color: colour }).collect();
        let indices = (1..corners.len() as u32 - 1).flat_map(|i| [0, i, i + 1]).collect();
        Mesh { indices, vertices, texture_id: WHITE }
    }

    /// Two half-transparent triangles form a rotated square. A pixel on their shared edge would be brighter if painted twice, and black if
    /// not painted.
    #[test]
    fn triangles_that_share_an_edge_cover_each_pixel_once() {
        let half = Color32::from_rgba_premultiplied(100, 100, 100, 100);
        for turn in 0..64 {
            let angle = turn as f32 * 0.1;
            let at = |k: f32| {
                let (s, c) = (angle + k * std::f32::consts::FRAC_PI_2).sin_cos();
                (20.0 + 17.3 * c, 20.0 + 17.3 * s)
            };
            let pixels = drawn(&painter(), fan(&[at(0.0), at(1.0), at(2.0), at(3.0)], half), 40);
            let once = u32::from_be_bytes([0, 100, 100, 100]);
            assert!(pixels.iter().all(|p| *p == 0 || *p == once), "turned by {angle}");
            // 2 * 17.3 * 17.3 is the square's area. The tolerance is a quarter of the outline's length in pixels.
            let covered = pixels.iter().filter(|p| **p == once).count() as f32;
            assert!((covered - 2.0 * 17.3 * 17.3).abs() < 25.0, "{covered} pixels");
        }
    }

    /// The fast path for rectangles gives the same result as two triangles, within 2 of 255 levels.
    #[test]
    fn the_rectangle_path_matches_two_triangles() {
        let mut painter = painter();
        let id = TextureId::User(7);
        let texels = (0..16u8).map(|i| Color32::from_rgb(i * 16, 255 - i * 9, i * 3)).collect();
        painter.set_texture(id, ImageDelta::full(ColorImage::new([4, 4], texels), TextureOptions::LINEAR));
        let mut mesh = Mesh { texture_id: id, ..Mesh::default() };
        let rect = Rect::from_min_max(pos2(3.2, 5.7), pos2(29.4, 26.5));
        mesh.add_rect_with_uv(rect, Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0)), Color32::WHITE);
        let by_rectangle = drawn(&painter, mesh.clone(), 32);
        // A degenerate triangle between the two prevents the rectangle path.
        let triangles = mesh.indices.clone();
        mesh.indices = [&triangles[..3], &[0, 0, 0], &triangles[3..]].concat();
        let by_triangles = drawn(&painter, mesh, 32);
        let difference = |a: u32, b: u32| a.to_be_bytes().into_iter().zip(b.to_be_bytes()).map(|(a, b)| a.abs_diff(b)).max();
        let worst = by_rectangle.iter().zip(&by_triangles).filter_map(|(a, b)| difference(*a, *b)).max();
        assert!(worst <= Some(2), "the two paths differ by {worst:?} levels of 255");
        assert!(by_rectangle.iter().any(|p| *p != 0));
    }

    #[test]
    fn nothing_is_painted_outside_the_clip_or_the_canvas() {
        let mut pixels = vec![0; 100];
        let clip_rect = Rect::from_min_max(pos2(2.0, 2.0), pos2(5.0, 4.0));
        let mesh = fan(&[(-50.0, -50.0), (500.0, -50.0), (500.0, 500.0), (-50.0, 500.0)], Color32::RED);
        let primitives = [ClippedPrimitive { clip_rect, primitive: Primitive::Mesh(mesh) }];
        painter().paint(&mut Canvas { width: 10, height: 10, pixels: &mut pixels }, 1.0, &primitives);
        let painted: Vec<usize> = pixels.iter().enumerate().filter(|(_, p)| **p != 0).map(|(i, _)| i).collect();
        assert_eq!(painted, [22, 23, 24, 32, 33, 34]);
    }

    /// Without a limit, the products of such coordinates overflow.
    #[test]
    fn a_triangle_with_huge_coordinates_covers_the_canvas() {
        for huge in [1e7, 1e30, f32::INFINITY] {
            let pixels = drawn(&painter(), fan(&[(-huge, -huge), (huge, -huge), (0.0, huge)], Color32::WHITE), 10);
            assert!(pixels.iter().all(|pixel| *pixel == 0x00ff_ffff), "{huge}");
        }
    }

    #[test]
    fn partial_updates_change_their_part_and_invalid_ones_nothing() {
        let mut painter = painter();
        let id = TextureId::User(1);
        let image = |n, c| ColorImage::filled([n, n], c);
        painter.set_texture(id, ImageDelta::full(image(4, Color32::BLACK), TextureOptions::NEAREST));
        painter.set_texture(id, ImageDelta::partial([1, 1], image(2, Color32::WHITE), TextureOptions::NEAREST));
        painter.set_texture(id, ImageDelta::partial([3, 3], image(2, Color32::RED), TextureOptions::NEAREST));
        let texels = &painter.textures[&id].texels;
        let white: Vec<usize> = (0..16).filter(|i| texels[*i] == Color32::WHITE).collect();
        assert_eq!(white, [5, 6, 9, 10]);
        assert!(!texels.contains(&Color32::RED));
    }
}
