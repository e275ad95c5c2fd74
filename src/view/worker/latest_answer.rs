//! The answer to a query whose inputs change while the window shows it, such as the time.
//!
//! In: the inputs of this frame and the query. Out: the newest answer that has arrived, with its own inputs. Always: at most one query runs; the next one
//! starts after its answer, with the inputs of that frame.

use crate::session::Session;
use crate::view::worker::render_worker::{Pending, RenderWorker, ask};

/// The newest answer (`T`) to a query with the inputs `I`. Round a time among the inputs, so that a running clock does not start a query in each frame.
pub(crate) struct LatestAnswer<I, T> {
    /// The inputs of the newest query, pending or answered.
    requested: Option<I>,
    pending: Option<Pending<T>>,
    /// The last answer that has arrived, with its inputs; `None` before the first.
    answer: Option<(I, T)>,
}

impl<I, T> Default for LatestAnswer<I, T> {
    fn default() -> Self {
        Self { requested: None, pending: None, answer: None }
    }
}

impl<I: Copy + PartialEq, T: Send + 'static> LatestAnswer<I, T> {
    /// Starts `query` if the inputs have changed and no query runs, and returns the newest answer with its inputs.
    pub(crate) fn update(
        &mut self,
        worker: &dyn RenderWorker,
        inputs: I,
        query: impl FnOnce(&Session) -> T + Send + 'static,
    ) -> Option<&(I, T)> {
        if let Some(answer) = self.pending.as_ref().and_then(Pending::take) {
            self.answer = self.requested.map(|requested| (requested, answer));
            self.pending = None;
        }
        if self.requested != Some(inputs) && self.pending.is_none() {
            self.requested = Some(inputs);
            self.pending = Some(ask(worker, query));
        }
        self.answer.as_ref()
    }

    /// Drops the answer, so that the query runs again. For a change of language: an answer may contain texts in the former language.
    pub(crate) fn clear(&mut self) {
        *self = Self::default();
    }
}
