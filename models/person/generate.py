"""Writes the person: low-poly meshes of unit size and one URDF a body (``python -m vipr.models.person.generate``).

Frames: world = the floor below the person, x towards the camera, y to the person's left, z up. Arms hang along -z at zero.
Every mesh is of unit size and scaled in the URDF, so that three bodies share six meshes. Sources: see README.md of this folder.
"""

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

FOLDER = Path(__file__).parent


@dataclass(frozen=True)
class Body:
    """Lengths of one body [m]."""

    name: str
    stature: float
    shoulder_height: float
    shoulder_half_width: float
    upper_arm: float
    forearm: float
    hand: float  # length, wrist to finger tips
    head: float  # height, chin to vertex
    girth: float = 1.0  # scale of widths

    @property
    def reach_to_palm(self) -> float:
        """Elbow to the middle of the hand [m]."""
        return self.forearm + 0.5 * self.hand


# Proportions of Drillis and Contini (fractions of stature): upper arm .186, forearm .146, hand .108, head .130, shoulder height .818,
# shoulder half-width .129 (to the joint about .11).
def _body(name: str, stature: float, girth: float) -> Body:
    H = stature
    return Body(name, H, 0.818 * H, 0.112 * H * girth**0.5, 0.186 * H, 0.146 * H, 0.108 * H, 0.130 * H, girth)


BODIES = {b.name: b for b in (_body("small", 1.58, 0.92), _body("medium", 1.72, 1.0), _body("large", 1.88, 1.1))}
JOINTS = (
    "sway_x", "sway_y", "torso_yaw", "head_yaw", "head_pitch",
    "left_shoulder_z", "left_shoulder_y", "left_shoulder_x", "left_elbow", "left_wrist_roll",
    "right_shoulder_z", "right_shoulder_y", "right_shoulder_x", "right_elbow", "right_wrist_roll",
)  # fmt: skip


def _lathe(profile, sides=12, uv=False):
    """Surface of revolution about z of (radius, z) rows, from low to high: vertices, normals, texture coordinates, triangles."""
    profile = np.asarray(profile, float)
    angle = np.linspace(0, 2 * np.pi, sides + 1)
    v, vt = [], []
    for k, (radius, z) in enumerate(profile):
        for j, a in enumerate(angle):
            v.append((radius * np.cos(a), radius * np.sin(a), z))
            vt.append((j / sides, k / (len(profile) - 1)))
    row, faces = sides + 1, []
    for k in range(len(profile) - 1):
        for j in range(sides):
            a, b, c, d = k * row + j, k * row + j + 1, (k + 1) * row + j + 1, (k + 1) * row + j
            faces += [(a, b, c), (a, c, d)]
    return np.array(v), np.array(vt), np.array(faces)


def _ellipsoid(rows=8, sides=12, low=-1.0):
    t = np.linspace(np.arcsin(low), np.pi / 2, rows + 1)
    return _lathe(np.c_[np.cos(t), np.sin(t)], sides)


def _join(*parts):
    v, vt, f, n = [], [], [], 0
    for vertices, texture, faces in parts:
        v.append(vertices), vt.append(texture), f.append(faces + n)
        n += len(vertices)
    return np.vstack(v), np.vstack(vt), np.vstack(f)


def _moved(part, scale, offset, R=None):
    v, vt, f = part
    v = v * scale
    if R is not None:
        v = v @ np.asarray(R).T
    return v + offset, vt, f


def write_obj(path: Path, part, smooth: bool = True) -> None:
    """Write vertices, normals (smooth: shared where vertices meet), texture coordinates and triangles."""
    v, vt, f = part
    cross = np.cross(v[f[:, 1]] - v[f[:, 0]], v[f[:, 2]] - v[f[:, 0]])
    key = np.unique(np.round(v, 5), axis=0, return_inverse=True)[1].ravel() if smooth else np.arange(len(v))
    summed = np.zeros((key.max() + 1, 3))
    for corner in range(3):
        np.add.at(summed, key[f[:, corner]], cross)
    normal = summed[key]
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
    f = f[np.linalg.norm(cross, axis=1) > 1e-12]
    lines = [f"v {a:.5f} {b:.5f} {c:.5f}" for a, b, c in v]
    lines += [f"vt {a:.4f} {b:.4f}" for a, b in vt]
    lines += [f"vn {a:.4f} {b:.4f} {c:.4f}" for a, b, c in normal]
    lines += ["f " + " ".join(f"{i + 1}/{i + 1}/{i + 1}" for i in tri) for tri in f]
    path.write_text("\n".join(lines) + "\n")


def _turn_x(degrees):
    a = np.radians(degrees)
    return np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])


def _hand():
    """Unit hand: wrist at the origin, fingers towards -z, palm towards x, length 1."""
    finger = _lathe([(0.0, -1.0), (0.7, -0.93), (1.0, -0.75), (1.0, 0.0)], 6)
    parts = [_moved(_ellipsoid(6, 10), (0.13, 0.23, 0.30), (0, 0, -0.27))]
    for y, length, tilt in ((-0.15, 0.40, -8), (-0.05, 0.47, -2), (0.06, 0.45, 4), (0.15, 0.36, 10)):
        parts.append(_moved(finger, (0.055, 0.055, length), (0, y, -0.50), _turn_x(tilt)))
    parts.append(_moved(finger, (0.06, 0.06, 0.36), (0.02, -0.17, -0.22), _turn_x(-42)))
    return _join(*parts)


def _mirrored(part):
    """The part in a mirror: y and the order of corners change sign."""
    v, vt, f = part
    return v * (1, -1, 1), vt, f[:, ::-1]


def _face_texture(size=128):
    """Brows, eyes, nose shade and mouth as a grey picture that multiplies the skin tone; the face looks along x (texture u = 0 or 1)."""
    t = np.full((size, size), 255.0, np.float32)

    def dab(u, v, width, height, depth):
        y, x = np.mgrid[0:size, 0:size] / size
        for shift in (-1, 0, 1):
            t[:] *= 1 - depth * np.exp(-((((x - u + shift) / width) ** 2 + ((y - v) / height) ** 2) ** 2))

    for side in (-1, 1):
        dab(side * 0.058 % 1, 0.45, 0.026, 0.022, 0.75)  # eye
        dab(side * 0.060 % 1, 0.395, 0.036, 0.012, 0.55)  # brow
    dab(0.0, 0.57, 0.018, 0.02, 0.25)  # nose
    dab(0.0, 0.665, 0.05, 0.014, 0.5)  # mouth
    return np.repeat(np.clip(t, 0, 255).astype(np.uint8)[..., None], 3, axis=2)


def meshes() -> dict:
    """Every mesh of the person by name."""
    limb = _lathe([(0.0, -1.0), (0.72, -0.99), (0.80, -0.9), (1.0, -0.35), (1.0, -0.05), (0.6, 0.04), (0.0, 0.06)], 10)
    # Torso of height 1, hips at 0, shoulders at 1, a low collar above; half-depth and half-width 1.
    torso = _lathe(
        [
            (0.0, -0.06),
            (0.85, -0.05),
            (0.80, 0.15),
            (0.78, 0.35),
            (0.95, 0.75),
            (0.97, 0.90),
            (0.62, 1.0),
            (0.30, 1.045),
            (0.0, 1.05),
        ],
        16,
    )
    head = _ellipsoid(12, 20)
    hair = _ellipsoid(6, 20, low=0.0)
    return {
        "limb": limb,
        "torso": torso,
        "head": head,
        "hair": hair,
        "left_hand": _hand(),
        "right_hand": _mirrored(_hand()),
        "neck": _lathe([(1, 0), (1, 1)], 10),
    }


def urdf(body: Body) -> str:
    """URDF of one body."""
    b, g = body, body.girth
    hip = 0.50 * b.stature
    torso = b.shoulder_height - hip
    head_z = b.stature - hip - 0.5 * b.head
    out = [
        f'<?xml version="1.0"?>\n<!-- Written by generate.py. -->\n<robot name="person_{b.name}">',
        '<link name="world"/>',
    ]

    def link(name, visuals=()):
        out.append(f'<link name="{name}">')
        for visual, mesh, xyz, rpy, scale in visuals:
            out.append(
                f'  <visual name="{visual}"><origin xyz="{xyz}" rpy="{rpy}"/><geometry>'
                f'<mesh filename="{mesh}.obj" scale="{scale[0]:.5f} {scale[1]:.5f} {scale[2]:.5f}"/></geometry></visual>'
            )
        out.append(
            '  <inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        )

    def joint(name, kind, parent, child, xyz, axis):
        out.append(
            f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
            f'<origin xyz="{xyz[0]:.5f} {xyz[1]:.5f} {xyz[2]:.5f}"/><axis xyz="{axis}"/><limit effort="0"/></joint>'
        )

    link("sway_link"), joint("sway_x", "prismatic", "world", "sway_link", (0, 0, hip), "1 0 0")
    link("sway"), joint("sway_y", "prismatic", "sway_link", "sway", (0, 0, 0), "0 1 0")
    link("torso", [("shirt", "torso", "0 0 0", "0 0 0", (0.115 * g, b.shoulder_half_width * 1.02, torso + 0.03)),
                   ("trousers", "limb", "0 0 0.02", "0 0 0", (0.11 * g, 0.17 * g, hip))])  # fmt: skip
    joint("torso_yaw", "continuous", "sway", "torso", (0, 0, 0), "0 0 1")
    link("neck_link"), joint("head_yaw", "continuous", "torso", "neck_link", (0, 0, head_z - 0.35 * b.head), "0 0 1")
    up = 0.35 * b.head
    link("head", [
        ("face", "head", f"0.01 0 {up:.4f}", "0 0 0", (0.42 * b.head, 0.345 * b.head, 0.5 * b.head)),
        ("hair", "hair", f"-0.012 0 {up + 0.022:.4f}", "0 -0.33 0", (0.46 * b.head, 0.40 * b.head, 0.50 * b.head)),
        ("neck", "neck", "-0.02 0 -0.09", "0 0 0", (0.055 * g, 0.055 * g, 0.12)),
    ])  # fmt: skip
    joint("head_pitch", "continuous", "neck_link", "head", (0, 0, 0), "0 1 0")
    for side, sign in (("left", 1), ("right", -1)):
        at = (0, sign * b.shoulder_half_width, b.shoulder_height - hip)
        (
            link(f"{side}_shoulder_a"),
            joint(f"{side}_shoulder_z", "continuous", "torso", f"{side}_shoulder_a", at, "0 0 1"),
        )
        link(f"{side}_shoulder_b")
        joint(f"{side}_shoulder_y", "continuous", f"{side}_shoulder_a", f"{side}_shoulder_b", (0, 0, 0), "0 1 0")
        link(
            f"{side}_upper_arm", [(f"{side}_upper_arm", "limb", "0 0 0", "0 0 0", (0.056 * g, 0.056 * g, b.upper_arm))]
        )
        joint(f"{side}_shoulder_x", "continuous", f"{side}_shoulder_b", f"{side}_upper_arm", (0, 0, 0), "1 0 0")
        link(
            f"{side}_forearm", [(f"{side}_forearm", "limb", "0 0 0", "0 0 0", (0.045 * g, 0.045 * g, b.forearm + 0.01))]
        )
        joint(f"{side}_elbow", "continuous", f"{side}_upper_arm", f"{side}_forearm", (0, 0, -b.upper_arm), "0 1 0")
        link(f"{side}_hand", [(f"{side}_hand", f"{side}_hand", "0 0 0", "0 0 0", (b.hand, b.hand, b.hand))])
        joint(f"{side}_wrist_roll", "continuous", f"{side}_forearm", f"{side}_hand", (0, 0, -b.forearm), "0 0 1")
    out.append("</robot>\n")
    return "\n".join(out)


def main() -> None:
    """Write meshes, face texture and the bodies."""
    for name, part in meshes().items():
        write_obj(FOLDER / f"{name}.obj", part)
    cv2.imwrite(str(FOLDER / "face.png"), _face_texture())
    for body in BODIES.values():
        (FOLDER / f"person_{body.name}.urdf").write_text(urdf(body))


if __name__ == "__main__":
    main()
