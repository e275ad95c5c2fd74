//! The window, part by part; tests/README.md says what each module tests. `interface` is also the harness of the others.

mod access;
mod clicks_after_typing;
mod composition;
mod contrast;
mod cut_texts;
mod dropped;
mod event_playback;
mod event_search;
mod events;
mod failures;
mod first_image;
mod flights;
mod information;
mod input;
mod inspect;
pub mod interface;
mod labels;
mod language;
mod marked_texts;
mod menu_focus;
mod now;
mod number_fields;
mod panels;
mod presets;
mod roll;
mod search;
mod sharing;
mod shortcuts;
mod side_panels;
mod sky_objects;
mod slow_answers;
mod source_search;
mod stars;
mod texts_of_layers;
mod time;
mod timeline;
mod tour;
#[cfg(feature = "gpu")]
mod window_frame;
#[cfg(unix)]
mod zones;
