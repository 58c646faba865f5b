#!/usr/bin/env python3
"""reference.py CAPTURE [--json]: a slow reading of docs/protocol.md, section 6.

Written from the text alone, to be held against the C code: one object for each
line, lists, no cleverness. It reads a classic pcap of Ethernet frames with
whole IPv4 UDP datagrams and the built-in wire profile, and prints all points as
CSV, or with --json the counters.
"""
import json
import struct
import sys

MAGIC = bytes.fromhex("edfef3a1efbe3412")
PIXELS = 1000
OPEN_LINES = 4
R = 8
GAP_US = 100_000
LINE_SPAN_US = 2_000
WORDS_OF_A_LINE = 16_384

COLUMNS = ("frame eye line pixel return_number number_of_returns edge "
           "timestamp range azimuth elevation pulse_width").split()
COUNTERS = ("lines lines_missing_angles words lost_words points late duplicate "
            "conflict malformed unknown_tag unknown_type foreign bad_words "
            "no_angle no_range heartbeat stray no_room lines_skipped frames "
            "set_ip timestamp tlv").split()


class Line:
    """A line that is open."""

    def __init__(self, number, clock):
        self.number = number
        self.clock = clock
        self.accepted_clocks = []
        self.frame = None
        self.angles = {}
        self.words = []
        self.ends = []
        self.words_held = 0

    def lost_words(self):
        """What the range packets show to be missing, from below."""
        return max(0, max(self.ends, default=0) - self.words_held)


class Eye:
    """Reassembly and frames of one eye."""

    def __init__(self):
        self.newest = None
        self.candidate = None
        self.open = []
        self.closed = []
        self.low_clocks = []
        self.broken = False
        self.frame = None
        self.top = 0
        self.previous_top = 0
        self.gap = 0
        self.since_wrap = None


class Sensor:
    """Both eyes of one sensor."""

    def __init__(self, counters, take_line):
        self.counters = counters
        self.take_line = take_line
        self.clock = None
        self.eyes = [Eye(), Eye()]
        self.frames = set()

    # Reassembly

    def packet(self, packet):
        clock = packet.raw_clock
        if self.clock is not None:
            difference = (packet.raw_clock - self.clock) & 0xFFFFFFFF
            if difference >= 1 << 31:
                difference -= 1 << 32
            clock = self.clock + difference
        eye = self.eyes[packet.eye]
        if not self.near_the_stream(packet.eye, clock):
            self.counters["stray"] += 1
            return
        self.clock = clock
        eye.newest = clock if eye.newest is None else max(eye.newest, clock)
        line = self.line_of(packet, clock)
        if line is None:
            self.counters["late"] += 1
            return
        why_not = self.put(line, packet)
        if why_not is not None:
            self.counters[why_not] += 1
            return
        line.accepted_clocks.append(clock)
        if len(line.accepted_clocks) == 2:
            line.frame = self.decide_frame(packet.eye, line.number)

    def near_the_stream(self, which, clock):
        """Rule 2; false for a stray."""
        eye = self.eyes[which]
        if eye.newest is None:
            return True
        if abs(clock - eye.newest) <= GAP_US:
            eye.candidate = None
            return True
        if eye.candidate is None or abs(clock - eye.candidate) > GAP_US:
            eye.candidate = clock
            return False
        while eye.open:
            self.close_first(which)
        eye.closed = []
        eye.low_clocks = []
        eye.newest = clock
        eye.broken = True
        eye.candidate = None
        return True

    def line_of(self, packet, clock):
        """Rule 3; None for a late packet."""
        eye = self.eyes[packet.eye]
        for place, line in enumerate(eye.open):
            if line.number != packet.line:
                continue
            if abs(clock - line.clock) <= LINE_SPAN_US:
                return line
            if clock < line.clock:
                return None
            for _ in range(place + 1):
                self.close_first(packet.eye)
            break
        else:
            for number, closed_clock in eye.closed[-R:]:
                if (number == packet.line
                        and abs(clock - closed_clock) <= LINE_SPAN_US):
                    return None
            if eye.low_clocks and clock < max(eye.low_clocks):
                return None
            if len(eye.open) == OPEN_LINES:
                self.close_first(packet.eye)
        line = Line(packet.line, clock)
        eye.open.append(line)
        return line

    def put(self, line, packet):
        """Rule 4; says what is wrong with the packet, or None."""
        if packet.tag == 2:
            pixels = range(packet.first, packet.first + len(packet.samples))
            known = line.angles
        else:
            words = [struct.unpack("<I", s)[0] for s in packet.samples]
            good = [w for w in words
                    if not w & 0x800 and (w & 0x3FF) < PIXELS]
            pixels = [w & 0x3FF for w in good]
            known = {w & 0x3FF for w in line.words}
        there = [p in known for p in pixels]
        if there and all(there):
            return "duplicate"
        if any(there):
            return "conflict"
        if packet.tag == 2:
            for pixel, sample in zip(pixels, packet.samples):
                line.angles[pixel] = struct.unpack("<hh", sample)
            return None
        if len(line.words) + len(good) > WORDS_OF_A_LINE:
            return "no_room"
        line.words += good
        line.words_held += len(words)
        self.counters["bad_words"] += len(words) - len(good)
        end = packet.first + len(words)
        if end <= WORDS_OF_A_LINE:
            line.ends.append(end)
        return None

    def close_first(self, which):
        eye = self.eyes[which]
        line = eye.open.pop(0)
        eye.closed.append((line.number, line.clock))
        if len(line.accepted_clocks) >= 2:
            eye.low_clocks.append(min(line.accepted_clocks))
        else:
            line.frame = 1 if eye.frame is None else eye.frame
        self.counters["lines"] += 1
        self.counters["lines_missing_angles"] += len(line.angles) < PIXELS
        self.counters["words"] += len(line.words)
        self.counters["lost_words"] += line.lost_words()
        self.frames.add(line.frame)
        self.take_line(which, line)

    def end(self):
        for which, eye in enumerate(self.eyes):
            while eye.open:
                self.close_first(which)
        for eye in self.eyes:
            self.counters["lines_skipped"] += eye.gap
        self.counters["frames"] += len(self.frames)

    # Frames

    def decide_frame(self, which, l):
        eye, other = self.eyes[which], self.eyes[1 - which]
        begun = other.frame is not None
        o, f = other.top, other.frame
        close_by = begun and abs(l - o) <= R

        def new_frame(gap):
            self.counters["lines_skipped"] += eye.gap
            eye.frame += 1
            if close_by:
                eye.frame = max(eye.frame, f)
            eye.top = l
            eye.gap = gap

        if eye.frame is None:
            eye.broken = False
            if not begun:
                eye.frame = 1
            elif close_by:
                eye.frame = f
            elif l > o:
                eye.frame = f - 1
            else:
                eye.frame = f + 1
            eye.top = l
            return eye.frame
        if eye.broken:
            eye.broken = False
            new_frame(0)
            eye.since_wrap = None
            return eye.frame
        if l < eye.top - R or (close_by and f > eye.frame):
            eye.previous_top = eye.top
            new_frame(l)
            eye.since_wrap = 0
            return eye.frame
        if eye.since_wrap is not None:
            eye.since_wrap += 1
            if (l > eye.top + R and eye.since_wrap < R
                    and l >= eye.previous_top - R):
                return eye.frame - 1
        if l > eye.top:
            eye.gap += l - eye.top - 1
        elif l < eye.top:
            eye.gap = max(0, eye.gap - 1)
        eye.top = max(eye.top, l)
        return eye.frame


# Packets


class Packet:
    """A data packet."""

    def __init__(self, data):
        (self.tag, self.eye, self.line, self.count, self.first,
         self.raw_clock) = struct.unpack_from("<BBHHHI", data, 12)
        self.samples = [data[24 + 4 * i:28 + 4 * i] for i in range(self.count)]


def kind_of(data):
    """The counter of a datagram, or a Packet."""
    if len(data) < 12 or data[:8] != MAGIC:
        return "foreign"
    if any(data[9:12]) or data[8] not in (5, 6, 7, 8):
        return "unknown_type"
    if data[8] != 8:
        kind, least = {5: ("set_ip", 16), 6: ("timestamp", 20),
                       7: ("tlv", 16)}[data[8]]
        return kind if len(data) >= least else "malformed"
    if len(data) == 12:
        return "heartbeat"
    if len(data) < 24:
        return "malformed"
    count = struct.unpack_from("<H", data, 16)[0]
    if count == 0 or len(data) < 24 + 4 * count or data[13] not in (0, 1):
        return "malformed"
    packet = Packet(data)
    if packet.tag not in (2, 3):
        return "unknown_tag"
    if packet.tag == 2 and packet.first + packet.count > PIXELS:
        return "malformed"
    return packet


# Samples


def points_of(line, counters):
    """The points of a line as rows without frame, eye, line, timestamp."""
    pixels = {}
    for word in line.words:
        pixels.setdefault(word & 0x3FF, []).append(word)
    for pixel in sorted(pixels):
        words = pixels[pixel]
        tofs = {edge: [tof_of(w) for w in words if edge_of(w) == edge]
                for edge in (0, 1)}
        seen = [0, 0]
        for word in words:
            edge, tof = edge_of(word), tof_of(word)
            k = seen[edge]
            seen[edge] += 1
            width = 0
            if edge == 1 and k < len(tofs[0]):
                width = max(0, tofs[0][k] - tof)
            if pixel not in line.angles:
                counters["no_angle"] += 1
            elif tof <= 0:
                counters["no_range"] += 1
            else:
                counters["points"] += 1
                azimuth, elevation = line.angles[pixel]
                yield (pixel, k + 1, len(tofs[edge]), edge,
                       tof * 13e-12 * 3e8 / 2, azimuth / 32768 * 30,
                       -7 + elevation / 32768 * 10, width * 0.013)


def edge_of(word):
    return word >> 10 & 1


def tof_of(word):
    tof = word >> 12
    return tof - (1 << 20) if tof >= 1 << 19 else tof


# Captures


def datagrams(capture):
    """(sensor, UDP payload) of each packet of a classic little-endian pcap."""
    with open(capture, "rb") as file:
        data = file.read()
    if data[:4] not in (b"\xd4\xc3\xb2\xa1", b"\x4d\x3c\xb2\xa1"):
        sys.exit(f"{capture}: not a little-endian pcap")
    at = 24
    while at + 16 <= len(data):
        length = struct.unpack_from("<I", data, at + 8)[0]
        frame = data[at + 16:at + 16 + length]
        at += 16 + length
        if len(frame) < 42 or frame[12:14] != b"\x08\x00" or frame[23] != 17:
            continue
        ip = frame[14:14 + struct.unpack_from(">H", frame, 16)[0]]
        udp = ip[4 * (ip[0] & 15):]
        source, destination, udp_length = struct.unpack_from(">HHH", udp)
        if 5517 in (source, destination):
            yield ip[12:16] if source == 5517 else ip[16:20], udp[8:udp_length]


def run(capture):
    """All rows and the counters of a capture."""
    counters = dict.fromkeys(COUNTERS, 0)
    rows = []

    def take_line(eye, line):
        for point in points_of(line, counters):
            rows.append((line.frame, eye, line.number, *point[:4],
                         line.clock, *point[4:]))

    sensors = {}
    for address, data in datagrams(capture):
        packet = kind_of(data)
        if isinstance(packet, str):
            counters[packet] += 1
        else:
            if address not in sensors:
                sensors[address] = Sensor(counters, take_line)
            sensors[address].packet(packet)
    for sensor in sensors.values():
        sensor.end()
    return rows, counters


def main(arguments):
    rows, counters = run(arguments[0])
    if "--json" in arguments:
        print(json.dumps(counters, indent=1))
        return
    print(",".join(COLUMNS))
    for row in rows:
        print(",".join(map(str, row[:8])),
              "%.4f,%.5f,%.5f,%.3f" % row[8:], sep=",")


if __name__ == "__main__":
    main(sys.argv[1:])
