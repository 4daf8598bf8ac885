"""Bare arms: which end of a region is the hand, where its elbow can be, and whose arm it is. Pixels of the labels."""

from dataclasses import dataclass

import numpy as np

from vipr.systems.compiled import compiled
from vipr.systems.hands.blobs import ends, middle_about

ARM_SLENDERNESS = 3.0  # length over width from which a region is an arm with a hand at one end
HAND_LENGTH_IN_WIDTHS = 2.3  # a hand is about this much longer than its arm is wide
# In heights of the head (Drillis and Contini's proportions of the body):
HAND_LENGTH, UPPER_ARM = 0.66, 1.43  # of the hand what is seen of it: fingers are thin and often bent
SHOULDER = (0.86, 0.90)  # from the middle of the face: to the side, down
INWARDS = 0.3  # from the shoulder towards the other, where elbows are still seen
FOREARM = 1.5  # from the elbow to the middle of the hand
ARM_BESIDE_HEAD = 0.9  # length from which a slender thing at the head is an arm, not a hand or the neck
ARM_WIDTH = 0.45  # what is wider is hand as well
AT_HEAD = 0.9  # from the middle of the face, within which an arm ends at the head
HAND_IN_FACES = 0.75  # area of the largest usual hand over that of the face; more is hand and arm
FORESHORTENED = 2.2  # times longer than wide: a bare arm that points at the camera is hardly longer, hands are shorter


@dataclass(frozen=True)
class Body:
    """What the face says of one arm."""

    shoulder: np.ndarray  # (2,) px
    other: np.ndarray  # (2,) px, the other arm's
    head: float  # px, height
    face_area: float  # px^2

    def beyond_elbow(self, point: np.ndarray) -> float:
        """How much farther from the shoulder a point is than the elbow can be, in heights of the head; 0 where it can be the elbow."""
        return max(0.0, float(np.hypot(*(point - self.shoulder))) / self.head - 1.08 * UPPER_ARM)

    def elbow_astray(self, ends: tuple[np.ndarray, np.ndarray]) -> float:
        """How far the likelier elbow of a bare arm with these ends is from where this arm's can be, in heights of the head.

        Within reach of the shoulder, and not before the chest: hands cross, elbows hardly ever.
        """
        outwards = 1.0 if self.shoulder[0] > self.other[0] else -1.0
        return min(
            self.beyond_elbow(end) + max(0.0, outwards * float(self.shoulder[0] - end[0]) / self.head - INWARDS)
            for end in ends
        )

    def is_elbow(self, point: np.ndarray) -> bool:
        """Whether a point is within reach of either elbow."""
        return min(float(np.hypot(*(point - s))) for s in (self.shoulder, self.other)) < 1.15 * UPPER_ARM * self.head


def hand_end(p: np.ndarray, expected, body: Body | None, motion: np.ndarray) -> tuple[np.ndarray, float]:
    """Centre (2,) of the hand in blob p (n, 2), and the number of its pixels.

    A compact blob of a hand's size is the hand. Of more than that (a bare arm), the hand is one end: the one that is too far from the
    shoulder to be the elbow, not the one at the sleeve, else the upper one (the elbow hangs), the one that moves in ``motion`` (h, w) uint8
    and the one near ``expected`` (2,) or None. Without a body, the end farther from the border of the image.
    """
    a, b, length, width = ends(p)
    much = body is not None and len(p) > HAND_IN_FACES * body.face_area
    if (length < ARM_SLENDERNESS * width and not much) or len(p) < 12 or length < 4:
        return p.mean(0), float(len(p))
    reach = (
        HAND_LENGTH_IN_WIDTHS * width
        if body is None
        else min(HAND_LENGTH * body.head, 1.3 * HAND_LENGTH_IN_WIDTHS * width)
    )
    unit = length if body is None else body.head

    def price(end):
        cost = -0.5 * _motion_about(p, *end, reach, motion) / 255.0
        if expected is not None:
            cost += 0.45 * np.hypot(*(end - expected)) / unit
        if body is None:
            return cost - _inside(end, motion.shape) / unit
        d = np.hypot(*(end - body.shoulder)) / unit
        return cost + 0.8 * end[1] / unit + 0.8 * min(max((0.7 - d) / 0.3, 0.0), 1.0) - 2.0 * body.beyond_elbow(end)

    tip = a if price(a) < price(b) else b
    if expected is not None and length > 2.5 * unit and np.hypot(*(tip - expected)) > 2.5 * reach:
        tip = p[np.argmin(((p - expected) ** 2).sum(1))]  # a bent arm, or two: neither end is where the hand should be
    return middle_about(p, *tip, reach)


def _inside(p: np.ndarray, shape) -> float:
    return min(p[0], p[1], shape[1] - 1 - p[0], shape[0] - 1 - p[1])


@compiled
def _motion_about(p, x, y, reach, motion):
    """Mean of motion (h, w) at the points p (n, 2) within reach of x, y."""
    total, n = 0.0, 0
    for k in range(len(p)):
        if (p[k, 0] - x) ** 2 + (p[k, 1] - y) ** 2 < reach**2:
            total, n = total + motion[int(p[k, 1]), int(p[k, 0])], n + 1
    return total / n


def far_end(p: np.ndarray, expected: np.ndarray, body: Body) -> np.ndarray | None:
    """Centre (2,) of the hand at an end of blob p (n, 2) that no elbow can reach, near where it is ``expected`` (2,); None without one."""
    reach = HAND_LENGTH * body.head
    a, b, length, _ = ends(p)
    if len(p) < 2.0 * HAND_IN_FACES * body.face_area or length < 1.5 * body.head:  # no more than hands
        return None
    tips = [end for end in (a, b) if not body.is_elbow(end) and np.hypot(*(end - expected)) < 1.8 * reach]
    if len(tips) != 1:
        return None
    return middle_about(p, *tips[0], reach)[0]


def arm_at_head(p: np.ndarray, face: np.ndarray, head: float) -> np.ndarray | None:
    """(2, 2) the end at the head and the other of a blob p (n, 2) beside a head, if it is an arm whose hand is before the face.

    It is slender, leads away from the head, and is longer than a hand, but not as long as an arm with its hand.

    ``face`` (2,) is the middle of the head, ``head`` its height [px].
    """
    a, b, length, width = ends(p)
    near, far = np.hypot(*(a - face)), np.hypot(*(b - face))
    leads_away = abs(far - near) > 0.7 * length and min(near, far) < AT_HEAD * head
    slender = length > 1.8 * width and width < ARM_WIDTH * head
    if not (slender and leads_away and ARM_BESIDE_HEAD * head < length < FOREARM * head):
        return None
    return np.array([a, b] if near < far else [b, a])


def astray(p: np.ndarray, left: Body, right: Body) -> float:
    """How much more the elbow of blob p (n, 2) would be astray in the left arm than in the right, in heights of the head, -1 to 1.

    0 where it is no bare arm.
    """
    a, b, length, width = ends(p)
    if length <= FORESHORTENED * width:
        return 0.0
    return min(max(left.elbow_astray((a, b)) - right.elbow_astray((a, b)), -1.0), 1.0)
