//! The pages of the atlas as HTML.
//!
//! In: the modules as the manifest lists them; for the page of a module also its runs of lines and its neighbours. Out: the text of a page. Names, figures and
//! links are plain text and need no script; `atlas.js` assembles the source.

use super::{IMAGE_SIDE_PX, ListedModule};
use std::fmt::Write;

/// Escapes text for HTML.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// The start of a page. `root`: relative path from the page to the atlas folder, empty or ending with `/`.
fn head(title: &str, root: &str) -> String {
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" content=\"width=device-width\">\n<title>{}</title>\n<link rel=\"stylesheet\" href=\"{root}atlas.css\">\n</head>\n<body>\n",
        escaped(title)
    )
}

/// A figure of a module as text; empty if the module lacks the figure.
fn number_or_empty(value: Option<f64>) -> String {
    value.map_or(String::new(), |v| format!("{v:.4}"))
}

/// The page of one module. `stem`: name of its files without the extension. `runs`: the module's lines, as `LineTable::add` returns them. `neighbours`: for
/// each neighbouring module, the change that leads to it and the stem of its files.
pub(crate) fn module_page(module: &ListedModule, stem: &str, runs: &str, neighbours: &[(String, &str)]) -> String {
    let name = escaped(&module.name);
    let mut html = head(&module.name, "../");
    let _ = write!(html, "<p><a href=\"../index.html\">All modules</a></p>\n<h1>{name}</h1>\n<div class=\"about\">\n");
    if module.has_image {
        let _ = writeln!(
            html,
            "<img src=\"../pictures/{stem}.png\" width=\"{side}\" height=\"{side}\" alt=\"The sample body drawn by {name}\">",
            stem = escaped(stem),
            side = 2 * IMAGE_SIDE_PX
        );
    }
    html.push_str("<table>\n");
    let figures = &module.figures;
    let rows = [
        ("Lines", module.lines.to_string()),
        ("Operations per pixel, each loop counted once", figures.operations.to_string()),
        ("Texture reads", figures.texture_reads.to_string()),
        ("Slots: values per pixel that are live at once", figures.slots.to_string()),
        ("Mean luminance of the image, where white is 1", number_or_empty(figures.mean_luminance)),
        ("Greatest difference between f32 and f64, levels of 255", number_or_empty(figures.rounding_levels)),
    ];
    for (label, value) in rows.iter().filter(|(_, value)| !value.is_empty()) {
        let _ = writeln!(html, "<tr><th>{label}</th><td>{value}</td></tr>");
    }
    html.push_str("</table>\n");
    if !neighbours.is_empty() {
        html.push_str("<div><h2>Modules that differ in one part of the key</h2>\n<ul class=\"neighbours\">\n");
        for (change, neighbour_stem) in neighbours {
            let _ = writeln!(html, "<li><a href=\"{}.html\">{}</a></li>", escaped(neighbour_stem), escaped(change));
        }
        html.push_str("</ul></div>\n");
    }
    let _ = write!(
        html,
        "</div>\n<h2>Source</h2>\n<p id=\"legend\"></p>\n<noscript><p>A script assembles the source; without it, <code>orrery shader emit {name}</code> prints the built-in one.</p></noscript>\n<pre id=\"source\" data-runs=\"{runs}\"></pre>\n<script src=\"../lines.js\"></script>\n<script src=\"../atlas.js\"></script>\n</body>\n</html>\n"
    );
    html
}

/// The index page: the list of all modules, with a filter.
pub(crate) fn index_page(revision: &str, modules: &[ListedModule]) -> String {
    let mut html = head("Orrery: atlas of shader modules", "");
    let _ = write!(
        html,
        "<h1>Atlas of shader modules</h1>\n<p>{} modules of revision <code>{}</code>. Each image is the same sample body, lit from the side, drawn by that module in the software renderer.</p>\n<p><label>Filter by key: <input id=\"filter\" type=\"search\" size=\"50\" placeholder=\"clouds -eclipse ringshadow\"></label> <span id=\"count\"></span></p>\n<ul class=\"modules\">\n",
        modules.len(),
        escaped(revision)
    );
    for module in modules {
        let image = if module.has_image {
            let stem = module.page.trim_start_matches("pages/").trim_end_matches(".html");
            let (stem, side) = (escaped(stem), IMAGE_SIDE_PX);
            format!("<img src=\"pictures/{stem}.png\" width=\"{side}\" height=\"{side}\" loading=\"lazy\" alt=\"\">")
        } else {
            String::new()
        };
        let _ = writeln!(
            html,
            "<li><a href=\"{}\">{image}<span>{}</span></a> <small>{} operations, {} texture reads</small></li>",
            escaped(&module.page),
            escaped(&module.name),
            module.figures.operations,
            module.figures.texture_reads
        );
    }
    html.push_str("</ul>\n<script src=\"atlas.js\"></script>\n</body>\n</html>\n");
    html
}
