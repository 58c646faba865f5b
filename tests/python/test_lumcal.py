"""lumcal: its command line, its files, how it ends."""
import json
import math
import os
import pathlib
import pty
import re
import signal
import subprocess
import sys
import time

import lumsdk
import pytest
from conftest import PATIENCE_S
from lumsdk.calibrate import _arguments, _cli, _solution

pytestmark = pytest.mark.usefixtures("own_signals")

TOP = pathlib.Path(__file__).resolve().parents[2]
COMMAND = [sys.executable, "-B", "-m", "lumsdk.calibrate._cli"]


def lumcal(*arguments, **options):
    return subprocess.run([*COMMAND, *map(str, arguments)], capture_output=True, text=True, check=False, timeout=PATIENCE_S, **options)


# --- Arguments ---


@pytest.mark.parametrize("arguments, told", [
    ((), "no command is given; there are eyes and check; see lumcal --help"),
    (("eye",), "'eye' is not a command; there are eyes and check; see lumcal --help"),
    (("eyes",), "no capture is named; see lumcal eyes --help"),
    (("check",), "no capture is named; see lumcal check --help"),
    (("check", "a.pcap", "b.pcap"), "check looks at one capture, and 2 are named: run it for each"),
    (("check", "-"), "a capture is read more than once, which standard input cannot be: name a file"),
    (("eyes", "a.pcap", "-"), "a capture is read more than once, which standard input cannot be: name a file"),
    (("eyes", "a.pcap", "./a.pcap"), "./a.pcap: is named twice; each capture counts once"),
    (("eyes", "a.pcap", "--bad"), "unknown option --bad; see lumcal eyes --help"),
    (("eyes", "a.pcap", "--rep", "r.html"), "unknown option --rep; see lumcal eyes --help"),
    (("eyes", "a.pcap", "-o"), "-o/--output: expected one argument; see lumcal eyes --help"),
    (("eyes", "a.pcap", "-o", "a.txt"), "--output: a.txt: a name that ends in .yaml or .yml is needed"),
    (("eyes", "a.pcap", "--report", "a.pdf"), "--report: a.pdf: a name that ends in .html or .htm is needed"),
    (("eyes", "a.pcap", "-o", "s3://a/b.yaml"), "--output: s3://a/b.yaml: is a URL; a file of this machine is needed"),
    (("check", "a.pcap", "-o", "a.yaml"), "--output: a.yaml: a name that ends in .png is needed"),
    (("check", "a.pcap", "--report", "a.html"), "--report does not go with check, which draws a picture: -o FILE.png"),
    (("check", "a.pcap", "--calibration", "none.yaml"), "none.yaml: cannot be read: No such file or directory"),
    (("check", "a.pcap", "--profile", "none.yaml"), "none.yaml: cannot be read: No such file or directory"),
    (("eyes", "a.pcap", "--set", "tof_lsb=13"), "set: unknown key 'tof_lsb'; did you mean 'tof_lsb_ps'?"),
])
def test_wrong_arguments_are_told_with_what_would_be_right(arguments, told, capsys):
    assert _cli.main(list(arguments)) == 2
    assert capsys.readouterr() == ("", f"lumcal: {told}\n")


def test_what_is_read_is_not_written(tmp_path, capsys):
    settings = tmp_path / "mine.yaml"
    settings.write_text("version: 1\n")
    assert _cli.main(["eyes", "a.pcap", "--calibration", str(settings), "-o", str(settings)]) == 2
    assert capsys.readouterr().err == f"lumcal: {settings}: is read and cannot be written too: choose another name\n"
    assert settings.read_text() == "version: 1\n"


def test_help_and_version(capsys):
    for arguments, wanted in (["--help"], _arguments.HELP), (["eyes", "--help"], _arguments.HELP_EYES), (["check", "x", "--help"], _arguments.HELP_CHECK):
        assert _cli.main(arguments) == 0
        assert capsys.readouterr() == (wanted, "")
        assert max(map(len, wanted.splitlines())) <= 80
    for arguments in ["--version"], ["eyes", "--version"]:
        assert _cli.main(arguments) == 0
        assert re.fullmatch(r"lumcal \d+\.\d+\.\d+\n", capsys.readouterr().out)


def test_usual_wishes_are_half_of_what_the_bars_of_mild_walls_allow():
    calibrations = pytest.importorskip("calibrations")
    mrad, place, offset, _, width, end = (bar / 2 for bar in calibrations.MILD)
    usual = {"deg": math.degrees(mrad / 1e3), "m": place / 1e3, "ps": offset / 1e3 / calibrations.PS_M, "width_deg": 60 * width / 100,
             "min_deg": 20 * end / 100, "max_deg": 20 * end / 100}
    for key, wish in _solution.WISHES.items():
        assert wish == pytest.approx(usual.get(key, usual[key.rsplit("_", 1)[-1]]), rel=0.02), key


def options_of(text):
    return set(re.findall(r"(?<![\w-])--[a-z]+", text))


def test_help_manual_and_parser_have_the_same_options():
    manual = (TOP / "docs/man/lumcal.1").read_text().replace("\\-", "-")
    listed = set(re.findall(r"-[a-z]+", " ".join(re.findall(r"^\.It (Fl .*)$", manual, re.M))))
    for command, text in ("eyes", _arguments.HELP_EYES), ("check", _arguments.HELP_CHECK):
        known = {name for action in _arguments._parser(command)._actions for name in action.option_strings if name.startswith("--")}
        known -= {"--report"} if command == "check" else set()
        assert options_of(text) | {"--version"} == known, command
        assert {name[1:] for name in known} <= listed, command


def test_one_table_alone_says_how_good_a_calibration_is():
    """It is measured anew now and then: no other text may promise what it does not hold."""
    page = (TOP / "docs/calibrate-accuracy.md").read_text()
    manual = " ".join((TOP / "docs/man/lumcal.1").read_text().split())
    assert "should be within one of it, and 95 % within two" in manual and "docs/calibrate-accuracy.md" in manual
    prose = {"calibrate-accuracy.md": "\n".join(line for line in page.splitlines() if not line.startswith("|")), "manual": manual,
             "help": _arguments.HELP, "eyes": _arguments.HELP_EYES,
             **{name: (TOP / name).read_text() for name in ("README.md", "docs/start.md", "docs/calibrate.md")}}
    for name, text in prose.items():
        assert not re.search(r"\b\d+ of 20\b|suffice\b", text), name
    assert re.search(r"^\| errors within two standard deviations \|", page, re.M)


@pytest.fixture(scope="module")
def complete(completion):
    return completion("lumcal", *COMMAND)


def test_completion(complete, tmp_path, monkeypatch):
    assert complete("") == ["eyes", "check"]
    assert complete("ch") == ["check"]
    assert set(complete("--")) == {"--help", "--version"}
    assert set(complete("eyes", "--")) == options_of(_arguments.HELP_EYES)
    assert set(complete("check", "--")) == options_of(_arguments.HELP_CHECK)
    assert complete("check", "--set", "tof") == ["tof_lsb_ps="]
    (tmp_path / "room.pcap").touch()
    monkeypatch.chdir(tmp_path)
    assert complete("eyes", "ro") == complete("eyes", "a.pcap", "--report", "ro") == ["room.pcap"]


def test_set_is_divided_into_calibration_and_profile(tmp_path):
    """The first belongs to what is looked for, and must not change how captures are read."""
    (tmp_path / "mine.yaml").write_text("version: 1\neyes: {blue: {mount: {z_m: 0.5}}}\n")
    made = _arguments.parse(["eyes", "a.pcap", "--calibration", str(tmp_path / "mine.yaml"), "--set", "eyes.blue.mount.x_m=0.1", "--set",
                             "group.line.at=14", "--sensor", "10.42.0.37"])
    begin = made.begin()
    assert (begin["eyes.blue.mount.x_m"], begin["eyes.blue.mount.z_m"]) == (0.1, 0.5)
    assert made.of_grid() == {"set": ["group.line.at=14"], "sensor": "10.42.0.37"}
    assert set(made.of_open()) == {"calibration", "set", "sensor"}


# --- What is missing ---


@pytest.mark.parametrize("module, name, arguments", [
    ("scipy", "SciPy", ("eyes", "a.pcap")), ("scipy", "SciPy", ("check", "a.pcap")),
    ("matplotlib", "matplotlib", ("check", "a.pcap", "-o", "a.png")), ("matplotlib", "matplotlib", ("eyes", "a.pcap", "--report", "a.html"))])
def test_a_missing_package_is_named_with_the_command_that_brings_it(module, name, arguments, tmp_path, monkeypatch, capsys):
    if module == "matplotlib":
        pytest.importorskip("scipy")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(sys.modules, module, None)
    assert _cli.main(list(arguments)) == 1
    assert re.fullmatch(rf"lumcal: .* needs {name}, which is not installed \(.*\): in a clone of lumsdk, pip install '\.\[calibrate\]'\n", capsys.readouterr().err)
    assert list(tmp_path.iterdir()) == []


def test_importing_the_package_imports_none_of_it():
    code = "import sys, lumsdk; assert not {'scipy', 'matplotlib', 'lumsdk.calibrate'} & set(sys.modules)"
    assert subprocess.run([sys.executable, "-B", "-c", code], check=False, timeout=PATIENCE_S).returncode == 0


# --- Files and ends of eyes, with a solution that is given ---


@pytest.fixture
def given(monkeypatch, tmp_path):
    """given(solution): lumcal eyes finds that one."""
    pytest.importorskip("scipy")
    pytest.importorskip("matplotlib")
    from lumsdk.calibrate import _eyes

    monkeypatch.chdir(tmp_path)

    def give(solution):
        monkeypatch.setattr(_eyes, "run", lambda options: solution)
        monkeypatch.setattr(_eyes, "to_yaml", lambda solution: "version: 1\n")
        monkeypatch.setattr(_eyes, "to_json", lambda solution: {"is_better": solution.is_better})
    return give


def test_a_better_calibration_is_written_and_told(given, tmp_path, capsys):
    import solutions

    given(solutions.make())
    assert _cli.main(["eyes", "a.pcap", "-o", "out.yaml", "--report", "out.html"]) == 0
    assert sorted(p.name for p in tmp_path.iterdir()) == ["out.html", "out.yaml"]
    told = capsys.readouterr()
    assert told.err == ""
    for word in ("3, 3 faces", "20.0 mm before, 2.0 mm after", "30.5123    0.0120     30.0000", "green.elevation.max_deg: " + solutions.HELD, "note: two captures",
                 "green azimuth 0.050, green elevation 0.000 degrees", "begin        mine.yaml"):
        assert word in told.out


def test_it_is_told_how_many_more_captures_reach_what_is_wished_for(given, capsys):
    """Of three, with a standard deviation that is twice as large: nine more, if all err each on its own. What is of no use needs others."""
    import solutions
    from lumsdk.calibrate import _eyes, _report, _tell

    solution, to_json = solutions.make(), _eyes.to_json

    def of_json():
        return [p["more_captures"] for p in to_json(solution)["parameters"]]

    yaw, held = solution.parameters[1:]
    yaw.wish, held.wish = 0.006, 1.0
    told = ["green.mount.yaw_deg: a standard deviation of 0.006, and not 0.0120, takes about 9 more captures",
            "if they are as good as these and their errors are independent: other walls, other poses"]
    given(solution)
    assert _cli.main(["eyes", "a.pcap"]) == 0
    assert "".join(f"more: {line}\n" for line in told) in capsys.readouterr().out
    assert f"<li>{told[0]}</li>" in _report._more(solution) and of_json() == [0, 9, 0]
    yaw.wish = 0.012
    assert _tell.more(solution) == [] and _report._more(solution) == ""
    yaw.wish, solution.is_settled = 0.006, False
    assert _tell.more(solution) == [] and not any(of_json())


def test_a_worse_calibration_is_not_written_but_its_report_is(given, tmp_path, capsys):
    import solutions

    (tmp_path / "out.yaml").write_text("earlier\n")
    given(solutions.make(is_better=False))
    assert _cli.main(["eyes", "a.pcap", "-o", "out.yaml", "--report", "out.html", "-q"]) == 1
    assert (tmp_path / "out.yaml").read_text() == "earlier\n"
    assert sorted(p.name for p in tmp_path.iterdir()) == ["out.html", "out.yaml"]
    told = capsys.readouterr()
    assert told.out == "" and told.err == ("lumcal: out.yaml is not written: the result is worse than its start on faces left out of "
                                            "the fit: 21.00 mm before, 30.00 mm after, and up to 21.62 mm count as no worse\n")


def test_all_files_of_a_run_get_their_names_or_none(given, tmp_path, monkeypatch, capsys):
    import solutions
    from lumsdk.calibrate import _eyes

    given(solutions.make())

    def fail(solution):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(_eyes, "to_yaml", fail)
    assert _cli.main(["eyes", "a.pcap", "-o", "out.yaml", "--report", "out.html"]) == 1
    assert "No space left on device" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_a_full_disk_names_the_file_and_leaves_none(given, tmp_path, monkeypatch, capsys):
    import solutions

    given(solutions.make())
    full, sync = [], os.fsync

    def fail(fd):
        full.append(fd)
        if len(full) > 1:
            raise OSError(28, "No space left on device")
        sync(fd)

    monkeypatch.setattr(os, "fsync", fail)
    assert _cli.main(["eyes", "a.pcap", "-o", "out.yaml", "--report", "out.html"]) == 1
    assert capsys.readouterr().err == "lumcal: out.yaml: cannot write it: No space left on device\n"
    assert list(tmp_path.iterdir()) == []


def hold_yaw(solution):
    solution.parameters[1].held = "show a wall"


def leave_one(solution):
    del solution.captures[1:]


@pytest.mark.parametrize("spoil, why", [
    (hold_yaw, "the mount of the green eye is not determined: green.mount.yaw_deg: show a wall"),
    (leave_one, "one capture does not determine the mount of the green eye: add two of the same room, .*"),
    (lambda solution: setattr(solution, "exchanged", "set eye_values"), "set eye_values"),
    (lambda solution: setattr(solution, "is_settled", False), "the solution did not settle: .*; record the room again")])
def test_what_is_of_no_use_makes_no_file_and_says_what_to_do(given, tmp_path, capsys, monkeypatch, spoil, why):
    """Better on faces held out or not."""
    import solutions
    from lumsdk.calibrate import _report, _tell

    solution = solutions.make()
    spoil(solution)
    given(solution)
    assert _cli.main(["eyes", "a.pcap", "-o", "out.yaml", "-q"]) == 1
    assert re.fullmatch(f"lumcal: out.yaml is not written: {why}\n", capsys.readouterr().err)
    assert list(tmp_path.iterdir()) == []
    for name in "_curves", "_maps", "_planes":
        monkeypatch.setattr(_report, name, lambda found: "")
    assert f"No calibration is written: {_tell.not_written(solution)}" in _report.page(solution)


def test_json_is_one_object(given, capsys):
    import solutions

    given(solutions.make())
    assert _cli.main(["eyes", "a.pcap", "--json", "-q"]) == 0
    assert json.loads(capsys.readouterr().out) == {"is_better": True}


def test_what_cannot_be_written_is_told_before_the_work(given, tmp_path, monkeypatch, capsys):
    from lumsdk.calibrate import _eyes

    given(None)
    monkeypatch.setattr(_eyes, "run", lambda options: pytest.fail("began to work"))
    assert _cli.main(["eyes", "a.pcap", "-o", "none/out.yaml"]) == 1
    assert "none/out.yaml: cannot be written" in capsys.readouterr().err.replace("cannot create it", "cannot be written")


def test_what_a_run_refuses_leaves_nothing(given, tmp_path, monkeypatch, capsys):
    from lumsdk.calibrate import _eyes

    given(None)

    def refuse(options):
        raise lumsdk.Error("a.pcap: 3 whole frames")

    monkeypatch.setattr(_eyes, "run", refuse)
    assert _cli.main(["eyes", "a.pcap", "-o", "out.yaml", "--report", "out.html"]) == 1
    assert capsys.readouterr().err == "lumcal: a.pcap: 3 whole frames\n"
    assert list(tmp_path.iterdir()) == []


def test_the_report_is_one_page_with_all_of_it(given):
    import solutions
    from lumsdk.calibrate import _report

    page = _report.page(solutions.make())
    assert page.count("<img ") == 3 and page.count("data:image/png;base64,") == 3
    assert not re.search(r"(?:src|href)=\"(?!data:)|<script|<link|@import|url\(", page)
    for text in ("a&amp;b.pcap", "record one &lt;with&gt; the floor", "green.mount.yaw_deg", "30.5123", "+0.5123", "blue eye", "The calibration is better",
                 "two captures see the same wall", "5,002", "Before: mine.yaml", "b.pcap, green eye", "green azimuth", "-0.0500", "0.0120", "1.40 mm",
                 "0.0030 degrees", "+0.0 mm"):
        assert text in page
    assert "<td>3</td>" in page and "<td>4</td>" not in page  # the last face has no cells
    for tag in ("table", "tr", "ul", "ol", "h2", "body", "html"):
        assert len(re.findall(f"<{tag}[ >]", page)) == page.count(f"</{tag}>"), tag


def test_a_report_of_one_eye_is_made(given):
    import solutions
    from lumsdk.calibrate import _report

    solution = solutions.make()
    solution.residuals.eye[:] = 1
    solution.held_out_before_m = solution.held_out_after_m = float("nan")
    page = _report.page(solution)
    assert "No face could be left out" in page and "The calibration is better" in page


def test_a_report_says_why_nothing_is_written(given, monkeypatch):
    import solutions
    from lumsdk.calibrate import _report

    for name in "_curves", "_maps", "_planes":
        monkeypatch.setattr(_report, name, lambda found: "")
    assert "No calibration is written: the result is worse than its start on faces left out of the fit" in _report.page(solutions.make(is_better=False))


# --- Signals and the terminal ---

WAITS = """
import pathlib, signal, sys
import lumsdk.calibrate._check as _check
from lumsdk.calibrate import _cli
def check(options, progress):
    progress("looking", 0.5)
    pathlib.Path("begun").touch()
    signal.pause()
_check.check = check
sys.exit(_cli.main(["check", "a.pcap", "-o", "a.png"]))
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_it_cleanly(number, tmp_path):
    pytest.importorskip("scipy")
    pytest.importorskip("matplotlib")
    master, slave = pty.openpty()
    process = subprocess.Popen([sys.executable, "-B", "-c", WAITS], cwd=tmp_path, stderr=slave)
    os.close(slave)
    while not (tmp_path / "begun").exists():
        assert process.poll() is None
        time.sleep(0.01)
    process.send_signal(number)
    assert process.wait(PATIENCE_S) == -number
    shown = b""
    try:
        while chunk := os.read(master, 4096):
            shown += chunk
    except OSError:
        pass  # the end of a terminal
    os.close(master)
    assert re.fullmatch(rb"\rlooking: 50 %\r +\r", shown)
    assert [p.name for p in tmp_path.iterdir()] == ["begun"]


def test_nothing_is_shown_of_progress_elsewhere(capsys):
    progress = _cli.Progress(True)
    progress("looking", 0.5)
    progress.clear()
    assert capsys.readouterr() == ("", "")


def test_a_capture_that_cannot_be_read_is_told(tmp_path):
    pytest.importorskip("scipy")
    (tmp_path / "text.pcap").write_text("This is not what a sensor sends. " * 20)
    for name in "text.pcap", "none.pcap":
        for command in "eyes", "check":
            done = lumcal(command, name, cwd=tmp_path)
            assert (done.returncode, done.stdout) == (1, ""), done.stderr
            assert re.fullmatch(rf"lumcal: {name}: .*\n", done.stderr), done.stderr
