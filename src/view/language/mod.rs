//! The window's texts, in the languages of `en/` and `de/`: Fluent files, one per panel.
//!
//! In: the id of a message, its arguments. Out: the text in the language of the running window. Always: a message that a language lacks is the English one, and one that no
//! file has is its id; nothing panics. Texts without arguments are formatted once, so that a panel looks them up at no cost worth naming. Not here: texts of the command line, of
//! links and of saved files, which are the same in every language.
//!
//! [`Language::Marked`] is English with `«»` around each message and `‹›` around each text that is filled in: what a panel shows without them does not come from these files.

pub mod choice;
pub(crate) mod dates;
mod elsewhere;
mod files;
pub(crate) mod numbers;

pub use self::choice::Language;
pub use self::elsewhere::translated;
pub(crate) use self::numbers::{decimal, signed};
use fluent_bundle::concurrent::FluentBundle;
use fluent_bundle::{FluentArgs, FluentResource, FluentValue};
use std::cell::Cell;
use std::collections::HashMap;
use std::sync::LazyLock;

thread_local! {
    /// The language of what this thread draws or answers: one window has one thread, and several tests run beside each other.
    static CURRENT: Cell<Language> = const { Cell::new(Language::English) };
}

/// The language of the running window.
pub(crate) fn current() -> Language {
    CURRENT.get()
}

/// Sets the language of this thread's texts.
pub fn set(language: Language) {
    CURRENT.set(language);
}

/// The text of a message: `text!("id")` is `&'static str`; `text!("id", name = value)` fills in arguments and is a `String`.
macro_rules! text {
    ($id:literal) => {
        $crate::view::language::plain($id)
    };
    ($id:literal, $($name:ident = $value:expr),+ $(,)?) => {
        $crate::view::language::filled($id, &[$((stringify!($name), $crate::view::language::Argument::value(&$value))),+])
    };
}
pub(crate) use text;

/// What a message's argument may be: text, or a count that chooses a plural form. Numbers with decimals are texts by [`decimal`] or [`signed`].
pub(crate) trait Argument {
    fn value(&self) -> FluentValue<'_>;
}

impl Argument for str {
    fn value(&self) -> FluentValue<'_> {
        self.into()
    }
}

impl Argument for String {
    fn value(&self) -> FluentValue<'_> {
        self.as_str().into()
    }
}

impl Argument for std::borrow::Cow<'_, str> {
    fn value(&self) -> FluentValue<'_> {
        self.as_ref().into()
    }
}

impl Argument for std::path::Display<'_> {
    fn value(&self) -> FluentValue<'_> {
        self.to_string().into()
    }
}

impl<T: Argument + ?Sized> Argument for &T {
    fn value(&self) -> FluentValue<'_> {
        (**self).value()
    }
}

macro_rules! counts {
    ($($count:ty),*) => {$(
        impl Argument for $count {
            fn value(&self) -> FluentValue<'_> {
                (*self).into()
            }
        }
    )*};
}
counts!(u8, u16, u32, u64, usize, i32, i64);

/// The messages of a language.
struct Messages {
    /// Each text is shown between marks.
    marked: bool,
    /// Those without arguments, ready to show.
    plain: HashMap<String, String>,
    bundle: FluentBundle<FluentResource>,
}

impl Messages {
    fn of(language: Language) -> Self {
        let mut bundle = FluentBundle::new_concurrent(vec![language.identifier()]);
        // Marks around arguments for mixed directions of writing would show as boxes.
        bundle.set_use_isolating(false);
        let marked = language == Language::Marked;
        let mut plain = HashMap::new();
        for file in files::of(language) {
            // What is wrong in a file is left out of it; a test finds it.
            let resource = FluentResource::try_new((*file).to_owned()).unwrap_or_else(|(resource, _)| resource);
            let _ = bundle.add_resource(resource);
        }
        for id in files::of(language).iter().flat_map(|file| files::ids(file)) {
            let mut errors = Vec::new();
            let pattern = bundle.get_message(id).and_then(|message| message.value());
            let text = pattern.map(|pattern| bundle.format_pattern(pattern, None, &mut errors).into_owned());
            if errors.is_empty() {
                plain.extend(text.map(|text| (id.to_owned(), if marked { message_marked(&text) } else { text })));
            }
        }
        Self { marked, plain, bundle }
    }

    fn filled(&self, id: &str, arguments: &FluentArgs<'_>) -> Option<String> {
        let pattern = self.bundle.get_message(id)?.value()?;
        let mut errors = Vec::new();
        if !self.marked {
            let text = self.bundle.format_pattern(pattern, Some(arguments), &mut errors).into_owned();
            return errors.is_empty().then_some(text);
        }
        let between_marks: FluentArgs<'_> = arguments.iter().map(|(name, value)| (name, argument_marked(value))).collect();
        let text = self.bundle.format_pattern(pattern, Some(&between_marks), &mut errors).into_owned();
        errors.is_empty().then(|| message_marked(&text))
    }
}

fn message_marked(text: &str) -> String {
    format!("«{text}»")
}

/// Numbers stay as they are: they choose plural forms.
fn argument_marked<'v>(value: &FluentValue<'v>) -> FluentValue<'v> {
    match value {
        FluentValue::String(text) => format!("‹{text}›").into(),
        other => other.clone(),
    }
}

static ENGLISH: LazyLock<Messages> = LazyLock::new(|| Messages::of(Language::English));
static GERMAN: LazyLock<Messages> = LazyLock::new(|| Messages::of(Language::German));
static MARKED: LazyLock<Messages> = LazyLock::new(|| Messages::of(Language::Marked));

/// Read at the first use of a language: a window has one.
fn messages(language: Language) -> &'static Messages {
    match language {
        Language::English => &ENGLISH,
        Language::German => &GERMAN,
        Language::Marked => &MARKED,
    }
}

/// What the current language has, else English.
fn in_turn<T>(find: impl Fn(&'static Messages) -> Option<T>) -> Option<T> {
    find(messages(current())).or_else(|| find(messages(Language::English)))
}

/// A message without arguments.
pub(crate) fn plain(id: &'static str) -> &'static str {
    in_turn(|messages| messages.plain.get(id)).map_or(id, String::as_str)
}

/// A message with its arguments.
pub(crate) fn filled(id: &'static str, arguments: &[(&'static str, FluentValue<'_>)]) -> String {
    let arguments: FluentArgs<'_> = arguments.iter().map(|(name, value)| (*name, value.clone())).collect();
    in_turn(|messages| messages.filled(id, &arguments)).unwrap_or_else(|| id.to_owned())
}

/// A message whose arguments are texts.
fn filled_by_text(id: &'static str, arguments: &[(&'static str, String)]) -> String {
    let arguments: Vec<(&'static str, FluentValue<'_>)> = arguments.iter().map(|(name, value)| (*name, value.as_str().into())).collect();
    filled(id, &arguments)
}

/// What a thing is called whose name comes from elsewhere (an effect, a body): the message `kind-name`, else the name itself.
pub(crate) fn named<'n>(kind: &str, name: &'n str) -> &'n str {
    let id = format!("{kind}-{}", name.to_lowercase().replace([' ', '_'], "-"));
    in_turn(|messages| messages.plain.get(&id)).map_or(name, String::as_str)
}

/// The name of a body of the catalog.
pub(crate) fn body_name(name: &str) -> &str {
    named("body", name)
}

#[cfg(test)]
mod tests;
