"""A sensor at full load into a recording: what was sent, what came, what each process took."""
import json
import os
import pathlib
import signal
import subprocess
import threading
import time

from support import PATIENCE_S

TICKS = os.sysconf("SC_CLK_TCK")


def cpu_seconds(pid):
    fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / TICKS


def last(path, event):
    """The last event of a kind in the sensor's log, or None."""
    text = path.read_text() if path.exists() else ""
    events = [json.loads(line) for line in text.splitlines(True) if line.endswith("\n")]
    return next((e for e in reversed(events) if e["event"] == event), None)


def wait_for(path, event, process):
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end and process.poll() is None:
        found = last(path, event)
        if found:
            return found
        time.sleep(0.05)
    raise RuntimeError(f"no {event} from the sensor: {process.poll()}")


def count_skipped(path):
    """Lines that the sensor left out, as far as its log tells."""
    text = path.read_text() if path.exists() else ""
    events = [json.loads(line) for line in text.splitlines(True) if line.endswith("\n")]
    return sum(e["lines"] for e in events if e["event"] == "skipped")


class Sweeper(threading.Thread):
    """Removes the files of a rotated recording, except for the newest few, so that a long one fits on the disk.
    Bit by bit: to remove a large file at once may keep a core in the kernel for longer than a receive buffer lasts."""

    KEPT = 3
    PERIOD_S = 0.5
    STEP = 16 << 20
    STEP_S = 0.005

    def __init__(self, folder):
        super().__init__(daemon=True)
        self.folder = folder
        self.over = threading.Event()

    def run(self):
        while not self.over.wait(self.PERIOD_S):
            for path in sorted(self.folder.glob("load-*.pcap"))[:-self.KEPT]:
                for size in range(path.stat().st_size, 0, -self.STEP):
                    os.truncate(path, size)
                    time.sleep(self.STEP_S)
                path.unlink()

    def end(self):
        self.over.set()
        self.join()


def is_accounted_for(r):
    """Whether what was received and what was dropped is what was sent, as far as the drops are known."""
    missing = r["sent"] - r["received"] - r["kernel_drops"]
    return missing == 0 or (r["at_least"] and missing > 0)


def drops_of(pid):
    """Datagrams that the kernel has dropped of a process's sockets."""
    links = [os.readlink(path) for path in pathlib.Path(f"/proc/{pid}/fd").iterdir()]
    inodes = {link[len("socket:["):-1] for link in links if link.startswith("socket:[")}
    rows = [line.split() for line in pathlib.Path("/proc/net/udp").read_text().splitlines()[1:]]
    return sum(int(row[-1]) for row in rows if row[9] in inodes)


def stop_until_dropped(process):
    """Stop a program until datagrams were dropped, each time for less than the 3 s after which a sensor turns its laser off."""
    end = time.monotonic() + PATIENCE_S
    while drops_of(process.pid) == 0 and time.monotonic() < end:
        process.send_signal(signal.SIGSTOP)
        again = time.monotonic() + 2
        while drops_of(process.pid) == 0 and time.monotonic() < again:
            time.sleep(0.01)
        process.send_signal(signal.SIGCONT)
        time.sleep(1)


def run(bin_dir, folder, seconds, rate, lines=640, address="127.40.0.1", outputs=("load.pcap",), stalls=(), buffer=None, drops=False, rotate=None,
        receive_buffer=None):
    """Stream for so long; a dict of counts and shares of CPU. The sensor ends first, so that all it sent has come.
    stalls: outputs, before the others, that a reader opens and never reads.
    rotate: the recording goes on in another file after so much; only the newest stay.
    drops: at the end lumdump is stopped until the kernel has dropped what it has no room for."""
    folder = pathlib.Path(folder)
    readers = []
    for name in stalls:
        os.mkfifo(folder / name)
        readers.append(os.open(folder / name, os.O_RDONLY | os.O_NONBLOCK))
    log = folder / "load.log"
    log.unlink(missing_ok=True)
    sensor = subprocess.Popen([bin_dir / "lumsim", "--address", address, "--lines", str(lines), "--rate", str(rate),
                               "--frames", "3", "--joined", "--log", log, "-q"], stdin=subprocess.DEVNULL, stderr=subprocess.PIPE)
    dump = None
    sweeper = Sweeper(folder)
    sweeper.start()
    try:
        wait_for(log, "frames", sensor)
        arguments = [bin_dir / "lumdump", f"udp://{address}", "--laser", "--json"]
        arguments += ["--buffer", buffer] if buffer else []
        arguments += ["--receive-buffer", receive_buffer] if receive_buffer else []
        arguments += ["--rotate", rotate] if rotate else []
        for output in (*stalls, *outputs):
            arguments += ["-o", folder / output]
        dump = subprocess.Popen(arguments, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        wait_for(log, "stream", sensor)
        time.sleep(4)  # until the laser is warm and its returns have come to full strength
        skipped = count_skipped(log)
        before = [cpu_seconds(p.pid) for p in (sensor, dump)]
        began = time.monotonic()
        time.sleep(seconds)
        after = [cpu_seconds(p.pid) for p in (sensor, dump)]
        wall = time.monotonic() - began
        if drops:
            stop_until_dropped(dump)
        sensor.send_signal(signal.SIGTERM)
        sensor.wait(PATIENCE_S)
        stop, stream = last(log, "stop"), last(log, "stream")
        time.sleep(0.5)
        dump.send_signal(signal.SIGINT)
        out, err = dump.communicate(timeout=PATIENCE_S)
    finally:
        sweeper.end()
        for p in (sensor, dump):
            if p is not None and p.poll() is None:
                p.kill()
                p.wait()
        sensor.stderr.close()
        for reader in readers:
            os.close(reader)
    live = json.loads(out)
    return {"sent": stop["packets"] + stop["answers"], "skipped": stop["lines_skipped"] - skipped, "received": live["received"],
            "kernel_drops": live["kernel_drops"], "at_least": live["kernel_drops_at_least"], "ring_drops": live["ring_drops"],
            "recording_drops": live["recording_drops"], "stderr": err,
            "sensor_cpu": (after[0] - before[0]) / wall, "dump_cpu": (after[1] - before[1]) / wall, "live": live,
            "streamed_s": stop["t"] - stream["t"]}
