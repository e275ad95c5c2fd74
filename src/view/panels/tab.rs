//! The panels at the sides of the viewport: one row for each, in the order of their digit keys.
//!
//! Not here: what a panel shows (`side_panels::contents` calls it), and the place of its button (`top_bar`).

use super::icons::Icon;
use crate::view::language::text;

/// A panel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tab {
    Moments,
    Events,
    Effects,
    Shader,
    Compare,
    Information,
    Performance,
    Share,
}

/// What the interface shows of a panel before it is open.
struct Row {
    tab: Tab,
    /// The name under which the settings store the panel.
    name: &'static str,
    title: fn() -> &'static str,
    /// The tooltip of the panel's button.
    about: fn() -> &'static str,
    icon: Icon,
    /// Whether the panel shows source text or images, which need more space than a list.
    is_wide: bool,
}

/// The rows, in the order of [`Tab`].
static ROWS: [Row; 8] = [
    Row {
        tab: Tab::Moments,
        name: "Moments",
        title: || text!("tab-moments"),
        about: || text!("tab-moments-about"),
        icon: Icon::Moments,
        is_wide: false,
    },
    Row {
        tab: Tab::Events,
        name: "Events",
        title: || text!("tab-events"),
        about: || text!("tab-events-about"),
        icon: Icon::Events,
        is_wide: false,
    },
    Row {
        tab: Tab::Effects,
        name: "Effects",
        title: || text!("tab-effects"),
        about: || text!("tab-effects-about"),
        icon: Icon::Effects,
        is_wide: false,
    },
    Row {
        tab: Tab::Shader,
        name: "Shader",
        title: || text!("tab-shader"),
        about: || text!("tab-shader-about"),
        icon: Icon::Shader,
        is_wide: true,
    },
    Row {
        tab: Tab::Compare,
        name: "Compare",
        title: || text!("tab-compare"),
        about: || text!("tab-compare-about"),
        icon: Icon::Compare,
        is_wide: true,
    },
    Row {
        tab: Tab::Information,
        name: "Information",
        title: || text!("tab-information"),
        about: || text!("tab-information-about"),
        icon: Icon::Information,
        is_wide: false,
    },
    Row {
        tab: Tab::Performance,
        name: "Performance",
        title: || text!("tab-performance"),
        about: || text!("tab-performance-about"),
        icon: Icon::Performance,
        is_wide: false,
    },
    Row {
        tab: Tab::Share,
        name: "Share",
        title: || text!("tab-share"),
        about: || text!("tab-share-about"),
        icon: Icon::Share,
        is_wide: false,
    },
];

impl Tab {
    /// All panels: digit key `k` opens the panel at index `k - 1`.
    pub const ALL: [Self; ROWS.len()] = {
        let mut all = [Self::Moments; ROWS.len()];
        let mut k = 0;
        while k < ROWS.len() {
            all[k] = ROWS[k].tab;
            assert!(all[k] as usize == k, "the rows are in the order of the variants");
            k += 1;
        }
        all
    };

    fn row(self) -> &'static Row {
        &ROWS[self as usize]
    }

    /// The digit key that opens the panel.
    pub(super) fn digit(self) -> usize {
        self as usize + 1
    }

    /// The panel of a typed digit.
    pub(super) fn of_digit(typed: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|tab| tab.digit().to_string() == typed)
    }

    /// The name under which the settings store the panel.
    pub(super) fn name(self) -> &'static str {
        self.row().name
    }

    pub fn title(self) -> &'static str {
        (self.row().title)()
    }

    /// The tooltip of the panel's button.
    pub(super) fn about(self) -> &'static str {
        (self.row().about)()
    }

    pub(super) fn icon(self) -> Icon {
        self.row().icon
    }

    /// Whether the panel shows source text or images, which need more space than a list.
    pub(super) fn is_wide(self) -> bool {
        self.row().is_wide
    }
}
