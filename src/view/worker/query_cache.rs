//! Answers that are computed off the window's thread, each once.
//!
//! In: a key and a query. Out: the answer, some frames later. Always: a query runs once per key until the cache is cleared; asking never blocks.

use crate::session::Session;
use crate::view::worker::render_worker::{Pending, RenderWorker, ask};
use std::collections::HashMap;
use std::hash::Hash;

enum Answer<T> {
    Coming(Pending<T>),
    Here(T),
}

/// The answers so far.
pub(crate) struct QueryCache<K, T>(HashMap<K, Answer<T>>);

impl<K, T> Default for QueryCache<K, T> {
    fn default() -> Self {
        Self(HashMap::new())
    }
}

/// Capacity; when it is exceeded, the cache is cleared.
const CAPACITY: usize = 600;

impl<K: Eq + Hash + Clone, T: Send + 'static> QueryCache<K, T> {
    /// The answer, if it has arrived; otherwise starts `query`, unless it is running.
    pub(crate) fn get(&mut self, worker: &dyn RenderWorker, key: &K, query: impl FnOnce(&Session) -> T + Send + 'static) -> Option<&T> {
        if !self.0.contains_key(key) {
            if self.0.len() >= CAPACITY {
                self.0.clear();
            }
            self.0.insert(key.clone(), Answer::Coming(ask(worker, query)));
        }
        self.known(key)
    }

    /// The answer, if it was requested and has arrived.
    pub(crate) fn known(&mut self, key: &K) -> Option<&T> {
        let answer = self.0.get_mut(key)?;
        if let Answer::Coming(pending) = answer
            && let Some(here) = pending.take()
        {
            *answer = Answer::Here(here);
        }
        match answer {
            Answer::Here(here) => Some(here),
            Answer::Coming(_) => None,
        }
    }

    pub(crate) fn forget(&mut self) {
        self.0.clear();
    }
}
