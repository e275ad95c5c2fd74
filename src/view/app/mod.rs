//! The state behind the window: the view, its camera, time, history and settings.
//!
//! In: the user's actions, real time, positions of bodies. Out: plain values: the view to draw, texts for the panels, settings to save. Not here: the
//! window and the panels.

pub mod body_positions;
pub mod civil_time;
pub mod composition_state;
pub mod date_text;
pub mod event_search;
pub mod event_view;
pub mod exposure_adaptation;
pub mod file_names;
pub mod flight;
pub mod initial_view;
pub(crate) mod julian_calendar;
pub mod known_events;
pub mod moment_view;
mod option_serde;
pub mod orbit_camera;
pub mod place_text;
pub(crate) mod placed_times;
pub mod preset_changes;
pub mod presets;
pub mod search;
pub mod settings;
pub mod sky_target;
pub mod telescope_setup;
pub mod time_rate;
pub mod timeline;
pub mod tour;
pub mod view_state;
pub mod viewer;
pub mod what_to_see_now;
