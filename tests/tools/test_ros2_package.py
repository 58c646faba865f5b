#!/usr/bin/env python3
"""tools/ros2: the pipe of lumdump and a stand-in for lumros2, which ends as a whole; launch files, by a stand-in for launch;
the layout for Foxglove."""
import importlib.util
import itertools
import json
import os
import pathlib
import re
import signal
import subprocess
import sys
import types
import unittest

import shards
import yaml
from live import Sensor, wait_until
from mcap_file import File
from support import BIN, Folder, PATIENCE_S

TOP = pathlib.Path(__file__).resolve().parents[2]
PACKAGE = TOP / "tools/ros2/lumsdk_ros2"
STREAM = PACKAGE / "scripts/lumsdk_stream"
ADDRESSES = (f"127.23.0.{i}" for i in itertools.count(1))

# Keeps what comes, and its arguments; ends with the stream.
STAND_IN = """#!/bin/sh
printf '%s\\n' "$@" > "$0.arguments"
echo $$ > "$0.pid"
exec cat > "$0.mcap"
"""


class Pipe(unittest.TestCase):
    def setUp(self):
        self.folder = Folder(self)
        self.address = next(ADDRESSES)
        self.sensor = Sensor(self, self.folder, "--frames", "2", address=self.address)
        self.reader = self.folder / "lumros2"
        self.reader.write_text(STAND_IN)
        self.reader.chmod(0o755)
        (self.folder / "lumdump").symlink_to(BIN / "lumdump")

    def start(self, *words):
        environment = dict(os.environ, PATH=f"{self.folder.path}:/usr/bin:/bin")
        p = subprocess.Popen([sys.executable, STREAM, PACKAGE / "config/sensor.yaml", f"address={self.address}", *words],
                             env=environment, stderr=subprocess.PIPE, text=True)
        self.addCleanup(p.stderr.close)
        self.addCleanup(p.wait)
        self.addCleanup(p.kill)
        return p

    def until_clouds(self):
        out = self.folder / "lumros2.mcap"
        wait_until(lambda: out.exists() and out.stat().st_size > 8 and self.received().of("/points"), "a cloud")

    def received(self):
        return File((self.folder / "lumros2.mcap").read_bytes())

    def until_off(self):
        wait_until(lambda: not self.sensor.laser_is_up(), "the laser to go off")

    def test_ctrl_c_gives_all_of_it(self):
        p = self.start("namespace=front", "frame_id=front", "qos={points: sensor}", "remap={points: /lidar}", f"record={self.folder / 'a.pcap'}")
        self.until_clouds()
        p.send_signal(signal.SIGINT)
        self.assertEqual(p.wait(PATIENCE_S), 0, p.stderr.read())
        self.until_off()
        file = self.received()
        self.assertTrue(file.is_whole)
        self.assertIn(b"front_blue\0", file.of("/tf_static")[0].data)
        self.assertGreater((self.folder / "a.pcap").stat().st_size, 1000)
        self.assertEqual((self.folder / "lumros2.arguments").read_text().split(),
                         ["-", "--quiet", "--namespace", "front", "--depth", "5", "--qos", "points=sensor", "--remap",
                          "points:=/lidar"])

    def test_a_sensor_of_a_rig_has_its_own_topic_and_place(self):
        rig = self.folder.write("rig.yaml", f"version: 1\nsensors:\n  - {{name: front, address: {self.address}, pose: {{x_m: 1}}}}\n"
                                            "  - {name: left, address: 127.23.9.9}\n")
        p = self.start(f"rig={rig}")
        out = self.folder / "lumros2.mcap"
        wait_until(lambda: out.exists() and out.stat().st_size > 8 and self.received().of("/front/points"), "a cloud")
        p.send_signal(signal.SIGINT)
        self.assertEqual(p.wait(PATIENCE_S), 0, p.stderr.read())
        data = self.received().of("/tf_static")[0].data
        for name in (b"base_link\0", b"front\0", b"front_blue\0"):
            self.assertIn(name, data)
        self.assertNotIn(b"left", data)

    def test_what_a_rig_has_already_is_refused(self):
        rig = self.folder.write("rig.yaml", f"version: 1\nsensors:\n  - {{name: front, address: {self.address}}}\n")
        p = self.start(f"rig={rig}", f"calibration={rig}")
        self.assertNotEqual(p.wait(PATIENCE_S), 0)
        self.assertIn("--calibration does not go with --rig", str(p.stderr.read()))

    def test_a_reader_that_dies_ends_it(self):
        p = self.start()
        self.until_clouds()
        os.kill(int((self.folder / "lumros2.pid").read_text()), signal.SIGKILL)
        self.assertNotEqual(p.wait(PATIENCE_S), 0)
        self.assertIn("lumros2 ended with status -9", p.stderr.read())
        self.until_off()

    def test_it_is_killed_and_the_laser_goes_off(self):
        p = self.start()
        self.until_clouds()
        p.kill()
        p.wait()
        self.until_off()
        wait_until(lambda: self.received().is_whole, "the end of the stream")

    def test_what_cannot_be_started_is_told(self):
        self.reader.unlink()
        p = self.start()
        self.assertEqual(p.wait(PATIENCE_S), 2)
        self.assertIn("lumros2 cannot be started: No such file or directory; it belongs to lumsdk", p.stderr.read())
        self.until_off()

    def test_parameters_that_are_wrong_are_named(self):
        for word, says in (("lazer=true", "the parameter lazer is unknown"), ("depth=x", "depth is 'x'; it has to be of type int"),
                           ("address", "KEY=VALUE is needed"), ("depth=true", "of type int")):
            p = self.start(word)
            self.assertEqual(p.wait(PATIENCE_S), 2)
            self.assertIn(says, p.stderr.read())


class Thing:
    """Whatever launch has: remembers what it was made of."""

    def __init__(self, *given, **named):
        self.given, self.named = given, named

    def perform(self, context):
        return context[self.given[0]]


def launch_of(name):
    """The description of a launch file, with a launch that only remembers."""
    names = {"launch": ["LaunchDescription"], "launch.actions": ["DeclareLaunchArgument", "ExecuteProcess", "OpaqueFunction", "Shutdown"],
             "launch.conditions": ["IfCondition"], "launch.substitutions": ["LaunchConfiguration", "PathJoinSubstitution"],
             "launch_ros": [], "launch_ros.substitutions": ["FindPackagePrefix", "FindPackageShare"]}
    kinds = {}
    for module, classes in names.items():
        sys.modules[module] = types.ModuleType(module)
        for each in classes:
            kinds[each] = type(each, (Thing,), {})
            setattr(sys.modules[module], each, kinds[each])
    spec = importlib.util.spec_from_file_location(name.split(".", 1)[0], PACKAGE / "launch" / name)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.generate_launch_description().given[0], kinds


class Launch(unittest.TestCase):
    def test_a_sensor(self):
        actions, kinds = launch_of("sensor.launch.py")
        declared = [a.given[0] for a in actions if isinstance(a, kinds["DeclareLaunchArgument"])]
        stream, rviz = (a for a in actions if isinstance(a, kinds["ExecuteProcess"]))
        words = [w[0] for w in stream.named["cmd"][2:]]
        self.assertEqual([f"{name}=" for name in declared[2:]], words)
        known = yaml.safe_load((PACKAGE / "config/sensor.yaml").read_text())["/**"]["ros__parameters"]
        self.assertLessEqual({w[:-1] for w in words}, set(known))
        self.assertIsInstance(stream.named["on_exit"], kinds["Shutdown"])
        self.assertEqual(rviz.named["cmd"][0], "rviz2")

    def test_a_recording(self):
        actions, kinds = launch_of("play.launch.py")
        (play,) = (a.given[0] if a.given else a.named["function"] for a in actions if isinstance(a, kinds["OpaqueFunction"]))
        values = {a.given[0]: a.named.get("default_value", "") for a in actions if isinstance(a, kinds["DeclareLaunchArgument"])}
        (process,) = play(values | {"file": "drive.mcap"})
        self.assertEqual(process.named["cmd"], ["lumros2", "drive.mcap", "--rate", "1"])
        (process,) = play(values | {"file": "a.mcap", "namespace": "front", "loop": "true"})
        self.assertEqual(process.named["cmd"], ["lumros2", "a.mcap", "--rate", "1", "--namespace", "front", "--loop"])


class Files(unittest.TestCase):
    def test_parameters_are_those_that_the_stream_knows(self):
        known = re.search(r"KEYS = \{(.*?)\n\}", STREAM.read_text(), re.S).group(1)
        said = yaml.safe_load((PACKAGE / "config/sensor.yaml").read_text())["/**"]["ros__parameters"]
        self.assertEqual(set(re.findall(r'"(\w+)":', known)) - {"domain"}, set(said))

    def test_layouts_name_topics_and_frames_that_there_are(self):
        topics = set(re.findall(r'\{"(/\w+)",\s*"\w+/msg', (TOP / "src/cloud/ros_messages.c").read_text()))
        self.assertIn("/points", topics)
        layout = json.loads((TOP / "tools/ros2/foxglove.json").read_text())
        panels = set(layout["configById"])
        self.assertEqual(panels, set(re.findall(r'"(\w+!lumsdk)"', json.dumps(layout["layout"]))))
        named = set(re.findall(r'"(/\w+)"', json.dumps(layout)))
        self.assertTrue(named and named <= topics, named)
        rviz = yaml.safe_load((PACKAGE / "rviz/luminar.rviz").read_text())["Visualization Manager"]
        self.assertEqual(rviz["Global Options"]["Fixed Frame"], "luminar")
        self.assertLessEqual({d["Topic"]["Value"] for d in rviz["Displays"] if "Topic" in d}, topics)

    def test_the_package_names_what_is_there(self):
        cmake = (PACKAGE / "CMakeLists.txt").read_text()
        for name in re.search(r"DIRECTORY ([\w ]+) DESTINATION", cmake).group(1).split():
            self.assertTrue((PACKAGE / name).is_dir())
        self.assertIn("<name>lumsdk_ros2</name>", (PACKAGE / "package.xml").read_text())


if __name__ == "__main__":
    shards.main()
