"""What the tracker of a model can be told: numbers, and a switch for every part of it."""

from dataclasses import dataclass

import numpy as np

from vipr.systems.errors import InputError


@dataclass(frozen=True)
class TrackerSettings:
    """Every part of the tracker; each switch turns one part off for comparison."""

    nodes: int = 200  # tracking nodes, at most
    spacing: float = 3.0  # px, smallest interval of nodes
    reach: float = 14.0  # px, search along the normal where nothing else has found the object yet
    fine_reach: float = 5.0  # px, in the last passes
    contrast: float = 3.0  # grey levels, weakest edge that is looked at
    hypotheses: int = 4  # edges kept for each node
    prediction: bool = True  # constant-velocity filter; else the last pose is the start
    affine: bool = True  # affine motion of the nodes before the pose (eq. 26 to 34)
    quadratic: bool = False  # quadratic instead of affine
    gradient_fit: bool = True  # discrete search on the gradients (eq. 35)
    dynamic_step: bool = True  # whose steps follow the velocity
    texture: bool = True  # patches learnt while tracking
    patches: int = 64  # of a keyframe
    covered: bool = True  # patches that something covers are not learnt, and given up
    sharp: bool = True  # last pass with a sharp derivative: print beside an edge does not pull it
    colour: bool = True  # edges by the strongest colour channel; else by grey
    quantised_normals: bool = False  # the paper's 0, 45, 90, 135 degrees and whole pixels
    second_try: bool = True  # other starts and longer searches when the evidence is thin
    rivals: bool = True  # other poses near the one found that fit more closely
    start_search: bool = True  # look around a pose that was given, which may be tens of pixels off
    recall: bool = True  # look for a lost object in the whole image, by what it looked like
    initial_px: float = 1.0  # px, how well a given pose places the model's corners if it is good
    model_error: float = 0.02  # px, least error of an edge of the model, common to its nodes
    round_error: float = 0.05  # px, the same of limbs and rims, beside which there is shading
    spin_noise: float = 30.0  # rad/s^2, RMS angular acceleration expected
    speed_noise: float = 4.0  # m/s^2, RMS acceleration expected

    def __post_init__(self):
        for name, value in vars(self).items():
            if not isinstance(value, bool) and not (np.isfinite(value) and value > 0):
                raise InputError(f"tracker settings: {name} must be positive, got {value}")
