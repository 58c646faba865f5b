#!/usr/bin/env python3
"""lumctl shell at a real terminal. From a pipe: tests/world/stories/shell.c."""
import fcntl
import os
import pty
import re
import signal
import subprocess
import termios
import unittest

import shards
from live import Sensor, readable, wait_until
from support import BIN, PATIENCE_S, Folder


class Terminal(unittest.TestCase):
    """At a pseudo-terminal."""

    def setUp(self):
        self.folder = Folder(self)

    def start(self, last, *arguments, sensor=(), before=None):
        address = f"127.32.1.{last}"
        self.sensor = Sensor(self, self.folder, "--rate", "2", *sensor, address=address)
        master, slave = pty.openpty()
        self.addCleanup(os.close, master)
        environment = {**os.environ, "TERM": "vt100", "XDG_STATE_HOME": str(self.folder.path)}
        self.p = subprocess.Popen([str(BIN / "lumctl"), "--host", address, "shell", *arguments], stdin=slave, stdout=slave,
                                  stderr=slave, start_new_session=True, env=environment, preexec_fn=before)
        os.close(slave)
        self.addCleanup(self.kill)
        self.master, self.seen = master, ""
        self.expect("lumctl>")

    def kill(self):
        if self.p.poll() is None:
            self.p.kill()
        self.p.wait()

    def read(self):
        while readable(self.master, 0.05):
            try:
                data = os.read(self.master, 4096)
            except OSError:
                return self.seen
            if not data:
                break
            self.seen += re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", data.decode(errors="replace"))
        return self.seen

    def expect(self, text):
        wait_until(lambda: text in self.read(), f"{text!r} in {self.seen[-300:]!r}")

    def type(self, text):
        self.seen = ""
        os.write(self.master, text.encode())

    def test_a_command_shows_its_outcome_and_a_prompt_again(self):
        self.start(1)
        self.type("power 50\r")
        self.expect("lumctl>")
        wait_until(lambda: [e for e in self.sensor.events("tlv") if "50p" in e.get("note", "")], "the command")
        self.type("quit\r")
        self.assertEqual(self.p.wait(PATIENCE_S), 0)

    def test_a_status_that_changes_appears_above_the_prompt(self):
        self.start(2, sensor=["--fault", "fan@USR1"])
        self.sensor.cue(signal.SIGUSR1)
        self.expect("FAN_PWM_BAD")
        self.type("\x04")
        self.assertEqual(self.p.wait(PATIENCE_S), 0)

    def test_ctrl_c_takes_back_the_line_and_not_the_shell(self):
        # the session's own terminal: its key is a signal, and takes back what it holds
        self.start(3, before=lambda: fcntl.ioctl(0, termios.TIOCSCTTY, 0))
        self.type("power 5")
        self.expect("power 5")
        self.type("\x03")
        self.expect("lumctl>")
        self.type("6p\r")
        wait_until(lambda: [e for e in self.sensor.events("tlv") if e.get("note") == "6p"], "the command")
        self.assertIsNone(self.p.poll())
        self.type("exit\r")
        self.assertEqual(self.p.wait(PATIENCE_S), 0)

    def test_ctrl_c_ends_a_command_and_not_the_shell(self):
        self.start(4)
        self.type("status --watch\r")
        self.expect("laser down")
        self.p.send_signal(signal.SIGINT)
        self.expect("lumctl>")
        self.type("exit\r")
        self.assertEqual(self.p.wait(PATIENCE_S), 0)

    def test_what_follows_an_echoed_key_begins_a_line(self):
        self.start(6, "--heartbeat")
        self.type("status --watch\r")
        self.expect("laser down")
        self.type("\x03")  # echoed; no terminal of this session's turns it into a signal
        self.expect("^C")  # what it throws away with that is gone by then
        self.p.send_signal(signal.SIGINT)
        self.expect("lumctl>")
        self.assertNotRegex(self.seen, r"[^\r\n]lumctl>")
        self.type("\x04")
        self.expect("the laser is off")
        self.assertNotRegex(self.seen, r"[^\r\n]lumctl: the laser is off")
        self.assertEqual(self.p.wait(PATIENCE_S), 0)

    def test_sigterm_ends_it_and_the_laser(self):
        self.start(5, "--heartbeat")
        self.type("laser on\r")
        wait_until(self.sensor.laser_is_up, "the laser")
        self.p.send_signal(signal.SIGTERM)
        self.p.wait(PATIENCE_S)
        self.assertFalse(self.sensor.laser_is_up())


if __name__ == "__main__":
    shards.main()
