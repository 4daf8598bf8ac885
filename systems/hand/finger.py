"""Where a Barrett finger's tip is: the geometry of one finger in its own plane, clutch seated.

A finger moves in a plane through its base axis: the spread axis of fingers 1 and 2, the palm's axis for finger 3. ``reach`` is the
distance of the ball at the tip's end from that axis, ``height`` its distance above the mounting face, both at the ball's centre [m]; the
finger's skin is ``RADIUS`` further. Figures: models/barrett_hand/README.md.
"""

import numpy as np

from vipr.systems.errors import InputError

BASE_REACH, BASE_HEIGHT = 0.050, 0.0754  # m, of the joint of the inner link
# m, rad: from joint 2 to joint 3.
INNER, INNER_ANGLE = float(np.hypot(0.06994, 0.003)), float(np.arctan2(0.003, 0.06994))
OUTER, OUTER_ANGLE = 0.0496, np.pi / 4  # m, from joint 3 to the ball at the tip; rad, bent in at rest
RADIUS = 0.0095  # m
SPREAD_AXIS = 0.025  # m, of fingers 1 and 2 from the palm's axis
PALM_HEIGHT, PALM_RADIUS = 0.080, 0.0445  # m
GRASP_HEIGHT = 0.135  # m, of the frame ``grasp`` above the mounting face
LARGEST_CLOSING = np.radians(100.0)  # beyond it the tips point back to the palm


def tip(finger: float) -> tuple[float, float]:
    """(reach, height) [m] of the tip's ball at a finger angle [rad]."""
    inner, outer = finger + INNER_ANGLE, finger * 4.0 / 3.0 + OUTER_ANGLE
    reach = BASE_REACH + INNER * np.cos(inner) + OUTER * np.cos(outer)
    return float(reach), float(BASE_HEIGHT + INNER * np.sin(inner) + OUTER * np.sin(outer))


WIDEST_REACH = tip(0.0)[0]
NARROWEST_REACH = tip(LARGEST_CLOSING)[0]


def closing(reach: float) -> float:
    """Finger angle [rad] at which the tip's ball has come in to the reach [m]: it moves inwards all the way."""
    if not NARROWEST_REACH <= reach <= WIDEST_REACH:
        raise InputError(
            f"Barrett Hand: a fingertip reaches {1e3 * NARROWEST_REACH:.0f} to {1e3 * WIDEST_REACH:.0f} mm from its base axis, "
            f"asked for {1e3 * reach:.0f} mm"
        )
    low, high = 0.0, float(LARGEST_CLOSING)
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if tip(middle)[0] > reach else (low, middle)
    return 0.5 * (low + high)


def centring(radius: float, spread: float) -> tuple[float, float]:
    """(offset, reach) [m] of a round of that radius between the three tips that close alike and meet it at once.

    offset: of its centre from the palm's axis towards finger 3. The radius is the object's; the tips' own is added here. With spread 0
    fingers 1 and 2 stand side by side against finger 3.
    """
    R, s, c = radius + RADIUS, np.sin(spread), np.cos(spread)
    # |(a + s r, c r + y)| = R with y = r - R: all three balls touch the circle of radius R about (0, y), fingers 1 and 2 from -y.
    a2, a1, a0 = s**2 + (1.0 + c) ** 2, 2.0 * (SPREAD_AXIS * s - (1.0 + c) * R), SPREAD_AXIS**2
    inside = a1**2 - 4.0 * a2 * a0
    if inside < 0:
        raise InputError(
            f"Barrett Hand: fingers spread {np.degrees(spread):.0f} deg do not close on a round of radius {1e3 * radius:.0f} mm"
        )
    reach = (-a1 + np.sqrt(inside)) / (2.0 * a2)
    return float(reach - R), float(reach)
