"""Looks of the arm, the hand and the camera, each mesh in its link's frame."""

from pathlib import Path

import numpy as np

from vipr.models.build.mesh import Mesh

MATERIALS = {
    "ivory": (0.78, 0.77, 0.72),
    "black": (0.10, 0.10, 0.11),
    "steel": (0.50, 0.51, 0.53),
    "grey": (0.33, 0.34, 0.36),
    "rubber": (0.16, 0.16, 0.17),
}


def puma_links() -> dict[str, Mesh]:
    """Meshes of links 0 to 6 in their Denavit-Hartenberg frames."""
    base = Mesh()
    base.tube("black", (0, 0, 0), (0, 0, 0.025), 0.15)
    base.tube("ivory", (0, 0, 0.025), (0, 0, 0.53), 0.088, caps=(False, False))
    base.tube("black", (0, 0, 0.53), (0, 0, 0.585), 0.095)
    waist = Mesh()  # frame 1: y up, z across
    waist.tube("ivory", (0, -0.086, 0), (0, 0.085, 0), 0.088)
    waist.tube("ivory", (0, 0, -0.115), (0, 0, 0.155), 0.084)
    waist.tube("black", (0, 0, 0.155), (0, 0, 0.188), 0.078)
    waist.tube("black", (0, 0, -0.122), (0, 0, -0.115), 0.06)
    upper = Mesh()  # frame 2: x from shoulder to elbow
    upper.slab("ivory", [(-0.4318, 0, 0.098), (0, 0, 0.072)], 0.19, 0.285)
    upper.slab("ivory", [(-0.4318, 0, 0.085), (-0.53, 0, 0.062)], 0.20, 0.275)
    upper.tube("black", (-0.4318, 0, 0.285), (-0.4318, 0, 0.291), 0.055)
    upper.tube("black", (0, 0, 0.285), (0, 0, 0.291), 0.042)
    # frame 3: z along the forearm, y across, away from the upper arm. The elbow's axis is at x = -20.3 mm.
    fore = Mesh()
    side = Mesh()
    side.slab("ivory", [(0, -0.0203, 0.068), (0.22, -0.016, 0.052), (0.36, 0, 0.038)], -0.036, 0.036)
    fore += side.moved(np.array([[0, 1, 0, 0], [0, 0, 1, 0], [1, 0, 0, 0], [0, 0, 0, 1.0]]))
    fore.tube("black", (-0.0203, -0.046, 0), (-0.0203, -0.036, 0), 0.05)
    fore.tube("black", (-0.0203, 0.036, 0), (-0.0203, 0.042, 0), 0.04)
    fore.tube("black", (0, 0, 0.36), (0, 0, 0.375), 0.036)
    wrist = Mesh()  # frame 4: y along the forearm
    wrist.tube("ivory", (0, -0.057, 0), (0, -0.036, 0), 0.036)
    wrist.box("ivory", (-0.022, -0.045, -0.040), (0.022, 0.018, -0.030))
    wrist.box("ivory", (-0.022, -0.045, 0.030), (0.022, 0.018, 0.040))
    bend = Mesh()  # frame 5: y along the axis of joint 5
    bend.tube("black", (0, -0.030, 0), (0, 0.030, 0), 0.027)
    bend.tube("ivory", (0, 0, 0.01), (0, 0, 0.034), 0.027)
    flange = Mesh()
    flange.tube("black", (0, 0, 0.034), (0, 0, 0.046), 0.024)
    flange.tube("steel", (0, 0, 0.046), (0, 0, 0.05625), 0.032)
    return {f"link_{i}": mesh for i, mesh in enumerate((base, waist, upper, fore, wrist, bend, flange))}


def hand_links() -> dict[str, Mesh]:
    """Meshes of the Barrett Hand's bodies: palm (z out of the palm), knuckle, inner and outer link (x along, y to the closing side)."""
    palm = Mesh()
    palm.tube("black", (0, 0, 0), (0, 0, 0.012), 0.046)
    palm.tube("steel", (0, 0, 0.012), (0, 0, 0.058), 0.0445)
    palm.tube("black", (0, 0, 0.058), (0, 0, 0.080), 0.0445)
    palm.box("steel", (-0.012, 0.030, 0.052), (0.012, 0.062, 0.068))  # foot of finger 3
    palm.box("steel", (-0.012, 0.038, 0.066), (-0.0098, 0.060, 0.084))
    palm.box("steel", (0.0098, 0.038, 0.066), (0.012, 0.060, 0.084))
    knuckle = Mesh()  # frame: at the spread axis, z out of the palm, x towards the finger, at the height of joint 2
    knuckle.slab("steel", [(0, 0, 0.0125), (0.046, 0, 0.0125)], -0.034, -0.011)
    knuckle.box("steel", (0.038, -0.012, -0.011), (0.060, -0.0098, 0.0085))
    knuckle.box("steel", (0.038, 0.0098, -0.011), (0.060, 0.012, 0.0085))
    inner = Mesh()
    inner.slab("steel", [(0, 0, 0.0095), (0.06994, 0.003, 0.0095)], -0.0095, 0.0095, sides=12)
    inner.box("rubber", (0.016, 0.0085, -0.008), (0.056, 0.0105, 0.008))
    outer = Mesh()
    outer.slab("grey", [(0, 0, 0.0095), (0.0496, 0, 0.0095)], -0.0092, 0.0092, sides=12)
    outer.slab("rubber", [(0.030, 0.0005, 0.0092), (0.0497, 0.0004, 0.0094)], -0.0094, 0.0094, sides=12)
    return {"palm": palm, "knuckle": knuckle, "inner": inner, "outer": outer}


def camera_parts() -> dict[str, Mesh]:
    """The XC-77 in the camera frame (x right, y down, z forward, origin at the centre of projection) and its tripod below a z-up frame."""
    camera = Mesh()
    camera.box("grey", (-0.022, -0.0145, -0.135), (0.022, 0.0145, -0.040))
    camera.tube("black", (0, 0, -0.040), (0, 0, 0.012), 0.0145)
    camera.tube("black", (0, 0, -0.012), (0, 0, 0.0), 0.0165)
    tripod = Mesh()
    tripod.box("black", (-0.03, -0.05, -0.02), (0.03, 0.05, 0))
    tripod.tube("black", (0, 0, -0.35), (0, 0, -0.02), 0.014, sides=12)
    for a in np.radians([90, 210, 330]):
        foot = np.array([0.45 * np.cos(a), 0.45 * np.sin(a), -1.5])
        tripod.tube("grey", (0.03 * np.cos(a), 0.03 * np.sin(a), -0.12), foot, 0.014, 0.009, sides=8)
    return {"xc77": camera, "tripod": tripod}


def write(folder: Path) -> None:
    """Write all meshes below folder."""
    for name, parts in (("puma560", puma_links()), ("barrett_hand", hand_links()), ("xc77", camera_parts())):
        (folder / name).mkdir(parents=True, exist_ok=True)
        for part, mesh in parts.items():
            mesh.write(folder / name / f"{part}.obj", MATERIALS)
