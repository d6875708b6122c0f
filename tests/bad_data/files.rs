//! What is given instead of a file of data.

use std::fs::{self, File};

use super::Folder;
use super::support::recordings::run_csv;

/// Formats of recordings, each with whether this build reads it.
const FORMATS: [(&str, bool); 5] = [
    ("csv", true),
    ("mat", true),
    ("parquet", cfg!(feature = "parquet")),
    ("mcap", cfg!(feature = "mcap")),
    ("db3", cfg!(feature = "db3")),
];

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
    // The name does not matter where the content is data.
    for name in ["data.xlsx", "data", "data.log", "data.txt"] {
        folder.put(name, run_csv());
        folder.reads(name, &["200 samples"]);
    }
    let sheet = [b"PK\x03\x04".as_slice(), &[0; 22], &[19, 0, 0, 0], b"[Content_Types].xml"].concat();
    let others: [(&[u8], &[&str]); 8] = [
        (&sheet, &["spreadsheet", "CSV"]),
        (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", &["an old spreadsheet", "CSV"]),
        (b"#ROSBAG V2.0\n", &["a bag of ROS 1", "mcap convert run.log run.mcap"]),
        (b"ARROW1\0\0", &["Feather", "read_feather('run.log')"]),
        (b"\x28\xb5\x2f\xfd\0", &["compressed by zstd", "unzstd run.log -o run`"]),
        (b"\x80\x04\x95", &["a pickle of Python", "read_pickle('run.log')"]),
        (b"\x1f\x8b\x08 no gzip", &["cannot read"]),
        (b"PK\x03\x04", &["ZIP"]),
    ];
    for (content, parts) in others {
        folder.put("run.log", content);
        folder.refuses_data("run.log", &[&["run.log"], parts].concat());
        folder.refuses(&["data", "run.log"], &[&["run.log"], parts].concat());
    }
    // A name that a shell would take apart is not put into a command.
    let quoted = folder.put("it's; rm.h5", b"\x89HDF\r\n\x1a\n");
    let message = lostmotion::dataset::read_table(&quoted).expect_err("refused").to_string();
    assert!(message.contains("h5py.File('FILE')"), "{message}");
    for name in ["gone.csv", "gone.mat", "gone.parquet", "gone.toml", "gone/run.csv"] {
        folder.refuses_data(name, &[name, "cannot read"]);
    }
    folder.refuses(&["data", "gone.mat"], &["gone.mat"]);
    folder.refuses(&["check", "gone.toml"], &["gone.toml"]);
    folder.refuses_data("model.toml", &["model.toml:1", "schema", "lostmotion/dataset/1"]);
    folder.refuses_data(".", &[".", "(a folder)", "a regular file"]);
}
