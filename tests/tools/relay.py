#!/usr/bin/env python3
"""relay.py A B [--seed N] [--loss P] [--duplicate P] [--reorder P] [--delay S] [--record FILE]

A wire between two interfaces that treats UDP datagrams of port 5517 badly: loses, repeats, delays them, lets later ones
overtake. All else, ARP among it, passes. Both directions have a fate of their own, drawn from the seed. What is
forwarded to the side of the client (A) and goes to the receiver of the data is recorded as it leaves. Ends by SIGTERM or
--duration, at the latest; prints its counts as JSON."""
import argparse
import heapq
import json
import random
import select
import signal
import socket
import struct
import sys
import time

ETH_P_ALL = 0x0003
PACKET_OUTGOING = 4
PORT = 5517
SO_RCVBUFFORCE = 33
COUNTS = ("seen", "forwarded", "lost", "repeated", "reordered", "delayed", "recorded")


def open_interface(name):
    s = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(ETH_P_ALL))
    s.setsockopt(socket.SOL_SOCKET, SO_RCVBUFFORCE, 64 << 20)
    s.bind((name, ETH_P_ALL))
    s.setblocking(False)
    return s


def ports_of(frame):
    """Ports of a UDP datagram over IPv4, or None."""
    if len(frame) < 42 or frame[12:14] != b"\x08\x00" or frame[23] != 17:
        return None
    at = 14 + 4 * (frame[14] & 15)
    return struct.unpack_from(">HH", frame, at)


def without_checksum(frame):
    """The sender's interface left the UDP checksum to hardware that is not there: 0 is none."""
    at = 14 + 4 * (frame[14] & 15) + 6
    return frame[:at] + b"\0\0" + frame[at + 2:]


class Record:
    def __init__(self, path):
        self.file = open(path, "wb") if path else None
        if self.file:
            self.file.write(struct.pack("<IHHiIII", 0xA1B23C4D, 2, 4, 0, 0, 65535, 1))

    def add(self, frame):
        if self.file:
            now = time.time_ns()
            self.file.write(struct.pack("<IIII", now // 10**9, now % 10**9, len(frame), len(frame)) + frame)

    def close(self):
        if self.file:
            self.file.close()


class Direction:
    """Frames that go one way."""

    def __init__(self, out, options, seed, record):
        self.out = out
        self.options = options
        self.random = random.Random(seed)
        self.record = record
        self.counts = dict.fromkeys(COUNTS, 0)
        self.held = []  # (time, order, frame)
        self.order = 0
        self.wanted_port = None  # whose data is recorded

    def strikes(self, probability, name):
        yes = self.random.random() < probability
        self.counts[name] += yes
        return yes

    def take(self, frame):
        ports = ports_of(frame)
        if ports is None or PORT not in ports:
            self.send(frame, False)
            return
        frame = without_checksum(frame)
        self.counts["seen"] += 1
        o = self.options
        if self.strikes(o.loss, "lost"):
            return
        for _ in range(1 + self.strikes(o.duplicate, "repeated")):
            wait = 0.0
            if self.strikes(o.reorder, "reordered"):
                wait += self.random.uniform(0.0002, 0.003)
            if self.strikes(o.delays, "delayed"):
                wait += self.random.uniform(0, o.delay)
            if wait > 0:
                self.order += 1
                heapq.heappush(self.held, (time.monotonic() + wait, self.order, frame))
            else:
                self.send(frame, True)

    def send(self, frame, ours):
        try:
            self.out.send(frame)
        except OSError:
            return
        if ours:
            self.counts["forwarded"] += 1
            if self.record and ports_of(frame)[1] == self.wanted_port:
                self.counts["recorded"] += 1
                self.record.add(frame)

    def release(self):
        now = time.monotonic()
        while self.held and self.held[0][0] <= now:
            self.send(heapq.heappop(self.held)[2], True)

    def next_wait(self):
        return max(0.0, self.held[0][0] - time.monotonic()) if self.held else 0.2


def is_heartbeat(frame):
    at = 14 + 4 * (frame[14] & 15)
    return struct.unpack_from(">H", frame, at + 4)[0] == 20 and frame[at + 16] == 8


def main():
    p = argparse.ArgumentParser()
    p.add_argument("client")
    p.add_argument("sensor")
    p.add_argument("--seed", type=int, default=1)
    for name in ("loss", "duplicate", "reorder", "delays"):
        p.add_argument("--" + name, type=float, default=0.0)
    p.add_argument("--delay", type=float, default=0.05)
    p.add_argument("--record")
    p.add_argument("--duration", type=float, default=120)
    o = p.parse_args()
    client, sensor = open_interface(o.client), open_interface(o.sensor)
    record = Record(o.record)
    to_client = Direction(client, o, o.seed * 2, record)
    to_sensor = Direction(sensor, o, o.seed * 2 + 1, None)
    ways = {client: to_sensor, sensor: to_client}
    stop = []
    signal.signal(signal.SIGTERM, lambda *_: stop.append(1))
    end = time.monotonic() + o.duration
    print("ready", flush=True)
    while not stop and time.monotonic() < end:
        wait = min(to_client.next_wait(), to_sensor.next_wait())
        for s in select.select([client, sensor], [], [], wait)[0]:
            for _ in range(256):
                try:
                    frame, address = s.recvfrom(65535)
                except BlockingIOError:
                    break
                except OSError:
                    break
                if address[2] == PACKET_OUTGOING:
                    continue
                if s is client and ports_of(frame) and ports_of(frame)[1] == PORT and is_heartbeat(frame):
                    to_client.wanted_port = ports_of(frame)[0]
                ways[s].take(frame)
        to_client.release()
        to_sensor.release()
    record.close()
    print(json.dumps({"to_client": to_client.counts, "to_sensor": to_sensor.counts}))
    return 0


if __name__ == "__main__":
    sys.exit(main())
