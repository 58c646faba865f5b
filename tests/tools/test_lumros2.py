#!/usr/bin/env python3
"""lumros2: its command line. What it publishes is read by tests/ros2."""
import os
import re
import unittest

from support import run


class Arguments(unittest.TestCase):
    def refused(self, *arguments, **environment):
        r = run("lumros2", *arguments, env={**os.environ, **environment})
        self.assertEqual(r.returncode, 2, r.stderr)
        self.assertEqual(r.stdout, "")
        self.assertTrue(r.stderr.startswith("lumros2: "), r.stderr)
        self.assertEqual(r.stderr.count("\n"), 1, r.stderr)
        return r.stderr

    def test_what_is_wrong_is_told(self):
        for arguments, text in (((), "an MCAP file is needed"), (("a.mcap", "b.mcap"), "'b.mcap': only one file"),
                                (("-", "--loop"), "standard input can be read only once"),
                                (("a", "--rate", "0.0001"), "--rate"), (("a", "--rate", "1001"), "--rate"),
                                (("a", "--rate", "-1"), "--rate"), (("a", "--domain", "233"), "--domain"),
                                (("a", "--depth", "0"), "--depth"), (("a", "--namespace", "a b"), "a namespace such as"),
                                (("a", "--remap", "points=cloud"), "FROM:=TO"), (("a", "--qos", "best"), "sensor, reliable"),
                                (("a", "--nothing"), "--nothing")):
            self.assertIn(text, self.refused(*arguments))

    def test_the_domain_of_the_environment_is_checked(self):
        for text in ("x", "-1", "233", "1 "):
            self.assertIn("ROS_DOMAIN_ID", self.refused("a.mcap", ROS_DOMAIN_ID=text))

    def test_a_file_that_is_not_there_needs_no_network(self):
        r = run("lumros2", "none.mcap", env={**os.environ, "CYCLONEDDS_URI": "<no xml"})
        self.assertEqual(r.returncode, 1, r.stderr)
        self.assertRegex(r.stderr, r"^lumros2: none\.mcap: cannot be opened: .*\n$")

    def test_help_and_version(self):
        text = run("lumros2", "--help").stdout
        self.assertEqual(run("lumros2", "-h").stdout, text)
        for line in text.splitlines():
            self.assertLessEqual(len(line), 80, line)
        for option in ("rate", "loop", "readers", "domain", "namespace", "remap", "qos", "depth", "quiet", "verbose"):
            self.assertRegex(text, rf"--{option}\b")
        self.assertRegex(run("lumros2", "--version").stdout, r"^lumros2 \d+\.\d+\.\d+\n$")
        self.assertTrue(re.search(r"Exit status: 0 done, 1 it failed, 2 bad", text))


if __name__ == "__main__":
    unittest.main()
