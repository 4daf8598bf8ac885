"""Clearance of arm and hand: against distances of the real model, and on cases worked out by hand."""

import numpy as np
import pytest

from vipr.diagrams.workcell import WorkcellConfig, held_shapes
from vipr.diagrams.workcell_layout import collision_guard, obstacles, puma_with_hand
from vipr.scenarios.bench.arm import MODEL_LESS, random_configuration
from vipr.scenarios.bench.model_distances import ModelDistances
from vipr.systems import se3
from vipr.systems.arm import puma560
from vipr.systems.arm.gaps import pair_gaps, smallest_gaps
from vipr.systems.arm.puma_body import hand_shapes, puma_with_hand_body
from vipr.systems.arm.shapes import box, capsule, compile_gaps, cylinder, gap, sphere
from vipr.systems.errors import InputError

ARM = puma_with_hand()


def random_configurations(count, seed):
    rng = np.random.default_rng(seed)
    return [random_configuration(rng) for _ in range(count)]


def test_clearance_is_never_more_than_the_models_distance_and_seldom_much_less():
    model, around = ModelDistances(), obstacles(np.zeros(3))
    short = []
    for q, hand in random_configurations(300, seed=4):
        body = puma_with_hand_body(ARM, hand)
        ours, pair = body.clearance(q, around)
        true = model.smallest(q, hand, body, around)
        assert ours <= true + 1e-3, pair
        if true > 0 and not any(name in part for part in pair for name in MODEL_LESS):
            short.append(true - ours)
    assert len(short) > 150
    assert np.quantile(short, 0.9) < 1e-3 and max(short) < 0.015


def test_every_collision_shape_of_the_models_is_there():
    ours = {s.name for s in (*puma_with_hand_body(ARM).shapes, *obstacles())}
    assert set(ModelDistances().names.values()) - ours == set()


def test_many_configurations_at_once_give_what_each_gives_alone():
    body = puma_with_hand_body(ARM)
    q = np.array([q for q, _ in random_configurations(20, seed=1)])
    gaps, pairs = body.clearance(q, obstacles())
    for k in range(20):
        gap_k, pair_k = body.clearance(q[k], obstacles())
        assert gap_k == pytest.approx(gaps[k], abs=2e-4)
        assert pair_k == pairs[k] or abs(gap_k - gaps[k]) < 2e-4


@pytest.mark.parametrize(
    "a, b, distance",
    [
        (sphere("a", 0.1, (0, 0, 0)), sphere("b", 0.2, (0.3, 0.4, 0)), 0.2),
        (sphere("a", 0.1, (0, 0, 1.0)), box("b", (2, 2, 1), np.eye(4)), 0.4),
        (sphere("a", 0.1, (1.3, 1.4, 0)), box("b", (2, 2, 1), np.eye(4)), 0.4),
        (capsule("a", 0.1, 2.0, np.eye(4)), capsule("b", 0.1, 2.0, se3.pose(np.eye(3), [1, 0, 0.5])), 0.8),
        (cylinder("a", 0.5, 1.0, np.eye(4)), sphere("b", 0.1, (0, 0.8, 0.9)), 0.4),
        (cylinder("a", 0.5, 1.0, np.eye(4)), box("b", (4, 4, 0.2), se3.pose(np.eye(3), [0, 0, 0.9])), 0.3),
        (
            box("a", (0.2, 0.2, 2.0), se3.pose(se3.exp_so3(np.array([0, 0, np.pi / 4])), [0, 0, 0])),
            box("b", (0.2, 2.0, 0.2), se3.pose(se3.exp_so3(np.array([0, np.pi / 4, 0])), [1.0, 0, 0])),
            1.0 - 0.2 * np.sqrt(2),
        ),
    ],
)
def test_gaps_of_simple_pairs_are_exact(a, b, distance):
    assert gap(a, b) == pytest.approx(distance, abs=1e-6) == gap(b, a)


def test_overlap_is_negative():
    assert gap(sphere("a", 0.1, (0, 0, 0.55)), box("b", (2, 2, 1), np.eye(4))) == pytest.approx(-0.05)


def test_the_nominal_pose_is_clear_and_a_hand_in_the_table_is_not():
    body = puma_with_hand_body(ARM)
    assert body.clearance(puma560.NAMED["nominal"], obstacles())[0] > 0.05
    X_W6 = se3.pose(np.diag([1.0, -1, -1]), [0.55, 0, 0.62])
    deep, (mine, other) = body.clearance(puma560.inverse_near(X_W6, puma560.NAMED["nominal"]), obstacles())
    assert deep < -0.01 and (mine.startswith("finger") or mine == "palm") and other in ("table", "stage", "stage_foot")


def test_what_the_hand_holds_counts_as_part_of_it():
    carton = box("carton", (0.1, 0.1, 0.2), se3.pose(np.eye(3), [0, 0, 0.18]))
    empty, full = puma_with_hand_body(ARM), puma_with_hand_body(ARM, held=(carton,))
    q = puma560.inverse_near(se3.pose(np.diag([1.0, -1, -1]), [0.55, 0, 0.87]), puma560.NAMED["nominal"])
    assert full.clearance(q, obstacles()) == (
        pytest.approx(0.87 - puma560.FLANGE - 0.28 - 0.52, abs=1e-6),
        ("carton", "stage"),
    )
    assert empty.clearance(q, obstacles())[0] > 0.05


def test_an_object_fixed_to_the_hand_is_guarded_with_it():
    X_EO = se3.pose(np.diag([1.0, -1, -1]), [0, 0, 0.2])
    shapes = held_shapes(WorkcellConfig(object="rice_box", X_EO_held=X_EO))
    assert [s.name for s in shapes] == ["rice_box"]
    assert np.allclose(2 * shapes[0].half, [0.115, 0.050, 0.165])
    assert np.allclose(shapes[0].X[:3, 3], [0, 0, 0.135 + 0.2 - 0.165 / 2])
    guard = collision_guard(shapes)
    assert ("rice_box", "table") in guard.names and not any("rice_box" in a and "finger" in b for a, b in guard.names)
    assert held_shapes(WorkcellConfig(object="rice_box")) == ()


def test_after_compiling_ahead_clearance_and_guard_compile_nothing_more():
    compile_gaps()
    before = [len(f.signatures) for f in (pair_gaps, smallest_gaps)]
    guard = collision_guard()
    guard.body.clearance(puma560.NAMED["nominal"], guard.obstacles)
    for motor in (None, np.zeros(4)):
        guard.gaps(puma560.NAMED["nominal"][None], np.arange(5), guard.table(motor))
    assert [len(f.signatures) for f in (pair_gaps, smallest_gaps)] == before


def test_bad_shapes_and_fingers_beyond_their_stops_are_refused():
    with pytest.raises(InputError, match="shape a: sizes must be positive, got"):
        box("a", (0.1, -0.1, 0.1), np.eye(4))
    with pytest.raises(InputError, match=r"finger_1_proximal is at 171\.9 deg, allowed are 0 to 140 deg"):
        hand_shapes(np.array([0, 3.0, 0, 0, 0, 0, 0, 0]))
