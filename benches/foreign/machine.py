"""A drawn arm: gears, motors, friction and sensors of a limb, a nominal model that is off, and at most one hidden effect."""
import math

import numpy as np

from limb import Links

PEAK = 3.0  # [rad/s²] of all joints, which with the weight of the links sizes the motors

# Accuracy of a data sheet, as `[accuracy]` has it by default: relative standard deviations.
SHEET = {"rotor": 0.10, "constant": 0.05, "stiffness": 0.30}


class Machine:
    """`joints`: parameters of arm.c of each joint. `links`: the true limb. `late`: delays of current and position [s]."""

    def __init__(self, limb, draw, roughness):
        self.nominal, self.late, self.gravity = limb, [0.0, 0.0], [0.0, 0.0, -9.81]
        self.links = limb.rough(draw, roughness)
        self.low, self.high = box(limb, draw)
        about = Links(self.links.compiled())
        poses = draw.uniform(self.low, self.high, size=(60, len(limb.names)))
        self.weight = np.max([abs(about.gravity(pose)) for pose in poses], axis=0)
        self.inertia = np.mean([about.inertia(pose) for pose in poses], axis=0)
        self.peak = self.weight + PEAK * self.inertia
        self.peak = np.maximum(self.peak, 0.05 * self.peak.max())
        for k in reversed(range(len(self.peak) - 1)):  # no motor much smaller than the next one
            self.peak[k] = max(self.peak[k], 0.7 * self.peak[k + 1])
        self.joints = [joint(draw, peak, inertia) for peak, inertia in zip(self.peak, self.inertia)]
        self.sheet = [
            {name: value[name] * math.exp(spread * roughness * draw.normal()) for name, spread in SHEET.items()} for value in self.joints
        ]

    @property
    def names(self):
        return self.nominal.names

    def sheet_model(self):
        """The model file of someone who has the data sheets: no friction, no gaps."""
        lines = ['schema = "lostmotion/model/1"', 'name = "arm"', 'urdf = "robot.urdf"']
        for name, true, told in zip(self.names, self.joints, self.sheet):
            lines += [
                f'\n[joints."{name}"]',
                f"gear_ratio = {true['ratio']:.1f}",
                f"rotor_inertia = {told['rotor'] / true['ratio'] ** 2:.4e}",
                f"gear_stiffness = {told['stiffness']:.4e}",
                f"motor.torque_constant = {told['constant'] / true['ratio']:.5e}",
                f"drive.current_limit = {true['limit']:.3f}",
                f"encoder.counts_per_turn = {turns(true)}",
                f"velocity_sensor.low_pass_time_constant = {true['low_pass']:.4e}",
                f"current_sensor.noise = {true['noise']:.4e}",
                f"current_sensor.resolution = {true['resolution']:.4e}",
            ]
        return "\n".join(lines) + "\n"


def turns(joint):
    return round(joint["counts"] * 2 * math.pi / joint["ratio"])


def box(limb, draw):
    """Lowest and highest angle of each joint that the motion visits [rad]."""
    low, high = np.array([limb.range(joint) for joint in limb.joints]).T
    reach = np.minimum(0.42 * (high - low), draw.uniform(0.6, 1.2, size=len(low)))
    middle = np.clip(draw.uniform(-0.5, 0.5, size=len(low)), low + 1.1 * reach, high - 1.1 * reach)
    return middle - reach, middle + reach


def joint(draw, peak, inertia):
    """Parameters of a joint whose motor gives `peak` [N·m] with some reserve, in front of links of `inertia` [kg·m²]."""
    between = lambda low, high: math.exp(draw.uniform(math.log(low), math.log(high)))
    ratio, coulomb = round(between(50, 160)), peak * between(0.05, 0.15)
    limit, rotor = between(2, 10), inertia * between(0.2, 1.0) + peak * between(0.003, 0.01)
    constant = 2.5 * peak / limit
    stiffness = peak * between(150, 500)
    counts = 2 ** draw.integers(11, 17)
    bandwidth = 2 * math.pi * between(1.5, 4)
    moved = rotor + inertia
    viscous = coulomb * between(0.3, 1.2)
    resolution = limit / 2 ** draw.integers(10, 13)
    return {
        "rotor": rotor, "stiffness": stiffness, "damping": 0.05 * 2 * math.sqrt(stiffness * rotor * inertia / moved),
        "half_gap": 0.5 * between(2e-4, 4e-3), "coulomb": coulomb, "rest": coulomb * between(1.05, 1.5), "stribeck": between(0.01, 0.08),
        "viscous_positive": viscous, "viscous_negative": viscous, "behind": draw.uniform(0, 0.1),
        "constant": constant, "lag": 1e-3, "limit": limit, "ratio": ratio, "counts": counts * ratio / (2 * math.pi),
        "low_pass": between(2e-3, 2e-2), "noise": between(0.3, 3) * resolution, "resolution": resolution,
        "kp": moved * bandwidth**2, "kv": 1.6 * moved * bandwidth, "ki": 0.3 * moved * bandwidth**3,
        "warming_time": 1.0,
    }
