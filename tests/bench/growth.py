"""How the cost grows with length, lines, returns and sensors: instructions, which are repeatable, by callgrind."""
import json
import re
import shutil
import subprocess
import sys

# What is simulated: a title, and the options of lumsim of each sensor.
CASES = [("2 frames of 64 lines", [["--frames", "2"]]),
         ("8 frames", [["--frames", "8"]]),
         ("32 frames", [["--frames", "32"]]),
         ("2 frames of 640 lines", [["--frames", "2", "--lines", "640"]]),
         *((f"{n} returns a pixel at most", [["--frames", "4", "--returns-max", str(n)]]) for n in (1, 2, 4, 8)),
         *((f"{n} sensors, a capture each", [["--frames", "4", "--seed", str(i)] for i in range(n)]) for n in (2, 4))]

OUTPUTS = ("summary", []), ("PLY", ["--threads", "1", "-o"])


def count(command):
    """Instructions of a command."""
    done = subprocess.run(["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", *map(str, command)],
                          capture_output=True, text=True, check=False)
    found = re.search(r"Collected : (\d+)", done.stderr)
    if done.returncode != 0 or found is None:
        sys.exit(f"bench: {' '.join(map(str, command))}: {done.stderr}")
    return int(found.group(1))


def run(tools, folder):
    """Prints a row for each case: what a packet costs, and a point, without the start of the program."""
    if shutil.which("valgrind") is None:
        sys.exit("bench: --growth needs valgrind (Debian: valgrind)")
    nothing = folder / "nothing.pcap"
    subprocess.run([tools / "lumsim", "-o", nothing, "--frames", "1", "--loss", "1", "--quiet"], check=True)
    out = folder / "growth.ply"
    start = {name: count([tools / "lumdump", nothing, "--quiet", *options, *([out] if options else [])])
             for name, options in OUTPUTS}
    print(f"{'':34}{'packets':>9}{'points':>10}   {'instructions: a packet of a summary':>36}{'a point of a PLY':>18}")
    for title, sensors in CASES:
        captures = []
        for i, options in enumerate(sensors):
            captures.append(folder / f"sensor-{i}.pcap")
            subprocess.run([tools / "lumsim", "-o", captures[-1], "--address", f"10.42.0.{37 + i}", *options, "--quiet"], check=True)
        told = json.loads(subprocess.run([tools / "lumdump", *captures, "--json"], check=True, capture_output=True, text=True).stdout)
        packets = told["records"]
        points = sum(sensor["points"] for sensor in told["sensors"])
        cost = {name: count([tools / "lumdump", *captures, "--quiet", *options, *([out] if options else [])]) - start[name]
                for name, options in OUTPUTS if len(sensors) == 1 or name == "summary"}  # a cloud is of one sensor
        a_point = f"{cost['PLY'] / points:18.1f}" if "PLY" in cost else f"{'':>18}"
        print(f"{title:34}{packets:9}{points:10}   {cost['summary'] / packets:36.0f}{a_point}", flush=True)
        for path in captures:
            path.unlink()
    return 0
