//! What is given instead of a file of data.

use std::fs::{self, File};

use super::Folder;
use super::support::recordings::run_csv;

/// Formats of recordings, each with whether this build reads it.
const FORMATS: [(&str, bool); 4] =
    [("csv", true), ("mat", true), ("parquet", cfg!(feature = "parquet")), ("mcap", cfg!(feature = "mcap"))];

fn formats() -> impl Iterator<Item = &'static str> {
    FORMATS.into_iter().filter(|(_, read)| *read).map(|(format, _)| format)
}

#[cfg(unix)]
#[test]
fn regress_devices_and_pipes_are_refused_at_once() {
    use std::os::unix::fs::symlink;
    let folder = Folder::new();
    for format in formats().chain(["toml"]) {
        for (device, kind) in [("zero", "(a device)"), ("null", "(a device)")] {
            let name = format!("{device}.{format}");
            symlink(format!("/dev/{device}"), folder.path(&name)).expect("a link");
            folder.refuses_data(&name, &[&name, kind, "a regular file"]);
            folder.refuses(&["check", &name], &[&name, kind, "a regular file"]);
            if format != "toml" {
                folder.refuses(&["data", &name], &[&name, kind, "a regular file"]);
            }
        }
        let name = format!("pipe.{format}");
        let made = std::process::Command::new("mkfifo").arg(folder.path(&name)).status().expect("mkfifo");
        assert!(made.success());
        folder.refuses_data(&name, &[&name, "(a pipe)", "a regular file"]);
        folder.refuses(&["check", &name], &[&name, "(a pipe)", "a regular file"]);
        let name = format!("folder.{format}");
        fs::create_dir(folder.path(&name)).expect("a folder");
        folder.refuses_data(&name, &[&name, "(a folder)", "a regular file"]);
        folder.refuses(&["check", &name], &[&name, "(a folder)", "a regular file"]);
    }
    let listener = std::os::unix::net::UnixListener::bind(folder.path("socket.csv")).expect("a socket");
    folder.refuses_data("socket.csv", &["socket.csv", "(a socket)", "a regular file"]);
    drop(listener);
    symlink(folder.path("gone"), folder.path("dangling.csv")).expect("a link");
    folder.refuses_data("dangling.csv", &["dangling.csv: cannot read"]);
    // A link to a file of data is that file.
    folder.put("run.csv", run_csv());
    symlink(folder.path("run.csv"), folder.path("link.csv")).expect("a link");
    folder.reads("link.csv", &["200 samples"]);
}

#[test]
fn regress_a_file_of_any_size_is_refused_before_it_is_read() {
    let folder = Folder::new();
    for format in formats() {
        let name = format!("large.{format}");
        // 3 GiB of nothing: it takes no room on the disk.
        File::create(folder.path(&name)).and_then(|file| file.set_len(3 << 30)).expect("a sparse file");
        folder.refuses_data(&name, &[&name, "size = 3 GiB", "at most 2 GiB", "shorter sessions"]);
        let name = format!("empty.{format}");
        folder.put(&name, "");
        folder.refuses_data(&name, &[&name, "size = 0 bytes", "not empty"]);
    }
    File::create(folder.path("large.toml")).and_then(|file| file.set_len(20 << 20)).expect("a sparse file");
    folder.refuses_data("large.toml", &["large.toml: size = 20 MiB", "at most 16 MiB"]);
    folder.refuses(&["check", "large.toml"], &["large.toml: size = 20 MiB", "at most 16 MiB"]);
}

#[test]
fn regress_what_is_no_file_of_data_is_refused() {
    let folder = Folder::new();
    for (name, format) in [("data.xlsx", "xlsx"), ("data", "no extension"), ("data.csv.gz", "gz"), ("data.txt", "txt")]
    {
        folder.put(name, run_csv());
        folder.refuses_data(
            name,
            &[name, &format!("format = {format}"), ".csv", ".mat", ".parquet", ".mcap", "manifest"],
        );
    }
    for name in ["gone.csv", "gone.mat", "gone.parquet", "gone.toml", "gone/run.csv"] {
        folder.refuses_data(name, &[name, "cannot read"]);
    }
    folder.refuses(&["data", "gone.mat"], &["gone.mat"]);
    folder.refuses(&["check", "gone.toml"], &["gone.toml"]);
    folder.refuses_data("model.toml", &["model.toml:1", "schema", "lostmotion/dataset/1"]);
    folder.refuses_data(".", &[".", "format = no extension"]);
}
