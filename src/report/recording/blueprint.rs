//! Layout of a recording in the viewer: the arm and the result on the left, traces of a joint in the middle, plots on
//! the right.

use nalgebra::Vector3;
use rerun::external::re_log_types::BlueprintActivationCommand;
use rerun::log::LogMsg;
use rerun::{AsComponents, RecordingStream, RecordingStreamBuilder};
use rerun_types::blueprint::{archetypes as blueprint, components};
use rerun_types::datatypes;

use super::CANVAS;
use super::entities::{APPLICATION, failed, single};
use crate::error::Result;

/// Panels of a joint, in their order from the top.
const PANELS: [&str; 10] = [
    "residual",
    "prediction_error",
    "position_error",
    "velocity",
    "position",
    "gap",
    "current",
    "torque",
    "force",
    "contact",
];
/// Number of plots that are visible at once; the others are in tabs.
const PLOTS_AT_ONCE: usize = 3;
/// [s] A recording is played in about this time.
const PLAYED_IN: f64 = 40.0;

/// The content to arrange.
#[derive(Debug)]
pub struct Layout {
    /// Title of the recording.
    title: String,
    /// [m] Centre and radius of the arm, if there is one.
    robot: Option<(Vector3<f64>, f64)>,
    /// [s] Length of the recording.
    duration: f64,
    /// Joint, panel and unit, in the order of the first traces.
    panels: Vec<(String, &'static str, &'static str)>,
    /// Path and title.
    plots: Vec<(String, String)>,
    /// The joint whose tab is in front.
    in_front: Option<String>,
}

impl Layout {
    /// Only a result, and an arm if there is one.
    pub fn new(title: &str, robot: Option<(Vector3<f64>, f64)>, duration: f64) -> Self {
        Self { title: title.to_owned(), robot, duration, panels: Vec::new(), plots: Vec::new(), in_front: None }
    }

    /// Brings the tab of a joint to the front.
    pub fn bring_to_front(&mut self, joint: &str) {
        self.in_front = Some(joint.to_owned());
    }

    /// Adds a panel of that joint, with an axis of that unit.
    pub fn panel(&mut self, joint: &str, panel: &'static str, unit: &'static str) {
        if !self.panels.iter().any(|(known, name, _)| known == joint && *name == panel) {
            self.panels.push((joint.to_owned(), panel, unit));
        }
    }

    /// Adds a plot at that path.
    pub fn plot(&mut self, path: &str, title: &str) {
        self.plots.push((path.to_owned(), title.to_owned()));
    }

    /// Writes the layout into the recording.
    pub fn send(&self, stream: &RecordingStream) -> Result<()> {
        let fail = |source| failed("blueprint", source);
        let (recording, storage) = RecordingStreamBuilder::new(APPLICATION)
            .recording_id(format!("layout of {}", self.title))
            .recording_started(rerun_types::components::Timestamp(0.into()))
            .blueprint()
            .memory()
            .map_err(fail)?;
        recording.set_time_sequence("blueprint", 0);
        let mut writer = Writer { recording: &recording, nodes: 0 };
        let root = self.root(&mut writer)?;
        let viewport = blueprint::ViewportBlueprint::new()
            .with_root_container(components::RootContainer(datatypes::Uuid { bytes: root.id }))
            .with_auto_layout(components::AutoLayout(false.into()))
            .with_auto_views(components::AutoViews(false.into()));
        writer.log("viewport", &viewport)?;
        let hidden = blueprint::PanelBlueprint::new().with_state(components::PanelState::Collapsed);
        writer.log("blueprint_panel", &hidden)?;
        writer.log("selection_panel", &hidden)?;
        let time = blueprint::TimePanelBlueprint::new()
            .with_state(components::PanelState::Collapsed)
            .with_timeline("time")
            .with_playback_speed((self.duration / PLAYED_IN).max(1.0));
        writer.log("time_panel", &time)?;
        let messages = storage.take();
        let id = messages.iter().find_map(|message| match message {
            LogMsg::SetStoreInfo(info) => Some(info.info.store_id.clone()),
            _ => None,
        });
        let id = id.ok_or_else(|| failed("blueprint", "nothing was logged"))?;
        stream.send_blueprint(messages, BlueprintActivationCommand::make_active(id));
        Ok(())
    }

    fn root(&self, writer: &mut Writer<'_>) -> Result<Node> {
        let mut columns = Vec::new();
        let result = writer.view("TextDocument", "Result", "result", &[])?;
        if let Some((centre, radius)) = self.robot {
            let arm = writer.arm(centre, radius)?;
            columns
                .push((writer.container(components::ContainerKind::Vertical, "", &[(arm, 1.2), (result, 1.0)])?, 1.0));
        } else {
            columns.push((result, 1.0));
        }
        if !self.panels.is_empty() {
            columns.push((self.traces(writer)?, 1.1));
        }
        if !self.plots.is_empty() {
            columns.push((self.plots(writer)?, 1.1));
        }
        writer.container(components::ContainerKind::Horizontal, "", &columns)
    }

    /// A tab for each joint, its panels below each other.
    fn traces(&self, writer: &mut Writer<'_>) -> Result<Node> {
        let mut joints: Vec<&str> = Vec::new();
        for (joint, ..) in &self.panels {
            if !joints.contains(&joint.as_str()) {
                joints.push(joint);
            }
        }
        let mut tabs = Vec::new();
        for joint in &joints {
            let mut panels = Vec::new();
            for panel in PANELS {
                let known = self.panels.iter().find(|(known, name, _)| known == *joint && *name == panel);
                if let Some((.., unit)) = known {
                    let origin = format!("joints/{joint}/{panel}");
                    let title = format!("{joint}: {} [{unit}]", panel.replace('_', " "));
                    panels.push((writer.over_time(&title, &origin, self.duration)?, 1.0));
                }
            }
            tabs.push((writer.container(components::ContainerKind::Vertical, joint, &panels)?, 1.0));
        }
        let front = self.in_front.as_ref().and_then(|joint| joints.iter().position(|one| one == joint)).unwrap_or(0);
        writer.tabs("Joints", &tabs, front)
    }

    /// The first plots below each other, and the others in tabs in the last place.
    fn plots(&self, writer: &mut Writer<'_>) -> Result<Node> {
        let mut views = Vec::new();
        for (path, title) in &self.plots {
            views.push((writer.canvas(path, title)?, 1.0));
        }
        if views.len() > PLOTS_AT_ONCE {
            let rest = views.split_off(PLOTS_AT_ONCE - 1);
            views.push((writer.tabs("Plots", &rest, 0)?, 1.0));
        }
        writer.container(components::ContainerKind::Vertical, "Plots", &views)
    }
}

/// A view or a container in the blueprint.
#[derive(Debug, Clone)]
struct Node {
    id: [u8; 16],
    path: String,
}

/// A property of a view: the name of its archetype and its value.
type Property<'a> = (&'a str, &'a dyn AsComponents);

/// Logs views and containers with sequential identifiers, so that identical runs give identical files.
struct Writer<'a> {
    recording: &'a RecordingStream,
    nodes: u32,
}

impl Writer<'_> {
    fn log(&self, path: &str, value: &dyn AsComponents) -> Result<()> {
        self.recording
            .log_serialized_batches(path, false, value.as_serialized_batches())
            .map_err(|source| failed(path, source))
    }

    fn node(&mut self, kind: &str) -> Node {
        self.nodes += 1;
        let mut id = [0; 16];
        id[12..].copy_from_slice(&self.nodes.to_be_bytes());
        Node { id, path: format!("{kind}/00000000-0000-0000-0000-{:012x}", self.nodes) }
    }

    fn view(&mut self, class: &str, name: &str, origin: &str, properties: &[Property<'_>]) -> Result<Node> {
        let node = self.node("view");
        let contents = blueprint::ViewContents::new([components::QueryExpression("$origin/**".into())]);
        self.log(&format!("{}/ViewContents", node.path), &contents)?;
        let view = blueprint::ViewBlueprint::new(components::ViewClass(class.into()))
            .with_display_name(rerun_types::components::Name(name.into()))
            .with_space_origin(origin.to_owned());
        self.log(&node.path, &view)?;
        for (property, value) in properties {
            self.log(&format!("{}/{property}", node.path), *value)?;
        }
        Ok(node)
    }

    /// The arm, seen from the front, the side and above, at a distance that shows all of it.
    fn arm(&mut self, centre: Vector3<f64>, radius: f64) -> Result<Node> {
        let eye = centre + 1.6 * radius * Vector3::new(0.75, -0.75, 0.55);
        let eye = blueprint::EyeControls3D::new()
            .with_kind(components::Eye3DKind::Orbital)
            .with_position(<[f32; 3]>::from(eye.map(single)))
            .with_look_target(<[f32; 3]>::from(centre.map(single)))
            .with_eye_up([0.0, 0.0, 1.0]);
        let ground = blueprint::Background::new(components::BackgroundKind::SolidColor).with_color([24, 26, 30]);
        self.view("3D", "Arm", "arm", &[("EyeControls3D", &eye), ("Background", &ground)])
    }

    /// Curves over the whole recording.
    fn over_time(&mut self, name: &str, origin: &str, duration: f64) -> Result<Node> {
        #[expect(clippy::cast_possible_truncation, reason = "nanoseconds of a recording stay far below 2⁶³")]
        let end = (duration * 1e9) as i64;
        let range = datatypes::TimeRange {
            start: datatypes::TimeRangeBoundary::Absolute(0.into()),
            end: datatypes::TimeRangeBoundary::Absolute(end.into()),
        };
        let axis = blueprint::TimeAxis::new().with_view_range(range);
        self.view("TimeSeries", name, origin, &[("TimeAxis", &axis)])
    }

    fn canvas(&mut self, path: &str, title: &str) -> Result<Node> {
        let [width, height] = CANVAS;
        let bounds = datatypes::Range2D { x_range: [0.0, width].into(), y_range: [-12.0, height + 12.0].into() };
        let bounds = blueprint::VisualBounds2D::new(components::VisualBounds2D(bounds));
        self.view("2D", title, path, &[("VisualBounds2D", &bounds)])
    }

    /// Parts of which one is visible at a time, `front` at first.
    fn tabs(&mut self, name: &str, parts: &[(Node, f32)], front: usize) -> Result<Node> {
        let node = self.container(components::ContainerKind::Tabs, name, parts)?;
        if let Some((part, _)) = parts.get(front) {
            let active = blueprint::ContainerBlueprint::update_fields().with_active_tab(part.path.as_str());
            self.log(&node.path, &active)?;
        }
        Ok(node)
    }

    fn container(&mut self, kind: components::ContainerKind, name: &str, parts: &[(Node, f32)]) -> Result<Node> {
        let node = self.node("container");
        let contents = parts.iter().map(|(part, _)| components::IncludedContent(part.path.clone().into()));
        let shares = parts.iter().map(|(_, share)| *share);
        let container = blueprint::ContainerBlueprint::new(kind).with_contents(contents);
        let container = if name.is_empty() {
            container
        } else {
            container.with_display_name(rerun_types::components::Name(name.into()))
        };
        let container = match kind {
            components::ContainerKind::Horizontal => {
                container.with_col_shares(shares.map(|share| components::ColumnShare(share.into())))
            }
            components::ContainerKind::Vertical => {
                container.with_row_shares(shares.map(|share| components::RowShare(share.into())))
            }
            _ => container,
        };
        self.log(&node.path, &container)?;
        Ok(node)
    }
}
