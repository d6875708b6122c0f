"""Limbs of public robot files: chains of two to seven turning joints, as URDFs of their own, and what MuJoCo says of their links."""
import copy
import math
import pathlib
import xml.etree.ElementTree as tree

import mujoco
import numpy as np

TURNING = ("revolute", "continuous")
LONGEST = 7
DROPPED = ("visual", "collision", "transmission", "gazebo", "mimic", "sensor", "material", "safety_controller", "calibration")


class Limb:
    """A chain of joints; every other joint of the file is fixed."""

    def __init__(self, file, names):
        self.file, self.names = file, names
        self.root = tree.parse(file).getroot()
        for parent in list(self.root.iter()):
            for child in [child for child in parent if child.tag in DROPPED]:
                parent.remove(child)
        joints = {joint.get("name"): joint for joint in self.root.findall("joint")}
        self.joints = [joints[name] for name in names]
        self.last = self.joints[-1].find("child").get("link")
        self.prune(joints)

    def prune(self, joints):
        """Leaves the way from the root to the first joint, without masses, and all that the limb carries, fixed to it."""
        carried, before = {self.joints[0].find("child").get("link")}, {self.joints[0].find("parent").get("link")}
        for _ in joints:
            for joint in joints.values():
                parent, child = joint.find("parent").get("link"), joint.find("child").get("link")
                if parent in carried:
                    carried.add(child)
                elif child in before:
                    before.add(parent)
        for element in list(self.root):
            if element.tag == "link" and element.get("name") in before:
                for inertial in element.findall("inertial"):
                    element.remove(inertial)
            kept = element.get("name") if element.tag == "link" else element.find("child").get("link") if element.tag == "joint" else None
            if kept not in carried | before:
                self.root.remove(element)
            elif element.tag == "joint" and element.get("name") not in self.names:
                element.set("type", "fixed")

    @property
    def name(self):
        return f"{self.file.stem}:{self.names[0]}"

    def range(self, joint):
        """Lowest and highest angle [rad]; of a joint without limits one turn."""
        limit = joint.find("limit")
        if joint.get("type") == "continuous" or limit is None or limit.get("lower") == limit.get("upper"):
            return -math.pi, math.pi
        return max(-math.pi, float(limit.get("lower", 0))), min(math.pi, float(limit.get("upper", 0)))

    def write(self, path):
        path.write_text(tree.tostring(self.root, encoding="unicode"))

    def rough(self, draw, accuracy):
        """This limb with masses, centres and inertias off by normal random numbers times `accuracy`."""
        other = copy.deepcopy(self)
        for inertial in other.root.iter("inertial"):
            mass, inertia, origin = (inertial.find(tag) for tag in ("mass", "inertia", "origin"))
            if mass is None or inertia is None or float(mass.get("value")) <= 0:
                continue
            moments = [float(inertia.get(axis)) for axis in ("ixx", "iyy", "izz")]
            radius = math.sqrt(max(0.0, sum(moments) / 3 / float(mass.get("value"))))
            origin = tree.SubElement(inertial, "origin", {"xyz": "0 0 0"}) if origin is None else origin
            centre = [float(word) for word in origin.get("xyz", "0 0 0").split()]
            moved = np.array(centre) + draw.normal(size=3) * accuracy * min(0.005, 0.2 * radius)
            origin.set("xyz", " ".join(map(repr, moved.tolist())))
            factor = math.exp(0.10 * accuracy * draw.normal())
            mass.set("value", repr(float(mass.get("value")) * factor))
            factor *= math.exp(0.15 * accuracy * draw.normal())
            for axis in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz"):
                inertia.set(axis, repr(float(inertia.get(axis, 0)) * factor))
        return other

    def loaded(self, mass, place, radius):
        """This limb with a ball on its last link."""
        other = copy.deepcopy(self)
        joint = tree.SubElement(other.root, "joint", {"name": "to_load", "type": "fixed"})
        tree.SubElement(joint, "parent", {"link": other.last})
        tree.SubElement(joint, "child", {"link": "load"})
        tree.SubElement(joint, "origin", {"xyz": " ".join(map(repr, place)), "rpy": "0 0 0"})
        inertial = tree.SubElement(tree.SubElement(other.root, "link", {"name": "load"}), "inertial")
        tree.SubElement(inertial, "mass", {"value": repr(mass)})
        moment = repr(0.4 * mass * radius**2)
        tree.SubElement(inertial, "inertia", {"ixx": moment, "iyy": moment, "izz": moment, "ixy": "0", "ixz": "0", "iyz": "0"})
        return other

    def compiled(self, gravity=(0.0, 0.0, -9.81)):
        """MuJoCo's model of the links, without contacts, limits and friction."""
        root = copy.deepcopy(self.root)
        options = tree.SubElement(root, "mujoco")
        tree.SubElement(options, "compiler", {"balanceinertia": "true", "fusestatic": "true", "discardvisual": "true", "strippath": "true"})
        for joint in root.iter("joint"):
            for tag in ("dynamics", "limit"):
                for child in joint.findall(tag):
                    joint.remove(child)
            if joint.get("type") == "revolute":
                joint.set("type", "continuous")
        model = mujoco.MjModel.from_xml_string(tree.tostring(root, encoding="unicode"))
        model.opt.gravity[:] = gravity
        assert [model.joint(k).name for k in range(model.njnt)] == list(self.names)
        return model


class Links:
    """Gravity torque and inertia of a limb's joints."""

    def __init__(self, model):
        self.model, self.data = model, mujoco.MjData(model)

    def gravity(self, pose):
        self.data.qpos[:], self.data.qvel[:] = pose, 0
        mujoco.mj_forward(self.model, self.data)
        return self.data.qfrc_bias.copy()

    def inertia(self, pose):
        self.data.qpos[:] = pose
        mujoco.mj_forward(self.model, self.data)
        full = np.zeros((self.model.nv, self.model.nv))
        mujoco.mj_fullM(self.model, self.data, full)
        return full.diagonal().copy()


def limbs(folder):
    """The longest limb towards each end of each URDF below `folder`, sorted; files that are no URDF are left out."""
    found = []
    for file in sorted(pathlib.Path(folder).rglob("*.urdf")):
        try:
            found += of_file(file)
        except (tree.ParseError, AttributeError):
            continue
    return found


def of_file(file):
    above = {}
    for joint in tree.parse(file).getroot().findall("joint"):
        above[joint.find("child").get("link")] = (joint.find("parent").get("link"), joint)
    chains = set()
    for link in set(above) - {parent for parent, _ in above.values()}:
        chain = []
        while link in above:
            link, joint = above[link]
            if joint.get("type") in TURNING and joint.find("mimic") is None:
                chain.append(joint.get("name"))
        if len(chain) >= 2:
            chains.add(tuple(reversed(chain[:LONGEST])))
    # A limb that is the first part of another one is no other limb.
    return [(file, chain) for chain in sorted(chains) if not any(chain != other and chain == other[: len(chain)] for other in chains)]
