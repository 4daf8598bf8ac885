"""What a run can record: one channel an input port of the recorder, a topic of the log and a source of the report's plots."""

from dataclasses import dataclass
from typing import NamedTuple

from vipr.systems.errors import InputError


@dataclass(frozen=True)
class Channel:
    """Base of the channels."""

    name: str  # of the port; the topic is "/<name>"


@dataclass(frozen=True)
class ImageChannel(Channel):
    """Camera frames (`CameraFrame`): JPEG in the log, stills in the report, and the video if it is the one chosen for it."""

    frame: str = "camera"  # frame in which the image was taken
    every: int = 2  # the log holds each so many-th frame, the video all of them
    quality: int = 80  # of the JPEG, 0 to 100
    video: bool = False  # whether this is the picture of video.mp4 and of the stills


@dataclass(frozen=True)
class PoseChannel(Channel):
    """Pose of a frame in its parent's: a `RigidTransform`, or an `ObjectPose` where tracked.

    While a tracked pose is lost there is no pose; each change of its state is an event.
    """

    parent: str = "world"
    child: str = ""  # name of the frame in the log; the channel's own name if empty
    tracked: bool = False

    @property
    def frame(self) -> str:
        return self.child or self.name


@dataclass(frozen=True)
class VectorChannel(Channel):
    """Numbers with names and units."""

    names: tuple[str, ...] = ()
    units: tuple[str, ...] = ()  # one a name, "" for none

    @property
    def size(self) -> int:
        return len(self.names)


@dataclass(frozen=True)
class JointChannel(Channel):
    """Joint positions q [rad or m] in the order of the names, followed by the velocities if there are any: (n,) or (2n,)."""

    joints: tuple[str, ...] = ()
    velocities: bool = False

    @property
    def size(self) -> int:
        return len(self.joints) * (2 if self.velocities else 1)


@dataclass(frozen=True)
class StatusChannel(Channel):
    """What a stage says of itself (`Status`); each change is an event."""


class Event(NamedTuple):
    """Something that happened in a run."""

    time: float  # s, simulated
    source: str  # name of the channel or part that it happened in
    text: str
    level: str = "info"  # info | warning | error


def check_channels(channels) -> tuple[Channel, ...]:
    """The channels as a tuple, if their names differ, at most one is the video and each number has a unit."""
    channels = tuple(channels)
    names = [channel.name for channel in channels]
    for channel in channels:
        if not channel.name or names.count(channel.name) > 1:
            raise InputError(f"recording: each channel needs a name of its own, got {channel.name!r} twice or empty")
        if isinstance(channel, VectorChannel) and len(channel.names) != len(channel.units):
            raise InputError(
                f"recording: channel {channel.name}: as many units as names are needed, got {len(channel.units)} "
                f"for {len(channel.names)}"
            )
        if isinstance(channel, ImageChannel) and channel.every < 1:
            raise InputError(f"recording: channel {channel.name}: every must be at least 1 frame, got {channel.every}")
    filmed = [channel.name for channel in channels if isinstance(channel, ImageChannel) and channel.video]
    if len(filmed) > 1:
        raise InputError(f"recording: one channel can be the video, got {', '.join(filmed)}")
    return channels
