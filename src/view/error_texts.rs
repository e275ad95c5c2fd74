//! The texts of errors of the program's modules (session, scene, ephemeris, files, links) in the window's language.
//!
//! In: an error. Out: one line. Always: common errors (a time outside the ephemeris, a camera inside a body, a file that cannot be read or written)
//! are translated completely; for other errors a translated sentence says what failed, and the English detail follows. In English the text of an
//! error is the same as on the command line.

use crate::ephemeris::EphemerisError;
use crate::files::WriteError;
use crate::image::ImageError;
use crate::message::{Argument, Message, message};
use crate::render::plan::PlanError;
use crate::scene::SceneError;
use crate::session::{RendererError, SessionError};
use crate::shader::key::KeyTextError;
use crate::view::app::view_state::ViewStateError;
use crate::view::language::{message_text, text};
use crate::view::link::{SCHEME, ViewTextError};
use std::error::Error;

/// The text of an error in the window's language.
pub(crate) fn error_text(error: &(dyn Error + 'static)) -> String {
    message_text(&error_message(error))
}

/// Why a link or a file is not opened.
#[derive(Clone, Debug, PartialEq)]
pub struct UnreadFile {
    /// For standard error.
    pub in_english: String,
    /// In the window's language.
    pub in_window: String,
}

impl UnreadFile {
    /// A file that cannot be read. `file`: as messages quote it.
    pub(crate) fn of_file(file: &str, why: String) -> Self {
        let in_english = format!("{file}: {why}; a link starts with {SCHEME}");
        let reason = message!("error-file", path = Argument::English(file.to_owned()), why = Argument::English(why));
        Self { in_english, in_window: text!("warning-no-file", reason = message_text(&reason), scheme = SCHEME) }
    }

    /// A file that the session cannot read as data; the error names the file.
    pub(crate) fn of_error(error: &SessionError) -> Self {
        Self { in_english: error.to_string(), in_window: error_text(error) }
    }

    /// A link, or the text of a file, that describes no view and no tour. `link`: the link or the file, as messages quote it.
    pub(crate) fn of_text(link: &str, error: &(dyn Error + 'static)) -> Self {
        Self { in_english: format!("{link}: {error}"), in_window: format!("{link}: {}", error_text(error)) }
    }
}

fn error_message(error: &(dyn Error + 'static)) -> Message {
    let detail = || Argument::English(error.to_string());
    if let Some(e) = error.downcast_ref::<SessionError>() {
        return session_error_message(e);
    }
    if let Some(e) = error.downcast_ref::<SceneError>() {
        return scene_error_message(e);
    }
    if let Some(EphemerisError(why)) = error.downcast_ref() {
        return why.clone();
    }
    if let Some(WriteError { path, why }) = error.downcast_ref() {
        return message!("error-write", path = Argument::English(path.clone()), why = Argument::English(why.clone()));
    }
    match error.downcast_ref() {
        Some(ViewTextError::Fields(_)) => return message!("error-request", detail = detail()),
        Some(ViewTextError::View(e)) => return error_message(e),
        Some(ViewTextError::Session(e)) => return session_error_message(e),
        None => {}
    }
    match error.downcast_ref() {
        Some(ViewStateError::Ephemeris(EphemerisError(why))) => why.clone(),
        Some(ViewStateError::Request(e)) => scene_error_message(e),
        Some(ViewStateError::Field(_) | ViewStateError::NoSuchBody(_)) => message!("error-request", detail = detail()),
        None if error.is::<ImageError>() => message!("error-map", detail = detail()),
        None if error.is::<KeyTextError>() => message!("error-key", detail = detail()),
        None => message!("error-other", detail = detail()),
    }
}

fn session_error_message(error: &SessionError) -> Message {
    let detail = Argument::English(error.to_string());
    match error {
        SessionError::File { path, why } => {
            message!("error-file", path = Argument::English(path.clone()), why = Argument::English(why.clone()))
        }
        SessionError::Catalog(_) | SessionError::Stars(_) | SessionError::SmallBodies(_) => message!("error-catalog", detail = detail),
        SessionError::Ephemeris(EphemerisError(why)) => why.clone(),
        SessionError::Scene(e) => scene_error_message(e),
        SessionError::Plan(PlanError::Map { .. }) => message!("error-map", detail = detail),
        SessionError::Plan(_) | SessionError::Shaders(_) | SessionError::CustomSurface(_) => message!("error-shader", detail = detail),
        SessionError::Renderer(RendererError::Software(_)) => message!("error-drawing", detail = detail),
        SessionError::Renderer(_) => message!("error-gpu", detail = detail),
    }
}

fn scene_error_message(error: &SceneError) -> Message {
    match error {
        SceneError::Ephemeris(EphemerisError(why)) => why.clone(),
        SceneError::Inside(body) => message!("error-inside", body = body),
        SceneError::Unknown(_) => message!("error-unknown", detail = Argument::English(error.to_string())),
        SceneError::OutOfRange(_)
        | SceneError::EffectBody(_)
        | SceneError::CameraField { .. }
        | SceneError::Request(_)
        | SceneError::NotABody(_) => message!("error-request", detail = Argument::English(error.to_string())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalog::{Catalog, NaifId};
    use crate::ephemeris::{BEST_SOURCE, Ephemeris};
    use crate::scene::SceneError;
    use crate::shader::key::ShaderKey;
    use crate::time::Instant;
    use crate::view::language::{Language, set};

    /// The dialog about a wrong file or link of the command line was in English.
    #[test]
    fn the_dialog_about_the_view_of_the_command_line_is_in_the_language_of_the_window() {
        let of_file = || UnreadFile::of_file("/tmp/x.json", "No such file or directory (os error 2)".into());
        let of_text = || UnreadFile::of_text("orrery://view?aim=3", &ViewTextError::Fields(vec!["aim: no such field".into()]));
        set(Language::English);
        for unread in [of_file(), of_text()] {
            assert_eq!(unread.in_english, unread.in_window);
        }
        set(Language::German);
        for (unread, german) in [
            (
                of_file(),
                "/tmp/x.json kann nicht gelesen werden: keine solche Datei, kein solcher Ordner; ein Link beginnt mit orrery://view?",
            ),
            (of_text(), "orrery://view?aim=3: Diese Ansicht ist nicht möglich: aim: no such field"),
        ] {
            assert_eq!(unread.in_window, german);
            assert!(unread.in_english.is_ascii(), "{unread:?}");
        }
        set(Language::English);
    }

    /// In English an error reads as on the command line. In German a common error is translated; any other has a German sentence before it.
    #[test]
    fn errors_are_translated_to_german_and_unchanged_in_english() {
        let boxed = |e: SessionError| Box::new(e) as Box<dyn Error>;
        let catalog = Catalog::embedded();
        let ephemeris = Ephemeris::embedded(&catalog).expect("an ephemeris");
        let late = Instant::parse("9999-12-31T00:00:00Z").expect("a time");
        let outside = || ephemeris.state(NaifId::MOON, NaifId::EARTH, late, BEST_SOURCE).expect_err("too late");
        let denied = || "Permission denied (os error 13)".to_owned();
        let misspelt = "lambert.albdo.sun1".parse::<ShaderKey>().expect_err("no such word");
        let errors: [(Box<dyn Error>, &str); 9] = [
            (Box::new(misspelt), "Das ist kein Shader-Schlüssel: shader key `lambert.albdo.sun1`: `albdo` "),
            (boxed(SessionError::Ephemeris(outside())), "Zeitraum der Quellen für Mond: 23. November 3002 v. Chr. (greg.) bis "),
            (boxed(SessionError::Scene(SceneError::Inside("Moon".into()))), "Die Kamera ist im Inneren von Mond: "),
            (boxed(SessionError::File { path: "a.toml".into(), why: denied() }), "a.toml kann nicht gelesen werden: keine Berechtigung"),
            (Box::new(WriteError { path: "a.png".into(), why: denied() }), "a.png kann nicht geschrieben werden: keine Berechtigung"),
            (
                boxed(SessionError::Plan(PlanError::Map { file: "m.png".into(), why: "cut".into() })),
                "Eine Karte ist nicht lesbar: map m.png: cut",
            ),
            // An error of the view that a link describes has the same text as without the link.
            (
                Box::new(ViewTextError::Session(SessionError::Ephemeris(outside()))),
                "Zeitraum der Quellen für Mond: 23. November 3002 v. Chr. (greg.) bis ",
            ),
            (Box::new(ViewTextError::Fields(vec!["aim: no such field".into()])), "Diese Ansicht ist nicht möglich: aim: no such field"),
            (Box::new(std::io::Error::other("odd")), "Ein Fehler ist aufgetreten: odd"),
        ];
        for (error, german) in &errors {
            set(Language::English);
            assert_eq!(error_text(&**error), error.to_string());
            set(Language::German);
            assert!(error_text(&**error).starts_with(german), "{}", error_text(&**error));
        }
        set(Language::English);
    }
}
