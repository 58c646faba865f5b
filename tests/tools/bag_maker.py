"""Bags of ROS 1 with the packets of a capture, as the node for ROS 1 publishes them, made by nothing but Python."""
import struct

from mcap_maker import times_of
from support import frames_of

TYPE = "lumsdk_ros/Packets"
BLUE, GREEN, CLOUDS = 0, 1, 2
BATCH = 50


def field(name, value):
    body = name.encode() + b"=" + value
    return struct.pack("<I", len(body)) + body


def record(op, data, **fields):
    header = b"".join(field(name, value) for name, value in fields.items()) + field("op", bytes([op]))
    return struct.pack("<I", len(header)) + header + struct.pack("<I", len(data)) + data


def connection(number, topic, kind):
    about = field("topic", topic) + field("type", kind.encode()) + field("md5sum", b"*") + field("message_definition", b"")
    return record(7, about, conn=struct.pack("<I", number), topic=topic)


def message(number, ns, body):
    return record(2, body, conn=struct.pack("<I", number), time=struct.pack("<II", ns // 10**9, ns % 10**9))


def packets(eye, sensor, begin, end, chosen):
    """A message of one eye: (number, ns, payload) of each of its packets."""
    head = struct.pack("<III", 0, 0, 0) + struct.pack("<I", 7) + b"luminar" + struct.pack("<BIQQB", eye, sensor, begin, end, 0)
    count = struct.pack("<I", len(chosen))
    data = b"".join(payload for _, _, payload in chosen)
    return (head + count + b"".join(struct.pack("<H", n - begin) for n, _, _ in chosen)
            + count + b"".join(struct.pack("<II", ns // 10**9, ns % 10**9) for _, ns, _ in chosen)
            + count + b"".join(struct.pack("<H", len(payload)) for _, _, payload in chosen)
            + struct.pack("<I", len(data)) + data)


def bag(capture, compression=b"none", pack=bytes, chunk_size=300_000):
    """Clouds stand beside the packets; in some batches one eye comes first, in some the other."""
    all_of_it, sensor = [], 0
    for number, (ns, frame) in enumerate(zip(times_of(capture), frames_of(capture))):
        sensor = struct.unpack_from(">I", frame, 26)[0]
        payload = frame[42:34 + struct.unpack_from(">H", frame, 38)[0]]
        all_of_it.append((number, ns, payload))
    chunks, now = [], connection(BLUE, b"/blue", TYPE) + connection(GREEN, b"/green", TYPE) + connection(CLOUDS, b"/c", "sensor_msgs/PointCloud2")
    for begin in range(0, len(all_of_it), BATCH):
        batch = all_of_it[begin:begin + BATCH]
        # Packets that are of neither eye travel with the blue one.
        eyes = [[p for p in batch if (p[2][9] == GREEN) == (eye == GREEN)] for eye in (BLUE, GREEN)]
        order = (BLUE, GREEN) if begin // BATCH % 2 else (GREEN, BLUE)
        for eye in order:
            now += message(eye, batch[0][1], packets(eye, sensor, begin, begin + len(batch), eyes[eye]))
            now += message(CLOUDS, batch[0][1], bytes(1000))
        if len(now) > chunk_size:
            chunks.append(now)
            now = b""
    chunks.append(now)
    out = b"#ROSBAG V2.0\n" + record(3, b" " * 4000, index_pos=bytes(8), conn_count=struct.pack("<I", 3),
                                      chunk_count=struct.pack("<I", len(chunks)))
    for content in chunks:
        out += record(5, pack(content), compression=compression, size=struct.pack("<I", len(content)))
        out += record(4, bytes(12), ver=struct.pack("<I", 1), conn=bytes(4), count=struct.pack("<I", 1))
    return out + connection(BLUE, b"/blue", TYPE) + record(6, bytes(8), ver=struct.pack("<I", 1), count=bytes(4))
