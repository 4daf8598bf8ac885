"""Where the machine cannot render, the user reads what to install."""

import ctypes

import pytest

from vipr.systems.camera import offscreen
from vipr.systems.errors import InputError


def test_a_missing_egl_is_named_with_its_cure(monkeypatch):
    def no_library(name):
        raise OSError(name)

    monkeypatch.setattr(ctypes, "CDLL", no_library)
    with pytest.raises(InputError, match=r"libEGL\.so\.1 is missing; .*apt-get install .*libegl1"):
        offscreen.require_offscreen_rendering()


def test_a_missing_driver_is_named_with_its_cure(monkeypatch):
    monkeypatch.setattr(offscreen, "_DRIVERS", ("/nowhere/*.so",))
    with pytest.raises(InputError, match="libgl1-mesa-dri"):
        offscreen.require_offscreen_rendering()
