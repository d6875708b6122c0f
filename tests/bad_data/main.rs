//! Broken data of every kind: the program says what is wrong where, ends with exit code 2, writes nothing, and never hangs.
//!
//! A case is a file, a command that reads it, and what its one message has to say. The whole folder runs in seconds: a reader that
//! reads on without end fails by its time limit.

mod csv;
mod files;
mod identity;
mod make;
mod manifests;
mod mat;
#[cfg(feature = "mcap")]
mod mcap;
mod mutated;
#[cfg(feature = "parquet")]
mod parquet;
mod time;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use tempfile::TempDir;

/// Longest that a refusal may take: it comes within 0.1 s; the rest is room for a busy machine.
const LIMIT: Duration = Duration::from_secs(10);

const URDF: &str = r#"<robot name="turntable">
  <link name="base"/>
  <link name="table">
    <inertial><mass value="2"/><inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.03"/></inertial>
  </link>
  <joint name="turn" type="revolute">
    <parent link="base"/><child link="table"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" effort="5" velocity="40"/>
  </joint>
</robot>
"#;

const MODEL: &str = r#"schema = "lostmotion/model/1"
name = "turntable"
urdf = "robot.urdf"

[joints.turn]
gear_ratio = 5.0
rotor_inertia = 0.0008
gear_stiffness = 3000.0
gear_damping = 2.0
backlash = 0.008

[joints.turn.motor]
torque_constant = 0.023

[joints.turn.friction]
coulomb = 0.3
viscous = 0.4
"#;

/// A folder with a model.
struct Folder(TempDir);

impl Folder {
    fn new() -> Self {
        let folder = Self(tempfile::tempdir().expect("a temporary folder"));
        folder.put("robot.urdf", URDF);
        folder.put("model.toml", MODEL);
        folder
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn put(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        fs::write(self.path(name), content).expect("a file in a temporary folder");
        self.path(name)
    }

    /// Runs the program here, for at most [`LIMIT`].
    #[track_caller]
    fn run(&self, arguments: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lostmotion"));
        command.args(arguments).current_dir(self.0.path()).env_remove("LOSTMOTION_DATA");
        let mut child = command
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program runs");
        let start = Instant::now();
        // Its messages are shorter than what a pipe holds, so that it never waits for this reader.
        while child.try_wait().expect("a state").is_none() {
            if start.elapsed() > LIMIT {
                child.kill().expect("ended");
                panic!("{arguments:?} takes longer than {LIMIT:?}");
            }
            std::thread::sleep(Duration::from_millis(2));
        }
        child.wait_with_output().expect("its output")
    }

    #[track_caller]
    fn replay(&self, data: &str) -> Output {
        self.run(&["replay", "--quiet", "--out", "out", "--model", "model.toml", "--data", data])
    }

    /// Runs a command and asserts exit code 2, these parts in its one message, nothing printed and nothing written.
    #[track_caller]
    fn refuses(&self, arguments: &[&str], parts: &[&str]) {
        let before = names(self.0.path());
        let output = self.run(arguments);
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
        assert!(message.starts_with("error: "), "{message}");
        for word in ["panicked", "unwrap", "Error {", "Kind(", "thread '", "RUST_BACKTRACE"] {
            assert!(!message.contains(word), "debug text: {message}");
        }
        assert!(message.len() < 3000 && message.lines().count() == 1, "one short message: {message}");
        for part in parts {
            assert!(message.contains(part), "`{part}` not in: {message}");
        }
        assert!(output.stdout.is_empty(), "{}", String::from_utf8_lossy(&output.stdout));
        assert_eq!(names(self.0.path()), before, "nothing is written by {arguments:?}");
    }

    /// `replay` refuses the data.
    #[track_caller]
    fn refuses_data(&self, name: &str, parts: &[&str]) {
        self.refuses(&["replay", "--quiet", "--out", "out", "--model", "model.toml", "--data", name], parts);
    }

    /// `check` reads the file, and says this.
    #[track_caller]
    fn reads(&self, name: &str, parts: &[&str]) {
        let output = self.run(&["check", name]);
        let text = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
        for part in parts {
            assert!(text.contains(part), "`{part}` not in: {text}");
        }
    }
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("the folder");
    let mut names: Vec<String> =
        entries.map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// Asserts that each content of a file of this name is refused with these parts in the message, the name among them.
#[track_caller]
fn each_is_refused<C: AsRef<[u8]>>(name: &str, cases: &[(C, &[&str])]) {
    let folder = Folder::new();
    for (content, parts) in cases {
        folder.put(name, content);
        folder.refuses_data(name, &[&[name], *parts].concat());
    }
}
