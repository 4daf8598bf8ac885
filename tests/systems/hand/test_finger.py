"""The finger's plane geometry against the hand's model."""

import numpy as np
import pytest
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

from vipr.models import model_path
from vipr.systems.errors import InputError
from vipr.systems.hand import finger, transmission


@pytest.fixture(scope="module")
def hand():
    plant = MultibodyPlant(0.001)
    Parser(plant).AddModels(str(model_path("barrett_hand/barrett_hand.sdf")))
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("palm"))
    plant.Finalize()
    return plant


def ball(plant, motors, k):
    context = plant.CreateDefaultContext()
    plant.SetPositions(context, transmission.joint_angles(motors, transmission.SEATED))
    return plant.GetFrameByName(f"finger_{k}_outer").CalcPoseInWorld(context) @ np.array([finger.OUTER, 0.0, 0.0])


@pytest.mark.parametrize("angle", [0.0, 0.6, 1.2, 1.6])
def test_tip_is_where_the_model_has_it(hand, angle):
    p = ball(hand, np.array([angle, angle, angle, 0.0]), 3)
    np.testing.assert_allclose(finger.tip(angle), [p[1], p[2]], atol=1e-9)


def test_closing_is_the_inverse_of_reach():
    for angle in (0.1, 0.8, 1.5):
        assert finger.closing(finger.tip(angle)[0]) == pytest.approx(angle, abs=1e-9)
    with pytest.raises(InputError, match="asked for 200 mm"):
        finger.closing(0.2)


@pytest.mark.parametrize("spread", [0.0, 0.25])
def test_all_three_tips_meet_a_centred_round_at_once(hand, spread):
    offset, reach = finger.centring(0.033, spread)
    motors = np.append(np.full(3, finger.closing(reach)), spread)
    for k in (1, 2, 3):
        p = ball(hand, motors, k)
        assert np.hypot(p[0], p[1] - offset) == pytest.approx(0.033 + finger.RADIUS, abs=1e-6)
