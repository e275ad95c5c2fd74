//! The table of the panels at the sides of the viewport: one row for each, in the order of their digit keys.
//!
//! In: the panels' modules. Out: all that the top bar, the shortcuts and `side_panels` know about a panel. Always: no panel imports this file; a panel
//! that opens another one names it by `super::Tab`.

use super::icons::Icon;
use super::{Interface, Tab, compare, effects, events, information, moments, performance, shader, share};
use crate::view::app::viewer::Action;
use crate::view::language::text;
use crate::view::worker::render_worker::RenderWorker;
use egui::Ui;

/// Number of panels, from the first, whose buttons show their titles. The buttons of any later panels show only icons, so that the bar keeps its height.
const TITLED_BUTTONS: usize = 8;

/// The group of a panel's button in the top bar, in order from left to right.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Group {
    /// Where and when to look.
    Explore,
    /// Under the caption *See*: what is drawn.
    See,
    /// Under the caption *Understand*: facts about bodies.
    Bodies,
    /// Also under *Understand*: how the image is drawn.
    Drawing,
    /// Save and share views and images; the appearance of the window.
    Share,
}

/// What the interface knows about a panel.
struct Row {
    tab: Tab,
    title: fn() -> &'static str,
    /// The tooltip of the panel's button.
    about: fn() -> &'static str,
    icon: Icon,
    group: Group,
    /// Whether the panel needs more space than a list: for source text, images, or a table of several columns.
    is_wide: bool,
    /// Shows the panel's controls.
    show: fn(&mut Interface, &mut Ui, &dyn RenderWorker, &mut Vec<Action>),
}

/// The rows, in the order of [`Tab`]. The compiler demands one for each variant.
const ROWS: &[Row; Tab::ALL.len()] = &[
    Row {
        tab: Tab::Moments,
        title: || text!("tab-moments"),
        about: || text!("tab-moments-about"),
        icon: Icon::Moments,
        group: Group::Explore,
        is_wide: false,
        show: moments::panel,
    },
    Row {
        tab: Tab::Events,
        title: || text!("tab-events"),
        about: || text!("tab-events-about"),
        icon: Icon::Events,
        group: Group::Explore,
        is_wide: false,
        show: events::panel,
    },
    Row {
        tab: Tab::Effects,
        title: || text!("tab-effects"),
        about: || text!("tab-effects-about"),
        icon: Icon::Effects,
        group: Group::See,
        is_wide: false,
        show: |interface, ui, worker, _| effects::panel(interface, ui, worker),
    },
    Row {
        tab: Tab::Shader,
        title: || text!("tab-shader"),
        about: || text!("tab-shader-about"),
        icon: Icon::Shader,
        group: Group::Drawing,
        is_wide: true,
        show: |interface, ui, worker, _| shader::panel(interface, ui, worker),
    },
    Row {
        tab: Tab::Compare,
        title: || text!("tab-compare"),
        about: || text!("tab-compare-about"),
        icon: Icon::Compare,
        group: Group::Drawing,
        is_wide: true,
        show: |interface, ui, worker, _| compare::panel(interface, ui, worker),
    },
    Row {
        tab: Tab::Information,
        title: || text!("tab-information"),
        about: || text!("tab-information-about"),
        icon: Icon::Information,
        group: Group::Bodies,
        is_wide: false,
        show: |interface, ui, worker, _| information::panel(interface, ui, worker),
    },
    Row {
        tab: Tab::Performance,
        title: || text!("tab-performance"),
        about: || text!("tab-performance-about"),
        icon: Icon::Performance,
        group: Group::Drawing,
        is_wide: false,
        show: |interface, ui, _, _| performance::panel(interface, ui),
    },
    Row {
        tab: Tab::Share,
        title: || text!("tab-share"),
        about: || text!("tab-share-about"),
        icon: Icon::Share,
        group: Group::Share,
        is_wide: false,
        show: share::panel,
    },
];

const _: () = {
    let mut k = 0;
    while k < ROWS.len() {
        assert!(ROWS[k].tab as usize == k, "the rows are in the order of the variants");
        k += 1;
    }
};

impl Tab {
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

    pub(super) fn group(self) -> Group {
        self.row().group
    }

    /// Whether the panel's button shows its title beside the icon.
    pub(super) fn has_titled_button(self) -> bool {
        self.digit() <= TITLED_BUTTONS
    }

    /// Whether the panel needs more space than a list.
    pub(super) fn is_wide(self) -> bool {
        self.row().is_wide
    }

    /// Shows the panel's controls.
    pub(super) fn show(self, interface: &mut Interface, ui: &mut Ui, worker: &dyn RenderWorker, actions: &mut Vec<Action>) {
        (self.row().show)(interface, ui, worker, actions);
    }
}
