//! Files that others name: whether they are there, and whether links lead out of their folder.
//!
//! In: paths. Out: yes or no, or an error. Nothing is opened.

use std::io::{Error, ErrorKind, Result};
use std::path::Path;

/// Whether something has this path: a file, but also a folder or a link that leads nowhere, in the place of a file, so that reading it gives an error.
pub(crate) fn is_there(path: &Path) -> bool {
    path.symlink_metadata().is_ok()
}

/// Checks that a file is inside a folder after links are resolved. Used for files that a catalog or label names, because their folder may come from an
/// untrusted source.
///
/// # Errors
/// The file is outside the folder, or one of them does not exist.
pub(crate) fn check_inside(folder: &Path, path: &Path) -> Result<()> {
    let target = path.canonicalize().map_err(|e| match e.kind() {
        ErrorKind::NotFound if path.is_symlink() => Error::new(ErrorKind::NotFound, "a link to a file that does not exist"),
        _ => e,
    })?;
    match target.starts_with(folder.canonicalize()?) {
        true => Ok(()),
        false => Err(Error::new(ErrorKind::InvalidInput, "a link that leads out of its folder; put the file itself there")),
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn links_that_lead_out_of_a_folder_are_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir_all(at("own/deep")).expect("a folder");
        std::fs::create_dir(at("own-too")).expect("a folder");
        for name in ["own/map", "own-too/map", "secret"] {
            std::fs::write(at(name), name).expect("a file");
        }
        let link = |to: &str, name: &str| std::os::unix::fs::symlink(to, at(name)).expect("a link");
        link("map", "own/near");
        link("../secret", "own/up");
        link("../own-too/map", "own/beside");
        link("/etc/passwd", "own/far");
        link("../..", "own/deep/root");
        link("own", "alias");
        let own = at("own");
        for name in ["map", "near"] {
            assert!(check_inside(&own, &own.join(name)).is_ok() && check_inside(&at("alias"), &at("alias").join(name)).is_ok(), "{name}");
        }
        for name in ["up", "beside", "far", "../secret", "/etc/passwd", "deep/root/secret", "none", "near/x"] {
            assert!(check_inside(&own, &own.join(name)).is_err(), "{name}");
        }
        link("/not/mounted", "own/dangling");
        let texts = ["dangling", "none"].map(|name| check_inside(&own, &own.join(name)).expect_err(name).to_string());
        assert!(texts[0] == "a link to a file that does not exist" && texts[1] != texts[0], "{texts:?}");
        assert_eq!(["map", "deep", "dangling", "none"].map(|name| is_there(&own.join(name))), [true, true, true, false]);
    }
}
