#!/usr/bin/env python3
"""measure.py BUILD_DIR [SECONDS [BUFFER]]: clouds of a street from lumros2 to a reader by Fast DDS: how many came, how old they
were when the reader could take them, and the processor time of each program. From a file, and from a sensor by a pipe.

BUFFER: bytes of the reader's sockets; without it, what the system gives.
"""
import os
import pathlib
import subprocess
import sys
import time

from check import BIN, CLOUD, FILES, PATIENCE_S, Program, Reader, messages_of, player

TICKS = os.sysconf("SC_CLK_TCK")
SECONDS = float(sys.argv[2]) if len(sys.argv) > 2 else 60.0
BUFFER = ("--buffer", sys.argv[3]) if len(sys.argv) > 3 else ()


def processor_s(program):
    words = pathlib.Path(f"/proc/{program.process.pid}/stat").read_text().rpartition(")")[2].split()
    return (int(words[11]) + int(words[12])) / TICKS


def udp_losses():
    """Datagrams that found a full receive buffer, in this network."""
    names, values = [line.split() for line in pathlib.Path("/proc/net/snmp").read_text().splitlines() if line.startswith("Udp:")]
    return int(values[names.index("RcvbufErrors")])


def watch(what, reader, programs):
    """Prints what happened in so many seconds, after the first samples."""
    reader.wait(5)
    begin = len(reader.samples())
    losses = udp_losses()
    before = {name: processor_s(p) for name, p in programs.items()}
    began = time.monotonic()
    time.sleep(SECONDS)
    seconds = time.monotonic() - began
    shares = {name: (processor_s(p) - before[name]) / seconds for name, p in programs.items()}
    samples = reader.samples()[begin:]
    ages = sorted(s["age_us"] / 1000 for s in samples)
    stamps = sorted(s["stamp_age_us"] / 1000 for s in samples)
    since = f"since its stamp {stamps[len(stamps) // 2]:.0f} ms at the median; " if "lumdump" in programs else ""
    sent = samples[-1]["sequence"] - samples[0]["sequence"] + 1
    size = sum(s["bytes"] for s in samples) / len(samples)
    print(f"{what}: {len(samples)} of {sent} clouds of {size / 1e6:.2f} MB ({size / 24 / 1000:.0f},000 points) in {seconds:.1f} s; "
          f"age: median {ages[len(ages) // 2]:.1f} ms, 90 % {ages[len(ages) * 9 // 10]:.1f}, 99 % {ages[len(ages) * 99 // 100]:.1f}, "
          f"most {ages[-1]:.1f}; {since}datagrams lost: {udp_losses() - losses}; "
          + ", ".join(f"{name} {100 * share:.0f} %" for name, share in shares.items()), flush=True)
    Program.end_all()


def recording(name, simulation, *options):
    capture = FILES.folder / f"{name}.pcap"
    path = FILES.folder / f"{name}.mcap"
    for words in ((BIN / "lumsim", "-q", "-o", capture, *simulation), (BIN / "lumdump", "-q", capture, "-o", path, *options)):
        subprocess.run([str(w) for w in words], check=True, timeout=PATIENCE_S)
    return path


def from_file(what, path):
    reader = Reader("rt/points", CLOUD, *BUFFER)
    played = player(path, "--loop", "--readers", 1)
    watch(f"{what}, {len(messages_of(path, '/points'))} frames again and again", reader, {"lumros2": played, "reader": reader})


def from_sensor(what, simulation, *options):
    sensor = Program(BIN / "lumsim", *simulation)
    reader = Reader("rt/points", CLOUD, *BUFFER)
    read_end, write_end = os.pipe()
    dump = Program(BIN / "lumdump", "udp://127.0.0.1", "--laser", "-o", "-", "--format", "mcap", *options, stdout=write_end,
                   env={**os.environ, "XDG_STATE_HOME": str(FILES.folder / "state")})
    play = Program(BIN / "lumros2", "-", stdin=read_end)
    os.close(read_end)
    os.close(write_end)
    watch(what, reader, {"lumsim": sensor, "lumdump": dump, "lumros2": play, "reader": reader})


def main():
    street = ("--frames", "20", "--seed", "3")
    from_file("file, plain", recording("plain", street, "--edge", "both", "--compression", "none"))
    from_file("file, zstd", recording("packed", street, "--edge", "both", "--compression", "zstd"))
    from_file("file, 640 lines at 2 Hz", recording("fine", ("--frames", "6", "--lines", "640", "--rate", "2"), "--compression", "none"))
    from_sensor("sensor, plain", (), "--edge", "both", "--compression", "none")
    from_sensor("sensor, zstd", (), "--edge", "both")
    from_sensor("sensor, 640 lines at 2 Hz", ("--lines", "640", "--rate", "2"), "--compression", "none")


if __name__ == "__main__":
    main()
