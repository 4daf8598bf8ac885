"""The living room: what its camera sees, what its truth says, and that looks and light change only what they should."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from vipr.diagrams.living_room import SKIN_TONES, CameraPlace, LivingRoom, Look, random_look
from vipr.models.person.generate import BODIES
from vipr.scenarios.people.film import Studio, film_gestures
from vipr.scenarios.people.motion import HandPaths, joint_positions, plane_path, rest
from vipr.systems.errors import InputError
from vipr.systems.hands.label_truth import FACE, LEFT, RIGHT, tracks_from_labels
from vipr.systems.signals import CameraFrame, HandTracks

PLACE = CameraPlace(width=80, height=60)


@pytest.fixture(scope="module")
def studio():
    return Studio("medium", PLACE)


def pose(left=(0.35, 0.35, 0.0), right=(0.35, -0.3, -0.2)):
    paths = HandPaths(left=np.array([left]), right=np.array([right]))
    return joint_positions(paths, BODIES["medium"], np.random.default_rng(0), idle=0.0)[0]


def test_the_ports_are_sampled_together_at_the_cameras_rate():
    room = LivingRoom("medium", place=PLACE)
    simulator = Simulator(room)
    context = simulator.get_mutable_context()
    room.GetInputPort("person_positions").FixValue(context, pose())
    room.GetInputPort("light").FixValue(context, [1.0, 5000.0])
    assert not room.GetOutputPort("frame").Eval(context).arrived
    assert room.GetOutputPort("hand_tracks_true").Eval(context).number == -1
    simulator.AdvanceTo(0.05)
    frame, truth = (room.GetOutputPort(name).Eval(context) for name in ("frame", "hand_tracks_true"))
    assert isinstance(frame, CameraFrame) and isinstance(truth, HandTracks)
    assert frame.image.shape == (60, 80, 3) and (frame.number, truth.number) == (1, 1) and frame.time == truth.time
    assert truth.face_seen and truth.left_seen and truth.right_seen


def test_the_persons_left_hand_is_on_the_images_right_and_where_the_pinhole_puts_it(studio):
    _, labels = studio.shoot(pose())
    truth = tracks_from_labels(labels, 0.0, 0)
    assert truth.left[0] > truth.face[0] > truth.right[0]
    focal = 0.5 * PLACE.width / np.tan(0.5 * PLACE.field_of_view)
    shoulder_height = next(PLACE.level - (y / focal) * (PLACE.distance - 0.35) for y in (truth.left[1] - 29.5,))
    expected = 39.5 + focal * 0.35 / (PLACE.distance - 0.35)
    assert abs(truth.left[0] - expected) < 2.0 and 1.2 < shoulder_height < 1.6


def test_a_hand_behind_the_back_is_not_seen(studio):
    _, labels = studio.shoot(pose(right=(-0.25, -0.1, -0.42)))
    assert np.count_nonzero(labels == RIGHT) < 6 and np.count_nonzero(labels == LEFT) > 6


def test_skin_looks_like_the_tone_and_clothes_change_with_the_look(studio):
    shades = []
    for tone in SKIN_TONES:
        studio.dress(Look(skin=tone))
        image, labels = studio.shoot(pose())
        shades.append(image[labels == FACE].mean())
    assert (np.diff(shades) < 0).all()
    studio.dress(Look(sleeves="long"))
    long = studio.shoot(pose())[0].astype(int)
    studio.dress(Look(sleeves="short"))
    short, labels = studio.shoot(pose())
    changed = np.abs(short - long).max(2) > 20
    assert set(np.unique(labels[changed])) <= {FACE, LEFT, RIGHT, 12, 14, 15, 16, 17, 20} and {16, 17} & set(
        np.unique(labels[changed])
    )


def test_the_light_changes_the_picture_and_not_the_truth(studio):
    room = studio._room
    context = studio._context
    studio.dress(Look())
    pictures = []
    for light in ([1.0, 5000.0], [0.5, 5000.0], [1.0, 3200.0]):
        simulator = Simulator(room)
        inner = simulator.get_mutable_context()
        room.GetInputPort("person_positions").FixValue(inner, pose())
        room.GetInputPort("light").FixValue(inner, light)
        simulator.AdvanceTo(0.01)
        pictures.append(room.GetOutputPort("frame").Eval(inner).image.reshape(-1, 3).mean(0))
    white, dim, warm = pictures
    assert np.allclose(dim, 0.5 * white, rtol=0.02)
    assert warm[2] / warm[0] > 1.5 * white[2] / white[0]
    assert context is studio._context


def test_a_film_is_a_function_of_its_arguments():
    paths = [HandPaths(right=plane_path(np.column_stack([np.linspace(-0.3, 0.3, 5), np.zeros(5)])))]
    a, b, c = (next(iter(film_gestures(paths, seed=seed, place=PLACE, images=True))) for seed in (3, 3, 4))
    assert np.array_equal(a.images, b.images) and not np.array_equal(a.images, c.images)
    assert np.array_equal(a.tracks.positions, b.tracks.positions, equal_nan=True)
    assert a.truth.seen[:, 2].all() and np.ptp(a.truth.positions[:, 2, 0]) > 3


def test_hands_go_where_the_paths_say_and_bad_paths_are_named():
    body = BODIES["medium"]
    q = joint_positions(HandPaths(left=np.tile(rest(body, "left"), (3, 1))), body, np.random.default_rng(0))
    assert q.shape == (3, 15) and np.isfinite(q).all()
    with pytest.raises(InputError, match=r"right must be finite with shape \(n, 3\) in metres"):
        HandPaths(right=np.zeros((4, 2)))
    with pytest.raises(InputError, match="one length, got 2 and 3 frames"):
        HandPaths(right=np.zeros((2, 3)), left=np.zeros((3, 3)))
    with pytest.raises(InputError, match="at least one hand"):
        HandPaths()


def test_shirts_are_never_of_skins_colour():
    for seed in range(50):
        r, g, b = random_look(np.random.default_rng(seed)).shirt
        assert not (1.1 < r / g < 2.6 and b < 1.1 * g)
