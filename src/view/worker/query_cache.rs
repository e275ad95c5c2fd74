//! A cache of query results that are computed off the window's thread.
//!
//! In: a key and a query. Out: the answer, some frames later. Always: the query of a key runs once, until the key's entry is dropped; a lookup never blocks.
//! One frame must not look up more than `CAPACITY` keys: their entries would be dropped before the answers arrive.

use crate::session::Session;
use crate::view::worker::render_worker::{Pending, RenderWorker, ask};
use std::collections::HashMap;
use std::hash::Hash;

/// The answer to a query, pending or arrived.
enum Answer<T> {
    Waiting(Pending<T>),
    Ready(T),
}

/// The answers to queries by key, pending or arrived.
pub(crate) struct QueryCache<K, T> {
    answers: HashMap<K, Answer<T>>,
}

impl<K, T> Default for QueryCache<K, T> {
    fn default() -> Self {
        Self { answers: HashMap::new() }
    }
}

/// Largest number of entries. Before a further query, a full cache drops all entries, also those of pending queries.
const CAPACITY: usize = 600;

impl<K: Eq + Hash + Clone, T: Send + 'static> QueryCache<K, T> {
    /// The answer, if it has arrived. Starts `query` if the cache has no entry for this key.
    pub(crate) fn get(&mut self, worker: &dyn RenderWorker, key: &K, query: impl FnOnce(&Session) -> T + Send + 'static) -> Option<&T> {
        if !self.answers.contains_key(key) {
            if self.answers.len() >= CAPACITY {
                self.answers.clear();
            }
            self.answers.insert(key.clone(), Answer::Waiting(ask(worker, query)));
        }
        self.known(key)
    }

    /// The answer, if it has arrived. Starts no query.
    pub(crate) fn known(&mut self, key: &K) -> Option<&T> {
        let answer = self.answers.get_mut(key)?;
        if let Answer::Waiting(pending) = answer
            && let Some(ready) = pending.take()
        {
            *answer = Answer::Ready(ready);
        }
        match answer {
            Answer::Ready(ready) => Some(ready),
            Answer::Waiting(_) => None,
        }
    }

    /// Drops all entries.
    pub(crate) fn clear(&mut self) {
        self.answers.clear();
    }
}

impl<K, T, E> QueryCache<K, Result<T, E>> {
    /// Drops the entries whose answers are errors or have not arrived, so that their queries run again. For a change of language: an error may be a text in
    /// the language in which the query was made.
    pub(crate) fn forget_failures(&mut self) {
        self.answers.retain(|_, answer| matches!(answer, Answer::Ready(Ok(_))));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forgetting_failures_keeps_only_successful_answers() {
        let answers = [(1, Answer::Ready(Ok("text"))), (2, Answer::Ready(Err("why"))), (3, Answer::Waiting(Pending::default()))];
        let mut cache: QueryCache<i32, Result<&str, &str>> = QueryCache { answers: HashMap::from(answers) };
        cache.forget_failures();
        assert_eq!(cache.answers.keys().collect::<Vec<_>>(), [&1]);
        assert_eq!(cache.known(&1), Some(&Ok("text")));
    }
}
