"""Whatever twist is asked for, on every step no limit of the arm is exceeded, nothing is touched, and the tool keeps its direction."""

import numpy as np
import pytest

from vipr.diagrams.workcell_layout import JOINT_LIMITS as LIMITS
from vipr.diagrams.workcell_layout import collision_guard, puma_with_hand
from vipr.scenarios.bench.arm import DrivenArm, random_twists
from vipr.systems import se3
from vipr.systems.arm import puma560
from vipr.systems.arm.guard import CollisionGuard
from vipr.systems.arm.limit_use import limit_use
from vipr.systems.errors import InputError

ARM, GUARD = puma_with_hand(), collision_guard()


@pytest.mark.parametrize("seed", [1, 2])
def test_random_twists_never_exceed_a_limit_nor_touch_anything(seed):
    rng = np.random.default_rng(seed)
    drive = DrivenArm(guard=GUARD)
    (q, v), reasons, places = drive.state, set(), []
    for V, steps in random_twists(rng, 20):
        for _ in range(steps):
            q_new, v_new = drive.step(V)
            assert np.allclose(q_new - q, 0.01 * v_new, atol=1e-12)
            assert (limit_use(q_new, v_new, v, LIMITS, 0.01) <= 1.0 + 1e-9).all()
            q, v = q_new, v_new
            places.append(q)
            reasons.add(drive.limited_by)
    gaps, pairs = GUARD.body.clearance(np.array(places), GUARD.obstacles)
    worst = int(np.argmin(gaps))
    assert gaps[worst] >= GUARD.margin - 1e-4, f"{' near '.join(pairs[worst])} at step {worst}"
    assert reasons >= {"speed", "acceleration", "position", "collision"}


def directions(drive, V, steps):
    """Twist (w, v) of the tool in each of the steps, while a constant one is asked for."""
    for _ in range(steps):
        (q, _), (_, v_new) = drive.state, drive.step(V)
        yield ARM.tool_pose_and_jacobian(q)[1] @ v_new


@pytest.mark.parametrize(
    "V", [[0, 0, 0.3, 0.05, 0.2, 0.1], [0, 0, 0, 0, 3.0, 0], [0, 0, 2.5, 0, 0, 0], [0, 0, 0, -0.3, 0, 0.2]]
)
def test_the_tool_keeps_its_direction_while_it_starts_and_while_a_joint_is_at_its_speed(V):
    V, drive = np.array(V, float), DrivenArm()
    for V_new in directions(drive, V, 60):
        share = V_new @ V / (V @ V)
        assert 0 < share <= 1 + 1e-9
        assert np.linalg.norm(V_new - share * V) < 1e-9


def test_before_a_stop_the_tool_slows_down_on_its_line_and_halts_there():
    q = np.array([0.0, 0.8, -2.8, 0.0, 0.9, 4.2])
    V = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    V[:3] = 2.0 * ARM.tool_pose(q)[:3, 2]  # about the tool's axis: joint 6 alone, 25 degrees from its stop
    drive = DrivenArm(q)
    for V_new in directions(drive, V, 200):
        assert np.linalg.norm(V_new - (V_new @ V) / (V @ V) * V) < 1e-6
    assert drive.limited_by == "position" and drive.state[0][5] == pytest.approx(LIMITS.upper[5], abs=1e-6)
    drive.step(-V)
    assert drive.state[1][5] < 0 and drive.limited_by == "acceleration"  # and back without ado


def test_towards_the_table_the_hand_stops_smoothly_above_it_says_why_and_may_go_back():
    drive, down, gaps, speeds = DrivenArm(guard=GUARD), np.array([0, 0, 0, 0, 0, -0.2]), [], []
    for _ in range(500):
        q, v = drive.step(down)
        gaps.append(GUARD.body.clearance(q, GUARD.obstacles)[0])
        speeds.append(np.linalg.norm(v))
    assert GUARD.margin <= min(gaps) < GUARD.margin + 0.002 and gaps[-1] == min(gaps)
    assert drive.limited_by == "collision" and drive.status.startswith("held off: ")
    slowing = np.array(speeds[np.argmax(speeds) :])
    assert (np.diff(slowing) <= 1e-9).all() and slowing[-1] < 1e-3
    for _ in range(50):
        drive.step(-down)
    assert GUARD.body.clearance(drive.state[0], GUARD.obstacles)[0] > gaps[-1] + 0.05 and not drive.limited_by


def test_from_within_the_margin_the_arm_may_leave_but_not_go_deeper():
    drive = DrivenArm(guard=GUARD)
    for _ in range(400):
        drive.step([0, 0, 0, 0, 0, -0.2])
    q = drive.state[0]
    wide = CollisionGuard(GUARD.body, GUARD.obstacles, margin=0.05)  # where 5 mm were allowed, 50 are asked for
    stuck, leaving = DrivenArm(q, wide), DrivenArm(q, wide)
    for _ in range(50):
        stuck.step([0, 0, 0, 0, 0, -0.2])
        leaving.step([0, 0, 0, 0, 0, 0.2])
    assert np.abs(stuck.state[0] - q).max() < 1e-9 and stuck.limited_by == "collision"
    assert ARM.tool_pose(leaving.state[0])[2, 3] > ARM.tool_pose(q)[2, 3] + 0.05


@pytest.mark.parametrize("V", [[0, 0, 0, 0.3, 0, 0], [0, 0, 0, 0, 0, 0.3]])
def test_through_a_singularity_the_rates_stay_calm_and_it_is_named(V):
    drive = DrivenArm(np.array([0.0, 0.9, -2.2, 0.0, 0.3, 0.0]))
    named = set()
    for _ in range(300):  # out until the arm is stretched
        _, v = drive.step(V)
        named.add(drive.limited_by)
        assert (np.abs(v) <= LIMITS.speed + 1e-9).all()
    assert named & {"singularity", "position"}


@pytest.mark.parametrize(
    "margin, approach, said", [(-0.01, 8, "margin must be 0 to 500 mm, got -10 mm"), (0.005, 0, "approach")]
)
def test_a_bad_guard_is_refused(margin, approach, said):
    with pytest.raises(InputError, match=said):
        CollisionGuard(GUARD.body, GUARD.obstacles, margin=margin, approach=approach)


def test_a_hand_that_closes_is_kept_further_from_the_table_than_an_open_one():
    palm_down = puma560.inverse_near(se3.pose(np.diag([1.0, -1, -1]), [0.55, 0, 0.85]), puma560.NAMED["nominal"])
    heights = []
    for finger in (0.0, 1.2):
        drive = DrivenArm(palm_down, GUARD)
        for _ in range(300):
            drive.step([0, 0, 0, 0, 0, -0.2], motor=np.array([finger, finger, finger, 0.0]))
        assert drive.limited_by == "collision"
        heights.append(ARM.tool_pose(drive.state[0])[2, 3])
    assert heights[1] > heights[0] + 0.02


def test_the_guard_bounds_how_far_fingers_reach():
    for motor in np.random.default_rng(0).uniform(0, [2.44, 2.44, 2.44, 3.1], (50, 4)):
        for shape in GUARD.with_hand(motor).shapes:
            extent = np.linalg.norm(shape.X[:3, 3]) + np.linalg.norm(shape.half) + shape.radius
            assert extent < GUARD.hand_extent or not shape.name.startswith("finger")


def test_a_start_within_the_table_is_refused():
    with pytest.raises(InputError, match=r"arm: starts with \w+ \d+ mm deep in \w+"):
        DrivenArm(np.array([0.0, 0.2, -3.0, 0.0, 0.4, 0.0]), GUARD)
