"""Raw frames, and packets written again from them."""
import dataclasses
import pickle
import struct
import warnings

import numpy as np
import pytest

import lumsdk
from lumsdk._lines import LINE_DTYPE

PROFILES = {
    "big-endian": {"sample_order": "big", "angle_order": "elevation_azimuth", "eye_values": {"blue": 7, "green": 9}},
    "no-clock": {"group": {"timestamp": "none"}},
    "ticks": {"group": {"timestamp": {"at": 20, "bytes": 8, "order": "big", "unit_ns": 100}, "samples": 32}},
    "bits": {"group": {"tag": {"at": 12, "bytes": 2, "bits": [0, 2]}, "eye": {"at": 12, "bytes": 2, "bits": [3, 5]},
                       "num_samples": "none"}},
    "wide": {"group": {"tag": 14, "eye": 15, "line": {"at": 16, "bytes": 4}, "num_samples": {"at": 20, "bytes": 4, "order": "big"},
                       "first_sample_index": {"at": 24, "bytes": 4}, "timestamp": 28, "samples": 48}},
}
FAULTS = {"lost": ("--loss", "0.02"), "twice": ("--duplicate", "0.05"), "in another order": ("--reorder", "0.05"),
          "all": ("--loss", "0.02", "--duplicate", "0.03", "--reorder", "0.03", "--corrupt", "0.002", "--seed", 3)}


NEAR = {"eyes.blue.tof_offset_ps": -100_000}


def packets_of(path):
    """Time, addresses and payload of each datagram of the sensors."""
    content, at, found = path.read_bytes(), 24, []
    while at < len(content):
        seconds, ns, length, _ = struct.unpack_from("<IIII", content, at)
        frame = content[at + 16:at + 16 + length]
        if frame[34:36] == struct.pack(">H", 5517):
            found.append((seconds * 10 ** 9 + ns, frame[26:30], frame[42:]))
        at += 16 + length
    return found


def undone(frame):
    """All words to arrays and back: nothing of the frame's memory is left."""
    for line in frame.to_lines():
        pixel, tof, rising = np.column_stack([line.pixel, line.tof, line.rising]).T
        packets = np.array(line.packets.tolist(), line.packets.dtype)
        yield lumsdk.Line(line.number, line.eye, line.clock_us, line.angles.astype("f8"), pixel, tof, rising, line.arrival_ns,
                          line.has_angles.copy(), packets, line.sensor,
                          place=None if line.place is None else np.array(line.place.tolist()))


def of_arrays(frame):
    """The frame to arrays of a program and back."""
    columns = {name: np.array(frame[name].tolist(), frame[name].dtype) for name in frame.columns}
    made = lumsdk.Frame.from_arrays(columns, lines=frame.lines.copy(), number=frame.number, sensor=frame.sensor, utc_ns=frame.utc_ns)
    yield made.with_raw(frame.angles.astype("i8"), frame.has_angles.copy(), frame.packets.copy(), frame.profile)


def mixed(path, out):
    """The words of each packet, which are in the order of pixels, in the opposite order; those of a pixel stay in theirs."""
    content, at = bytearray(path.read_bytes()), 24
    while at < len(content):
        length, = struct.unpack_from("<8xI", content, at)
        payload = memoryview(content)[at + 16 + 42:at + 16 + length]
        if content[at + 16 + 34:at + 16 + 36] == struct.pack(">H", 5517) and payload[12] == 3:
            words = np.frombuffer(payload[28:], "<u4")
            words[:] = words[np.argsort(-(words & 1023).astype("i4"), kind="stable")]
        at += 16 + length
    out.write_bytes(content)
    return out


def points_of(path, fields=LINE_DTYPE.names, **options):
    """What is compared: all columns, lines and times."""
    with lumsdk.open(path, columns="all", edge="both", **options) as source:
        return [(frame.number, frame.sensor, frame.utc_ns, frame.lines[list(fields)].tolist(), [frame[name].tobytes() for name in frame.columns])
                for frame in source]


def rewrite(path, out, edit=lambda frame: [frame], options=(), **written):
    with lumsdk.open(path, raw=True, **dict(options)) as source:
        return lumsdk.write_capture(out, (item for frame in source for item in edit(frame)), **written)


# --- Frames ---


@pytest.fixture(scope="module")
def capture(make_capture):
    """Small."""
    return make_capture("-n", 4)


@pytest.fixture
def raw_frame(capture):
    # An offset by which some words have no range.
    with lumsdk.open(capture, raw=True, columns="all", set=NEAR) as source:
        return source[1]


def test_every_word_is_a_row(capture, raw_frame):
    with lumsdk.open(capture, columns="all", edge="both", set=NEAR) as source:
        frame = source[1]
    gives = ~np.isnan(raw_frame["x"])
    assert len(raw_frame) > len(frame) > 0
    assert raw_frame.columns == (*frame.columns, "tof", "raw_azimuth", "raw_elevation")
    for name in frame.columns:
        assert raw_frame[name][gives].tobytes() == frame[name].tobytes(), name
    assert np.isnan(raw_frame["range"][~gives]).all()
    assert (raw_frame["tof"][~gives] <= 100_000 / 13).all()
    assert raw_frame.lines["point_count"].sum() == len(raw_frame)


def test_raw_angles_are_those_of_the_rows(raw_frame):
    which = np.repeat(np.arange(len(raw_frame.lines)), raw_frame.lines["point_count"])
    assert raw_frame.angles.shape == (len(raw_frame.lines), 1000, 2)
    assert raw_frame.angles.dtype == np.int16
    assert raw_frame.has_angles.all()
    both = np.stack([raw_frame["raw_azimuth"], raw_frame["raw_elevation"]], axis=-1)
    assert np.array_equal(both, raw_frame.angles[which, raw_frame["pixel"]])
    kept = raw_frame.packets
    assert (kept["num_samples"][kept["tag"] == 2].reshape(-1, 3) == [334, 334, 332]).all()
    assert kept["num_samples"][kept["tag"] == 3].sum() == len(raw_frame)


def test_a_raw_frame_is_pickled_with_all_it_has(raw_frame):
    again = pickle.loads(pickle.dumps(raw_frame))
    assert again == raw_frame
    assert np.array_equal(again.angles, raw_frame.angles)
    assert np.array_equal(again.packets, raw_frame.packets)
    assert again.profile == lumsdk.Profile()


@pytest.mark.parametrize(("option", "value"), [("edge", "rising"), ("returns", "first"), ("range", (1, 2)), ("box", ":1,:1,:1")])
def test_what_hides_words_does_not_go_with_raw(capture, option, value):
    with pytest.raises(lumsdk.OptionError, match=f"{option} does not go with raw=True, where every word is a row"):
        lumsdk.open(capture, raw=True, **{option: value})


def test_a_frame_that_is_not_raw_says_so(capture, tmp_path):
    with lumsdk.open(capture, columns="all") as source:
        frame = next(iter(source))
    with pytest.raises(lumsdk.OptionError, match="has no raw part: open the capture with raw=True"):
        print(frame.angles)
    with pytest.raises(lumsdk.OptionError, match=r"frame 1: it has no column 'tof'; use a frame of open\(raw=True\)"):
        lumsdk.write_capture(tmp_path / "out.pcap", [frame])
    assert not list(tmp_path.iterdir())


# --- Packets again ---


@pytest.mark.parametrize("profile", [None, *PROFILES])
def test_undamaged_packets_come_again_byte_for_byte(make_capture, tmp_path, profile):
    options, arguments = {}, ()
    if profile is not None:
        made = tmp_path / "profile.yaml"
        made.write_text(lumsdk.Profile(PROFILES[profile]).to_yaml())
        options, arguments = {"profile": made}, ("--profile", made)
    path = make_capture("-n", 2, *arguments, name=f"{profile}.pcap")
    for edit in (undone, of_arrays) if profile in (None, "ticks") else (of_arrays,):
        out = tmp_path / "out.pcap"
        written = rewrite(path, out, edit, options, **options)
        assert (written.cut_anew, written.repeated, written.dropped) == (0, 0, {})
        assert packets_of(out) == packets_of(path)


def test_words_that_are_not_ordered_by_pixel_come_again_in_their_order(make_capture, tmp_path):
    path, out = mixed(make_capture("-n", 2), tmp_path / "mixed.pcap"), tmp_path / "out.pcap"
    for edit in undone, of_arrays:
        assert rewrite(path, out, edit).cut_anew == 0
        assert packets_of(out) == packets_of(path)

    def without_places(frame):
        assert "raw_place" in frame.columns
        columns = {name: frame[name] for name in frame.columns if name != "raw_place"}
        made = lumsdk.Frame.from_arrays(columns, lines=frame.lines, number=frame.number, utc_ns=frame.utc_ns)
        yield made.with_raw(frame.angles, frame.has_angles, frame.packets, frame.profile)

    def back(frame):
        yield frame.replace(raw_place=frame["raw_place"][::-1])

    def masked(frame):  # the words of some lines
        yield frame[frame["line"] % 3 > 0]

    for edit in without_places, back:
        assert rewrite(path, out, edit).cut_anew == 0
        assert packets_of(out) != packets_of(path)
        assert points_of(out) == points_of(path)
    written = rewrite(path, out, masked)
    assert 0 < written.cut_anew < written.lines
    assert set(packets_of(out)) & set(packets_of(path))


@pytest.mark.parametrize(("faults", "profile"), [("lost", None), ("twice", "no-clock"), ("in another order", "bits"),
                                                 ("in another order", "no-clock"), ("all", None), ("all", "bits")])
def test_points_and_times_of_damaged_captures_come_again(make_capture, tmp_path, faults, profile):
    options, arguments = {}, ()
    if profile is not None:
        made = tmp_path / "profile.yaml"
        made.write_text(lumsdk.Profile(PROFILES[profile]).to_yaml())
        options, arguments = {"profile": made}, ("--profile", made)
    path = make_capture("-n", 2, *arguments, *FAULTS[faults], name=f"{profile}.pcap")
    out = tmp_path / "out.pcap"
    written = rewrite(path, out, undone, options, **options)
    assert written.dropped == {}
    assert written.cut_anew == 0
    assert points_of(out, **options) == points_of(path, **options)


def test_a_part_of_a_drive_is_cut_out(capture, tmp_path):
    out = tmp_path / "part.pcap"
    with lumsdk.open(capture, raw=True) as source:
        lumsdk.write_capture(out, source[1:4])
    whole, part = points_of(capture), points_of(out)
    assert len(part) == 3
    # The last lines of a stream come eye by eye, and so in another order than in its middle.
    assert [columns for *_, columns in part[:2]] == [columns for *_, columns in whole[1:3]]
    assert len(part[2][-1][0]) == len(whole[3][-1][0])


def test_after_a_seek_lines_whose_packets_are_not_known_are_cut_anew(capture, tmp_path):
    with lumsdk.open(capture, raw=True) as source:
        source.index()
        sought = source[3]
    with lumsdk.open(capture, raw=True) as source:
        read = list(source)[3]
    lumsdk.write_capture(tmp_path / "sought.pcap", [sought])
    lumsdk.write_capture(tmp_path / "read.pcap", [read])
    assert points_of(tmp_path / "sought.pcap") == points_of(tmp_path / "read.pcap")


def test_an_edit_is_what_readers_see(capture, tmp_path):
    def edit(frame):
        for line in frame.to_lines():
            near = line.tof < 3000
            yield lumsdk.Line(line.number, line.eye, line.clock_us, line.angles, line.pixel[near], line.tof[near] + 100,
                              line.rising[near], line.arrival_ns, sensor=line.sensor)

    out = tmp_path / "out.pcap"
    written = rewrite(capture, out, edit)
    assert written.cut_anew == written.lines > 0
    with lumsdk.open(capture, raw=True) as before, lumsdk.open(out, raw=True) as after:
        for old, new in zip(before, after):
            assert np.array_equal(new["tof"], old["tof"][old["tof"] < 3000] + 100)
            assert np.array_equal(new.lines["clock_us"], old.lines["clock_us"])


def test_another_profile_has_the_same_points_and_times(capture, tmp_path):
    for name in "big-endian", "ticks", "wide":
        profile = lumsdk.Profile(PROFILES[name])
        out = tmp_path / f"{name}.pcap"
        written = rewrite(capture, out, profile=profile)
        assert written.dropped == {}
        assert points_of(out, profile=profile) == points_of(capture)


def test_frames_of_several_sensors_come_into_one_file(make_capture, tmp_path):
    paths = [make_capture("-n", 4, "--address", f"10.42.0.{i}", name=f"{i}.pcap") for i in (37, 38)]
    out = tmp_path / "out.pcap"
    with lumsdk.open(paths[0], raw=True) as one, lumsdk.open(paths[1], raw=True) as other:
        lumsdk.write_capture(out, (frame for both in zip(one, other) for frame in both))
    for i, path in zip((37, 38), paths):
        assert points_of(out, sensor=f"10.42.0.{i}") == points_of(path)


def test_frames_of_a_rig_have_the_addresses_of_their_sensors(make_capture, tmp_path):
    path, out = make_capture("-n", 2, name="one.pcap"), tmp_path / "out.pcap"
    rig = [{"name": "front", "address": "10.42.0.37", "pose": {"x_m": 1}}]
    lumsdk.write_capture(out, lumsdk.open(path, raw=True, rig=rig))
    assert packets_of(out) == packets_of(path) and points_of(out) == points_of(path)
    [made] = list(lumsdk.sync(lumsdk.open(path, raw=True, rig=rig)))[:1]
    with pytest.raises(lumsdk.OptionError, match=r"the points of several sensors, front; write .*one by one: frames.values\(\)"):
        lumsdk.write_capture(out, made.joined())


def test_a_pcapng_file_says_where_it_comes_from(make_capture, tmp_path):
    profile = tmp_path / "profile.yaml"
    profile.write_text(lumsdk.Profile(PROFILES["wide"]).to_yaml())
    path, out = make_capture("-n", 3, "--profile", profile, name="source.pcap"), tmp_path / "out.pcapng"
    rewrite(path, out, options={"profile": profile, "set": {"eyes.blue.mount.x_m": 0.5}})
    with lumsdk.open(out) as source:
        assert source.profile == lumsdk.Profile(PROFILES["wide"])
        assert source.calibration["eyes.blue.mount.x_m"] == 0.5
        assert 'source: "source.pcap"' in source.provenance[0]
    assert points_of(out) == points_of(path, profile=profile, set={"eyes.blue.mount.x_m": 0.5})


def made_line(number, eye="blue", clock_us=0, **other):
    """Ten metres straight ahead, in every pixel."""
    values = {"number": number, "eye": eye, "clock_us": clock_us, "angles": np.zeros((1000, 2), "i2"), "pixel": np.arange(1000),
              "tof": np.full(1000, 5128), "rising": np.ones(1000, bool), "arrival_ns": 1_700_000_000 * 10 ** 9 + clock_us * 1000}
    return lumsdk.Line(**{**values, **other})


def test_a_capture_is_made_up_from_nothing(tmp_path):
    lines = [made_line(number, eye, 1_000_000 + 1500 * number + 200_000 * frame) for frame in range(3) for number in range(40)
             for eye in ("blue", "green")]
    out = tmp_path / "out.pcap"
    assert lumsdk.write_capture(out, lines).lines == 240
    with lumsdk.open(out) as source:
        frames = list(source)
    assert [len(frame) for frame in frames] == [80_000] * 3
    assert np.allclose(np.concatenate([frame["range"] for frame in frames]), 5128 * 0.00195, atol=1e-3)


@pytest.mark.parametrize(("line", "said"), [
    ({"tof": np.full(1000, 600_000)}, "tof is 600000; use a whole number from -524288 to 524287"),
    ({"tof": np.full(1000, 0.5)}, "tof has the type float64, or values that are not whole"),
    ({"pixel": np.arange(1, 1001)}, "pixel is 1000; use a whole number from 0 to 999"),
    ({"pixel": np.arange(999, -1, -1)}, "pixel 998 follows pixel 999"),
    ({"pixel": np.arange(5)}, r"pixel has the shape \(5,\); use \(1000,\)"),
    ({"angles": np.zeros((1000, 2), "i4") + 40_000}, "angles is 40000; use a whole number from -32768 to 32767"),
    ({"angles": np.zeros((10, 2), "i2")}, r"angles has the shape \(10, 2\); use \(1000, 2\)"),
    ({"number": 70_000}, "its line number is 70000; the profile's field of 16 bits holds at most 65535"),
    ({"eye": "red"}, "eye is 'red'; use \"blue\" or \"green\""),
    ({"arrival_ns": -1}, "arrival_ns is -1; use a whole number from 0"),
    ({"place": np.arange(1000) - 1}, "place is -1; use a whole number from 0 to 65535"),
    ({"place": [0]}, r"place has the shape \(1,\); use \(1000,\)"),
    ({"sensor": "here"}, "sensor is 'here'; use an address"),
    ({"packets": 5}, "line 3 of the blue eye: packets has the fields of no structured array; use clock_raw, arrival_ns"),
    ({"packets": np.zeros(1, [("line", "u4")])}, "packets has the fields line; use clock_raw, arrival_ns"),
])
def test_what_a_packet_cannot_hold_is_refused(tmp_path, line, said):
    with pytest.raises(lumsdk.OptionError, match=said):
        lumsdk.write_capture(tmp_path / "out.pcap", [made_line(3, **line)] if "number" not in line else [made_line(**line)])
    assert not list(tmp_path.iterdir())


def test_frames_of_two_profiles_are_refused(capture, make_capture, tmp_path):
    profile = lumsdk.Profile(PROFILES["big-endian"])
    (tmp_path / "profile.yaml").write_text(profile.to_yaml())
    other, out = make_capture("-n", 3, "--profile", tmp_path / "profile.yaml", name="other.pcap"), tmp_path / "out.pcap"
    with lumsdk.open(capture, raw=True) as one, lumsdk.open(other, raw=True, profile=profile) as two:
        with pytest.raises(lumsdk.OptionError, match="frames of two profiles, the second of .*other.pcap; profile= names the one"):
            lumsdk.write_capture(out, [one[0], two[0]])
        assert not out.exists()
        with pytest.warns(lumsdk.CaptureWarning, match="a reader will drop packets of it: duplicate"):
            assert lumsdk.write_capture(out, [one[0], two[0]], profile=profile).frames == 2


def test_a_clock_that_the_profile_cannot_tell_is_refused(capture, tmp_path):
    short = lumsdk.Profile({"group": {"timestamp": {"at": 20, "bytes": 1}}})
    with pytest.raises(lumsdk.OptionError, match="the profile's clock of 8 bits needs less than 128 us"):
        rewrite(capture, tmp_path / "out.pcap", profile=short)


def test_frames_without_a_clock_do_not_get_one(make_capture, tmp_path):
    (tmp_path / "profile.yaml").write_text(lumsdk.Profile(PROFILES["no-clock"]).to_yaml())
    path = make_capture("-n", 3, "--profile", tmp_path / "profile.yaml", name="dark.pcap")
    with pytest.raises(lumsdk.OptionError, match="its profile has no clock, and that of the file has one"):
        rewrite(path, tmp_path / "out.pcap", options={"profile": tmp_path / "profile.yaml"}, profile=lumsdk.Profile())


def test_lines_that_readers_drop_are_told(tmp_path):
    lines = [made_line(number, clock_us=1_000_000 + 1500 * number) for number in range(40)]
    with pytest.warns(lumsdk.CaptureWarning, match="a reader will drop packets of it: late 6"):
        written = lumsdk.write_capture(tmp_path / "out.pcap", [*lines, made_line(3, clock_us=1_004_500, arrival_ns=2 * 10 ** 18)])
    assert written.dropped == {"late": 6}


def test_what_is_no_capture_is_refused(tmp_path, raw_frame):
    with pytest.raises(lumsdk.OptionError, match=r"captures that are written end with .pcap or .pcapng"):
        lumsdk.write_capture(tmp_path / "out.las", [raw_frame])
    with pytest.raises(TypeError, match="takes frames and lines, not int"):
        lumsdk.write_capture(tmp_path / "out.pcap", [raw_frame, 5])
    assert not list(tmp_path.iterdir())
    with pytest.raises(lumsdk.Error, match="the directory does not exist") as caught:
        lumsdk.write_capture(tmp_path / "none" / "out.pcap", [raw_frame])
    assert isinstance(caught.value, OSError)


@pytest.mark.parametrize("items", [lambda source: source, lambda source: source[1:3], list,
                                   lambda source: (line for frame in source for line in frame.to_lines())])
def test_the_source_is_not_written_over(items, make_capture, tmp_path, monkeypatch):
    path = make_capture("-n", 2, name="source.pcap")
    content = path.read_bytes()
    monkeypatch.chdir(path.parent)
    with open(path, "rb") as file:
        for given in path.name, file:
            with lumsdk.open(given, raw=True) as source, \
                    pytest.raises(lumsdk.OptionError, match="is the source itself, which this run reads: name another output"):
                lumsdk.write_capture(path, items(source))
    assert path.read_bytes() == content


def test_what_packets_do_not_have_is_told(raw_frame, tmp_path):
    out = tmp_path / "out.pcap"
    changed = raw_frame.replace(range=raw_frame["range"] + 1).replace(xyz=raw_frame.xyz + 1).with_columns(label=raw_frame["pixel"])
    with pytest.warns(lumsdk.CaptureWarning, match="range, xyz of frames were changed, but packets do not have them"):
        lumsdk.write_capture(out, [changed])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert lumsdk.write_capture(out, [raw_frame.replace(tof=np.maximum(raw_frame["tof"], 1))]).no_range == 0
    tof = np.abs(raw_frame["tof"]) + 1
    tof[:5], tof[5] = -tof[:5], 0
    known = raw_frame.losses["no_range"]
    assert lumsdk.write_capture(out, raw_frame.replace(tof=np.where(np.arange(len(tof)) < known, -1, 9))).no_range == known > 0
    with pytest.warns(lumsdk.CaptureWarning, match="6 words have a tof of 0 or below, which gives no range unless"):
        lumsdk.write_capture(out, raw_frame.replace(tof=tof).to_lines())


def test_a_line_is_shown_in_a_line(raw_frame):
    line = raw_frame.to_lines()[0]
    eye = "blue" if line.eye in ("blue", 0) else "green"
    assert repr(line) == f"<Line {line.number} of the {eye} eye of 10.42.0.37: {len(line.tof)} words>"


def test_columns_are_what_is_written(raw_frame, tmp_path):
    columns = raw_frame.to_dict()
    edited = pickle.loads(pickle.dumps(raw_frame))
    edited["tof"][:] = np.where(columns["tof"] > 0, columns["tof"] + 7, columns["tof"])
    edited["raw_azimuth"][:] += 3
    out = tmp_path / "out.pcap"
    written = lumsdk.write_capture(out, [edited])
    assert written.cut_anew == 0
    with lumsdk.open(out, raw=True) as source:
        frame = source[0]
    assert np.array_equal(np.sort(frame["tof"]), np.sort(edited["tof"]))
    assert np.array_equal(np.sort(frame["raw_azimuth"]), np.sort(columns["raw_azimuth"] + np.int16(3)))


@pytest.mark.parametrize("field", ["clock_us", "arrival_ns", "number", "eye"])
def test_what_is_changed_in_the_lines_is_in_the_packets(raw_frame, tmp_path, field):
    lines, columns = raw_frame.lines.copy(), raw_frame.to_dict()
    if field == "eye":
        lines["eye"], columns["eye"] = 1 - lines["eye"], 1 - columns["eye"]
    else:
        lines[field] += 500
    columns["line"] = np.repeat(lines["number"], lines["point_count"])
    made = lumsdk.Frame.from_arrays(columns, lines=lines, sensor="10.42.0.40")
    out = tmp_path / "out.pcap"
    made = made.with_raw(raw_frame.angles, raw_frame.has_angles, raw_frame.packets)
    assert lumsdk.write_capture(out, [made]).cut_anew == 0
    with lumsdk.open(out, raw=True) as source:
        frame = source[0]
    assert frame.sensor == "10.42.0.40"
    names = ["number", "eye", "clock_us", "arrival_ns", "point_count"]
    assert np.array_equal(np.sort(frame.lines[names]), np.sort(lines[names]))


def test_rows_without_words_leave_lines_of_angles(raw_frame, tmp_path):
    out = tmp_path / "out.pcap"
    few = raw_frame[raw_frame["line"] % 2 == 0]
    assert lumsdk.write_capture(out, [few]).cut_anew == (few.lines["point_count"] == 0).sum() > 0
    with lumsdk.open(out, raw=True) as source:
        frame = source[0]
    assert np.array_equal(np.sort(frame["tof"]), np.sort(few["tof"]))
    assert frame.has_angles.all()
    assert len(frame.lines) == len(few.lines)


@pytest.mark.parametrize("ending", ["csv", "ply", "pcd", "npy", "npz", "parquet", "feather"])
def test_raw_columns_are_in_files_that_name_them(capture, raw_frame, tmp_path, ending):
    if ending in ("parquet", "feather"):
        pytest.importorskip("pyarrow")
    out = tmp_path / f"out.{ending}"
    columns = ["x", "y", "z", "tof", "raw_azimuth"]
    lumsdk.convert([raw_frame], out, columns=columns)
    whole = out.read_bytes()
    lumsdk.convert(capture, out, raw=True, columns=columns)
    if ending in ("csv", "parquet", "feather", "npz", "npy"):
        read = {"csv": lambda: np.genfromtxt(out, delimiter=",", names=True, max_rows=9),
                "npy": lambda: np.load(out), "npz": lambda: np.load(out)}.get(ending)
        read = read or (lambda: pytest.importorskip(f"pyarrow.{ending}").read_table(out))
        with lumsdk.open(capture, raw=True) as source:
            first = source[0]
        made = read()
        assert np.array_equal(np.asarray(made["tof"])[:9], first["tof"][:9])
        assert np.array_equal(np.asarray(made["raw_azimuth"])[:9], first["raw_azimuth"][:9])
    else:
        assert b"tof" in whole[:1000] and b"raw_azimuth" in whole[:1000]
    lumsdk.convert([raw_frame], out)
    assert b"raw_azimuth" not in out.read_bytes()


def test_all_columns_of_raw_frames_are_those_that_each_has(make_capture, tmp_path):
    """Not the places of words, which only some frames have."""
    path = make_capture("-n", 2)
    out = tmp_path / "out.npz"
    for source in path, mixed(path, tmp_path / "mixed.pcap"):
        lumsdk.convert(source, out, raw=True, columns="all")
        made = np.load(out)
        assert "tof" in made and "raw_place" not in made
        lumsdk.convert(list(lumsdk.open(source, raw=True, columns="all")), out, columns="all")
        assert np.array_equal(np.load(out)["tof"], made["tof"])


def test_tables_have_the_raw_columns(raw_frame):
    pytest.importorskip("pyarrow")
    pytest.importorskip("pandas")
    assert raw_frame.to_arrow(columns=["tof", "x"]).column_names == ["tof", "x"]
    assert "raw_elevation" in raw_frame.to_pandas()


def test_raw_columns_are_of_raw_frames(capture, tmp_path):
    with pytest.raises(lumsdk.OptionError, match="columns: 'tof' is of raw frames; read them with raw=True"):
        lumsdk.convert(capture, tmp_path / "out.npz", columns=["x", "tof"])
    with lumsdk.open(capture, raw=True, columns=["x", "tof"]) as source:
        assert source[0].columns == ("x", "line", "pixel", "eye", "edge", "tof", "raw_azimuth", "raw_elevation")


def test_a_capture_is_written_to_a_url(raw_frame, tmp_path):
    store = pytest.importorskip("fsspec").filesystem("memory")
    lumsdk.write_capture("memory://raw/out.pcap", [raw_frame])
    lumsdk.write_capture(tmp_path / "out.pcap", [raw_frame])
    assert store.cat("/raw/out.pcap") == (tmp_path / "out.pcap").read_bytes()
    with pytest.raises(lumsdk.OptionError, match="storage_options does not go with .*out.pcap: it is for a URL"):
        lumsdk.write_capture(tmp_path / "out.pcap", [raw_frame], storage_options={"anon": True})


def test_a_frame_without_a_sensor_is_of_the_usual_one(tmp_path):
    frame = lumsdk.Frame.from_arrays(tof=np.full(3, 1000), pixel=np.arange(3), edge=np.ones(3, "u1"), line=np.zeros(3, "u4"),
                                     eye=np.zeros(3, "u1"), raw_azimuth=np.zeros(3, "i2"), raw_elevation=np.zeros(3, "i2"))
    lumsdk.write_capture(tmp_path / "out.pcap", [frame])
    with lumsdk.open(tmp_path / "out.pcap") as source:
        assert [(len(made), made.sensor) for made in source] == [(3, "10.42.0.37")]


def test_a_jump_that_readers_take_for_another_is_told(tmp_path):
    lumsdk.write_capture(tmp_path / "in.pcap", [made_line(number, clock_us=1500 * number) for number in range(20)])
    with lumsdk.open(tmp_path / "in.pcap", raw=True) as source:
        lines = [line for frame in source for line in frame.to_lines()]
    moved = [dataclasses.replace(line, clock_us=line.clock_us + 2 ** 31 * (line.number >= 10)) for line in lines]
    with pytest.warns(lumsdk.CaptureWarning, match="at 1 places the clock jumps by half a round of the profile's field or more"):
        assert lumsdk.write_capture(tmp_path / "out.pcap", moved).clock_jumps == 1


def test_rows_that_are_not_of_their_line_are_refused(raw_frame, tmp_path):
    edited = pickle.loads(pickle.dumps(raw_frame))
    edited["line"][5] = 17
    with pytest.raises(lumsdk.OptionError, match=r"frame 2: line: points \d+ and 5 are of one line of the frame, and have \d+ and 17; use one number"):
        lumsdk.write_capture(tmp_path / "out.pcap", [edited])


def test_with_raw_gives_a_frame_what_it_lacks(raw_frame, tmp_path):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        again = raw_frame.with_raw(raw_frame.angles.tolist(), raw_frame.has_angles, raw_frame.packets)
        lumsdk.write_capture(tmp_path / "one.pcap", [raw_frame])
        lumsdk.write_capture(tmp_path / "two.pcap", [again])
    assert (tmp_path / "one.pcap").read_bytes() == (tmp_path / "two.pcap").read_bytes()
    with pytest.raises(lumsdk.OptionError, match=r"angles has the shape \(3, 1000, 2\); use"):
        raw_frame.with_raw(np.zeros((3, 1000, 2), "i2"))
    with pytest.raises(lumsdk.OptionError, match="packets: line is 4000; use a place in frame.lines"):
        wrong = raw_frame.packets.copy()
        wrong["line"][0] = 4000
        raw_frame.with_raw(raw_frame.angles, packets=wrong)
