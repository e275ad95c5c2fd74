//! The window's texts in English and German, from the Fluent files in `en/` and `de/` and from those of [`crate::message`].
//!
//! In: the id of a message and its arguments. Out: the text in the window's language. Always: a message that is missing in a language is shown in
//! English; if English lacks it too, its id is shown. Nothing panics. Texts without arguments are formatted once, so that panels can look
//! them up in every frame. Not here: texts of the command line, of links and of saved files, which are the same in every language.
//!
//! [`Language::MarkedEnglish`] is English with `«»` around each message and `‹›` around each text argument. Text that a panel shows without these marks does
//! not come from the Fluent files.

pub mod choice;
pub(crate) mod dates;
mod files;
pub(crate) mod numbers;
mod translation;

pub use self::choice::Language;
pub(crate) use self::numbers::{decimal, signed};
pub use self::translation::{catalog_entry_text, catalog_text, message_text, reason_text};
use fluent_bundle::concurrent::FluentBundle;
use fluent_bundle::{FluentArgs, FluentResource, FluentValue};
use std::cell::Cell;
use std::collections::HashMap;
use std::sync::LazyLock;

thread_local! {
    /// The language of the texts that this thread produces. Per thread, because several tests run in parallel.
    static CURRENT: Cell<Language> = const { Cell::new(Language::English) };
}

/// The language of this thread's texts.
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
        $crate::view::language::text_by_id($id)
    };
    ($id:literal, $($name:ident = $value:expr),+ $(,)?) => {
        $crate::view::language::text_with_arguments(
            $id,
            &[$((stringify!($name), $crate::view::language::FluentArgument::value(&$value))),+],
        )
    };
}
pub(crate) use text;

/// An argument of a message: text, or a count that chooses a plural form. Numbers with decimals are passed as text from [`decimal`] or [`signed`].
pub(crate) trait FluentArgument {
    /// The argument as Fluent takes it.
    fn value(&self) -> FluentValue<'_>;
}

impl FluentArgument for str {
    fn value(&self) -> FluentValue<'_> {
        self.into()
    }
}

impl FluentArgument for String {
    fn value(&self) -> FluentValue<'_> {
        self.as_str().into()
    }
}

impl FluentArgument for std::borrow::Cow<'_, str> {
    fn value(&self) -> FluentValue<'_> {
        self.as_ref().into()
    }
}

impl FluentArgument for std::path::Display<'_> {
    fn value(&self) -> FluentValue<'_> {
        self.to_string().into()
    }
}

impl<T: FluentArgument + ?Sized> FluentArgument for &T {
    fn value(&self) -> FluentValue<'_> {
        (**self).value()
    }
}

macro_rules! integer_arguments {
    ($($integer:ty),*) => {$(
        impl FluentArgument for $integer {
            fn value(&self) -> FluentValue<'_> {
                (*self).into()
            }
        }
    )*};
}
integer_arguments!(u8, u16, u32, u64, usize, i32, i64);

/// The messages of a language.
struct Messages {
    /// Whether messages and text arguments get marks, as in [`Language::MarkedEnglish`].
    is_marked: bool,
    /// The formatted messages without arguments, by id.
    without_arguments: HashMap<String, String>,
    /// All messages of the language; for [`Language::MarkedEnglish`] the English ones, without marks.
    bundle: FluentBundle<FluentResource>,
}

impl Messages {
    /// Reads the messages of a language from its built-in files.
    fn of(language: Language) -> Self {
        let mut bundle = FluentBundle::new_concurrent(vec![language.identifier()]);
        // The Unicode isolation marks that Fluent puts around arguments would show as boxes.
        bundle.set_use_isolating(false);
        let is_marked = language == Language::MarkedEnglish;
        let mut without_arguments = HashMap::new();
        let all_files = || files::message_files(language).iter().chain(files::catalog_files(language));
        for file in all_files() {
            // Invalid entries of a file are skipped; a test finds them.
            let resource = FluentResource::try_new((*file).to_owned()).unwrap_or_else(|(resource, _)| resource);
            let _ = bundle.add_resource(resource);
        }
        for id in all_files().flat_map(|file| files::ids(file)) {
            let mut errors = Vec::new();
            let pattern = bundle.get_message(id).and_then(|message| message.value());
            let text = pattern.map(|pattern| bundle.format_pattern(pattern, None, &mut errors).into_owned());
            // Without arguments, only the messages that need none are formatted without errors.
            if errors.is_empty() {
                without_arguments.extend(text.map(|text| (id.to_owned(), if is_marked { marked_message(&text) } else { text })));
            }
        }
        Self { is_marked, without_arguments, bundle }
    }

    /// A message with its arguments; `None` if the message or one of its arguments is missing.
    fn with_arguments(&self, id: &str, arguments: &FluentArgs<'_>) -> Option<String> {
        let pattern = self.bundle.get_message(id)?.value()?;
        let mut errors = Vec::new();
        if !self.is_marked {
            let text = self.bundle.format_pattern(pattern, Some(arguments), &mut errors).into_owned();
            return errors.is_empty().then_some(text);
        }
        let marked_arguments: FluentArgs<'_> = arguments.iter().map(|(name, value)| (name, marked_argument(value))).collect();
        let text = self.bundle.format_pattern(pattern, Some(&marked_arguments), &mut errors).into_owned();
        errors.is_empty().then(|| marked_message(&text))
    }
}

fn marked_message(text: &str) -> String {
    format!("«{text}»")
}

/// Marks a text argument. Numbers stay unchanged, because they choose plural forms.
fn marked_argument<'v>(value: &FluentValue<'v>) -> FluentValue<'v> {
    match value {
        FluentValue::String(text) => format!("‹{text}›").into(),
        other => other.clone(),
    }
}

static ENGLISH: LazyLock<Messages> = LazyLock::new(|| Messages::of(Language::English));
static GERMAN: LazyLock<Messages> = LazyLock::new(|| Messages::of(Language::German));
static MARKED: LazyLock<Messages> = LazyLock::new(|| Messages::of(Language::MarkedEnglish));

/// The messages of a language, read at its first use, since a window normally uses one language.
fn messages(language: Language) -> &'static Messages {
    match language {
        Language::English => &ENGLISH,
        Language::German => &GERMAN,
        Language::MarkedEnglish => &MARKED,
    }
}

/// The result of `find` for the current language, or else for English.
fn with_fallback<T>(find: impl Fn(&'static Messages) -> Option<T>) -> Option<T> {
    find(messages(current())).or_else(|| find(messages(Language::English)))
}

/// The text of a message without arguments. Unlike `text!`, it takes an id that is not a literal.
pub(crate) fn text_by_id(id: &'static str) -> &'static str {
    with_fallback(|messages| messages.without_arguments.get(id)).map_or(id, String::as_str)
}

/// The text of a message with its arguments.
pub(crate) fn text_with_arguments(id: &'static str, arguments: &[(&'static str, FluentValue<'_>)]) -> String {
    let arguments: FluentArgs<'_> = arguments.iter().map(|(name, value)| (*name, value.clone())).collect();
    with_fallback(|messages| messages.with_arguments(id, &arguments)).unwrap_or_else(|| id.to_owned())
}

/// The translation of a name that another module gave to a thing (an effect, a body). It is the message `kind-name`, with the name in lower case and hyphens
/// for its spaces and underscores. Without such a message the name stays as given.
pub(crate) fn translated_name<'n>(kind: &str, name: &'n str) -> &'n str {
    let id = format!("{kind}-{}", name.to_lowercase().replace([' ', '_'], "-"));
    with_fallback(|messages| messages.without_arguments.get(&id)).map_or(name, String::as_str)
}

/// The translated name of a body of the catalog.
pub(crate) fn body_name(name: &str) -> &str {
    translated_name("body", name)
}

#[cfg(test)]
mod message_tests;
#[cfg(test)]
mod tests;
