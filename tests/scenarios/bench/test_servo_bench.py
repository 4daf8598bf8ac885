"""The servo's benchmark: what one geometric run tells, and the laws' outcomes in cases with a known answer."""

from dataclasses import replace

import numpy as np
import pytest

from vipr.diagrams.servo_robot import STOPPING_TIME
from vipr.diagrams.workcell_layout import JOINT_LIMITS
from vipr.scenarios.align import Follow, FollowSettings
from vipr.scenarios.bench.servo.calibration import wrong
from vipr.scenarios.bench.servo.hard import CASES, looking
from vipr.scenarios.bench.servo.starts import placing, summary
from vipr.scenarios.bench.servo.trial import LAWS, Setting, fly
from vipr.scenarios.place_by_showing import PlaceSettings


@pytest.fixture(scope="module")
def flight():
    return fly(Setting.of(placing(PlaceSettings(duration_s=4.0), 3)), LAWS["2.5D"])


def test_a_placed_object_comes_to_its_place_within_all_limits(flight):
    assert flight.converged and flight.in_view and flight.within_limits
    assert 1.0 < flight.time < 4.0
    straight = np.linalg.norm(flight.X_WE[-1, :3, 3] - flight.X_WE[0, :3, 3])
    assert straight <= flight.path < 2.0 * straight
    assert flight.final_px < 0.5 and flight.clearance > 0.005


def test_summary_counts_what_converged(flight):
    assert summary([flight, flight])[0] == "2 of 2"


def test_held_object_is_placed_although_the_calibration_is_wrong():
    flight = fly(
        Setting.of(placing(PlaceSettings(duration_s=5.0, calibration=wrong(1)), 1)), LAWS["image-based, current L"]
    )
    assert flight.setting.believed is not None
    assert flight.mm[flight.last].max() < 2.0


def test_the_arm_stands_within_80_ms_of_the_first_exposure_without_target_from_its_full_speed_and_goes_on():
    setting = Setting.of(placing(PlaceSettings(place=4, duration_s=4.0), 4))
    seen = fly(setting, LAWS["position-based"], step=0.01)
    fastest = seen.t[np.argmax(np.max(np.abs(seen.rates) / (STOPPING_TIME * JOINT_LIMITS.acceleration), axis=1))]
    begin = 0.04 * np.ceil(fastest / 0.04)
    flight = fly(replace(setting, blind=(begin - 1e-6, begin + 0.4)), LAWS["position-based"], step=0.01)
    speed = np.abs(flight.rates).max(axis=1)
    assert speed[np.searchsorted(flight.t, begin)] > 0.1, "it was moving"
    assert (speed[(flight.t > begin + 0.075) & (flight.t < begin + 0.4)] < 1e-9).all()
    assert flight.converged and flight.within_limits


def test_feed_forward_is_worth_a_factor_of_five_behind_a_moving_object():
    scenario = Follow(FollowSettings(approach_s=1.5, settle_s=0.5), 1)
    rms = []
    for feed_forward in (True, False):
        law = type(LAWS["position-based"])(gain=4.0, feed_forward=feed_forward)
        flight = fly(Setting.of(scenario), law)
        rms.append(np.sqrt(np.mean(flight.mm[scenario.windows(flight.t)["following"]] ** 2)))
    assert rms[0] < 5.0 and rms[1] > 5.0 * rms[0]


def test_half_a_turn_about_the_optical_axis_ends_at_a_limit_by_the_image_alone_and_at_the_goal_by_the_pose():
    setting = looking(CASES["180 deg about the optical axis"], 1)
    by_image, by_pose = (fly(setting, LAWS[name]) for name in ("image-based, current L", "position-based"))
    assert by_image.stopped_at_a_limit and not by_image.converged and by_image.within_limits
    assert by_image.X_CO[:, 2, 3].max() > 1.5 * by_image.X_CO[0, 2, 3], "it retreats"
    assert by_pose.converged
