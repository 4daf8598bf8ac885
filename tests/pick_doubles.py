"""A thing with one grasp, a robot that knows it, and what a tracker would say of it: for tests of the pick."""

import numpy as np

from vipr.diagrams.workcell_layout import JOINT_LIMITS, fixed_camera, puma_with_hand
from vipr.systems import se3
from vipr.systems.grasping.grasp import Grasp, GraspTable, Symmetry
from vipr.systems.grasping.pick import Picker
from vipr.systems.grasping.pick_state import PickSettings
from vipr.systems.grasping.planning import Surroundings
from vipr.systems.signals import ObjectPose

X_WO = se3.pose(np.eye(3), [0.55, 0.0, 0.52])
FROM_ABOVE = se3.pose(np.diag([1.0, -1.0, -1.0]), [0.0, 0.0, 0.14])
GRASP = Grasp(name="above", X_OG=FROM_ABOVE, preshape=np.full(3, 1.0), closed=np.full(3, 1.2), quality=0.2, held=1.0)
TABLE = GraspTable("thing", 0.3, Symmetry(np.array([0.0, 0.0, 0.06])), (GRASP,))


def picker(**settings):
    """A pick of one thing by one grasp, with nothing around."""
    around = Surroundings(puma_with_hand(), JOINT_LIMITS)
    return Picker(TABLE, around, fixed_camera(), PickSettings(frames=2, **settings))


def sighting(t, X=X_WO, state="tracking"):
    """What the tracker says of an object at X_WO."""
    X_CO = se3.inverse(fixed_camera()) @ X
    return ObjectPose(X_CO=X_CO, covariance=1e-8 * np.eye(6), state=state, time=t, number=round(t / 0.04))
