"""How ``vipr bench people`` counts: hits, swaps, seen or not, and that a scene is a function of its seed."""

import numpy as np
import pytest

from vipr.scenarios.bench.people.clips import score_clip
from vipr.scenarios.bench.people.pixels import scores
from vipr.scenarios.bench.people.rooms import BOOTSTRAP, RoomResult, judge, names_after_parting, summarise
from vipr.scenarios.bench.people.variants import VARIANTS, moved
from vipr.scenarios.people.scenes import KINDS, light_program, random_scene
from vipr.systems.signals import HandTracks


def tracks(**parts):
    known = {name: np.array(p, float) for name, p in parts.items()}
    return HandTracks(**known, **{f"{name}_seen": True for name in known})


def reference(**parts):
    row = {"shoulder_px": 100.0}
    for name in ("face", "lhand", "rhand"):
        x, y, visibility = parts.get(name, (0.0, 0.0, 0.0))
        row |= {f"{name}_x": x, f"{name}_y": y, f"{name}_vis": visibility}
    return row


def test_a_hit_is_near_enough_in_shoulder_widths_and_counts_where_the_reference_is_sure():
    seen = [tracks(face=(0, 34)), tracks(face=(0, 36)), tracks(left=(49, 0)), tracks(right=(0, 0)), tracks()]
    rows = [
        reference(face=(0, 0, 0.9)), reference(face=(0, 0, 0.9)), reference(lhand=(0, 0, 0.6)),
        reference(lhand=(0, 0, 0.6)), reference(lhand=(0, 0, 0.4)),
    ]  # fmt: skip
    face, left = score_clip("clip", seen, rows)
    assert (face.part, face.visible, face.hits) == ("face", 2, 1) and face.median_error == pytest.approx(0.35)
    assert (left.part, left.visible, left.hits, left.either) == ("left", 2, 1, 2)


@pytest.mark.parametrize("variant", VARIANTS.values(), ids=VARIANTS)
def test_the_reference_of_a_variant_is_where_the_variant_puts_it(variant):
    image = np.zeros((120, 160, 3), np.uint8)
    image[57:64, 67:74] = 255
    row = moved(reference(face=(70, 60, 0.9), lhand=(70, 60, 0.8)), variant, (160, 120))
    y, x = np.nonzero(variant.picture(image).min(2) == variant.picture(image).max((0, 1)).min())
    assert (row["face_x"], row["face_y"]) == pytest.approx((x.mean(), y.mean()), abs=0.6)
    hand, other = ("rhand", "lhand") if variant.mirrored else ("lhand", "rhand")
    assert row[f"{hand}_x"] == row["face_x"] and (row[f"{hand}_vis"], row[f"{other}_vis"]) == (0.8, 0.0)
    assert row["shoulder_px"] == 100 * variant.scale


def result(swapped, contact, n=80):
    error, seen = np.full((n, 3), 1.0), np.ones((n, 3), bool)
    flags = np.zeros((2, n), bool)
    flags[0, swapped], flags[1, contact] = True, True
    return RoomResult(random_scene(1), error, seen, seen.copy(), flags[1], flags[0])


def test_a_swap_after_touching_is_counted_once_and_one_without_contact_apart():
    fine, after, without = (
        result(slice(0, 0), slice(40, 50)), result(slice(48, 80), slice(40, 50)), result(slice(30, 36), slice(0, 0)),
    )  # fmt: skip
    assert names_after_parting(fine) == (1, 0)
    assert names_after_parting(after) == (1, 1)
    s = summarise([fine, after, without])
    assert (s["partings"], s["swapped_after_parting"], s["scenes_swapped_without_contact"]) == (2, 1, 1)
    assert s["frames"] == 3 * (80 - BOOTSTRAP) and s["tracked"] == {"face": 1.0, "left": 1.0, "right": 1.0}


def test_parts_that_are_not_reported_are_not_tracked():
    r = result(slice(0, 0), slice(0, 0))
    r.seen[BOOTSTRAP::2, 0], r.error[BOOTSTRAP::2, 0] = False, np.nan
    s = summarise([r])
    assert s["tracked"]["face"] == pytest.approx(0.5, abs=0.02) == s["seen_right"]["face"]


def test_nothing_to_see_is_judged_as_nothing_seen():
    frames = [(np.full((60, 80, 3), 90, np.uint8), np.zeros((60, 80), np.int16))] * 30
    s = judge(random_scene(0), frames)
    assert not s.seen.any() and not s.seen_true.any() and not s.contact.any()


def test_a_scene_is_a_function_of_its_seed_and_stays_before_the_person():
    for seed in range(10):
        a, b = random_scene(seed), random_scene(seed)
        assert a.kind == KINDS[seed % 5] and a.look == b.look and np.array_equal(a.paths.left, b.paths.left)
        assert np.abs(a.paths.left).max() < 1.2 and len(a.light) == len(a.paths) == 150
    assert not np.array_equal(random_scene(1).paths.left, random_scene(6).paths.left)


@pytest.mark.parametrize("program", ["constant", "fixed", "step", "drift"])
def test_light_stays_within_its_range(program):
    light = light_program(np.random.default_rng(2), program, 100)
    assert light.shape == (100, 2) and light[:, 0].min() >= 0.4 and light[:, 0].max() <= 1.6
    assert light[:, 1].min() >= 3000 and light[:, 1].max() <= 8000
    changes = np.count_nonzero(np.abs(np.diff(light[:, 1])) > 1e-9)
    assert changes == 0 if program in ("constant", "fixed") else changes >= 3


def test_precision_and_recall():
    found, true = np.array([1, 1, 1, 0], bool), np.array([1, 1, 0, 1], bool)
    assert scores(found, true) == pytest.approx((2 / 3, 2 / 3))
    assert scores(~true & ~true, np.zeros(4, bool)) == (0.0, 0.0)
