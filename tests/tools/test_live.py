#!/usr/bin/env python3
"""Hosts in namespaces, wherever the tests run: also where the root is no mount point of its own, as in a plain chroot."""
import os
import pathlib
import re
import signal
import subprocess
import sys
import unittest

from live import NO_NAMESPACES, Hosts, Sensor, needs_namespaces, wait_until
from support import PATIENCE_S, Folder, summary

HERE = pathlib.Path(__file__).resolve()


@needs_namespaces
class Namespaces(unittest.TestCase):
    def test_a_tool_on_one_host_reaches_a_sensor_on_another(self):
        folder = Folder(self)
        hosts = Hosts(self, folder)
        Sensor(self, folder, "--rate", "2", address="10.42.0.37", namespace=hosts.sensor)
        r = hosts.run("lumctl", "--host", "10.42.0.37", "status")
        self.assertEqual(r.returncode, 0, r.stderr)
        self.assertIn(hosts.mac(hosts.sensor), hosts.ip("-n", hosts.client, "neigh", "show", "10.42.0.37"))

    def test_a_recording_on_one_host_of_a_sensor_on_another(self):
        folder = Folder(self)
        hosts = Hosts(self, folder)
        sensor = Sensor(self, folder, "--rate", "2", address="10.42.0.37", namespace=hosts.sensor)
        raw = folder / "raw.pcap"
        dump = hosts.start("lumdump", "udp://10.42.0.37", "--laser", "-o", raw)
        wait_until(lambda: sensor.laser_is_up() and raw.exists() and raw.stat().st_size > 1_000_000, "data")
        self.assertEqual(dump.end(signal.SIGINT), 0, dump.stderr())
        self.assertFalse(sensor.laser_is_up())
        self.assertGreater(summary(raw)["points"], 1000)


class Tests(unittest.TestCase):
    def test_no_test_enters_one_by_a_command_that_a_chroot_refuses(self):
        entering = re.compile(r'"netns",\s*"exec"|"ip", "-n"|netns exec [^`]')
        wrong = [path.name for path in sorted(HERE.parents[1].rglob("*.py")) if path != HERE and entering.search(path.read_text())]
        self.assertEqual(wrong, [], "live.inside(), Hosts.ip() and Hosts.mac() do it")


def bind_all(root):
    """The folders of / below another, as a script: all but /run, where namespaces get their names."""
    for path in sorted(pathlib.Path("/").iterdir()):
        if path.is_symlink():
            (root / path.name).symlink_to(os.readlink(path))
        elif path.is_dir():
            (root / path.name).mkdir()
            if path.name not in ("run", "lost+found"):
                yield f"mount --rbind '{path}' '{root}{path}'"


PRIVATE = ["unshare", "--mount", "--propagation", "private"]


def can_mount_for_itself():
    """Whether what is mounted for a test stays out of everybody else's sight; not where the root is a plain chroot already."""
    return subprocess.run([*PRIVATE, "true"], capture_output=True).returncode == 0


@needs_namespaces
@unittest.skipUnless(NO_NAMESPACES or can_mount_for_itself(), "no mounts of its own here: this root may be a plain chroot itself")
class PlainChroot(unittest.TestCase):
    def test_tests_in_namespaces_run(self):
        root = Folder(self) / "root"
        root.mkdir()
        command = [sys.executable, "-B", str(HERE), "-v", "Namespaces.test_a_tool_on_one_host_reaches_a_sensor_on_another"]
        script = "\n".join(["set -e", *bind_all(root), f'exec chroot "{root}" "$@"'])
        r = subprocess.run([*PRIVATE, "sh", "-c", script, "sh", *command],
                           capture_output=True, text=True, timeout=PATIENCE_S)
        self.assertEqual(r.returncode, 0, r.stderr)
        self.assertIn("... ok", r.stderr)


if __name__ == "__main__":
    unittest.main()
