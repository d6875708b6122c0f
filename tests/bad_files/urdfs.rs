//! URDF files.

use super::all_refused;
use super::files::Case;

const CASES: &[Case] = &[
    ("<robot name=\"turntable\">", "<sdf name=\"turntable\">", "robot.urdf", &["</sdf>"]),
    ("</robot>", "", "robot.urdf:2", &["</robot>"]),
    ("</robot>", "</robot><robot name=\"b\"/>", "robot.urdf:22", &["nothing after the outermost"]),
    ("<mass value=\"2\"/>", "<mass value=\"-2\"/>", "robot.urdf:7: link table: mass = -2", &["≥ 0 [kg]"]),
    ("<mass value=\"2\"/>", "<mass value=\"nan\"/>", "robot.urdf:7: link table: mass value = \"nan\"", &["a number"]),
    ("<mass value=\"2\"/>", "<mass value=\"inf\"/>", "robot.urdf:7: link table: mass value = \"inf\"", &["a number"]),
    (
        "<mass value=\"2\"/>",
        "<mass value=\"1e300\"/>",
        "robot.urdf:7: link table: mass value = \"1e300\"",
        &["1e9 [kg]"],
    ),
    (
        "<mass value=\"2\"/>\n      <inertia ixx=\"0.02\" ixy=\"0\" ixz=\"0\" iyy=\"0.02\" iyz=\"0\" izz=\"0.03\"/>",
        "<mass value=\"1e-300\"/>",
        "robot.urdf:7: link table: mass",
        &["≥ 1e-9 [kg]"],
    ),
    ("<mass value=\"2\"/>", "<mass value=\"\"/>", "robot.urdf:7: link table: mass value", &["a number"]),
    ("<mass value=\"2\"/>", "<mass/>", "robot.urdf:7: link table: mass value", &["(missing)"]),
    ("<mass value=\"2\"/>", "<mass value=\"2,0\"/>", "robot.urdf:7: link table: mass value = \"2,0\"", &["a number"]),
    ("ixx=\"0.02\"", "ixx=\"1e300\"", "robot.urdf:8: link table: inertia ixx = \"1e300\"", &["1e12 [kg·m²]"]),
    ("iyy=\"0.02\" ", "", "robot.urdf:8: link table: inertia iyy", &["(missing)"]),
    ("<mass value=\"2\"/>", "", "robot.urdf:5: URDF", &["<mass> in link table"]),
    ("<origin xyz=\"0.1 0 0\"", "<origin xyz=\"1e300 0 0\"", "robot.urdf:6: link table: origin xyz", &["1e5 [m]"]),
    ("<origin xyz=\"0.1 0 0\"", "<origin xyz=\"0.1 0\"", "robot.urdf:6: link table: origin xyz", &["3 numbers"]),
    (
        "<origin xyz=\"0 0 0.5\" rpy=\"0 0 0\"",
        "<origin xyz=\"0 0 0.5\" rpy=\"0 0 1e300\"",
        "robot.urdf:17: joint turn: origin rpy",
        &["1e4 [rad]"],
    ),
    ("<axis xyz=\"0 0 1\"/>", "<axis xyz=\"0 0 0\"/>", "robot.urdf:18: joint turn: axis", &["not zero"]),
    ("<axis xyz=\"0 0 1\"/>", "<axis xyz=\"0 0 1e300\"/>", "robot.urdf:18: joint turn: axis xyz", &["1e6"]),
    ("<axis xyz=\"0 0 1\"/>", "<axis xyz=\"0 0 nan\"/>", "robot.urdf:18: joint turn: axis xyz", &["3 numbers"]),
    ("<axis xyz=\"0 0 1\"/>", "<axes xyz=\"0 0 1\"/>", "robot.urdf:18: URDF", &["<axis>, not <axes>"]),
    ("lower=\"-3\" upper=\"3\"", "lower=\"3\" upper=\"-3\"", "robot.urdf:19: joint turn: limit", &["lower ≤ upper"]),
    ("lower=\"-3\"", "lower=\"nan\"", "robot.urdf:19: joint turn: limit lower = \"nan\"", &["a number"]),
    ("damping=\"0.01\"", "damping=\"-1\"", "robot.urdf:20: joint turn: dynamics", &["damping ≥ 0"]),
    ("friction=\"0.02\"", "friction=\"1e300\"", "robot.urdf:20: joint turn: dynamics friction", &["1e10"]),
    ("<parent link=\"base\"/>", "<parent link=\"bse\"/>", "robot.urdf:15: joint turn: parent = bse", &["such as base"]),
    ("<parent link=\"base\"/>", "", "robot.urdf:14: URDF", &["<parent> in joint turn"]),
    ("<child link=\"table\"/>", "<child link=\"base\"/>", "robot.urdf", &["base"]),
    (
        "<link name=\"base\"/>",
        "<link name=\"base\"/><link name=\"base\"/>",
        "robot.urdf:3: link base",
        &["no other link has"],
    ),
    (
        "<link name=\"base\"/>",
        "<link name=\"base\"/><link name=\"shelf\"/><link name=\"box\"/><joint name=\"lid\" type=\"fixed\"><parent link=\"shelf\"/><child link=\"box\"/></joint>",
        "robot.urdf:3",
        &["one link that no joint moves", "shelf", "fixed joint"],
    ),
    ("<link name=\"base\"/>", "<link/>", "robot.urdf:3: link ?: name", &["(missing)"]),
    (
        "</robot>",
        "<joint name=\"turn\" type=\"fixed\"><parent link=\"base\"/><child link=\"table\"/></joint></robot>",
        "robot.urdf",
        &["no other joint"],
    ),
    (
        "</robot>",
        "<joint name=\"back\" type=\"fixed\"><parent link=\"table\"/><child link=\"base\"/></joint></robot>",
        "robot.urdf",
        &["base"],
    ),
    ("type=\"revolute\"", "type=\"ball\"", "robot.urdf:14: joint turn: type = ball", &["revolute"]),
    ("type=\"revolute\"", "type=\"fixed\"", "model.toml:6: joints.turn", &["movable joints"]),
    ("size=\"0.2 0.1 0.1\"", "size=\"0.2 -1 0.1\"", "robot.urdf:10: link table: collision", &["sizes > 0"]),
    ("size=\"0.2 0.1 0.1\"", "size=\"0.2 0.1 1e300\"", "robot.urdf:11: link table: box size", &["1e5 [m]"]),
    ("<box size=\"0.2 0.1 0.1\"/>", "<box size=\"0.2 0.1 0.1\"/><blob/>", "robot.urdf:11: URDF", &["one box"]),
    ("<box size=\"0.2 0.1 0.1\"/>", "<bo size=\"0.2 0.1 0.1\"/>", "robot.urdf:11: URDF", &["<box>, not <bo>"]),
    (
        "<axis xyz=\"0 0 1\"/>",
        "<axis xyz=\"0 0 1\"/><mimic joint=\"turn\"/>",
        "robot.urdf:18: joint turn: mimic",
        &["a joint of its own"],
    ),
    ("<link name=\"base\"/>", "<xacro:include filename=\"x\"/><link name=\"base\"/>", "robot.urdf:3", &["run xacro"]),
    ("<mass value=\"2\"/>", "<mass value=\"2\" value=\"3\"/>", "robot.urdf:7: URDF", &["`value` once"]),
    ("name=\"turntable\">", "name=\"turntable\"><!-- never closed", "robot.urdf:2", &["end of this tag"]),
];

#[test]
fn regress_bad_urdfs_are_refused_with_place_and_expectation() {
    all_refused("robot.urdf", &["check", "model.toml"], CASES);
}

/// A name that reaches a terminal as it is could clear it, or show another text than it says.
const CONTROLS: &[Case] = &[
    (
        "<link name=\"table\">",
        "<link name=\"ta&#10;ble\">",
        "robot.urdf:4: link ta\\nble: name = ta\\nble",
        &["a name without control characters"],
    ),
    (
        "<link name=\"base\"/>",
        "<link name=\"&#x1b;[2Jbase\"/>",
        "robot.urdf:3: link \\u{1b}[2Jbase: name = \\u{1b}[2Jbase",
        &["a name without control characters"],
    ),
    (
        "<joint name=\"turn\"",
        "<joint name=\"turn&#x202e;\"",
        "robot.urdf:14: joint turn\\u{202e}: name",
        &["a name without control characters"],
    ),
    (
        "<parent link=\"base\"/>",
        "<parent link=\"ba\tse\"/>",
        "robot.urdf:15: joint turn: parent link = ba\\tse",
        &["a name without control characters"],
    ),
    (
        "<axis xyz=\"0 0 1\"/>",
        "<axis xyz=\"0 0 1\"/><mimic joint=\"a&#7;\"/>",
        "robot.urdf:18: joint turn: mimic joint = a\\u{7}",
        &["a name without control characters"],
    ),
];

#[test]
fn regress_names_with_control_characters_are_refused_in_a_urdf() {
    all_refused("robot.urdf", &["check", "model.toml"], CONTROLS);
    all_refused("robot.urdf", &["new", "robot.urdf", "--out", "new.toml"], CONTROLS);
}
