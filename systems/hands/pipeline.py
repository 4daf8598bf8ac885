"""The whole chain of Fig. 3 as one pure function: an image and what was believed before give what is believed now."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from vipr.systems.hands.tracks import TracksBelief, follow
from vipr.systems.signals import HandTracks
from vipr.systems.skin.chain import SkinBelief, see_skin
from vipr.systems.skin.classifier import SkinOptions


@dataclass(frozen=True, eq=False)
class PeopleBelief:
    """All that is remembered between frames; a value, to be replaced, never changed."""

    skin: SkinBelief = field(default_factory=SkinBelief)
    hands: TracksBelief = field(default_factory=TracksBelief)

    @property
    def tracks(self) -> HandTracks:
        """Face and hands in the last frame."""
        return self.hands.output


def see_people(
    image: np.ndarray,
    time: float,
    number: int,
    belief: PeopleBelief,
    options: SkinOptions = SkinOptions(),
    mark: Callable[[str], None] = lambda stage: None,
) -> PeopleBelief:
    """The belief after an image (h, w, 3) BGR uint8 exposed at ``time`` [s], later than the one before.

    ``mark`` is called with the name of each stage when it is done.
    """
    skin = see_skin(image, time, number, belief.skin, options, belief.tracks, mark)
    hands = follow(skin.regions, belief.hands)
    mark("tracking")
    return PeopleBelief(skin, hands)


def exchanged(tracks: HandTracks) -> HandTracks:
    """The tracks of a mirrored picture, in which the person's left hand is on the image's left: the hands' names exchanged."""
    other = {"left": "right", "right": "left"}
    swapped = {
        f"{a}{end}": getattr(tracks, f"{b}{end}") for a, b in other.items() for end in ("", "_velocity", "_seen")
    }
    merged = tuple(other.get(name, name) for name in tracks.merged)
    return replace(tracks, **swapped, merged=merged, areas=tracks.areas[[0, 2, 1]])
