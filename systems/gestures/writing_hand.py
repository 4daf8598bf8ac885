"""The hand that writes, whichever part of a person the tracker takes it for.

Who draws a sign in the air does so with one hand, and a tracker that mistook the names of the hands, or took the hand for the face, has
still followed it. Of all ways to go through the tracks frame by frame, the one that travels furthest without jumping is taken, be it
nowhere at the beginning or the end: a Viterbi path over the tracks.
"""

import numpy as np

REACH = 0.8  # faces a frame of 1/25 s, the fastest that a hand writes
JUMP = 2.0  # faces of travel lost by each face beyond that,
FOUND = 3.0  # but no more than these: a hand that was lost may be found again elsewhere
SWITCH = 1.0  # faces of travel that must be gained to go over from one track to another
FLICKER = 7  # frames of the median that travel is measured behind: what flickers to and fro does not travel


def writing_hand(tracks: np.ndarray) -> np.ndarray:
    """(T, 2) the way of the hand that writes, of the tracks (T, K, 2) of K parts in faces at 25 Hz, NaN where a part is not seen.

    NaN where that hand is not seen, and before and after what does not hang together with its way.
    """
    T, K, _ = tracks.shape
    way = np.concatenate([tracks, np.full((T, 1, 2), np.nan)], axis=1)  # the last is nowhere
    held, nowhere = _held(tracks), np.arange(K + 1) == K
    travel = np.column_stack([_travel(held), np.zeros(T)])
    change = np.where(nowhere | nowhere[:, None], 0.5 * FOUND, SWITCH) * ~np.eye(K + 1, dtype=bool)  # (from, to)
    total, came = np.zeros(K + 1), np.zeros((T, K + 1), int)
    for t in range(1, T):
        loss = change.copy()
        step = np.linalg.norm(held[t, None] - held[t - 1, :, None], axis=2)
        loss[:K, :K] += np.clip(JUMP * (np.nan_to_num(step) - REACH), 0.0, FOUND)
        reached = total[:, None] - loss
        came[t], total = reached.argmax(axis=0), reached.max(axis=0) + travel[t]
    hand = np.zeros(T, int)
    hand[-1:] = total.argmax()
    for t in range(T - 1, 0, -1):
        hand[t - 1] = came[t, hand[t]]
    return way[np.arange(T), hand]


def _held(tracks):
    """Where each part was last seen."""
    seen = np.isfinite(tracks).all(axis=2)
    last = np.maximum.accumulate(np.where(seen, np.arange(len(tracks))[:, None], 0), axis=0)
    return np.take_along_axis(tracks, last[..., None], axis=0)


def _travel(tracks):
    """(T, K) faces since the frame before, of the tracks' medians; jumps and what is nowhere do not travel."""
    T, half = len(tracks), FLICKER // 2
    around = np.clip(np.arange(T)[:, None] + np.arange(-half, half + 1), 0, T - 1)
    steady = np.median(tracks[around], axis=1)
    step = np.linalg.norm(np.diff(steady, axis=0, prepend=steady[:1]), axis=2)
    return np.where(step < REACH, step, 0.0)
