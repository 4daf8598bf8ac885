"""The hand that writes, whichever of a person's hands the tracker calls it.

Who draws a sign in the air does so with one hand, left or right, and a tracker that mistook the names of the hands, or mistakes them
meanwhile, has still followed it. Of all ways to go through the hands' tracks frame by frame, the one that travels furthest without
jumping is taken: a Viterbi path over the hands.
"""

import numpy as np

REACH = 0.8  # faces a frame of 1/25 s, the fastest that a hand writes
JUMP = 2.0  # faces of travel lost by each face beyond that,
FOUND = 3.0  # but no more than these: a hand that was lost may be found again elsewhere
SWITCH = 1.0  # faces of travel that must be gained to go over from one track to another
FLICKER = 7  # frames of the median that travel is measured behind: what flickers to and fro does not travel


def writing_hand(hands: np.ndarray) -> np.ndarray:
    """(T, 2) the way of the hand that writes, of the tracks (T, K, 2) of K hands in faces at 25 Hz; NaN where that hand is nowhere yet."""
    T, K, _ = hands.shape
    total, came = np.zeros(K), np.zeros((T, K), int)
    travel = _travel(hands)
    for t in range(1, T):
        step = np.linalg.norm(hands[t, None] - hands[t - 1, :, None], axis=2)  # (from, to)
        loss = np.clip(JUMP * (np.nan_to_num(step) - REACH), 0.0, FOUND) + SWITCH * ~np.eye(K, dtype=bool)
        reached = total[:, None] - loss
        came[t], total = reached.argmax(axis=0), reached.max(axis=0) + travel[t]
    hand = np.zeros(T, int)
    hand[-1:] = total.argmax()
    for t in range(T - 1, 0, -1):
        hand[t - 1] = came[t, hand[t]]
    return hands[np.arange(T), hand]


def _travel(hands):
    """(T, K) faces since the frame before, of the tracks' medians; jumps and what is nowhere do not travel."""
    T, half = len(hands), FLICKER // 2
    around = np.clip(np.arange(T)[:, None] + np.arange(-half, half + 1), 0, T - 1)
    steady = np.median(hands[around], axis=1)
    step = np.linalg.norm(np.diff(steady, axis=0, prepend=steady[:1]), axis=2)
    return np.where(step < REACH, step, 0.0)
