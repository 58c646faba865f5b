"""Where the programs of the wheel are looked for."""
import pathlib
import sysconfig

import pytest

import lumsdk
from lumsdk import _programs


def put(folder, name="lumdump", mode=0o755):
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / name
    path.write_text("#!/bin/sh\n")
    path.chmod(mode)
    return path


@pytest.fixture
def places(tmp_path, monkeypatch):
    """No program anywhere, but for what a test puts there."""
    monkeypatch.setattr(_programs, "_script_folders", lambda: iter([tmp_path / "scripts"]))
    monkeypatch.delenv("LUM_BIN", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path / "path"))
    return tmp_path


def test_scripts_come_before_the_environment_and_that_before_the_path(places, monkeypatch):
    wanted = [put(places / name) for name in ("scripts", "named", "path")]
    monkeypatch.setenv("LUM_BIN", str(places / "named"))
    for path in wanted:
        assert _programs.find("lumdump") == str(path)
        path.unlink()


def test_scripts_of_this_python_are_looked_through_first():
    assert next(_programs._script_folders()) == pathlib.Path(sysconfig.get_path("scripts"))


def test_those_of_pip_target_are_found(tmp_path, monkeypatch):
    (tmp_path / "lumsdk").mkdir()
    monkeypatch.setattr(_programs, "__file__", str(tmp_path / "lumsdk/_programs.py"))
    assert tmp_path / "bin" in list(_programs._script_folders())


def test_what_cannot_be_run_is_none(places):
    put(places / "scripts", mode=0o644)
    wanted = put(places / "path")
    assert _programs.find("lumdump") == str(wanted)


@pytest.mark.parametrize("folder", [None, "named"])
def test_nowhere_tells_where_it_was_looked_for_and_what_to_do(places, monkeypatch, folder):
    if folder:
        monkeypatch.setenv("LUM_BIN", str(places / folder))
    with pytest.raises(lumsdk.Error) as error:
        _programs.find("lumdump")
    text = str(error.value)
    assert "lumdump" in text
    assert str(places / "scripts") in text
    assert f"LUM_BIN ({places / folder})" in text if folder else "LUM_BIN, which is not set" in text
    assert "PATH" in text
    assert "pip install" in text


@pytest.mark.parametrize("name", ["", "../lumdump", "bin/lumdump"])
def test_a_path_is_no_name(name):
    with pytest.raises(lumsdk.Error, match="lumctl, lumdump, lumsim"):
        _programs.find(name)


def test_a_build_of_the_sources_finds_its_own(monkeypatch):
    """The package of a build is python/lumsdk, beside bin."""
    folder = pathlib.Path(lumsdk.__file__).resolve().parents[2] / "bin"
    if not (folder / "lumdump").exists():
        pytest.skip("the package is not that of a build")
    monkeypatch.delenv("LUM_BIN", raising=False)
    monkeypatch.setenv("PATH", "")
    found = pathlib.Path(_programs.find("lumdump"))
    assert found == folder / "lumdump" or found.parent == pathlib.Path(sysconfig.get_path("scripts"))
