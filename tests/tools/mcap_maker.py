"""MCAP files with datagrams, made by nothing but Python: as another program would write them."""
import struct
import zlib

from support import frames_of

MAGIC = b"\x89MCAP0\r\n"
SCHEMA = "lumsdk_msgs/msg/Datagram"
CLOUDS, PACKETS = 1, 2


def text(value):
    return struct.pack("<I", len(value)) + value.encode()


def record(opcode, body):
    return struct.pack("<BQ", opcode, len(body)) + body


def channel(number, name):
    """A schema and its channel, of one number."""
    return (record(3, struct.pack("<H", number) + text(name) + text("ros2msg") + text("uint8 x"))
            + record(4, struct.pack("<HH", number, number) + text(f"/{number}") + text("cdr") + struct.pack("<I", 0)))


def message(number, body, ns=0):
    return record(5, struct.pack("<HIQQ", number, 0, ns, ns) + body)


def datagram(ns, frame):
    """The message of an Ethernet frame with a UDP datagram."""
    source, destination = frame[26:30], frame[30:34]
    sport, dport, length = struct.unpack_from(">HHH", frame, 34)
    payload = frame[42:34 + length]
    return (b"\0\1\0\0" + struct.pack("<iI", ns // 10**9, ns % 10**9) + source + struct.pack("<H", sport)
            + destination + struct.pack("<HII", dport, length - 8, len(payload)) + payload)


def times_of(capture):
    at, unit = 24, 1 if capture[:4] == b"\x4d\x3c\xb2\xa1" else 1000
    while at < len(capture):
        s, part, length = struct.unpack_from("<III", capture, at)
        yield s * 10**9 + part * unit
        at += 16 + length


def chunk(records, compression="", pack=bytes):
    packed = pack(records)
    head = struct.pack("<QQQI", 0, 0, len(records), zlib.crc32(records)) + text(compression)
    return record(6, head + struct.pack("<Q", len(packed)) + packed)


def mcap(capture, compression="", pack=bytes, size=1_000_000, schema=SCHEMA):
    """The datagrams of a pcap file, and clouds beside them, in chunks of about this size."""
    chunks, now = [], bytearray(channel(CLOUDS, "sensor_msgs/msg/PointCloud2") + channel(PACKETS, schema))
    count = 0
    for ns, frame in zip(times_of(capture), frames_of(capture)):
        now += message(PACKETS, datagram(ns, frame), ns)
        if count % 100 == 0:
            now += message(CLOUDS, bytes(100), ns)
            count += 1
        count += 1
        if len(now) > size:
            chunks.append(bytes(now))
            now = bytearray()
    chunks.append(bytes(now))
    out = MAGIC + record(1, text("ros2") + text("a test"))
    out += b"".join(chunk(c, compression, pack) + record(7, bytes(6)) for c in chunks) + record(15, bytes(4))
    return out + record(11, struct.pack("<Q", count) + bytes(38)) + record(2, bytes(20)) + MAGIC
