// SPDX-License-Identifier: MIT OR Apache-2.0
//! Files that a verb writes: all of them whole, or none. `-` is standard output.

use crate::input::is_standard;
use crate::outcome::Failure;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

/// Refuses paths that cannot be written, before any work is done.
pub(crate) fn check_paths<'a>(paths: impl IntoIterator<Item = &'a Path>) -> Result<(), Failure> {
    let mut seen: Vec<&Path> = Vec::new();
    for path in paths {
        let refuse = |what: &str| {
            Failure::bad_input(format!("{}: cannot be written: {what}", path.display()))
        };
        if path.is_dir() || path.file_name().is_none() {
            return Err(refuse("is a directory, allowed: a file"));
        }
        if !folder_of(path).is_dir() {
            let folder = folder_of(path).display();
            return Err(refuse(&format!("there is no folder {folder}")));
        }
        if seen.contains(&path) {
            return Err(refuse("two outputs have this path"));
        }
        seen.push(path);
    }
    Ok(())
}

/// Refuses names of pictures that promise another format than these. Standard output, pipes and devices
/// have none.
///
/// - `formats`: their extensions
pub(crate) fn check_pictures<'a>(
    paths: impl IntoIterator<Item = &'a Path>,
    formats: &[&str],
) -> Result<(), Failure> {
    for path in paths {
        let extension = path.extension().unwrap_or_default();
        let is_allowed = formats
            .iter()
            .any(|format| extension.eq_ignore_ascii_case(format));
        if !(is_allowed || is_standard(path) || (path.exists() && !path.is_file())) {
            let found = if extension.is_empty() {
                "no extension".to_owned()
            } else {
                format!(".{}", extension.display())
            };
            let (path, allowed) = (path.display(), formats.join(", ."));
            return Err(Failure::bad_input(format!(
                "{path}: found {found}, allowed: .{allowed}"
            )));
        }
    }
    Ok(())
}

/// Writes every file beside its place and then renames them all: a disk that fills up, or a killed
/// process, leaves no half of a file under a name that was asked for.
pub(crate) fn write_all(files: &[(&Path, Vec<u8>)]) -> Result<(), Failure> {
    let unfinished: Vec<PathBuf> = files.iter().map(|(path, _)| beside(path)).collect();
    let written = files
        .iter()
        .zip(&unfinished)
        .try_for_each(|((path, bytes), beside)| {
            let written = if is_standard(path) {
                to_standard_output(bytes)
            } else {
                std::fs::write(beside, bytes)
            };
            match written {
                // A pipe by its name, such as /dev/stdout, whose reader has seen enough.
                Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
                written => written.map_err(|error| unwritable(path, &error)),
            }
        })
        .and_then(|()| {
            let mut renames = files.iter().zip(&unfinished);
            renames.try_for_each(|((path, _), beside)| match beside {
                same if same == path => Ok(()),
                _ => std::fs::rename(beside, path).map_err(|error| unwritable(path, &error)),
            })
        });
    if written.is_err() {
        for ((path, _), beside) in files.iter().zip(&unfinished) {
            if beside != path {
                // Those renamed already are no longer there, which is all right.
                drop(std::fs::remove_file(beside));
            }
        }
    }
    written
}

fn to_standard_output(bytes: &[u8]) -> io::Result<()> {
    let mut out = io::stdout().lock();
    out.write_all(bytes)?;
    out.flush()
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    }
}

/// `folder/.name.unfinished`; the path itself when it is standard output, a pipe or a device.
fn beside(path: &Path) -> PathBuf {
    if is_standard(path) || (path.exists() && !path.is_file()) {
        return path.to_owned();
    }
    let mut name = std::ffi::OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    name.push(".unfinished");
    path.with_file_name(name)
}

fn unwritable(path: &Path, error: &io::Error) -> Failure {
    Failure::bad_input(format!("{}: cannot be written: {error}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_written_whole_and_replace_older_ones() {
        let folder = tempfile::tempdir().expect("a folder");
        let (a, b) = (folder.path().join("a"), folder.path().join("b"));
        std::fs::write(&a, "an older and longer text").expect("writable");
        write_all(&[(&a, b"new".to_vec()), (&b, b"other".to_vec())]).expect("writable");
        assert_eq!(std::fs::read(&a).expect("there"), b"new");
        assert_eq!(std::fs::read(&b).expect("there"), b"other");
        let names = std::fs::read_dir(folder.path()).expect("a folder").count();
        assert_eq!(names, 2, "nothing else stays");
    }

    #[test]
    fn one_file_that_fails_takes_the_others_with_it() {
        let folder = tempfile::tempdir().expect("a folder");
        let good = folder.path().join("good");
        let bad = folder.path().join("none").join("bad");
        let failure = write_all(&[(&good, vec![1]), (&bad, vec![2])]).expect_err("no such folder");
        assert!(failure.message.contains("none/bad"), "{}", failure.message);
        let names = std::fs::read_dir(folder.path()).expect("a folder").count();
        assert_eq!(names, 0, "no part of the output stays");
    }

    #[test]
    fn pictures_have_one_of_the_formats() {
        let check_pictures = |paths| super::check_pictures(paths, &["png"]);
        for right in ["a.png", "b/A.PNG", "a.b.png", "/dev/null", "-"] {
            assert!(check_pictures(vec![Path::new(right)]).is_ok(), "{right}");
        }
        for (wrong, found) in [
            ("a.jpg", ".jpg"),
            ("png", "no extension"),
            ("a.png.tiff", ".tiff"),
        ] {
            let paths = vec![Path::new("right.png"), Path::new(wrong)];
            let failure = check_pictures(paths).expect_err(wrong);
            assert_eq!(
                failure.message,
                format!("{wrong}: found {found}, allowed: .png")
            );
        }
        let both = |path| super::check_pictures([Path::new(path)], &["png", "jpg"]);
        assert!(both("a.jpg").is_ok() && both("a.tiff").is_err());
    }

    #[test]
    fn paths_are_refused_before_the_work() {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("f");
        assert!(check_paths([file.as_path(), Path::new("f")]).is_ok());
        let refused = [
            vec![folder.path()],
            vec![file.as_path(), file.as_path()],
            vec![Path::new("/")],
        ];
        for paths in refused {
            assert!(check_paths(paths.clone()).is_err(), "{paths:?}");
        }
        let nowhere = folder.path().join("none").join("f");
        let failure = check_paths([nowhere.as_path()]).expect_err("no such folder");
        assert!(failure.message.contains("there is no folder"));
    }
}
