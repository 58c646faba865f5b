#!/usr/bin/env python3
"""watch.py [SECONDS]: passes on what ctest prints, and names every so often what has been running for as long. Where a run
is ended from outside, the last line says what it was waiting for."""
import re
import select
import sys
import time

PERIOD_S = 300.0


def tell(running, now_s, period_s, out):
    slow = sorted((begun_s, name) for name, begun_s in running.items() if now_s - begun_s >= period_s)
    if slow:
        print("still running: " + ", ".join(f"{name} ({(now_s - begun_s) / 60:.0f} min)" for begun_s, name in slow), file=out, flush=True)


def watch(lines, out, period_s=PERIOD_S, clock=time.monotonic):
    """lines: a line, or None where none came for a while."""
    running = {}
    told_s = clock()
    for line in lines:
        now_s = clock()
        if line is not None:
            print(line, end="", file=out, flush=True)
            if match := re.match(r" *Start +\d+: (\S+)", line):
                running[match[1]] = now_s
            elif match := re.match(r" *\d+/\d+ Test +#\d+: (\S+) ", line):
                running.pop(match[1], None)
        if now_s - told_s >= period_s:
            tell(running, now_s, period_s, out)
            told_s = now_s


def lines_of(stream, pause_s):
    """Reads no further than a line, because select() does not know what Python has read already."""
    waiting = b""
    while True:
        ready, _, _ = select.select([stream], [], [], pause_s)
        if not ready:
            yield None
            continue
        got = stream.read(65536)
        if not got:
            break
        *whole, waiting = (waiting + got).split(b"\n")
        yield from (line.decode(errors="replace") + "\n" for line in whole)
    if waiting:
        yield waiting.decode(errors="replace")


def main():
    period_s = float(sys.argv[1]) if len(sys.argv) > 1 else PERIOD_S
    watch(lines_of(open(sys.stdin.fileno(), "rb", buffering=0, closefd=False), min(period_s, 10.0)), sys.stdout, period_s)


if __name__ == "__main__":
    main()
