//! Long recordings of six joints at 1 kHz, and how much memory the program takes for them.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

const ROBOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/robots/sixaxis/model.toml");

/// A scenario file in `folder`: all joints move fast for about so many seconds, then `procedure`.
pub fn scenario(folder: &Path, seconds: u32, procedure: &str) -> String {
    let mut text = format!(
        "schema = \"lostmotion/scenario/1\"\nname = \"long\"\nquestion = \"How much memory?\"\nrobot = \"{ROBOT}\"\n\
         sensors = \"model\"\ncontrol_period = 0.001\nprocedure = \"{procedure}\"\n\n[[session]]\nname = \"long\"\n\
         kind = \"fast\"\nrest = 1.0\nduration = {seconds}\nlongest_rest = 0.2\nseed = 1\n"
    );
    // Middle, half the range [rad], speed [rad/s], acceleration [rad/s²], inertia [kg·m²] that the controller is made for.
    let joints = [
        (0.0, 1.2, 1.5, 4.0, 6.0),
        (0.3, 0.6, 1.0, 3.0, 7.0),
        (-0.5, 0.6, 1.2, 4.0, 2.5),
        (0.0, 1.2, 2.0, 8.0, 0.15),
        (0.2, 1.0, 2.0, 8.0, 0.15),
        (0.0, 1.5, 3.0, 12.0, 0.03),
    ];
    for (joint, (middle, ..)) in (1..).zip(joints) {
        text += &format!("start.joint{joint} = {middle}\n");
    }
    for (joint, (middle, half, speed, acceleration, _)) in (1..).zip(joints) {
        text += &format!(
            "[session.joints.joint{joint}]\nlowest = {}\nhighest = {}\nspeed = {speed}\nacceleration = {acceleration}\n",
            middle - half,
            middle + half
        );
    }
    text += "[controller]\nlaw = \"pi\"\nvelocity = \"sensor\"\n";
    for (joint, (.., inertia)) in (1..).zip(joints) {
        let (proportional, integral) = (30.0 * inertia, 300.0 * inertia);
        text += &format!("[controller.joints.joint{joint}]\nproportional = {proportional}\nintegral = {integral}\n");
    }
    let file = folder.join(format!("{procedure}_{seconds}.toml"));
    std::fs::write(&file, text).expect("a scenario");
    file.display().to_string()
}

/// What a command took.
pub struct Taken {
    /// [bytes] most memory that was resident at a time.
    pub peak: u64,
    /// Wall-clock time; of no interest to a test.
    #[allow(dead_code)]
    pub time: Duration,
}

/// Runs the program at `binary` with results in `out`; exit codes 0 and 3 are good.
pub fn taken(binary: &str, arguments: &[&str], out: Option<&Path>, threads: Option<u32>) -> Taken {
    let begin = Instant::now();
    let mut command = Command::new(binary);
    command.args(arguments).stdout(Stdio::null()).stderr(Stdio::null());
    if let Some(out) = out {
        command.arg("--quiet").arg("--out").arg(out);
    }
    if let Some(threads) = threads {
        command.env("RAYON_NUM_THREADS", threads.to_string());
    }
    let mut child = command.spawn().expect("the program");
    let status = format!("/proc/{}/status", child.id());
    let mut peak = 0;
    loop {
        // The system keeps the highest mark: only what the last millisecond adds is missed.
        peak = peak.max(high_water(&status).unwrap_or(0));
        if let Some(ended) = child.try_wait().expect("its end") {
            assert!(matches!(ended.code(), Some(0 | 3)), "{arguments:?}: {ended}");
            return Taken { peak, time: begin.elapsed() };
        }
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// [bytes] `VmHWM` of a status file of Linux.
fn high_water(status: &str) -> Option<u64> {
    let text = std::fs::read_to_string(status).ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(1024 * line.trim().strip_suffix(" kB")?.parse::<u64>().ok()?)
}

/// The robot's model file.
pub const MODEL: &str = ROBOT;
