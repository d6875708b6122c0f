//! A machine of one joint, with a value for every key of a model and a scenario.

/// Its description.
pub const URDF: &str = r#"<?xml version="1.0"?>
<robot name="turntable">
  <link name="base"/>
  <link name="table">
    <inertial>
      <origin xyz="0.1 0 0" rpy="0 0 0"/>
      <mass value="2"/>
      <inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.03"/>
    </inertial>
    <collision>
      <geometry><box size="0.2 0.1 0.1"/></geometry>
    </collision>
  </link>
  <joint name="turn" type="revolute">
    <parent link="base"/>
    <child link="table"/>
    <origin xyz="0 0 0.5" rpy="0 0 0"/>
    <axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" effort="5" velocity="4"/>
    <dynamics damping="0.01" friction="0.02"/>
  </joint>
</robot>
"#;

/// Its model file.
pub const MODEL: &str = r#"schema = "lostmotion/model/1"
name = "turntable"
urdf = "robot.urdf"
gravity = [0.0, 0.0, -9.81]

[joints.turn]
gear_ratio = 5.0
rotor_inertia = 0.0008
gear_stiffness = 3000.0
gear_damping = 2.0
backlash = 0.008
end_stop_stiffness = 1000.0

[joints.turn.motor]
torque_constant = 0.023
resistance = 0.5
inductance = 0.0005

[joints.turn.drive]
voltage_limit = 24.0
current_limit = 18.0
current_time_constant = 0.0004

[joints.turn.encoder]
counts_per_turn = 2000

[joints.turn.link_encoder]
resolution = 1e-5

[joints.turn.velocity_sensor]
low_pass_time_constant = 0.02

[joints.turn.current_sensor]
noise = 0.03
resolution = 0.01

[joints.turn.friction]
coulomb = [0.3, 0.32]
breakaway = [0.4, 0.42]
stribeck_velocity = 0.03
viscous = 0.4
link_share = 0.1

[[effects]]
effect = "cogging"
joint = "turn"
amplitude = 0.05
order = 12.0

[[effects]]
effect = "base_tilt"
tilt = 0.05
azimuth = 1.2

[[loads]]
session = "carrying"
mass = 0.5
x = 0.1
"#;

/// Sessions of every kind.
pub const SCENARIO: &str = r#"schema = "lostmotion/scenario/1"
name = "to_and_fro"
robot = "model.toml"
control_period = 0.001
seed = 3

[plant]
step = 0.001
substeps = 2

[[session]]
name = "places"
kind = "waypoints"
rest = 0.1
start.turn_deg = 0.0
[session.joints.turn]
positions_deg = [5, 0]
speed_deg = 60
acceleration_deg = 500
rest = 0.0

[[session]]
name = "stairs"
kind = "staircase"
rest = 0.1
[session.joints.turn]
first = 0.2
last = 0.4
increment = 0.2
acceleration = 10.0
deceleration = 10.0
steady_time = 0.1
settling_way = 0.01
advance = 0.001
gentle_up_to = 0.3
gentle_deceleration = 5.0

[[session]]
name = "quick"
kind = "fast"
duration = 0.4
longest_rest = 0.1
[session.joints.turn]
lowest = -0.5
highest = 0.5
speed = 2.0
acceleration = 20.0

[[session]]
name = "carrying"
kind = "rest"
duration = 0.2
[session.added_mass]
mass = 0.2
x = 0.1

[controller]
law = "sliding_mode"
velocity = "observer"
[controller.joints.turn]
lambda = 6.0
switching = 0.5
boundary = 0.2
disturbance_noise = 1.0
velocity_noise = 0.01
edge_noise = 0.05
velocity_error_limit = 0.5

[[obstacles]]
name = "post"
shape = "cylinder"
radius = 0.02
length = 0.3
xyz = [0.6, 0.6, 0.5]
rpy = [0.0, 0.0, 0.0]
stiffness = 1e5
damping = 100.0
edge_radius = 0.005
"#;
