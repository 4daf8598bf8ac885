"""Compiled functions are kept for the sources that they were made of."""

import numpy as np

from vipr.systems import compiled as kept
from vipr.systems.tracking import small_algebra


def test_a_change_in_any_module_of_the_stage_is_another_folder(tmp_path):
    (tmp_path / "caller.py").write_text("caller")
    (tmp_path / "called.py").write_text("called")
    before = kept.folder_of.__wrapped__(tmp_path)
    assert kept.folder_of.__wrapped__(tmp_path) == before
    (tmp_path / "called.py").write_text("called, changed")
    assert kept.folder_of.__wrapped__(tmp_path) != before


def test_what_is_compiled_is_found_by_the_next_process():
    small_algebra.solve(np.eye(3), np.ones(3))
    folder = kept.folder_of(kept.Path(small_algebra.__file__).parent)
    assert list(folder.rglob("small_algebra.solve-*.nbi"))


def test_a_folder_that_cannot_be_written_leaves_numba_its_own_places(tmp_path, monkeypatch):
    (tmp_path / "__pycache__").write_text("a file where the folder should be")
    monkeypatch.setattr(kept, "folder_of", lambda stage: tmp_path / "__pycache__" / "compiled-0")
    assert kept.compiled(lambda x: 2.0 * x)(3.0) == 6.0
    assert kept.config.CACHE_DIR != str(tmp_path / "__pycache__" / "compiled-0")
