//! The whole recording: the path of every entity, and the encoding in memory.

use rerun::sink::BinaryStreamStorage;
use rerun::{RecordingStream, RecordingStreamBuilder};

use super::blueprint::Layout;
use super::entities::{APPLICATION, colour, failed, log_static, times};
use super::{Motion, Trace, arm, canvas, traces};
use crate::error::Result;
use crate::report::document::Document;
use crate::report::plot::Plot;
use crate::units::JointKind;

/// [s] Pause between two motions.
const PAUSE: f64 = 1.0;

/// The bytes of the recording.
pub fn encode(document: &Document, motions: &[Motion<'_>]) -> Result<Vec<u8>> {
    let stream = RecordingStreamBuilder::new(APPLICATION)
        .recording_id(document.title.as_str())
        .recording_name(document.title.as_str())
        .recording_started(rerun_types::components::Timestamp(0.into()))
        .buffered()
        .map_err(|source| failed("the recording", source))?;
    let storage: BinaryStreamStorage = stream.binary_stream();
    let plots: Vec<&Plot> = document.plots().map(|(_, plot)| plot).filter(|plot| !plot.is_empty()).collect();
    let traces: Vec<Vec<Trace>> = motions.iter().map(traces_of).collect();
    layout(document, motions, &traces, &plots).send(&stream)?;

    log_static(&stream, "result", &rerun_types::archetypes::TextDocument::from_markdown(document.to_markdown()))?;
    let mut start = 0.0;
    for (motion, traces) in motions.iter().zip(&traces) {
        arm::log(&stream, motion, start)?;
        traces.iter().try_for_each(|trace| log_trace(&stream, trace, start))?;
        start += duration(motion) + PAUSE;
    }
    for (index, plot) in plots.iter().enumerate() {
        canvas::log(&stream, &path_of_plot(index), plot)?;
    }
    storage.flush(std::time::Duration::MAX).map_err(|source| failed("the recording", source))?;
    storage.read().ok_or_else(|| failed("the recording", "nothing was logged"))
}

fn duration(motion: &Motion<'_>) -> f64 {
    motion.session.end
}

/// The session's own channels, then the additional curves.
fn traces_of(motion: &Motion<'_>) -> Vec<Trace> {
    traces::of_session(&motion.session).into_iter().chain(motion.traces.iter().cloned().map(Trace::thinned)).collect()
}

/// The content to arrange.
fn layout(document: &Document, motions: &[Motion<'_>], traces: &[Vec<Trace>], plots: &[&Plot]) -> Layout {
    let robot = motions.first().map(|motion| arm::extent(motion.robot));
    let mut layout = Layout::new(&document.title, robot, motions.iter().map(|motion| duration(motion) + PAUSE).sum());
    for (motion, traces) in motions.iter().zip(traces) {
        traces.iter().for_each(|trace| layout.panel(&trace.joint, trace.panel, unit(motion, trace)));
    }
    document.in_front.iter().for_each(|joint| layout.bring_to_front(joint));
    plots.iter().enumerate().for_each(|(index, plot)| layout.plot(&path_of_plot(index), &plot.title));
    layout
}

/// Unit of a trace's panel.
fn unit(motion: &Motion<'_>, trace: &Trace) -> &'static str {
    let joint = motion.robot.joint_index(&trace.joint).map(|index| &motion.robot.bodies[index].joint);
    let kind = joint.map_or(JointKind::Revolute, |joint| joint.kind);
    match trace.panel {
        "velocity" => kind.velocity_unit(),
        "torque" | "residual" => kind.effort_unit(),
        "current" => "A",
        "force" => "N",
        "contact" => "flank",
        _ => kind.position_unit(),
    }
}

/// `plots/0`, `plots/1`, …
fn path_of_plot(index: usize) -> String {
    format!("plots/{index}")
}

/// One curve over time below `joints/<joint>/<panel>/`.
fn log_trace(stream: &RecordingStream, trace: &Trace, start: f64) -> Result<()> {
    let path = format!("joints/{}/{}/{}", trace.joint, trace.panel, trace.label);
    let name = trace.label.replace('_', " ");
    let style = rerun_types::archetypes::SeriesLines::new()
        .with_names([name])
        .with_colors([colour(trace.role)])
        .with_widths([1.5]);
    log_static(stream, &path, &style)?;
    // An instant without a value ends the curve: the next session's begins anew.
    let end = trace.time.last().copied();
    let time = times(trace.time.iter().copied().chain(end), start);
    let lengths = trace.values.iter().map(|_| 1).chain(end.map(|_| 0));
    let columns = rerun_types::archetypes::Scalars::new(trace.values.iter().copied())
        .columns(lengths)
        .map_err(|source| failed(&path, source))?;
    stream.send_columns(path.as_str(), [time], columns).map_err(|source| failed(&path, source))
}
