#!/usr/bin/env python3
"""lumctl shell, from a pipe and at a terminal."""
import json
import os
import pty
import re
import signal
import subprocess
import unittest

import shards
from live import Process, Sensor, readable, wait_until
from support import BIN, PATIENCE_S, Folder, run
from test_lumctl import FakeSensor


class Pipe(unittest.TestCase):
    def setUp(self):
        self.folder = Folder(self)

    def sensor(self, last, *arguments):
        return Sensor(self, self.folder, "--rate", "2", *arguments, address=f"127.32.0.{last}")

    def shell(self, last, text, *arguments):
        return run("lumctl", "--host", f"127.32.0.{last}", "shell", *arguments, stdin=text.encode())

    def notes(self, sensor):
        return [word for e in sensor.events("tlv") for word in e.get("note", "").replace(";", " ").split()]

    def test_words_and_the_manuals_raw_text_are_carried_out(self):
        sensor = self.sensor(1)
        r = self.shell(1, "power 60\n# a remark\n\n50p\nsend '30g 40b'\n55p 20g")
        self.assertEqual(r.returncode, 0, r.stderr)
        for text in ("60p", "50p", "30g", "40b", "55p", "20g"):
            self.assertIn(text, self.notes(sensor))

    def test_quit_ends_it_and_what_follows_is_not_read(self):
        sensor = self.sensor(2)
        self.assertEqual(self.shell(2, "power 61\nquit\npower 62\n").returncode, 0)
        self.assertNotIn("62p", self.notes(sensor))

    def test_it_goes_on_after_a_wrong_line_and_ends_with_its_status(self):
        sensor = self.sensor(3)
        r = self.shell(3, "power 101\n101p\nnonsense\npower 63\n")
        self.assertEqual(r.returncode, 2)
        self.assertIn("101", r.stderr)
        self.assertIn("63p", self.notes(sensor))

    def test_a_typo_is_answered_by_its_own_help(self):
        self.sensor(13)
        r = self.shell(13, "nonsense\nqut\nOf\nstatus --zzzzzz\nstatus -x\nhelp nonsense\n")
        self.assertIn("'nonsense': no such command; help lists them", r.stderr)
        self.assertIn("did you mean quit?", r.stderr)
        self.assertIn("'Of' begins with the letter O, not the digit zero; did you mean 0f?", r.stderr)
        self.assertIn("no such option; see help", r.stderr)
        self.assertNotIn("lumctl --help", r.stderr)

    def test_who_leaves_it_after_a_typo_leaves_with_status_0(self):
        self.sensor(14)
        for end in ("quit", "exit"):
            self.assertEqual(self.shell(14, f"nonsense\npower 101\nstatus\n{end}\n").returncode, 0)
        self.assertEqual(self.shell(14, "nonsense\n").returncode, 2)
        r = self.shell(14, "nonsense\napply /nonexistent.yaml\nlaser on\nquit\n")
        self.assertEqual(r.returncode, 1, r.stderr)  # nobody sends heartbeats

    def test_help_of_one_command_is_that_of_the_command_line(self):
        self.sensor(11)
        r = self.shell(11, "help power\nhelp\n")
        self.assertEqual(r.returncode, 0, r.stderr)
        self.assertIn(run("lumctl", "help", "power").stdout, r.stdout)
        self.assertIn("Commands are those of the command line", r.stdout)

    def test_words_behind_quit_are_told(self):
        sensor = self.sensor(12)
        r = self.shell(12, "exit 3\nquit now\npower 66\n")
        self.assertEqual(r.returncode, 2)
        self.assertIn("exit: '3' is one word too many", r.stderr)
        self.assertIn("quit: 'now' is one word too many", r.stderr)
        self.assertIn("66p", self.notes(sensor))

    def test_options_of_a_line_hold_for_that_line_alone(self):
        sensor = self.sensor(4)
        r = self.shell(4, "power 64 --dry-run\npower 65\n")
        self.assertEqual(r.returncode, 0, r.stderr)
        self.assertIn("65p", self.notes(sensor))
        self.assertNotIn("64p", self.notes(sensor))

    def test_with_heartbeat_it_owns_the_sensor_and_leaves_the_laser_off(self):
        sensor = self.sensor(5)
        r = self.shell(5, "laser on\n", "--heartbeat")
        self.assertEqual(r.returncode, 0, r.stderr)
        changes = sensor.events("laser")
        self.assertTrue([e for e in changes if e["up"]])
        self.assertFalse(sensor.laser_is_up())

    def test_without_heartbeat_it_sends_none(self):
        sensor = self.sensor(6)
        self.assertEqual(self.shell(6, "status\n").returncode, 0)
        self.assertEqual(sensor.events("heartbeat"), [])

    def test_after_set_ip_it_names_the_new_address(self):
        self.sensor(8)
        r = self.shell(8, "set-ip 127.32.0.9\ndoctor --json\n")
        found = [json.loads(text) for text in r.stdout.splitlines() if text.startswith("{")]
        self.assertEqual([f["sensor"] for f in found], ["127.32.0.9"], r.stdout + r.stderr)

    def test_a_shell_that_keeps_a_sensor_alive_waits_for_no_resolver(self):
        """localhost stands for every name: some take seconds."""
        sensor = self.sensor(15)
        r = self.shell(15, "set-ip localhost\nset-ip --dry-run some.name\nstatus --host localhost\nstatus --host 127.32.0.15\n"
                           "status --host some.name:5517\n", "--heartbeat")
        self.assertEqual(r.returncode, 2)
        self.assertEqual(r.stderr.count("no name is looked up while this shell sends heartbeats"), 4, r.stderr)
        self.assertIn("hold for a whole shell", r.stderr)
        self.assertEqual(sensor.events("set_ip"), [])
        self.assertEqual(self.shell(15, "set-ip --dry-run localhost\n").returncode, 0)

    def test_its_own_session_without_heartbeats_is_a_hazard_and_its_end_switches_off_twice_signalled(self):
        """The sensor says that the laser is down, and only then up."""
        packets = []
        fake = FakeSensor(self, "127.32.0.10", lambda kind, sequence, body, count: packets.append(body) or [
            (0.3 if b"d" in body else 0, p) for p in FakeSensor.plain(kind, sequence, 0x0210)])
        p = Process(self, self.folder, BIN / "lumctl", "--host", "127.32.0.10", "shell", "--heartbeat", "--timeout", 2000,
                    stdin=subprocess.PIPE)
        p.p.stdin.write(b"status\n")
        p.p.stdin.flush()
        wait_until(lambda: "HAZARD" in p.stdout(), "a hazard")
        p.send(signal.SIGTERM)
        wait_until(fake.texts, "the command")
        p.send(signal.SIGTERM)
        self.assertNotEqual(p.wait(), 0)
        self.assertIn("the laser is off", p.stderr())

    def test_an_endless_line_and_binary_input_do_no_harm(self):
        self.sensor(7)
        r = self.shell(7, "x" * 100000 + "\n\x00\x01\xff\nstatus\n")
        self.assertEqual(r.returncode, 2)
        self.assertIn("2047", r.stderr)


class Terminal(unittest.TestCase):
    """At a pseudo-terminal, with whatever line editing was built in."""

    def setUp(self):
        self.folder = Folder(self)

    def start(self, last, *arguments, sensor=()):
        address = f"127.32.1.{last}"
        self.sensor = Sensor(self, self.folder, "--rate", "2", *sensor, address=address)
        master, slave = pty.openpty()
        self.addCleanup(os.close, master)
        environment = {**os.environ, "TERM": "vt100", "XDG_STATE_HOME": str(self.folder.path)}
        self.p = subprocess.Popen([str(BIN / "lumctl"), "--host", address, "shell", *arguments], stdin=slave, stdout=slave,
                                  stderr=slave, start_new_session=True, env=environment)
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
        self.start(3)
        self.type("power 5")
        self.expect("power 5")
        self.seen = ""
        self.p.send_signal(signal.SIGINT)
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
