"""The pages of docs/python say what is so: their code runs, their tables name what there is, every public name is in the
reference and has a docstring."""
import ast
import html
import importlib.util
import inspect
import json
import os
import pathlib
import re
import subprocess
import sys
import typing

import lumsdk
import pages
import pytest
from conftest import BIN, PATIENCE_S, run

TOP = pathlib.Path(__file__).resolve().parents[2]
DOCS = TOP / "docs/python"
PAGES = sorted(DOCS.glob("*.md"))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """What the pages have at hand: a drive, the same in parts, one with losses, one that was cut, one with its truth, and two
    sensors in a room."""
    made = tmp_path_factory.mktemp("pages")
    run("lumsim", "-q", "-o", made / "street.pcap", "--frames", 20)
    run("lumdump", "-q", made / "street.pcap", "-o", made / "drive.pcap", "--rotate", "1s")
    (made / "street.pcap").rename(made / "drive.pcap")
    run("lumsim", "-q", "-o", made / "lossy.pcap", "--frames", 5, "--loss", 0.01)
    whole = (made / "lossy.pcap").read_bytes()
    (made / "cut.pcap").write_bytes(whole[:len(whole) * 2 // 3])
    run("lumsim", "-q", "-o", made / "town.pcap", "--frames", 20, "--scene", "town", "--path", "circle", "--velocity", 10,
        "--poses", made / "truth.txt")
    run("lumsim", "-q", "-o", made / "front.pcap", "--scene", "room", "--pose", "1.2,0,1.2,0,0,0")
    run("lumsim", "-q", "-o", made / "left.pcap", "--scene", "room", "--pose", "0,0.9,1.2,0,0,90", "--address", "10.42.0.38")
    return made


def runs_of_pages():
    """Each page, but of recipes each section, because a recipe is complete; that of torch only where torch is."""
    for page in [TOP / "README.md", *PAGES]:
        if page.name != "recipes.md":
            yield pytest.param([page], id=page.name)
            continue
        for block in pages.blocks(page):
            yield pytest.param([page, block.section], id=f"{page.name}: {block.section}",
                               marks=[pytest.mark.torch] if "torch" in block.needs else [])


@pytest.mark.parametrize("what", list(runs_of_pages()))
def test_code_of_a_page_runs(what, folder, tmp_path):
    for capture in folder.iterdir():
        os.link(capture, tmp_path / capture.name)
    command = [sys.executable, "-B", "-W", "error", str(pathlib.Path(pages.__file__)), *map(str, what)]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE_S, check=False)
    if done.returncode == 77:
        pytest.skip(done.stdout.strip().splitlines()[-1])
    assert done.returncode == 0, done.stderr


def code_of(page):
    """What a reader may run as it stands."""
    if page.suffix == ".ipynb":
        return ["".join(cell["source"]) for cell in json.loads(page.read_text())["cells"] if cell["cell_type"] == "code"]
    return [f"{block.given}\n{block.code}" for block in pages.blocks(page)]


@pytest.mark.parametrize("page", [TOP / "README.md", *sorted((TOP / "docs").rglob("*.md")), *DOCS.glob("*.ipynb")], ids=lambda page: page.name)
def test_code_of_a_page_sends_to_this_machine_alone(page):
    """A sensor that a reader has may be on, and somebody may stand in its beam."""
    for code in code_of(page):
        for node in ast.walk(ast.parse(code)):
            if isinstance(node, ast.Call) and ast.unparse(node.func).endswith("Sensor"):
                host = node.args[0] if node.args else None
                said = ast.unparse(node)
                assert host is not None, f"{said}: without a host, it is a real sensor's"
                assert not isinstance(host, ast.Constant) or host.value.startswith("127."), said
            assert not (isinstance(node, ast.Constant) and str(node.value).startswith("udp://")), node.value


def test_from_a_drive_to_a_map(tmp_path):
    """The commands of docs/odometry.md, of a second of that drive."""
    pytest.importorskip("kiss_icp")
    pytest.importorskip("matplotlib")
    text = (TOP / "docs/odometry.md").read_text()
    block = text[text.index("    lumsim -o drive.pcap --scene town"):].split("\n\n")[0]
    told = re.findall(r"^    (lum\w+) (.*?(?:truth|poses)\.txt.*?)(?: +#.*)?$", block, re.M)
    assert [name for name, _ in told] == ["lumsim", "lumodom", "lumdump"]
    said = []
    for name, arguments in told:
        command = [sys.executable, "-B", "-m", "lumsdk.odometry._cli"] if name == "lumodom" else [str(BIN / name)]
        command += re.sub(r"--frames \d+", "--frames 10", arguments).split()
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE_S, check=False)
        assert done.returncode == 0, done.stderr
        said.append(done.stdout + done.stderr)
    assert 9.5 < float(re.search(r"distance +([\d.]+) m", said[1])[1]) < 10.5
    assert int(re.search(r"voxels +(\d+)", said[2])[1]) > 10000


def test_pages_have_code():
    assert sum(1 for page in PAGES for _ in pages.blocks(page)) > 10


def rows(page, head):
    """The cells of the tables under a row of these heads."""
    is_within = False
    for line in page.read_text().splitlines():
        if line.startswith(f"| {head} |"):
            is_within = True
        elif not line.startswith("|"):
            is_within = False
        elif is_within and not line.startswith("|---"):
            yield [cell.strip() for cell in line.strip("|").split(" | ")]


def code(cell):
    """What stands between backticks."""
    return re.findall(r"`([^`]+)`", cell)


def test_every_option_is_one_of_open_and_of_lumdump(capture):
    help_text = run("lumdump", "--help").decode()
    shared = {code(name)[0]: code(tool)[0] for name, tool, *_ in rows(DOCS / "sources.md", "option | of `lumdump`")}
    own = {code(name)[0] for name, *_ in rows(DOCS / "sources.md", "option | takes")}
    for name, tool in shared.items():
        assert re.search(rf"^ +(?:-\w, |   )?{tool}\b", help_text, re.M), f"lumdump has no {tool}"
        assert tool.lstrip("-") in (name, name[:-1]), f"{name} is {tool} in lumdump"
    with pytest.raises(TypeError, match="there is no option") as refusal:
        lumsdk.open(capture, **{"": 0})
    listed = re.search(r"there are (.*)", str(refusal.value))[1].split(", ")
    assert sorted([*shared, *own]) == sorted(listed)


def test_values_of_options_are_taken(capture):
    """Each value between backticks, where it is one of Python."""
    for name, _, values, *_ in rows(DOCS / "sources.md", "option | of `lumdump`"):
        for value in code(values):
            if name in ("`set`", "`calibration`", "`profile`") or value[0] not in "\"(":
                continue
            if value != "(window, order)":
                lumsdk.open(capture, **{name.strip("`"): eval(value)}).close()


def test_columns_are_those_of_the_package():
    listed = {name: kind for names, kind, *_ in rows(DOCS / "concepts.md", "column | type") for name in code(names)}
    assert listed == {name: kind.name for name, kind in lumsdk.COLUMNS.items()}


def test_columns_that_a_frame_has_by_default_are_told(capture):
    rest = " ".join((DOCS / "concepts.md").read_text().split()).split("A frame has `x`", 1)[1]
    told = ["x", *code(rest.split(", or the columns", 1)[0])]
    assert tuple(told) == next(iter(lumsdk.open(capture))).columns


OUSTER = """
AbsolutePointConstraint AbsolutePoseConstraint ActiveTimeCorrection AdaptiveThreshold AsyncWriter AutoExposure AxisWithLabel
BagFrameSetSource BagPacketSource BeamUniformityCorrector BloomReductionOptimization CalibrationStatus Camera ChanField
ClassMap ClassMapSet ClassicDetectionConfig ClientError ClientOverflow ClientTimeout ClippedFrameSetSource Cloud CloudMode
CloudPaletteItem ColHeader ConstantVelocityDeskewMethod CoordinateFrame Cuboid DataFormat DeskewMethod DeskewMethodFactory
DetectionConfig DetectionEngine EmulatedZoneMon Encoder EventModifierKeys FieldClass FieldDecodeInfo FieldType ForwardSlicer
FrameBatcher FrameBorder FrameSet FrameSetSource FrameSetSourceMetadataSet FullScaleRange GroundSegConfig GroundSegEngine
HeaderType ICPRegistration Image ImageCloudMode ImageMode ImuPacket ImuVisualizationConfig IoType LIOLocalizationConfig
LIOSlamConfig Label LidarFrame LidarFrameStream LidarFrameViz LidarFrameVizAccumulatorsConfig LidarMode LidarPacket
LidarSensor Lines LocalToneMapper LocalizationConfig LocalizationEngine LossFunction MaskedFrameSetSource Mesh MouseButton
MouseButtonEvent MultiFrameSetSource MultipurposeIOMode NMEABaudRate Object ObjectOverlay OperatingMode OsfDropFrameError
OsfFrameSetSource OusterIoType Packet PacketFormat PacketInfo PacketSource PacketValidationFailure Packets
PcapDuplicatePortException PcapFrameSetSource PcapPacketSource PngLidarFrameEncoder PointToPointConstraint PointViz
PointVizNotRunningError Polarity Pose PoseOptimizer PoseToPoseConstraint Poser ProductInfo ProgressBar Reader
RecordingPacketSource ReducedFrameSetSource ReturnOrder SamplingMode SelectedFrameSetSource SensorConfig
SensorFrameSetSource SensorHttp SensorInfo SensorPacketSource Severity ShotLimitingStatus SimpleViz SlamConfig SlamEngine
SolverConfig SourceURLException Stl TargetDisplay ThermalShutdownStatus TimestampMode TrajectoryEvaluator UDPProfileIMU
UDPProfileLidar ValidatorEntry ValidatorIssues Version Vertex3f VizExtraMode VoxelDownsampleStrategy VoxelHashMap3d
VoxelHashMapXd WindowCtx Writer XYZLut XYZLutFloat ZPngLidarFrameEncoder Zone ZoneMode ZonePacket ZoneSet
ZoneSetOutputFilter ZoneState Zrb
""".split()  # the public classes of ouster-sdk 1.0.1


def test_each_class_of_ouster_sdk_is_in_one_row():
    assert sorted(name for cell, *_ in rows(DOCS / "coming-from.md", "of ouster-sdk") for name in code(cell)) == OUSTER


def test_what_is_here_in_place_of_another_sdk_is_here():
    page = DOCS / "coming-from.md"
    cells = [cells[1] for cells in rows(page, "task")] + [cell for cells in rows(page, "of ouster-sdk") for cell in cells[1:]]
    owners = {"lumsdk": lumsdk, "frame": lumsdk.Frame, "source": lumsdk.Source, "sensor": lumsdk.Sensor, "poses": lumsdk.Poses}
    named = [found.groups() for cell in cells for text in code(cell) for found in re.finditer(r"\b(\w+)\.(?!txt)(\w+)", text)
             if found[1] in owners]
    assert len(named) > 30
    assert not [f"{owner}.{name}" for owner, name in named if not hasattr(owners[owner], name)]


def test_exceptions_are_those_of_the_package():
    listed = {code(name)[0].split(".")[1]: code(also) for name, also, *_ in rows(DOCS / "errors.md", "exception | is also")}
    there = {name for name in lumsdk.__all__ if inspect.isclass(getattr(lumsdk, name)) and issubclass(getattr(lumsdk, name), lumsdk.Error)}
    assert set(listed) == there
    for name, also in listed.items():
        for other in also:
            assert other in {base.__name__ for base in getattr(lumsdk, name).__mro__}, f"{name} is no {other}"


PUBLIC = [name for name in lumsdk.__all__ if not name.startswith("__")]


@pytest.mark.parametrize("name", PUBLIC)
def test_a_public_name_is_in_the_reference(name):
    listed = re.findall(r"^::: lumsdk\.(\w+)$", (DOCS / "reference.md").read_text(), re.M)
    assert listed.count(name) == 1


@pytest.mark.parametrize("name", PUBLIC)
def test_a_public_name_has_a_docstring_and_so_have_its_members(name):
    value = getattr(lumsdk, name)
    if not callable(value) or typing.get_origin(value) is typing.Literal:
        return  # data, whose docstring the sources have
    assert value.__doc__, name
    if not inspect.isclass(value):
        return
    for member, thing in vars(value).items():
        if member.startswith("_") or not (callable(thing) or isinstance(thing, (property, classmethod, staticmethod))):
            continue
        assert inspect.getdoc(thing), f"{name}.{member}"


@pytest.mark.parametrize("name", PUBLIC)
def test_docstrings_indent_their_tables(name):
    """Four spaces keep its columns, in the reference too."""
    value = getattr(lumsdk, name)
    for thing in (value, *(vars(value).values() if inspect.isclass(value) else ())):
        text = inspect.getdoc(thing) if callable(thing) or isinstance(thing, property) else None
        assert not re.findall(r"^\w+ {2,}\S.*", text or "", re.M), thing


def test_what_is_written_without_a_name_is_in_the_reference():
    text = (DOCS / "reference.md").read_text()
    for name in ("Source.__getitem__", "Source.__len__", "Source.__iter__", "Frame.__getitem__", "Frame.__len__", "ray.read_captures",
                 *(f"torch.{name}" for name in ("Frames", "StreamedFrames", "collate", "collate_padded", "tensors"))):
        assert f"::: lumsdk.{name}\n" in text


def test_the_start_leads_to_every_page():
    text = (DOCS / "index.md").read_text()
    assert not [page.name for page in (*PAGES, *DOCS.glob("*.ipynb")) if page.name != "index.md" and f"]({page.name})" not in text]
    assert "](../fleet.md)" in text


def test_tables_of_docstrings_are_tables_on_the_site():
    """A block of text is cut off where its lines are too wide."""
    spec = importlib.util.spec_from_file_location("hooks", DOCS / "hooks.py")
    hooks = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(hooks)
    for function, name in ((lumsdk.open, "columns"), (lumsdk.convert, "format")):
        (table,) = re.findall(rf"(?<=\n\n)    {name} .*?(?=\n\n)", inspect.getdoc(function), re.S)
        shown = html.escape(inspect.cleandoc(table), quote=False)
        made = hooks.PLAIN.sub(hooks.as_table, f'<div class="highlight"><pre><span></span><code>{shown}\n</code></pre></div>')
        assert made.startswith("<table>") and made.count("<tr>") == len(re.findall(r"^    \S", table, re.M))
        assert f"<code>{name}</code>" in made
    code = "<pre><span></span><code>a  b\nc\n</code></pre>"
    assert hooks.PLAIN.sub(hooks.as_table, code) == code


def test_reference_has_no_name_that_is_gone():
    for name in re.findall(r"^::: lumsdk\.(\w+)$", (DOCS / "reference.md").read_text(), re.M):
        assert name in lumsdk.__all__


def test_every_page_is_in_the_navigation():
    listed = set(re.findall(r": python/([\w-]+\.(?:md|ipynb))$", (DOCS / "mkdocs.yml").read_text(), re.M))
    assert {path.name for path in (*PAGES, *DOCS.glob("*.ipynb"))} <= listed  # the site's build tells the opposite


def test_notebooks_are_kept_without_outputs():
    for path in DOCS.glob("*.ipynb"):
        notebook = json.loads(path.read_text())
        for cell in notebook["cells"]:
            assert not cell.get("outputs") and not cell.get("execution_count"), f"{path.name}: strip the outputs of {cell['source']}"
            assert set(cell["metadata"]) == set(), path.name


def test_tutorial_checks_what_it_tells():
    notebook = json.loads((DOCS / "tutorial.ipynb").read_text())
    cells = ["".join(cell["source"]) for cell in notebook["cells"] if cell["cell_type"] == "code"]
    assert sum("assert " in cell for cell in cells) >= 5
