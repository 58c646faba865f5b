"""What tests of live tools share: a sensor to talk to, its log, processes that end with their test, and hosts of their
own in network namespaces."""
import json
import os
import pathlib
import select
import shutil
import signal
import subprocess
import time
import unittest

import support

HERE = pathlib.Path(__file__).resolve().parent


def inside(namespace):
    """What runs a command in a network namespace. `ip netns exec` and `ip -n` would also mount /sys anew, for which the root
    has to be a mount point; that of a plain chroot is none."""
    return ["nsenter", f"--net=/run/netns/{namespace}"]


def why_no_namespaces():
    """What is in the way of network namespaces here, or None."""
    if os.geteuid() != 0 or not all(map(shutil.which, ("ip", "nsenter"))):
        return "network namespaces need root, iproute2 and util-linux"
    name = f"lum-try-{os.getpid()}"
    tried = (["ip", "netns", "add", name], [*inside(name), "true"], ["ip", "netns", "del", name])
    done = [subprocess.run(c, capture_output=True, text=True, timeout=support.PATIENCE_S) for c in tried]
    failed = [r.stderr.strip() for r in done if r.returncode != 0]
    return f"network namespaces cannot be made here: {'; '.join(failed)}" if failed else None


NO_NAMESPACES = why_no_namespaces()
needs_namespaces = unittest.skipIf(NO_NAMESPACES, NO_NAMESPACES)


def wait_until(condition, what="it"):
    """Poll for something that has to come; how long it takes is not what is tested."""
    end = time.monotonic() + support.PATIENCE_S
    while time.monotonic() < end:
        value = condition()
        if value:
            return value
        time.sleep(0.02)
    raise AssertionError(f"{what} did not come in {support.PATIENCE_S} s")


class Process:
    """A program that runs beside the test, in a namespace or not; its output goes to files."""

    def __init__(self, test, folder, *command, namespace=None, name=None, stdin=subprocess.DEVNULL, stdout=None):
        self.name = name or pathlib.Path(str(command[0])).name
        self.out = folder / f"{self.name}-{id(self)}.out"
        self.err = folder / f"{self.name}-{id(self)}.err"
        prefix = inside(namespace) if namespace else []
        with open(self.out, "wb") as out, open(self.err, "wb") as err:
            self.p = subprocess.Popen(prefix + [str(c) for c in command], stdin=stdin, stdout=stdout or out, stderr=err)
        test.addCleanup(self.kill)

    def stdout(self):
        return self.out.read_text(errors="replace")

    def stderr(self):
        return self.err.read_text(errors="replace")

    def send(self, number):
        self.p.send_signal(number)

    def wait(self):
        try:
            return self.p.wait(support.PATIENCE_S)
        except subprocess.TimeoutExpired:
            raise AssertionError(f"{self.name} does not end: {self.stderr()[-500:]}") from None

    def end(self, number=signal.SIGTERM):
        """Ask to end; its exit status."""
        if self.p.poll() is None:
            self.p.send_signal(number)
        return self.wait()

    def kill(self):
        if self.p.poll() is None:
            self.p.send_signal(signal.SIGCONT)
            self.p.kill()
            self.p.wait()
        if self.p.stdin:
            self.p.stdin.close()


def tool(test, folder, name, *arguments, **options):
    return Process(test, folder, support.BIN / name, *arguments, **options)


class Sensor(Process):
    """lumsim on the network, and what its log says. Where it is not itself under test, LUM_SENSOR_BIN may have a faster
    build of it."""

    folder_of_tool = pathlib.Path(os.environ.get("LUM_SENSOR_BIN", support.BIN)).resolve()

    def __init__(self, test, folder, *arguments, address="127.0.0.1", namespace=None):
        self.log_path = folder / f"sensor-{id(self)}.log"
        self.address = address
        ready = "start" if "--replay" in arguments else "frames"
        super().__init__(test, folder, self.folder_of_tool / "lumsim", "--address", address, "--log", self.log_path, *arguments,
                         namespace=namespace)
        wait_until(lambda: self.p.poll() is not None or self.events(ready), "lumsim")
        if self.p.poll() is not None:
            raise AssertionError(f"lumsim ended: {self.stderr()}")

    def log(self):
        text = self.log_path.read_text() if self.log_path.exists() else ""
        return [json.loads(line) for line in text.splitlines(True) if line.endswith("\n")]

    def events(self, kind, after=0.0):
        return [e for e in self.log() if e["event"] == kind and e["t"] > after]

    def cue(self, number):
        """A fault that waits for this signal happens: SIGUSR1 or SIGUSR2. Its event."""
        before = len(self.events("fault"))
        self.send(number)
        return wait_until(lambda: self.events("fault")[before:], "the fault")[0]

    def laser_is_up(self):
        changes = self.events("laser")
        return bool(changes) and changes[-1]["up"]


class Hosts:
    """Two hosts and the wire between them: a client at 10.42.0.1 and a sensor at 10.42.0.37, each in a namespace of its
    own."""

    def __init__(self, test, folder):
        self.test, self.folder = test, folder
        tag = f"lum{os.getpid()}x{id(self) % 100000}"
        self.client, self.sensor = tag + "c", tag + "s"
        test.addCleanup(self.remove)
        for name in (self.client, self.sensor):
            self.ip("netns", "add", name)
        self.ip("link", "add", "eth0", "netns", self.client, "type", "veth", "peer", "name", "eth0", "netns", self.sensor)
        for name, address in ((self.client, "10.42.0.1/24"), (self.sensor, "10.42.0.37/24")):
            self.ip("-n", name, "addr", "add", address, "dev", "eth0")
            self.ip("-n", name, "link", "set", "lo", "up")
            self.ip("-n", name, "link", "set", "eth0", "up")
        for name in (self.client, self.sensor):
            wait_until(lambda name=name: "LOWER_UP" in self.ip("-n", name, "link", "show", "eth0"), "the link")

    @staticmethod
    def ip(*arguments):
        """ip, on a host with -n NAMESPACE in front."""
        host = []
        if arguments[0] == "-n":
            host, arguments = inside(arguments[1]), arguments[2:]
        r = subprocess.run([*host, "ip", *arguments], capture_output=True, text=True, timeout=support.PATIENCE_S)
        if r.returncode != 0:
            raise AssertionError(f"ip {' '.join(arguments)}: {r.stderr.strip()}")
        return r.stdout

    @classmethod
    def mac(cls, name):
        """The hardware address of a host's eth0. /sys would have that of this host's own."""
        return json.loads(cls.ip("-n", name, "-json", "link", "show", "eth0"))[0]["address"]

    def remove(self):
        for name in (self.client, self.sensor):
            subprocess.run(["ip", "netns", "del", name], capture_output=True, timeout=support.PATIENCE_S)

    def run(self, name, *arguments):
        """A tool on the client's host, to its end."""
        r = subprocess.run([*inside(self.client), str(support.BIN / name), *map(str, arguments)],
                           capture_output=True, text=True, timeout=support.PATIENCE_S, stdin=subprocess.DEVNULL)
        return r

    def start(self, name, *arguments, **options):
        """A tool on the client's host, beside the test."""
        return Process(self.test, self.folder, support.BIN / name, *arguments, namespace=self.client, **options)


def readable(stream, seconds):
    return bool(select.select([stream], [], [], seconds)[0])
