//! Contacts of an event: names (such as P1, U2 or IV) and instants.
//!
//! In: contacts in any order. Out: the time between two of them, or all in order of time. Not here: the search for contacts.

use crate::time::Instant;

/// Name and instant of a contact, as the Earth's centre receives the light.
pub(crate) type Contact = (&'static str, Instant);

/// Seconds from one contact to another; `None` if either is missing.
pub(super) fn seconds_between(contacts: &[Contact], first: &str, last: &str) -> Option<f64> {
    let time_of = |name: &str| Some(contacts.iter().find(|c| c.0 == name)?.1.tdb_seconds_past_j2000());
    Some(time_of(last)? - time_of(first)?)
}

pub(super) fn sort_by_time(contacts: &mut [Contact]) {
    contacts.sort_by(|a, b| a.1.tdb_seconds_past_j2000().total_cmp(&b.1.tdb_seconds_past_j2000()));
}
