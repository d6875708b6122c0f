"""What can be hidden in a machine: each effect alters it, and says what a diagnosis should find: joints, parameter, value (None: not compared).

Strengths are shares of the dry friction of a joint, so that an effect of strength 1 adds a third to a half of it where it acts.
"""
import math

import numpy as np


def share(draw, strength, low=0.3, high=0.55):
    return strength * draw.uniform(low, high)


def one(machine, draw):
    return int(draw.integers(len(machine.joints)))


def phase(draw):
    return draw.uniform(-math.pi, math.pi)


def span(machine, k):
    return machine.high[k] - machine.low[k]


def none(machine, draw, strength):
    return None


def payload(machine, draw, strength):
    total = machine.links.compiled().body_mass.sum()
    mass = float(strength * total * draw.uniform(0.08, 0.20))
    place = (draw.normal(size=3) * 0.3 * math.sqrt(machine.inertia[-1] / total)).tolist()
    machine.links = machine.links.loaded(mass, place, 0.02)
    return list(range(len(machine.joints))), "mass", mass


def base_tilt(machine, draw, strength):
    tilt, azimuth = strength * draw.uniform(0.02, 0.05), phase(draw)
    aside = 9.81 * math.sin(tilt)
    machine.gravity = [aside * math.cos(azimuth), aside * math.sin(azimuth), -9.81 * math.cos(tilt)]
    return list(range(len(machine.joints))), "tilt", tilt


def cable_spring(machine, draw, strength):
    k = one(machine, draw)
    joint = machine.joints[k]
    joint["cable"] = share(draw, strength, 0.6, 1.2) * joint["coulomb"] / (0.5 * span(machine, k))
    joint["cable_rest"] = draw.uniform(machine.low[k], machine.high[k])
    return [k], "stiffness", joint["cable"]


def counterbalance(machine, draw, strength):
    k = int(np.argmax(machine.weight))
    machine.joints[k]["balancer"] = strength * machine.weight[k] * draw.uniform(0.08, 0.2)
    machine.joints[k]["balancer_angle"] = draw.uniform(machine.low[k], machine.high[k])
    return [k], "amplitude", machine.joints[k]["balancer"]


def cogging(machine, draw, strength):
    k = one(machine, draw)
    joint = machine.joints[k]
    joint |= {"cogging": share(draw, strength) * joint["coulomb"], "cogging_order": float(draw.choice([2, 4, 6, 7])), "cogging_phase": phase(draw)}
    return [k], "amplitude", joint["cogging"]


def torque_ripple(machine, draw, strength):
    k = int(np.argmax(machine.weight / [joint["coulomb"] for joint in machine.joints]))
    machine.joints[k] |= {"ripple": strength * draw.uniform(0.05, 0.1), "ripple_order": float(draw.choice([2, 4, 6])), "ripple_phase": phase(draw)}
    return [k], "amplitude", machine.joints[k]["ripple"]


def position_dependent_friction(machine, draw, strength):
    k = one(machine, draw)
    periods = draw.uniform(2, 6) * 2 * math.pi / span(machine, k)
    machine.joints[k] |= {"map": share(draw, strength), "map_order": periods, "map_phase": phase(draw)}
    return [k], "amplitude", machine.joints[k]["map"]


def coulomb_asymmetry(machine, draw, strength):
    k = one(machine, draw)
    machine.joints[k]["asymmetry"] = share(draw, strength, 0.12, 0.25) * draw.choice([-1, 1])
    return [k], "asymmetry", machine.joints[k]["asymmetry"]


def viscous_asymmetry(machine, draw, strength):
    k = one(machine, draw)
    joint, part = machine.joints[k], share(draw, strength) * draw.choice([-1, 1])
    joint["viscous_positive"] *= 1 + part
    joint["viscous_negative"] *= 1 - part
    return [k], "positive", joint["viscous_positive"]


def current_offset(machine, draw, strength):
    k = one(machine, draw)
    joint = machine.joints[k]
    joint["offset"] = share(draw, strength) * joint["coulomb"] / joint["constant"] * draw.choice([-1, 1])
    return [k], "offset", joint["offset"]


def transmission_error(machine, draw, strength):
    k = one(machine, draw)
    joint, teeth = machine.joints[k], float(draw.integers(30, 90))
    # At 1 rad/s the inertia of the links resists with this share of dry friction; their speed ripples by a fifth at most.
    wanted = share(draw, strength) * joint["coulomb"] / (machine.inertia[k] * teeth**2)
    joint |= {"mesh": min(wanted, 0.2 / teeth), "mesh_teeth": teeth, "mesh_phase": phase(draw)}
    return [k], "amplitude", joint["mesh"]


def load_dependent_friction(machine, draw, strength):
    k = int(np.argmax(machine.weight / [joint["coulomb"] for joint in machine.joints]))
    machine.joints[k]["by_load"] = strength * draw.uniform(0.04, 0.08)
    return [k], "coefficient", machine.joints[k]["by_load"]


def thermal_friction_drift(machine, draw, strength):
    excess, time = strength * draw.uniform(0.4, 0.8), draw.uniform(20, 60)
    for joint in machine.joints:
        joint |= {"warming": excess, "warming_time": time}
    return list(range(len(machine.joints))), "excess", excess


def quadratic_drag(machine, draw, strength):
    k = one(machine, draw)
    joint = machine.joints[k]
    joint["drag"] = share(draw, strength) * joint["coulomb"]
    return [k], "coefficient", joint["drag"]


def external_contact(machine, draw, strength):
    k = one(machine, draw)
    depth = 0.25 * span(machine, k)
    stiffness = share(draw, strength, 0.6, 1.2) * machine.joints[k]["coulomb"] / (0.5 * depth)
    machine.joints[k] |= {"contact": stiffness, "contact_angle": machine.high[k] - depth, "contact_side": 1.0}
    return [k], "stiffness", stiffness


def encoder_eccentricity(machine, draw, strength):
    k = one(machine, draw)
    joint = machine.joints[k]
    moved = joint["rotor"] + machine.inertia[k]
    joint |= {"runout": share(draw, strength) * joint["coulomb"] / (moved * joint["ratio"] ** 2), "runout_phase": phase(draw)}
    return [k], "amplitude", None


def rotor_inertia(machine, draw, strength):
    k = one(machine, draw)
    error = strength * draw.uniform(0.6, 1.0)
    machine.joints[k]["rotor"] = machine.sheet[k]["rotor"] * (1 + error)
    return [k], "error", error


def torque_constant_error(machine, draw, strength):
    k = int(np.argmax(machine.weight))
    error = strength * draw.uniform(0.2, 0.3) * draw.choice([-1, 1])
    machine.joints[k]["constant"] = machine.sheet[k]["constant"] * (1 + error)
    return [k], "error", error


def sensor_delay(machine, draw, strength):
    machine.late[int(draw.integers(2))] = strength * draw.uniform(0.004, 0.012)
    return list(range(len(machine.joints))), None, None


EFFECTS = [
    none, payload, base_tilt, cable_spring, counterbalance, cogging, torque_ripple, position_dependent_friction, coulomb_asymmetry,
    viscous_asymmetry, current_offset, transmission_error, load_dependent_friction, thermal_friction_drift, quadratic_drag, external_contact,
    encoder_eccentricity, rotor_inertia, torque_constant_error, sensor_delay,
]
