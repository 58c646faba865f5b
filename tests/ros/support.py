"""What the ROS checks share: processes that end with the run, results, clouds."""
import os
import pathlib
import signal
import socket
import struct
import subprocess
import time


class Failure(Exception):
    """A fact that does not hold."""


def check(fact, text):
    if not fact:
        raise Failure(text)


# For what has to come. It only ends a check that hangs: a busy machine may be slow.
PATIENCE_S = 300.0


def wait_until(condition, what):
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        value = condition()
        if value:
            return value
        time.sleep(0.05)
    raise Failure(f"{what} did not come in {PATIENCE_S} s")


def free_port():
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


def processes():
    """Of each process: its number, state, parent and group."""
    for stat in pathlib.Path("/proc").glob("[0-9]*/stat"):
        try:
            state, parent, group = stat.read_text().rpartition(")")[2].split()[:3]
        except OSError:
            continue
        yield int(stat.parent.name), state, int(parent), int(group)


def children_of(root):
    """All processes below one."""
    parents = {number: parent for number, _, parent, _ in processes()}
    found = [root]
    for each in found:
        found += [child for child, parent in parents.items() if parent == each]
    return found[1:]


def is_alive(group):
    """Not, when only zombies are left: who inherited them may never look."""
    return any(of == group and state not in "ZX" for _, state, _, of in processes())


class Processes:
    """Each in a group of its own, so that its children end with it."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        self.running = []
        self.count = 0

    def start(self, *command, name=None, environment=None, **options):
        self.count += 1
        name = name or pathlib.Path(str(command[0])).name
        log = self.folder / f"{self.count:02d}-{name}.log"
        with open(log, "wb") as out:
            p = subprocess.Popen([str(c) for c in command], stdin=subprocess.DEVNULL, stdout=out,
                                 stderr=subprocess.STDOUT, start_new_session=True,
                                 env={**os.environ, **(environment or {})}, **options)
        p.log, p.name = log, name
        self.running.append(p)
        return p

    def end(self, p, number=signal.SIGINT, group=False):
        """Ask to end, its children too where they do not hear it from it; its exit status."""
        if p.poll() is None:
            (os.killpg if group else os.kill)(p.pid, number)
        try:
            status = p.wait(PATIENCE_S)
        except subprocess.TimeoutExpired:
            raise Failure(f"{p.name} does not end: {tail(p)}") from None
        if group:
            wait_until(lambda: not is_alive(p.pid), f"the end of {p.name}'s children")
        self.sweep(p)
        return status

    def sweep(self, p):
        """Whatever is left of it: its children, some of which have groups of their own, and its group."""
        left = children_of(p.pid)
        for call, ids in ((os.kill, left), (os.killpg, [p.pid])):
            for each in ids:
                for number in (signal.SIGCONT, signal.SIGKILL):
                    try:
                        call(each, number)
                    except ProcessLookupError:
                        pass
        p.wait()
        if p in self.running:
            self.running.remove(p)

    def end_all(self, but=()):
        for p in reversed([p for p in self.running if p not in but]):
            try:
                self.end(p)
            except Failure:
                self.sweep(p)


def text_of(p):
    return p.log.read_text(errors="replace")


def tail(p):
    return text_of(p)[-600:]


POINT = struct.Struct("<fffffHBB")
FIELDS = [("x", 0, 7), ("y", 4, 7), ("z", 8, 7), ("intensity", 12, 7), ("time", 16, 7), ("ring", 20, 4),
          ("return", 22, 2), ("eye", 23, 2)]
NO_RING = 65535


def points_of(cloud):
    """x, y, z, intensity, time, ring, return, eye of each."""
    return list(POINT.iter_unpack(cloud.data))


def ns(stamp):
    return stamp.secs * 1_000_000_000 + stamp.nsecs


def check_form(cloud):
    """What holds for every cloud."""
    fields = [(f.name, f.offset, f.datatype) for f in cloud.fields]
    check(fields == FIELDS and all(f.count == 1 for f in cloud.fields), f"fields are {fields}")
    check((cloud.height, cloud.point_step) == (1, POINT.size), f"point_step is {cloud.point_step}")
    check(cloud.row_step == len(cloud.data) == cloud.width * POINT.size, "row_step, width and data do not agree")
    check(cloud.is_dense and not cloud.is_bigendian, "not dense, or big-endian")
    times = [p[4] for p in points_of(cloud)]
    check(not times or times[0] == 0.0, f"the first point is {times[:1]} s from the stamp")
    check(all(a <= b for a, b in zip(times, times[1:])), "not sorted by time")
    check(not times or times[-1] < 0.2, f"the last point is {times[-1:]} s from the stamp")


def units(value, scale):
    """As lumdump writes a float32: half a unit away from zero. Exact in a double."""
    n = int(abs(value) * scale + 0.5)
    return -n if value < 0 else n
