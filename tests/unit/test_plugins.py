from importlib.metadata import EntryPoint

import pytest

from ross_payload import plugins
from ross_payload.errors import PluginError


@pytest.fixture
def points(monkeypatch):
    def use(**values):
        found = [EntryPoint(name, value, "ross_payload.things") for name, value in values.items()]
        monkeypatch.setattr(plugins, "entry_points", lambda group: found)

    plugins._along.cache_clear()
    yield use
    plugins._along.cache_clear()


def test_only_the_one_asked_for_is_imported(points):
    points(good="math:tau", broken="no_such_module_anywhere:x")
    assert plugins.load("ross_payload.things", "good") == pytest.approx(6.283185307)


def test_an_unknown_name_lists_what_exists(points):
    points(good="math:tau", other="math:pi")
    with pytest.raises(PluginError, match=r"^far thing 'bad' is unknown; there are: good, other"):
        plugins.load("ross_sim.far_things", "bad")


def test_a_missing_extra_is_named(points, monkeypatch):
    monkeypatch.setitem(plugins.EXTRA_OF, "no_such_module_anywhere", "sim")
    points(voices="no_such_module_anywhere:x")
    with pytest.raises(PluginError, match=r"pip install '.*pyroomacoustics>="):
        plugins.load("ross_payload.things", "voices")


def test_a_broken_plugin_says_how(points):
    points(broken="math:no_such_name")
    with pytest.raises(PluginError, match="is broken: AttributeError"):
        plugins.load("ross_payload.things", "broken")


def test_two_plugins_of_one_name_are_refused_and_named(monkeypatch, points):
    points()
    found = [EntryPoint("good", value, "ross_payload.things") for value in ("math:tau", "math:pi", "math:tau")]
    monkeypatch.setattr(plugins, "entry_points", lambda group: found)
    with pytest.raises(PluginError, match=r"^thing 'good': expected one of that name, got math:pi of .* and math:tau"):
        plugins.load("ross_payload.things", "good")


def test_one_plugin_that_two_packages_bring_is_one(monkeypatch, points):
    points()
    monkeypatch.setattr(plugins, "entry_points", lambda group: [EntryPoint("good", "math:tau", group)] * 2)
    assert plugins.load("ross_payload.things", "good") == pytest.approx(6.283185307)


def test_an_environment_without_pip_is_written_by_that_of_the_system(monkeypatch):
    monkeypatch.setattr(plugins, "find_spec", lambda name: None)
    monkeypatch.setattr(plugins.shutil, "which", lambda name: None)
    monkeypatch.setattr(plugins.sys, "executable", "/opt/ross/bin/python")
    assert plugins.install_line("serial").startswith("python3 -m pip --python /opt/ross/bin/python install '")


def test_a_plugin_that_exits_while_it_is_imported_is_broken_and_hurts_no_other(points, monkeypatch, tmp_path):
    (tmp_path / "leaving_module.py").write_text("import sys\nsys.exit('no licence')\n")
    monkeypatch.syspath_prepend(tmp_path)
    points(leaving="leaving_module:x", good="math:tau")
    with pytest.raises(PluginError, match=r"plug-in 'leaving' .* is broken: SystemExit\('no licence'\)"):
        plugins.load("ross_payload.things", "leaving")
    assert plugins.load("ross_payload.things", "good") == pytest.approx(6.283185307)
