"""What the tool tests share: running the tools, and captures made by hand."""
import atexit
import contextlib
import csv
import gc
import json
import os
import pathlib
import signal
import struct
import subprocess
import tempfile
import threading
import time

BIN = pathlib.Path(os.environ.get("LUM_BIN", "build/bin")).resolve()
MAGIC = bytes.fromhex("edfef3a1efbe3412")
SENSOR = "10.42.0.37"
CLIENT = "10.42.0.1"

# For what has to come. It only ends a test that hangs: a busy machine, an instrument or an emulator may be slow.
PATIENCE_S = 300.0

# Tests hold millions of numbers and make few circles; to look for them again and again takes a third of the time.
gc.disable()

# Names that no host has are looked up: where no server answers, for a second.
os.environ.setdefault("RES_OPTIONS", "timeout:1 attempts:1")

# What runs beside a shell, or under nohup, ignores signals, and so would the programs that a test starts and signals.
for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT):
    if signal.getsignal(number) == signal.SIG_IGN:
        signal.signal(number, signal.SIG_DFL)

# What tools remember between runs goes to a folder of the test's own, never to the user's home.
STATE = tempfile.TemporaryDirectory()
atexit.register(STATE.cleanup)
os.environ["XDG_STATE_HOME"] = STATE.name


def run(tool, *arguments, stdin=b"", timeout=PATIENCE_S, **options):
    """Run a tool to its end; its output as text."""
    r = subprocess.run([str(BIN / tool), *map(str, arguments)], input=stdin,
                       capture_output=True, timeout=timeout, **options)
    r.stdout_bytes = r.stdout
    r.stdout = r.stdout.decode(errors="replace")
    r.stderr = r.stderr.decode(errors="replace")
    return r


@contextlib.contextmanager
def limited(*processes):
    """While something is waited for that only the end of programs ends: those that hang, or whose test fails, are killed."""
    def kill():
        for process in processes:
            process.kill()
    timer = threading.Timer(PATIENCE_S, kill)
    timer.start()
    try:
        yield
    except BaseException:
        kill()
        raise
    finally:
        timer.cancel()


def signal_and_see(process, number):
    """Send a signal to a running program and return once it has taken it. Of two that wait to be taken, one is lost."""
    process.send_signal(number)
    end = time.monotonic() + PATIENCE_S
    while process.poll() is None:
        if time.monotonic() > end:
            raise AssertionError(f"signal {number} is not taken")
        try:
            status = pathlib.Path(f"/proc/{process.pid}/status").read_text()
        except OSError:
            return  # it has just ended
        pending = [int(line.split()[1], 16) for line in status.splitlines() if line.startswith(("SigPnd", "ShdPnd"))]
        if not any(bits >> (number - 1) & 1 for bits in pending):
            return
        time.sleep(0.001)


def ip(address):
    return bytes(int(part) for part in address.split("."))


def block(kind, body, order="<"):
    """Of a pcapng file, as are the next three."""
    size = struct.pack(order + "I", len(body) + 12)
    return struct.pack(order + "I", kind) + size + body + size


def section(order="<"):
    return block(0x0A0D0D0A, struct.pack(order + "IHHq", 0x1A2B3C4D, 1, 0, -1), order)


def interface(link=1, order="<", name=b""):
    option = struct.pack(order + "HH", 2, len(name)) + name + bytes(-len(name) % 4) if name else b""
    return block(1, struct.pack(order + "HHI", link, 0, 0) + option, order)


def packet(frame, index=0, us=1_700_000_000_000_000, order="<"):
    fields = struct.pack(order + "IIIII", index, us >> 32, us & 0xFFFFFFFF, len(frame), len(frame))
    return block(6, fields + frame + bytes(-len(frame) % 4), order)


def udp(payload, source=SENSOR, destination=CLIENT, sport=5517, dport=50000):
    """An Ethernet frame with a UDP datagram."""
    segment = struct.pack(">HHHH", sport, dport, 8 + len(payload), 0) + payload
    header = struct.pack(">BBHHHBBH", 0x45, 0, 20 + len(segment), 1, 0, 64, 17, 0)
    return bytes(12) + b"\x08\x00" + header + ip(source) + ip(destination) + segment


def pcap(frames, link=1, snap=None, start=1_700_000_000.0, step=0.001):
    """A pcap file of frames, a millisecond apart."""
    out = [struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 65535, link)]
    for i, frame in enumerate(frames):
        kept = frame if snap is None else frame[:snap]
        t = start + i * step
        out.append(struct.pack("<IIII", int(t), int(round(t % 1 * 1e6)), len(kept), len(frame)) + kept)
    return b"".join(out)


def frames_of(data):
    """The frames of a little-endian pcap file."""
    at = 24
    while at < len(data):
        length = struct.unpack_from("<I", data, at + 8)[0]
        yield data[at + 16:at + 16 + length]
        at += 16 + length


def group(tag, eye, line, samples, first=0, clock=1000, packet_type=8):
    """A data packet of the default layout; samples are 4 bytes each."""
    return (MAGIC + struct.pack("<IBBHHHI", packet_type, tag, eye, line, len(samples), first, clock)
            + b"".join(samples))


def angles(eye=0, line=0, clock=1000):
    """The three angle packets of a line that looks straight ahead."""
    for first, count in ((0, 334), (334, 334), (668, 332)):
        samples = [struct.pack("<hh", 0, 0)] * count
        yield group(2, eye, line, samples, first, clock)


def word(tof, pixel, rising=True):
    return struct.pack("<I", (tof & 0xFFFFF) << 12 | (1024 if rising else 0) | pixel)


def line(words, eye=0, number=0, clock=1000):
    """All packets of a line."""
    yield from angles(eye, number, clock)
    yield group(3, eye, number, words, 0, clock)


def read_csv(path):
    with open(path, newline="") as f:
        return list(csv.DictReader(f))


def summary(*arguments):
    """lumdump's JSON summary."""
    r = run("lumdump", *arguments, "--json")
    if r.returncode != 0:
        raise AssertionError(f"lumdump {arguments}: {r.returncode} {r.stderr}")
    return json.loads(r.stdout)


def simulate(path, *arguments):
    r = run("lumsim", "-o", path, "--quiet", *arguments)
    if r.returncode != 0:
        raise AssertionError(f"lumsim {arguments}: {r.returncode} {r.stderr}")
    return path


def small_disk(test, path, size):
    """A disk of this size, such as 64k, until the test is done; where none can be made the test is skipped."""
    path.mkdir()
    mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", path], capture_output=True, text=True)
    if mounted.returncode != 0:
        test.skipTest(f"no small disk can be made here: {mounted.stderr.strip()}")
    test.addCleanup(subprocess.run, ["umount", path], check=True)
    return path


class Folder:
    """A folder that goes when the test is done."""

    def __init__(self, test):
        folder = tempfile.TemporaryDirectory()
        test.addCleanup(folder.cleanup)
        self.path = pathlib.Path(folder.name)

    def __truediv__(self, name):
        return self.path / name

    def write(self, name, data):
        path = self.path / name
        path.write_bytes(data.encode() if isinstance(data, str) else data)
        return path

    def names(self):
        return sorted(p.name for p in self.path.iterdir())
