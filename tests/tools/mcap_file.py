"""A small reader of MCAP files of the profile ros2, with the standard library alone. Checks each CRC that it meets, and
reads files that break off. Chunks have to be uncompressed."""
import collections
import struct
import zlib

MAGIC = b"\x89MCAP0\r\n"
HEADER, FOOTER, CHANNEL, MESSAGE, CHUNK, ATTACHMENT, METADATA = 1, 2, 4, 5, 6, 9, 12
POINT = struct.Struct("<fffffHBB")

Message = collections.namedtuple("Message", "topic time data")
Cloud = collections.namedtuple("Cloud", "stamp_ns points")
Point = collections.namedtuple("Point", "x y z intensity time ring number eye")


class Bytes:
    """Numbers and texts one after the other; of a CDR, aligned to their size."""

    def __init__(self, data, aligns=False):
        self.data, self.at, self.aligns = data, 0, aligns

    def number(self, size):
        self.at += -self.at % size if self.aligns else 0
        return int.from_bytes(self.take(size), "little")

    def take(self, n):
        if self.at + n > len(self.data):
            raise EOFError
        self.at += n
        return self.data[self.at - n:self.at]

    def text(self):
        return self.take(self.number(4)).rstrip(b"\0").decode()

    def pairs(self):
        inner, out = Bytes(self.take(self.number(4))), {}
        while inner.at < len(inner.data):
            key = inner.text()
            out[key] = inner.text()
        return out


class File:
    def __init__(self, data):
        if data[:len(MAGIC)] != MAGIC:
            raise ValueError("no magic")
        self.messages, self.attachments, self.metadata, self.compressions = [], {}, {}, []
        self.topics, self.qos, self.is_whole = {}, {}, False
        b = Bytes(data[len(MAGIC):])
        try:
            while not self.is_whole:
                op, content = b.number(1), Bytes(b.take(b.number(8)))
                self.note(op, content, data)
        except EOFError:
            return
        if b.data[b.at:] != MAGIC:
            raise ValueError("no magic at the end")

    def note(self, op, b, data):
        if op == CHANNEL:
            number, _ = b.number(2), b.number(2)
            self.topics[number] = b.text()
            _, self.qos[self.topics[number]] = b.text(), b.pairs()["offered_qos_profiles"]
        elif op == CHUNK:
            self.note_chunk(b)
        elif op == ATTACHMENT:
            b.take(16)
            name, _, text = b.text(), b.text(), b.take(b.number(8))
            check(zlib.crc32(b.data[:b.at]), b.number(4), name)
            self.attachments[name] = text.decode()
        elif op == METADATA:
            name = b.text()
            self.metadata[name] = b.pairs()
        elif op == FOOTER:
            start = b.number(8)
            check(zlib.crc32(data[start:-len(MAGIC) - 4]), int.from_bytes(b.data[-4:], "little"), "the summary")
            self.is_whole = True

    def note_chunk(self, b):
        b.take(16)
        size, crc, compression = b.number(8), b.number(4), b.text()
        records = b.take(b.number(8))
        self.compressions.append(compression)
        if compression:
            return
        check(len(records), size, "the size of a chunk")
        check(zlib.crc32(records), crc, "a chunk")
        inner = Bytes(records)
        while inner.at < len(records):
            check(inner.number(1), MESSAGE, "a record of a chunk")
            m = Bytes(inner.take(inner.number(8)))
            channel, _, time, _ = m.number(2), m.number(4), m.number(8), m.number(8)
            self.messages.append(Message(self.topics[channel], time, m.data[m.at:]))

    def of(self, topic):
        return [m for m in self.messages if m.topic == topic]

    def clouds(self):
        return [cloud_of(m) for m in self.of("/points")]


def check(got, want, what):
    if got != want:
        raise ValueError(f"{what}: {got}, want {want}")


def cdr(message):
    check(message.data[:4], b"\0\1\0\0", "the head of a message")
    return Bytes(message.data[4:], aligns=True)


def cloud_of(message):
    b = cdr(message)
    stamp_ns = b.number(4) * 10**9 + b.number(4)
    check(stamp_ns, message.time, "the time of a message")
    b.text()
    check(b.number(4), 1, "height")
    width = b.number(4)
    names = []
    for _ in range(b.number(4)):
        names.append(b.text())
        b.number(4), b.number(1), b.number(4)
    check(names, "x y z intensity time ring return eye".split(), "the fields")
    b.number(1)
    check((b.number(4), b.number(4)), (POINT.size, POINT.size * width), "the steps")
    points = b.take(b.number(4))
    check(b.take(1), b"\1", "is_dense")
    return Cloud(stamp_ns, [Point(*p) for p in POINT.iter_unpack(points)])


def statuses_of(message):
    """Name, level, message, and a dictionary of the values, of each status."""
    b = cdr(message)
    b.number(4), b.number(4), b.text()
    out = []
    for _ in range(b.number(4)):
        level, name, text, _ = b.number(1), b.text(), b.text(), b.text()
        out.append((name, level, text, {b.text(): b.text() for _ in range(b.number(4))}))
    return out
