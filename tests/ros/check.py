"""The ROS package at work. check.py BUILD PICTURE, called by run."""
import collections
import csv
import json
import math
import os
import pathlib
import re
import signal
import statistics
import struct
import subprocess
import sys
import time

import diagnostic_msgs.msg
import lumsdk_ros.msg
import rosbag
import rosgraph
import rospy
import sensor_msgs.msg
import std_msgs.msg
import tf2_msgs.msg

from support import (NO_RING, PATIENCE_S, Failure, Processes, check, check_form, children_of, free_port, ns, points_of, tail,
                     text_of, units, wait_until)

BUILD = pathlib.Path(sys.argv[1])
PICTURE = pathlib.Path(sys.argv[2])
WORK = BUILD / "work"
BIN = BUILD / "prefix/bin"
NODE = BUILD / "ros/lib/lumsdk_ros/lumsdk_node"
RAW = ["/luminar_raw_blue_data", "/luminar_raw_green_data"]
RATE = 10.0
BLUE, GREEN = 0, 1
ROOT = pathlib.Path(__file__).resolve().parents[2]
PROCESSES = Processes(WORK)
PORT = free_port()
HOST = f"127.62.{PORT % 200 + 1}"


class Listener:
    """A topic's messages."""

    def __init__(self, topic, kind):
        self.messages = []
        self.subscriber = rospy.Subscriber(topic, kind, self.messages.append, buff_size=1 << 26, tcp_nodelay=True)

    def wait(self, count):
        wait_until(lambda: len(self.messages) >= count, f"{count} messages of {self.subscriber.resolved_name}")
        return self.messages

    def wait_for_silence(self, seconds=4.0):
        """All that comes, once something came."""
        self.wait(1)
        while True:
            before = len(self.messages)
            time.sleep(seconds)
            if len(self.messages) == before:
                return self.messages

    def stop(self):
        self.subscriber.unregister()


def clouds(topic="/points"):
    return Listener(topic, sensor_msgs.msg.PointCloud2)


def run(*command):
    r = subprocess.run([str(c) for c in command], capture_output=True, text=True, timeout=PATIENCE_S,
                       stdin=subprocess.DEVNULL)
    check(r.returncode == 0, f"{command[0]}: {r.returncode} {r.stderr[-300:]}")
    return r.stdout


def capture(name, *arguments):
    path = WORK / name
    run(BIN / "lumsim", "-o", path, "--quiet", *arguments)
    return path


def launch(name, *arguments):
    return PROCESSES.start("roslaunch", "lumsdk_ros", name, *arguments, name=name)


def node(*arguments):
    return PROCESSES.start(NODE, "__name:=lumsdk_node", *arguments, name="node")


def sensor(last, *arguments):
    """lumsim on the network, and how to read its log."""
    address = f"{HOST}.{last}"
    path = WORK / f"sensor-{last}.log"
    path.unlink(missing_ok=True)
    p = PROCESSES.start(BIN / "lumsim", "--address", address, "--log", path, "--quiet", *arguments)

    def events(kind):
        lines = path.read_text().splitlines(True) if path.exists() else []
        return [e for e in (json.loads(s) for s in lines if s.endswith("\n")) if e["event"] == kind]
    wait_until(lambda: p.poll() is not None or events("frames"), "lumsim")
    return address, p, events


def record(name, *topics):
    path = WORK / name
    path.unlink(missing_ok=True)
    p = PROCESSES.start("rosbag", "record", "--buffsize=0", "-O", path, *topics)
    wait_until(lambda: all(subscribers_of(topic) > 0 for topic in topics), "the recorder")
    return path, p


def subscribers_of(topic):
    _, subscribed, _ = rosgraph.Master("/check").getSystemState()
    return sum(len(nodes) for name, nodes in subscribed if name == topic)


def same(a, b):
    """Two clouds, but for the count that ROS adds."""
    return (ns(a.header.stamp), a.header.frame_id, a.fields, a.width, a.data) == (
        ns(b.header.stamp), b.header.frame_id, b.fields, b.width, b.data)


def rows_of(path, *options):
    """lumdump's rows, by frame."""
    table = WORK / "points.csv"
    run(BIN / "lumdump", path, "-o", table, "--quiet", *options)
    frames = {}
    with open(table, newline="", encoding="ascii") as f:
        rows = csv.reader(f)
        Row = collections.namedtuple("Row", next(rows))
        for r in map(Row._make, rows):
            frames.setdefault(int(r.frame), []).append(r)
    table.unlink()
    return [frames[number] for number in sorted(frames)]


def decimal(text, places):
    sign = -1 if text.startswith("-") else 1
    whole, _, part = text.lstrip("-").partition(".")
    return sign * (int(whole) * 10 ** places + int(part.ljust(places, "0")))


def line_period(rows):
    """Microseconds: the median of what lies between neighbouring lines of an eye."""
    lines = {}
    for r in rows:
        lines.setdefault(r.eye, {})[int(r.line)] = int(r.timestamp)
    periods = []
    for eye in lines.values():
        known = sorted(eye.items())
        periods += [(t2 - t1) / (n2 - n1) for (n1, t1), (n2, t2) in zip(known, known[1:])]
    return statistics.median(periods)


def ring_of(row, lines):
    """Green's rings follow blue's."""
    return int(row.line) + (lines if int(row.eye) == GREEN else 0)


def check_cloud(cloud, rows, lines=64):
    """The same points with lumdump's numbers, and each at its line's and pixel's time."""
    period = line_period(rows)
    at = [int(r.timestamp) + int(r.pixel) * period / 1000 for r in rows]
    first = min(at)
    expected = sorted((ring_of(r, lines), int(r.return_number), int(r.eye), decimal(r.pulse_width, 3), decimal(r.x, 4),
                       decimal(r.y, 4), decimal(r.z, 4), t - first) for r, t in zip(rows, at))
    found = sorted((p[5], p[6], p[7], units(p[3], 1000), units(p[0], 10000), units(p[1], 10000), units(p[2], 10000),
                    p[4] * 1e6) for p in points_of(cloud))
    check(len(found) == len(expected), f"{len(found)} points, lumdump has {len(expected)}")
    for f, e in zip(found, expected):
        check(f[:7] == e[:7], f"{f} is not lumdump's {e}")
        check(abs(f[7] - e[7]) < 3.0, f"{f} is not at {e[7]} us")


def compare_with_lumdump(path, parameters, options):
    listener = clouds()
    p = launch("capture.launch", f"capture:={path}", "wait_for:=[points]", *parameters)
    found = listener.wait_for_silence()
    PROCESSES.end(p)
    listener.stop()
    frames = rows_of(path, *options)
    check(len(found) == len(frames), f"{len(found)} clouds, lumdump has {len(frames)} frames")
    for cloud, rows in zip(found, frames):
        check_form(cloud)
        check_cloud(cloud, rows)
    return found


def capture_is_lumdumps():
    path = capture("street.pcap", "--frames", 3, "--lines", 64)
    found = compare_with_lumdump(path, [], [])
    check(all(c.header.frame_id == "luminar" for c in found), "frame_id")
    for cloud, rows in zip(found, rows_of(path, "--time", "utc", "--return", "first")):
        late = ns(cloud.header.stamp) / 1000 - min(int(r.timestamp) for r in rows)
        check(-5000 < late < 5000, f"the stamp is {late} us from when the first line came")


def by_ring(points, ring=lambda p: p[5]):
    """Points that follow each other in a ring."""
    rings = {}
    for p in points:
        rings.setdefault(ring(p), []).append(p)
    return [(a, b) for ring in rings.values() for a, b in zip(ring, ring[1:])]


def angle(a, b):
    """Degrees between two points, seen from the sensor."""
    u, v = ([c / math.hypot(*p[:3]) for c in p[:3]] for p in (a, b))
    return math.degrees(2 * math.asin(min(1.0, math.dist(u, v) / 2)))


def neighbours_of_a_ring_are_neighbours():
    """What A-LOAM, LIO-SAM and FAST-LIO take for granted: who follows in a ring was seen next."""
    path = capture("street.pcap", "--frames", 3, "--lines", 64)
    listener = clouds()
    p = launch("capture.launch", f"capture:={path}", "wait_for:=[points]")
    found = list(listener.wait_for_silence())
    PROCESSES.end(p)
    listener.stop()
    check(len(found) == 3, f"{len(found)} clouds")
    for cloud in found:
        points = points_of(cloud)
        check({p[5] // 64 for p in points if p[7] == BLUE} == {0}, "blue's rings")
        check({p[5] // 64 for p in points if p[7] == GREEN} == {1}, "green's rings")
        pairs = by_ring(points)
        line = max(b[4] - a[4] for a, b in pairs)
        far = [(a, b) for a, b in pairs if angle(a, b) > 1.0 + 90.0 * (b[4] - a[4]) / line]
        check(not far, f"{len(far)} of {len(pairs)} neighbours are none, such as {far[:1]}")
        wide = sum(angle(a, b) > 20.0 for a, b in pairs)
        check(wide < len(pairs) / 1000, f"{wide} of {len(pairs)} neighbours are 20 degrees apart")
        mixed = sum(angle(a, b) > 20.0 for a, b in by_ring(points, lambda p: p[5] % 64))
        check(mixed > len(pairs) / 2, f"lines of both eyes in one ring would be seen: {mixed} of {len(pairs)}")


def rings_follow_the_number_of_lines():
    """As the frames show, or as it is stated."""
    many = capture("many.pcap", "--frames", 1, "--lines", 640)
    few = capture("few.pcap", "--frames", 1, "--lines", 64)
    for path, lines, first, highest in ((many, 0, 640, 1279), (many, 640, 640, 1279), (few, 640, 640, 703),
                                        (few, 0, 64, 127), (many, 64, 64, NO_RING)):
        listener = clouds()
        p = launch("capture.launch", f"capture:={path}", "wait_for:=[points]", f"lines:={lines}", "speed:=0")
        points = points_of(listener.wait_for_silence()[0])
        PROCESSES.end(p)
        listener.stop()
        green = [p[5] for p in points if p[7] == GREEN]
        check((min(green), max(green)) == (first, highest), f"{path.name}, {lines}: {min(green)} to {max(green)}")
        beyond = sum(p[5] == NO_RING for p in points)
        check((beyond > 0) == (highest == NO_RING), f"{path.name}, {lines}: {beyond} points without a ring")
        check(("lines beyond 64: their ring is 65535" in text_of(p)) == (beyond > 0), tail(p))
        check(("rings of the green eye begin at 640" in text_of(p)) == (path == many and lines == 0), tail(p))
        rings = {p[5] for p in points if p[7] == BLUE} & set(green)
        check(rings <= {NO_RING}, f"rings of both eyes: {sorted(rings)[:3]}")


def eyes_have_topics_of_their_own():
    path = capture("street.pcap", "--frames", 3, "--lines", 64)
    names = ["points", "points_blue", "points_green"]
    listeners = [clouds(f"/{name}") for name in names]
    p = launch("capture.launch", f"capture:={path}", f"wait_for:=[{', '.join(names)}]", "eye_topics:=true")
    both, *eyes = [list(each.wait_for_silence()) for each in listeners]
    PROCESSES.end(p)
    for each in listeners:
        each.stop()
    check([len(e) for e in eyes] == [len(both)] * 2, f"{len(both)} clouds, and {[len(e) for e in eyes]}")
    for cloud, *parts in zip(both, *eyes):
        found = []
        for eye, part in enumerate(parts):
            check_form(part)
            late = (ns(part.header.stamp) - ns(cloud.header.stamp)) / 1e9
            check(late >= 0 and part.header.frame_id == cloud.header.frame_id, "stamp or frame_id")
            check({p[7] for p in points_of(part)} == {eye}, "a point of the other eye")
            found += [(*p[:4], round((p[4] + late) * 1e6), p[5] + 64 * eye, *p[6:]) for p in points_of(part)]
        wanted = [(*p[:4], round(p[4] * 1e6), *p[5:]) for p in points_of(cloud)]
        for f, w in zip(sorted(found, key=without_time), sorted(wanted, key=without_time)):
            check(without_time(f) == without_time(w) and abs(f[4] - w[4]) <= 1, f"{f} is not {w}")
        check(len(found) == len(wanted), f"{len(found)} points of {len(wanted)}")


def without_time(point):
    return point[:4] + point[5:]


TWO = """<launch>
  <group ns="front">
    <include file="$(find lumsdk_ros)/launch/live.launch">
      <arg name="address" value="{}"/> <arg name="laser" value="true"/> <arg name="frame_id" value="front"/>
    </include>
  </group>
  <group ns="rear">
    <include file="$(find lumsdk_ros)/launch/live.launch">
      <arg name="address" value="{}"/> <arg name="laser" value="true"/> <arg name="frame_id" value="rear"/>
    </include>
  </group>
</launch>
"""


def two_sensors_have_topics_of_their_own():
    (front, p, _), (rear, q, _) = sensor(5), sensor(6)
    file = WORK / "two.launch"
    file.write_text(TWO.format(front, rear), encoding="ascii")
    tf = Listener("/tf_static", tf2_msgs.msg.TFMessage)
    diagnostics = Listener("/diagnostics", diagnostic_msgs.msg.DiagnosticArray)
    listeners = {name: clouds(f"/{name}/points") for name in ("front", "rear")}
    topics = [f"/{name}{topic}" for name in ("front", "rear") for topic in RAW]
    started = PROCESSES.start("roslaunch", file)
    bag, recorder = record("two.bag", *topics)
    for name, listener in listeners.items():
        wait_until(lambda: any(c.width > 10000 for c in listener.messages), f"a cloud of {name}")
        check({c.header.frame_id for c in listener.messages} == {name}, f"frame_id of {name}")
    wanted = {f"{name}/lumsdk_node: laser" for name in listeners}
    wait_until(lambda: wanted <= {s.name for m in diagnostics.messages for s in m.status}, "both diagnoses")
    def frames():
        return {t.child_frame_id for m in tf.messages for t in m.transforms}

    wanted = {"front_blue", "front_green", "rear_blue", "rear_green"}
    wait_until(lambda: frames() >= wanted, "transforms of both")  # each node has a connection of its own
    check(frames() == wanted, f"transforms of {sorted(frames())}")
    published = {name for name, _ in rosgraph.Master("/check").getSystemState()[0]}
    check(not published & set(RAW), "raw topics outside of their namespaces")
    for each in listeners.values():
        each.wait(len(each.messages) + 10)
        each.stop()
    PROCESSES.end(recorder, group=True)
    check(PROCESSES.end(started) == 0, f"exit status: {tail(started)}")
    check_bag_of_two(bag, {"front": front, "rear": rear})
    tf.stop()
    diagnostics.stop()
    again = clouds()
    started = launch("bag.launch", f"bag:={bag}", "recorded_in:=/rear", "time:=now")
    check(len(again.wait(5)) >= 5, "clouds of the rear sensor")
    PROCESSES.end(started)
    again.stop()
    PROCESSES.end(p)
    PROCESSES.end(q)


def check_bag_of_two(bag, addresses):
    with rosbag.Bag(str(bag)) as b:
        for name, address in addresses.items():
            number = int.from_bytes(bytes(int(part) for part in address.split(".")), "big")
            sensors = {m.sensor for _, m, _ in b.read_messages(topics=[f"/{name}{topic}" for topic in RAW])}
            check(sensors == {number}, f"{name}: packets of {sensors}")


def the_documentation_builds_as_install_md():
    """Where docs/ros.md installs lumsdk from, docs/install.md has built it."""
    readme, page = ((ROOT / name).read_text() for name in ("docs/install.md", "docs/ros.md"))
    built = re.search(r"^    cmake -B (\S+) && cmake --build (\S+)$", readme, re.M)
    check(built and built[1] == built[2], "docs/install.md builds nowhere")
    installed = re.findall(r"cmake --install (\S+) --prefix PREFIX", page)
    check(installed == [built[1]], f"docs/ros.md installs from {installed}, docs/install.md builds in {built[1]}")
    check(built[0] in page, "docs/ros.md does not build as docs/install.md does")


def rough_capture_is_lumdumps():
    path = capture("rough.pcap", "--frames", 3, "--lines", 64, "--loss", 0.02, "--reorder", 0.05, "--duplicate", 0.02,
                   "--seed", 3)
    compare_with_lumdump(path, ["edge:=both", "return:=last", "range_min:=3", "range_max:=60",
                                "smoothing:=31"],
                         ["--edge", "both", "--return", "last", "--range", "3:60", "--smooth", 31])


def calibration_is_used():
    path = WORK / "calibration.yaml"
    path.write_text("version: 1\neyes:\n  blue:\n    tof_offset_ps: 900.0\n    mount: {x_m: 0.25, y_m: 0.5, "
                    "z_m: -0.125, roll_deg: 1.5, pitch_deg: -2.0, yaw_deg: -31.0}\n", encoding="ascii")
    tf = Listener("/tf_static", tf2_msgs.msg.TFMessage)
    shot = capture("one.pcap", "--frames", 1, "--lines", 64)
    compare_with_lumdump(shot, [f"calibration:={path}"], ["--calibration", path])
    tf.stop()
    eyes = {t.child_frame_id: t.transform for m in tf.messages for t in m.transforms}
    check(set(eyes) == {"luminar_blue", "luminar_green"}, f"transforms of {sorted(eyes)}")
    where, q = eyes["luminar_blue"].translation, eyes["luminar_blue"].rotation
    check((where.x, where.y, where.z) == (0.25, 0.5, -0.125), f"the blue eye is at {where}")
    # where the eye's x and z axes point
    x = (1 - 2 * (q.y ** 2 + q.z ** 2), 2 * (q.x * q.y + q.z * q.w), 2 * (q.x * q.z - q.y * q.w))
    roll, pitch, yaw = (math.radians(a) for a in (1.5, -2.0, -31.0))
    wanted = (math.cos(yaw) * math.cos(pitch), math.sin(yaw) * math.cos(pitch), -math.sin(pitch))
    check(all(abs(a - b) < 1e-6 for a, b in zip(x, wanted)), f"the blue eye looks to {x}, not {wanted}")
    up = 2 * (q.y * q.z + q.x * q.w)
    check(abs(up - math.cos(pitch) * math.sin(roll)) < 1e-6, f"the blue eye's roll: {up}")


def what_a_capture_has_of_its_own_is_warned_of():
    """The node does not use it: it says so unless a parameter says what to use."""
    calibration = WORK / "own.yaml"
    calibration.write_text("version: 1\ntof_lsb_ps: 12.5\n", encoding="ascii")
    profile = WORK / "own-profile.yaml"
    profile.write_text("version: 1\nline_span_us: 3000\n", encoding="ascii")
    known = capture("own.pcapng", "--frames", 1, "--lines", 64, "--calibration", calibration, "--profile", profile)
    plain = capture("plain.pcapng", "--frames", 1, "--lines", 64)
    both = {"calibration", "profile"}
    subprocess.run(["rosparam", "delete", "/lumsdk_node"], capture_output=True, timeout=PATIENCE_S, check=False)  # of a launch before
    for path, arguments, kinds in ((known, [], both), (known, [f"_calibration:={calibration}"], {"profile"}), (plain, [], set()),
                                   (known, [f"_calibration:={calibration}", f"_profile:={profile}"], set())):
        log = of_a_capture(path, *arguments)[1]
        said = {k for k in both if f"{path} has a {k} of its own, which this node does not use: give it by ~{k}" in log}
        check(said == kinds, f"{path.name} {arguments}: warned of {said}, not {kinds}")


def of_a_capture(path, *parameters):
    """The clouds of a node, and what it said."""
    listener = clouds()
    p = node(f"_source:={path}", "_wait_for:=[points]", *parameters)
    found = listener.wait_for_silence()
    PROCESSES.end(p, signal.SIGTERM)
    listener.stop()
    run("rosparam", "delete", "/lumsdk_node")
    return found, text_of(p)


def sensors_of_one_address_are_told_apart():
    sides = [capture(f"side-{seed}.pcap", "--frames", 2, "--lines", 64, "--seed", seed) for seed in (3, 4)]
    both = WORK / "both.pcapng"
    run("mergecap", "-F", "pcapng", "-I", "none", "-w", both, *sides)
    sensors = json.loads(run(BIN / "lumdump", both, "--json"))["sensors"]  # interfaces are named by their numbers
    further = sensors[1]["name"]
    p = node(f"_source:={both}")
    check(p.wait(PATIENCE_S) == 1 and f"choose one by ~sensor: 10.42.0.37 {further}" in text_of(p), tail(p))
    run("rosparam", "delete", "/lumsdk_node")
    for name, side in ((s["name"], sides[int(s["interface"])]) for s in sensors):
        raw = Listener(RAW[0], lumsdk_ros.msg.Packets)
        found, said = of_a_capture(both, f"_sensor:={name}")
        packets = max(m.end for m in raw.messages)
        raw.stop()
        check(packets == json.loads(run(BIN / "lumdump", side, "--json"))["data"], f"{packets} packets on {RAW}")
        for cloud, rows in zip(found, rows_of(side)):
            check_cloud(cloud, rows)
        warned = f"several sensors have this address, and the first one was taken: name the other as {further}" in said
        check(len(found) == 2 and warned == ("%" not in name), f"{len(found)} clouds of {name}: {said[-300:]}")


def another_port_is_told_and_can_be_chosen():
    path = capture("street.pcap", "--frames", 2, "--lines", 64)
    moved = WORK / "nat.pcap"
    moved.write_bytes(path.read_bytes().replace(struct.pack(">H", 5517), struct.pack(">H", 5600)))
    p = node(f"_source:={moved}")
    wait_until(lambda: "but only port 5517 is read" in text_of(p), "the warning")
    PROCESSES.end(p, signal.SIGTERM)
    found, said = of_a_capture(moved, "_port:=5600")
    check(len(found) == 2 and "5517" not in said, f"{len(found)} clouds: {said[-300:]}")


def parameters_hold_a_calibration():
    """What rosparam load makes of the YAML file serves as well as its path."""
    shot = capture("one.pcap", "--frames", 1, "--lines", 64)
    path = WORK / "typical.yaml"
    text = next(BUILD.glob("prefix/share/lumsdk/typical.yaml")).read_text()
    path.write_text(text.replace("width_deg: 60", "width_deg: 58"), encoding="ascii")
    run("rosparam", "load", path, "/lumsdk_node/calibration")
    listener = clouds()
    p = node(f"_source:={shot}", "_wait_for:=[points]")
    found = listener.wait_for_silence()
    check(PROCESSES.end(p, signal.SIGTERM) == 0, f"exit status: {tail(p)}")
    listener.stop()
    run("rosparam", "delete", "/lumsdk_node")
    check(len(found) == 1, f"{len(found)} clouds")
    check_cloud(found[0], rows_of(shot, "--calibration", path)[0])


def bag_is_the_capture():
    """Recorded, played and decoded again."""
    path = capture("street.pcap", "--frames", 5, "--lines", 64, "--loss", 0.01, "--reorder", 0.02)
    bag, recorder = record("capture.bag", *RAW)
    listener = clouds()
    p = launch("capture.launch", f"capture:={path}", f"wait_for:=[points, {RAW[0]}, {RAW[1]}]")
    first = list(listener.wait_for_silence())
    PROCESSES.end(p)
    PROCESSES.end(recorder, group=True)
    listener.stop()
    check(len(first) == 5, f"{len(first)} clouds of 5 frames")
    check_bag(bag, path)
    check(rows_of(path) == rows_of(bag), "lumdump makes other points of the bag")
    again = play(bag, times=2)
    check(len(again) == 2 * len(first), f"{len(again)} clouds of twice {len(first)}")
    for i, (a, b) in enumerate(zip(first + first, again)):
        check(same(a, b), f"cloud {i} is another one")
    for i, (a, b) in enumerate(zip(first, play(bag, topics=RAW[:1]))):
        check(0 < b.width < a.width, f"cloud {i} of the blue eye alone: {b.width} of {a.width} points")


def check_bag(bag, path):
    """It holds each datagram of the capture that the sensor sent, and when it came."""
    packets = []
    with rosbag.Bag(str(bag)) as b:
        for _, m, _ in b.read_messages(topics=RAW):
            at = 0
            for place, stamp, length in zip(m.places, m.stamps, m.lengths):
                packets.append((m.begin + place, ns(stamp), bytes(m.data[at:at + length])))
                at += length
    packets.sort()
    check([p[0] for p in packets] == list(range(len(packets))), "numbers of packets have holes")
    data = path.read_bytes()
    at, i = 24, 0
    while at < len(data):
        seconds, part, length = (int.from_bytes(data[at + k:at + k + 4], "little") for k in (0, 4, 8))
        payload = data[at + 16 + 42:at + 16 + length]
        check(i < len(packets) and packets[i][1:] == (seconds * 10 ** 9 + part, payload), f"packet {i} differs")
        at += 16 + length
        i += 1
    check(i == len(packets), f"{len(packets)} packets of {i}")


def bag_launch_plays_a_bag():
    bag = WORK / "capture.bag"
    check(bag.exists(), "bag_is_the_capture has not left its bag")
    listener = clouds()
    p = launch("bag.launch", f"bag:={bag}", "time:=now")
    before = time.time()
    found = listener.wait_for_silence()
    PROCESSES.end(p)
    listener.stop()
    check(len(found) == 5, f"{len(found)} clouds of 5 frames")
    check(all(before < ns(c.header.stamp) / 1e9 < time.time() for c in found), "stamps are not of now")


def play(bag, topics=None, times=1):
    """The clouds of a bag's raw topics."""
    listener = clouds()
    p = launch("bag.launch")
    wait_until(lambda: all(subscribers_of(t) for t in RAW), "the node")
    for _ in range(times):
        run("rosbag", "play", "--quiet", "--wait-for-subscribers", "--delay=1", bag, "--topics", *(topics or RAW))
    found = list(listener.wait_for_silence())
    PROCESSES.end(p)
    listener.stop()
    return found


def value_of(status, key):
    return next(v.value for v in status.values if v.key == key)


def wait_for_status(listener, name, accept, what):
    """The newest diagnosis of a name that is as wanted."""
    def look():
        newest = [s for m in listener.messages[-1:] for s in m.status if s.name == f"lumsdk_node: {name}"]
        return newest[0] if newest and accept(newest[0]) else None
    return wait_until(look, what)


def is_rate(rate):
    return abs(rate - RATE) < 0.05 * RATE


def check_rates(listener):
    """Once this machine is not so busy that clouds are late or left out."""
    before = len(listener.messages)
    for cloud in listener.wait(before + 40)[before:before + 3]:
        check_form(cloud)

    def rate_of_stamps():
        last = listener.messages[-40:]
        return (len(last) - 1) * 1e9 / (ns(last[-1].header.stamp) - ns(last[0].header.stamp))
    wait_until(lambda: is_rate(rate_of_stamps()), f"{RATE} stamps a second")
    hz = PROCESSES.start("rostopic", "hz", "--window=40", "/points", environment={"PYTHONUNBUFFERED": "1"})
    wait_until(lambda: text_of(hz).count("average rate") >= 5, "rostopic hz")
    wait_until(lambda: is_rate(float(text_of(hz).rpartition("\n")[0].split("average rate: ")[-1].split()[0])),
               f"{RATE} a second, by rostopic hz")
    PROCESSES.end(hz)


def check_commands():
    answers = Listener("/answer", std_msgs.msg.String)
    commands = rospy.Publisher("/command", std_msgs.msg.String, queue_size=10)
    wait_until(lambda: commands.get_num_connections() and answers.subscriber.get_num_connections(), "the node")
    for text, wanted in (("50p 0g", "answered"), ("5p u ", "refused, not sent"), ("101p", "power is 0 to 100"),
                         ("", "refused, not sent"), ("5x", "is not a command")):
        count = len(answers.messages)
        commands.publish(text)
        answer = answers.wait(count + 1)[-1].data
        check(wanted in answer, f"{text!r}: {answer!r}")
    answers.stop()
    commands.unregister()


def live_sensor():
    address, p, events = sensor(1, "--rate", RATE)
    listener = clouds()
    diagnostics = Listener("/diagnostics", diagnostic_msgs.msg.DiagnosticArray)
    started = launch("live.launch", f"address:={address}", "laser:=true")
    wait_until(lambda: any(c.width > 10000 for c in listener.messages), "a cloud")
    check_rates(listener)
    wait_for_status(diagnostics, "data", lambda s: s.level == 0 and abs(float(value_of(s, "frames_per_second")) - RATE) < 2.0,
                    "good data")
    laser = wait_for_status(diagnostics, "laser", lambda s: value_of(s, "TLV_CMD_ON") == "true", "the laser's status")
    check((laser.level, value_of(laser, "laser"), value_of(laser, "FAN_PWM_BAD")) == (0, "up", "false"), f"{laser}")
    losses = wait_for_status(diagnostics, "losses", lambda s: True, "losses")
    check(value_of(losses, "malformed") == "0", f"{losses.values}")
    lacking = sum(int(value_of(losses, key)) for key in ("lost_words", "lines_missing_angles"))
    check(int(value_of(losses, "under_way_when_joined")) <= lacking, f"{losses.values}")
    check_commands()
    sent = [e["note"] for e in events("tlv")]
    check(set(sent) == {"status poll", "50p; 0g", "u"}, f"the sensor heard {set(sent)}")
    check(events("laser")[-1]["up"], "the laser is down")
    check(PROCESSES.end(started) == 0, f"exit status: {tail(started)}")
    check(not events("laser")[-1]["up"] and "the laser is off" in text_of(started), f"laser: {tail(started)}")
    for each in (listener, diagnostics):
        each.stop()
    PROCESSES.end(p)


def live_recording():
    """What the node showed while its packets were recorded, and the same packets decoded again."""
    address, p, _ = sensor(2, "--rate", RATE)
    listener = clouds()
    started = launch("live.launch", f"address:={address}", "laser:=true")
    wait_until(lambda: any(c.width > 10000 for c in listener.messages), "a cloud")
    bag, recorder = record("live.bag", *RAW)
    listener.wait(len(listener.messages) + 30)
    PROCESSES.end(recorder, group=True)
    PROCESSES.end(started)
    listener.stop()
    PROCESSES.end(p)
    shown = {bytes(c.data) for c in listener.messages}
    again = play(bag)
    # before, one eye's packets may not have been recorded yet
    again = again[next((i for i, c in enumerate(again) if bytes(c.data) in shown), len(again)):]
    check(len(again) >= 15, f"{len(again)} clouds")
    strange = [i for i, c in enumerate(again[:-1]) if bytes(c.data) not in shown]
    check(not strange, f"clouds {strange} of {len(again)} were never shown live")


def laser_is_safe():
    address, p, events = sensor(3, "--fault", "fan@USR1-USR2")
    diagnostics = Listener("/diagnostics", diagnostic_msgs.msg.DiagnosticArray)
    n = node(f"_source:=udp://{address}", "_laser:=true")
    wait_until(lambda: any(e["up"] for e in events("laser")), "the laser")
    p.send_signal(signal.SIGUSR1)
    laser = wait_for_status(diagnostics, "laser", lambda s: s.level == 2, "the hazard")
    check("FAN_PWM_BAD" in laser.message, laser.message)
    off = wait_until(lambda: [e for e in events("tlv") if e["note"] == "d"], "d")
    check(off[0]["t"] - [e for e in events("laser") if not e["up"]][0]["t"] < 1.5, "d comes late")
    p.send_signal(signal.SIGUSR2)
    wait_for_status(diagnostics, "laser", lambda s: s.level == 0, "the hazard's end")
    time.sleep(1.0)
    check(not events("laser")[-1]["up"], "the laser came back by itself")
    run("rostopic", "pub", "-1", "/command", "std_msgs/String", "u")
    wait_until(lambda: events("laser")[-1]["up"], "the laser, after u")
    n.send_signal(signal.SIGSTOP)
    wait_until(lambda: not events("laser")[-1]["up"], "the end of a stopped node's laser")
    beat = [e["t"] for e in events("heartbeat")][-1]
    check(events("laser")[-1]["t"] - beat < 3.3, "the laser outlives the heartbeats")
    n.send_signal(signal.SIGCONT)
    check(n.wait(PATIENCE_S) == 1 and "makes no progress" in text_of(n), f"a node that was stopped: {tail(n)}")
    off = len(events("laser"))
    signal.signal(signal.SIGQUIT, signal.SIG_IGN)  # as by a shell, for what it runs in the background
    n = node(f"_source:=udp://{address}", "_laser:=true")
    signal.signal(signal.SIGQUIT, signal.SIG_DFL)
    wait_until(lambda: len(events("laser")) > off and events("laser")[-1]["up"], "the laser of another node")
    check(PROCESSES.end(n, signal.SIGQUIT) == 0, f"exit status: {tail(n)}")
    check(not events("laser")[-1]["up"], "the laser is on")
    n = node(f"_source:=udp://{address}", "_laser:=true")
    wait_until(lambda: events("laser")[-1]["up"], "the laser of a third")
    n.kill()
    wait_until(lambda: not events("laser")[-1]["up"], "the end of a killed node's laser")
    check("d" in [e["note"] for e in events("tlv")[-2:]], "it went off by itself alone")
    diagnostics.stop()
    PROCESSES.end(p)


def a_laser_by_command_is_the_nodes():
    """Also without ~laser: it goes off with the node, which waited for its sensor, and is guarded until then."""
    n = node(f"_source:=udp://{HOST}.9")
    wait_until(lambda: "waiting for the sensor" in text_of(n), "the node")
    _, p, events = sensor(9)
    listener = clouds()
    listener.wait(1)
    run("rostopic", "pub", "-1", "/command", "std_msgs/String", "u")
    wait_until(lambda: any(c.width > 10000 for c in listener.messages), "a cloud, after u")
    listener.wait(len(listener.messages) + 10)
    run("rosnode", "kill", "/lumsdk_node")
    check(n.wait(PATIENCE_S) == 0 and "the laser is off" in text_of(n), f"{n.returncode}: {tail(n)}")
    check(not events("laser")[-1]["up"], "the laser is on")
    listener.stop()
    PROCESSES.end(p)


def a_command_to_be_off_holds():
    """Also where one to be on came right before it."""
    _, p, events = sensor(10)
    n = node(f"_source:=udp://{HOST}.10")
    answers, listener = Listener("/answer", std_msgs.msg.String), clouds()
    commands = rospy.Publisher("/command", std_msgs.msg.String, queue_size=10)
    wait_until(lambda: commands.get_num_connections() and answers.subscriber.get_num_connections(), "the node")
    listener.wait(1)
    for texts in ("u d",), ("u", "d"):
        for text in texts:
            count = len(answers.messages)
            commands.publish(text)
            check("answered" in answers.wait(count + 1)[-1].data, f"{text}: {answers.messages[-1].data}")
        listener.wait(len(listener.messages) + 30)
        check(not events("laser") or not events("laser")[-1]["up"], f"{texts}: {[e['note'] for e in events('tlv')]}")
    answers.stop()
    commands.unregister()
    listener.stop()
    PROCESSES.end(n)
    PROCESSES.end(p)


def two_nodes_cannot_own_a_sensor():
    address, p, _ = sensor(4)
    first = node(f"_source:=udp://{address}")
    wait_until(lambda: "source:" in text_of(first), "the first")
    second = PROCESSES.start(NODE, "__name:=second", f"_source:=udp://{address}", name="node")
    check(second.wait(PATIENCE_S) == 1 and any(f"process {child})" in text_of(second) for child in children_of(first.pid)),
          f"the second: {tail(second)}")
    check(PROCESSES.end(first) == 0, tail(first))
    PROCESSES.end(p)


def a_second_signal_ends_a_long_laser_off():
    heard = []
    for last, numbers in ((7, [signal.SIGINT, signal.SIGTERM]), (8, [signal.SIGINT])):  # two of one number could come as one
        address, p, events = sensor(last)
        n = node(f"_source:=udp://{address}", "_laser:=true")
        wait_until(lambda: any(e["up"] for e in events("laser")), "the laser")
        p.send_signal(signal.SIGSTOP)
        for number in numbers:
            n.send_signal(number)
        check(n.wait(PATIENCE_S) == 0 and "laser off was not answered" in text_of(n), tail(n))
        p.send_signal(signal.SIGCONT)
        run(BIN / "lumctl", "--host", address, "status")  # answered behind all that waited
        heard.append(sum(e["note"] == "d" for e in events("tlv")))
        PROCESSES.end(p)
    check(heard[0] < 0.75 * heard[1], f"so many laser off, given up and not: {heard}")  # 3 s of them, and 10 s


def a_moved_sensor_is_named():
    address, p, events = sensor(5)
    new = f"{HOST}.6"
    n = node(f"_source:=udp://{address}")
    wait_until(lambda: events("stream"), "the stream")
    run(BIN / "lumctl", "--host", address, "set-ip", new)
    wait_until(lambda: f"the data comes from {new} now, not from {address}" in text_of(n), "the new address")
    check(PROCESSES.end(n) == 0, tail(n))
    PROCESSES.end(p)


def bad_parameters_are_told():
    for parameter, wanted in (("_source:=/nonexistent.pcap", "/nonexistent.pcap"), ("_source:=udp://1.2.3", "udp://"),
                              ("_edge:=up", "~edge"), ("_return:=0", "~return"), ("_laser:=true", "~laser"),
                              ("_calibration:=/nonexistent.yaml", "/nonexistent.yaml"), ("_time:=then", "~time"),
                              ("_speed:=-1", "speed must be"),
                              ("_lines:=40000", "lines must be"), ("_wait_for:=[nothing]", "~wait_for"), ("_sensor:=10.42.0.37%eth1", "~sensor"),
                              ("_port:=5600", "~port")):
        arguments = ["_source:=bag", parameter] if "_source" not in parameter else [parameter]
        p = node(*arguments)
        check(p.wait(PATIENCE_S) == 1 and wanted in text_of(p), f"{parameter}: {p.returncode} {tail(p)}")
        run("rosparam", "delete", "/lumsdk_node")


def screen(environment):
    """The screen's pixels, as (width, bytes)."""
    r = subprocess.run(["import", "-silent", "-window", "root", "-depth", "8", "ppm:-"], capture_output=True,
                       env={**os.environ, **environment}, timeout=PATIENCE_S)
    if r.returncode != 0 or not r.stdout.startswith(b"P6"):
        return 0, b""
    _, size, _, pixels = r.stdout.split(b"\n", 3)
    return int(size.split()[0]), pixels


def count_colours(width, pixels):
    """Pixels of strong colour in the view, and such of the red and orange of a status in the panel of displays."""
    points = complaints = 0
    for i in range(0, len(pixels) - 2, 3):
        r, g, b = pixels[i:i + 3]
        y, x = divmod(i // 3, width)
        if x > 365:
            points += max(r, g, b) - min(r, g, b) > 100
        elif x < 342 and 85 <= y < 735:
            complaints += r > 150 and g < 170 and b < 80 and r - g > 50
    return points, complaints


def rviz_shows_the_cloud():
    xvfb = PROCESSES.start("Xvfb", "-displayfd", "1", "-screen", "0", "1280x800x24", "-nolisten", "tcp")
    display = wait_until(lambda: "\n" in text_of(xvfb) and text_of(xvfb).split()[-1], "Xvfb")
    environment = {"DISPLAY": f":{display}", "LIBGL_ALWAYS_SOFTWARE": "1", "QT_X11_NO_MITSHM": "1",
                   "XDG_RUNTIME_DIR": str(WORK), "HOME": str(WORK)}
    path = capture("street.pcap", "--frames", 10, "--lines", 64)
    p = PROCESSES.start("roslaunch", "lumsdk_ros", "capture.launch", f"capture:={path}", "loop:=true", "time:=now",
                        "rviz:=true", environment=environment, name="rviz")
    counts = [(0, 0)]

    def look():
        counts.append(count_colours(*screen(environment)))
        return counts[-1][0] > 20000
    try:
        wait_until(look, "20000 coloured pixels")
    finally:
        print(f"# coloured pixels: {counts[-1][0]}, of a status in red or orange: {counts[-1][1]}")
    time.sleep(1.0)
    _, complaints = count_colours(*screen(environment))
    subprocess.run(["import", "-silent", "-window", "root", "-colors", "256", f"png8:{PICTURE}"], check=True,
                   env={**os.environ, **environment}, timeout=PATIENCE_S)
    PROCESSES.end(p)
    PROCESSES.end(xvfb, signal.SIGTERM)
    check(complaints < 50, f"{complaints} pixels of a status in red or orange")
    logs = [text_of(p)] + [f.read_text(errors="replace") for f in (BUILD / "home/log").glob("**/rviz-*.log")]
    bad = [line for log in logs for line in log.splitlines() if "[ERROR]" in line or "[FATAL]" in line
           or "[ERROR/" in line or "has died" in line]
    check(not bad, f"its log: {bad[:3]}")
    check(PICTURE.stat().st_size <= 300_000, f"the picture has {PICTURE.stat().st_size} bytes")


CHECKS = [the_documentation_builds_as_install_md, neighbours_of_a_ring_are_neighbours,
          rings_follow_the_number_of_lines, eyes_have_topics_of_their_own, two_sensors_have_topics_of_their_own,
          capture_is_lumdumps, rough_capture_is_lumdumps, calibration_is_used,
          what_a_capture_has_of_its_own_is_warned_of, sensors_of_one_address_are_told_apart,
          another_port_is_told_and_can_be_chosen, parameters_hold_a_calibration,
          bag_is_the_capture, bag_launch_plays_a_bag, live_sensor, live_recording, laser_is_safe, a_laser_by_command_is_the_nodes,
          a_command_to_be_off_holds, two_nodes_cannot_own_a_sensor, a_moved_sensor_is_named,
          a_second_signal_ends_a_long_laser_off, bad_parameters_are_told, rviz_shows_the_cloud]


def main():
    passed = failed = 0
    chosen = [c for c in CHECKS if len(sys.argv) < 4 or c.__name__ in sys.argv[3:]]
    signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored by what a shell runs in the background
    uri = f"http://127.0.0.1:{PORT}"
    os.environ["ROS_MASTER_URI"] = uri
    core = PROCESSES.start("roscore", "-p", PORT)
    try:
        wait_until(lambda: rosgraph.is_master_online(uri), "roscore")
        rospy.init_node("check", disable_signals=True)
        for each in chosen:
            began = time.monotonic()
            try:
                each()
                passed += 1
                print(f"ok {each.__name__} ({time.monotonic() - began:.1f} s)", flush=True)
            except (Failure, subprocess.SubprocessError, OSError, LookupError, ValueError) as e:
                failed += 1
                print(f"FAIL {each.__name__}: {type(e).__name__}: {e}", flush=True)
            finally:
                PROCESSES.end_all(but=[core])
    finally:
        rospy.signal_shutdown("done")
        PROCESSES.end_all()
    print(f"{passed} passed, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
