"""A configuration is changed key by key; everything else stays, and the old file is kept."""

import os
import stat
from contextlib import nullcontext
from pathlib import Path

import pytest

from ross_payload.config import Config, load
from ross_payload.config.file_editing import edited, write_changes
from ross_payload.errors import ConfigError, OutputError

TEXT = """# mine
[array]  # two neighbours
spacing_m = 0.05  # as ordered
offset_deg = 90.0

[audio]
source = "device:x"   # odd spaces stay

[[links]]
url = "udpout:127.0.0.1:14550"
"""
CHANGES = {"array.spacing_m": 0.0642, "audio.invert": [False, True]}


def test_comments_order_and_other_keys_stay():
    text = edited(TEXT, CHANGES)
    assert text.replace("0.0642", "0.05").replace("invert = [false, true]\n", "") == TEXT
    assert 'source = "device:x"   # odd spaces stay\ninvert = [false, true]\n' in text


def test_a_table_that_is_missing_is_added():
    assert edited("seed = 1\n", {"array.spacing_m": 0.1}) == "seed = 1\n\n[array]\nspacing_m = 0.1\n"


@pytest.mark.parametrize("text", ["array = {spacing_m = 0.05}\n", "array.spacing_m = 0.05\n"])
def test_other_forms_of_a_table_are_edited_too(tmp_path, text):
    file = tmp_path / "ross.toml"
    file.write_text(text)
    write_changes(file, {"array.spacing_m": 0.1}, Config)
    assert load(file).array.spacing_m == 0.1


def test_a_byte_order_mark_hinders_nothing(tmp_path):
    file = tmp_path / "ross.toml"
    file.write_text("[array]\n", encoding="utf-8-sig")
    write_changes(file, {"array.spacing_m": 0.1}, Config)
    assert load(file).array.spacing_m == 0.1


def test_the_old_file_is_kept_and_mode_and_link_stay(tmp_path):
    file, link = tmp_path / "ross.toml", tmp_path / "link.toml"
    file.write_text(TEXT)
    file.chmod(0o640)
    link.symlink_to(file)
    kept = [write_changes(link, CHANGES, Config), write_changes(link, {"array.spacing_m": 0.07}, Config)]
    assert [path.name for path in kept] == ["ross.toml.before", "ross.toml.before-2"]
    assert kept[0].read_text() == TEXT
    assert link.is_symlink()
    assert stat.S_IMODE(file.stat().st_mode) == 0o640
    assert (load(file).array.spacing_m, load(file).audio.invert) == (0.07, (False, True))
    assert {path.name for path in tmp_path.iterdir()} == {
        "ross.toml",
        "link.toml",
        "ross.toml.before",
        "ross.toml.before-2",
    }


def test_what_would_be_refused_is_not_written(tmp_path):
    file = tmp_path / "ross.toml"
    file.write_text(TEXT)
    with pytest.raises(ConfigError, match=r"array.spacing_m: expected a number less than or equal to 1"):
        write_changes(file, {"array.spacing_m": 3.0}, Config)
    assert file.read_text() == TEXT
    assert [path.name for path in tmp_path.iterdir()] == ["ross.toml"]


def test_a_folder_that_cannot_be_written_changes_nothing(tmp_path, monkeypatch):
    file = tmp_path / "ross.toml"
    file.write_text(TEXT)

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.fsync", full)
    with pytest.raises(OutputError, match=r"cannot be written: No space left"):
        write_changes(file, CHANGES, Config)
    assert file.read_text() == TEXT
    assert [path.name for path in tmp_path.iterdir()] == ["ross.toml"]


class PowerCut(Exception):
    """Nothing more is done."""


class Disk:
    """What a folder holds after a power cut at one of the calls to the disk; ``prompt``: names get there at once.

    What was not synchronised is empty, and what is replaced keeps its name until the folder is synchronised.
    """

    def __init__(self, folder, monkeypatch, *, cut, prompt):
        self.folder, self.cut, self.prompt, self.calls = folder, cut, prompt, 0
        self.written = {path.stat().st_ino: path.read_text() for path in folder.iterdir()}
        self.names = self.present()
        fsync, replace = os.fsync, Path.replace
        monkeypatch.setattr("os.fsync", lambda handle: (self.call(), fsync(handle), self.synchronised(handle)))
        monkeypatch.setattr(Path, "replace", lambda part, path: (self.call(), replace(part, path), self.renamed()))

    def present(self):
        return {path.name: path.stat().st_ino for path in self.folder.iterdir()}

    def call(self):
        self.calls += 1
        if self.calls == self.cut:
            raise PowerCut

    def synchronised(self, handle):
        found = os.fstat(handle)
        if stat.S_ISDIR(found.st_mode):
            self.names = self.present()
        else:
            self.written[found.st_ino] = os.pread(handle, found.st_size, 0).decode()

    def renamed(self):
        self.names = self.present() if self.prompt else self.names

    def found(self):
        return {name: self.written.get(inode, "") for name, inode in self.names.items()}


@pytest.mark.parametrize("prompt", [True, False])
@pytest.mark.parametrize("cut", [*range(1, 7), 0])
def test_after_a_power_cut_the_old_file_is_there_under_one_name_or_the_other(tmp_path, monkeypatch, cut, prompt):
    file, kept, new = tmp_path / "ross.toml", "ross.toml.before", edited(TEXT, CHANGES)
    file.write_text(TEXT)
    disk = Disk(tmp_path, monkeypatch, cut=cut, prompt=prompt)
    with pytest.raises(PowerCut) if cut else nullcontext():
        write_changes(file, CHANGES, Config)
    found = disk.found()
    assert found["ross.toml"] in (TEXT, new)
    assert found.get(kept, TEXT) == TEXT
    assert found["ross.toml"] == TEXT or kept in found
    assert cut or (found["ross.toml"], disk.calls) == (new, 6)
