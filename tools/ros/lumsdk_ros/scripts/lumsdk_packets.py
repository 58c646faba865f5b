"""Raw packets of both eyes: into messages, back into their order, and on to lumdump."""
import collections
import operator
import struct
import time

import rospy
from lumsdk_ros.msg import Packets

PORT = 5517
BLUE, GREEN = 0, 1
HEARTBEAT_BYTES = 12
Packet = collections.namedtuple("Packet", "time_ns sensor payload")


def ros_time(ns):
    """Times before 1970 or after 2106 do not fit. Each packet has one, and __init__ takes longer than all else of it."""
    stamp = rospy.Time.__new__(rospy.Time)
    stamp.secs, stamp.nsecs = divmod(min(max(ns, 0), 0xFFFFFFFF * 1_000_000_000), 1_000_000_000)
    return stamp


class Layout:
    """Which packets are data, and of which eye, by the wire profile (docs/protocol.md, section 8): for the choice of the
    topic alone. lumdump checked the profile."""

    def __init__(self, profile):
        group = profile.get("group", {})
        tag, eye = (self.field(group.get(name, at)) for name, at in (("tag", 12), ("eye", 13)))
        self.types = {2, 3} if tag["at"] == 8 else {profile.get("data_packet_type", 8)}
        self.at, self.end, self.order = eye["at"], eye["at"] + eye.get("bytes", 1), eye.get("order", "little")
        bits = eye.get("bits", "all")
        low, high = (0, 63) if bits == "all" else bits
        self.low, self.mask = low, (2 << (high - low)) - 1
        self.green = {"blue": 0, "green": 1, **profile.get("eye_values", {})}["green"]

    @staticmethod
    def field(value):
        return value if isinstance(value, dict) else {"at": value}

    def is_data(self, payload):
        return len(payload) > HEARTBEAT_BYTES and payload[8] in self.types

    def eye(self, payload):
        value = int.from_bytes(payload[self.at:self.end], self.order) >> self.low & self.mask
        return GREEN if value == self.green and self.is_data(payload) else BLUE


class Batcher:
    """Packets to a message of each eye (Packets.msg)."""
    SPAN_NS, PACKETS_MAX, BYTES_MAX = 20_000_000, 4096, 1 << 20

    def __init__(self, layout, frame_id, output):
        self.layout, self.frame_id, self.output = layout, frame_id, output
        self.batch, self.parts, self.end, self.bytes = None, None, 0, 0
        self.first_ns, self.sensor = 0, 0

    def open(self, time_ns, sensor):
        self.first_ns, self.sensor, self.bytes = time_ns, sensor, 0
        self.parts = [], []
        self.batch = [Packets(eye=eye, sensor=sensor, begin=self.end, lengths=[], places=[], stamps=[]) for eye in (BLUE, GREEN)]
        for message in self.batch:
            message.header.stamp, message.header.frame_id = ros_time(time_ns), self.frame_id

    def is_full(self, packet):
        return (not 0 <= packet.time_ns - self.first_ns < self.SPAN_NS or packet.sensor != self.sensor
                or self.end - self.batch[0].begin >= self.PACKETS_MAX or self.bytes + len(packet.payload) > self.BYTES_MAX)

    def add(self, packet):
        if self.batch and self.is_full(packet):
            self.flush()
        if not self.batch:
            self.open(packet.time_ns, packet.sensor)
        eye = self.layout.eye(packet.payload)
        to = self.batch[eye]
        to.places.append(self.end - to.begin)
        to.stamps.append(ros_time(packet.time_ns))
        to.lengths.append(len(packet.payload))
        self.parts[eye].append(packet.payload)
        self.bytes += len(packet.payload)
        self.end += 1

    def skip(self):
        """A packet that nobody wants has its number."""
        self.flush()
        self.end += 1

    def flush(self, last=False):
        if not self.batch and last:
            self.open(self.first_ns, self.sensor)
        if not self.batch:
            return
        for message, parts in zip(self.batch, self.parts):
            message.data, message.end, message.last = b"".join(parts), self.end, last
            self.output(message)
        self.batch = None
        self.end = 0 if last else self.end


class Eye:
    """What of it waits to be put out: number and packet."""

    def __init__(self):
        self.queue = collections.deque()
        self.has_begun = self.has_ended = False
        self.end, self.heard = 0, 0.0


class Merger:
    """Restores the order of both eyes' packets: output(packet), and end() behind the last of a stream."""
    PATIENCE_S = 0.5  # the longest wait for an eye

    def __init__(self, output, end):
        self.output, self.end = output, end
        self.eyes, self.began = (Eye(), Eye()), 0.0
        self.lost = self.refused = 0

    @staticmethod
    def is_good(m):
        return (m.eye in (BLUE, GREEN) and m.begin <= m.end and len(m.places) == len(m.stamps) == len(m.lengths)
                and sum(m.lengths) == len(m.data) and list(m.places) == sorted(m.places)
                and (not m.places or m.places[-1] < m.end - m.begin))

    def take(self, m):
        if not self.is_good(m):
            self.refused += 1
            return
        eye, now = self.eyes[m.eye], time.monotonic()
        if eye.has_begun and (eye.has_ended or m.begin < eye.end):
            self.end_stream()
            eye = self.eyes[m.eye]
        if not any(each.has_begun for each in self.eyes):
            self.began = now
        self.lost += eye.has_begun and m.begin > eye.end
        eye.has_begun, eye.has_ended, eye.end, eye.heard = True, m.last, m.end, now
        at = 0
        for place, stamp, length in zip(m.places, m.stamps, m.lengths):
            eye.queue.append((m.begin + place, Packet(stamp.to_nsec(), m.sensor, m.data[at:at + length])))
            at += length
        self.tick()

    def limit(self, now):
        """Up to where both eyes, or the one that speaks, have told all."""
        waited_for = [eye.end for eye in self.eyes if not eye.has_ended
                      and now - (eye.heard if eye.has_begun else self.began) < self.PATIENCE_S]
        return min(waited_for + [max(eye.end for eye in self.eyes)])

    def tick(self):
        now = time.monotonic()
        if not any(eye.has_begun for eye in self.eyes):
            return
        self.put_out(self.limit(now))
        ended = [eye.has_ended for eye in self.eyes]
        is_late = now - max(eye.heard for eye in self.eyes) >= self.PATIENCE_S
        if all(ended) or (is_late and any(ended)):
            self.end_stream()

    def put_out(self, limit):
        ready = []
        for eye in self.eyes:
            while eye.queue and eye.queue[0][0] < limit:
                ready.append(eye.queue.popleft())
        ready.sort(key=operator.itemgetter(0))
        for _, packet in ready:
            self.output(packet)

    def end_stream(self):
        self.put_out(1 << 64)
        self.eyes = Eye(), Eye()
        self.end()


# A capture of IPv4, with nanoseconds.
PCAP_HEAD = struct.pack("<IHHIIII", 0xA1B23C4D, 2, 4, 0, 0, 1 << 16, 228)
IP_BYTES, UDP_BYTES, PAYLOAD_MAX = 20, 8, 65507


def pcap_record(packet):
    """A packet as its sensor sent it to anybody."""
    size = len(packet.payload)
    total = IP_BYTES + UDP_BYTES + size
    return b"".join((struct.pack("<IIII", *divmod(packet.time_ns, 1_000_000_000), total, total),
                     struct.pack(">BBHHHBBHIIHHHH", 0x45, 0, total, 0, 0, 64, 17, 0, packet.sensor, 0xFFFFFFFF, PORT, PORT + 1,
                                 UDP_BYTES + size, 0), packet.payload))
