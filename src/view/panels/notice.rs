//! The notice: the last messages of the session that are not about drivers, over the viewport's lower edge.
//!
//! In: messages of the session, a line each; whether a reply covers the notice. Out: a text of at most [`MAX_MESSAGE_LINES`] lines. Always: a message is
//! shown for [`NOTICE_DURATION_S`], also if others arrive meanwhile; time during which a reply covers the notice does not count. Standard error has all
//! messages.

use super::MAX_MESSAGE_LINES;
use crate::view::language::text;

/// How long the notice is shown after its last message, seconds.
const NOTICE_DURATION_S: f64 = 8.0;

/// The notice, which has no text while there is nothing to say.
#[derive(Default)]
pub(super) struct Notice {
    /// The messages as the session wrote them.
    messages: Vec<String>,
    /// The messages in the language of the window, one a line.
    text: String,
    /// When the notice disappears, in egui's time (`InputState::time`).
    until_s: f64,
}

impl Notice {
    /// Adds new messages to those that are still shown; of too many, the first are left out. `now_s`: egui's time.
    pub(super) fn add(&mut self, messages: Vec<String>, now_s: f64) {
        if messages.is_empty() {
            return;
        }
        self.messages.extend(messages);
        self.messages.drain(..self.messages.len().saturating_sub(MAX_MESSAGE_LINES));
        self.until_s = now_s + NOTICE_DURATION_S;
        self.rewrite_text();
    }

    /// Ends the notice once it has been shown long enough. `is_covered`: whether a reply is shown in its place.
    pub(super) fn update(&mut self, is_covered: bool, now_s: f64) {
        if self.messages.is_empty() {
            return;
        }
        if is_covered {
            self.until_s = now_s + NOTICE_DURATION_S;
        } else if self.until_s <= now_s {
            *self = Self::default();
        }
    }

    /// Writes the text in the current language.
    pub(super) fn rewrite_text(&mut self) {
        let lines: Vec<String> = self.messages.iter().map(|message| text!("notice", detail = message)).collect();
        self.text = lines.join("\n");
    }

    /// The text; empty if there is no notice.
    pub(super) fn text(&self) -> &str {
        &self.text
    }

    /// Time until the notice disappears, seconds; `None` if there is none.
    pub(super) fn remaining_s(&self, now_s: f64) -> Option<f64> {
        (!self.messages.is_empty()).then_some(self.until_s - now_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(range: std::ops::RangeInclusive<usize>) -> Vec<String> {
        range.map(|k| format!("message {k}")).collect()
    }

    /// A message once replaced those that had arrived a moment before.
    #[test]
    fn a_message_stays_although_another_arrives() {
        let mut notice = Notice::default();
        notice.add(lines(1..=1), 0.0);
        notice.add(lines(2..=2), 1.0);
        assert_eq!(notice.text(), "message 1\nmessage 2");
        notice.add(lines(3..=MAX_MESSAGE_LINES + 1), 2.0);
        assert_eq!(notice.text(), lines(2..=MAX_MESSAGE_LINES + 1).join("\n"));
        notice.update(false, 2.0 + NOTICE_DURATION_S - 0.1);
        assert!(!notice.text().is_empty() && notice.remaining_s(2.0) == Some(NOTICE_DURATION_S));
        notice.update(false, 2.0 + NOTICE_DURATION_S);
        assert!(notice.text().is_empty() && notice.remaining_s(2.0).is_none());
    }

    /// A reply is shown for longer than a notice, which once had ended before the reply did.
    #[test]
    fn time_under_a_reply_does_not_count() {
        let mut notice = Notice::default();
        notice.add(lines(1..=1), 0.0);
        for now_s in [5.0, 10.0, 20.0] {
            notice.update(true, now_s);
        }
        notice.update(false, 20.0 + NOTICE_DURATION_S - 0.1);
        assert_eq!(notice.text(), "message 1");
        notice.update(false, 20.0 + NOTICE_DURATION_S);
        assert_eq!(notice.text(), "");
    }
}
