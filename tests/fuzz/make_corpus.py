#!/usr/bin/env python3
"""make_corpus.py: adds the seeds of the fuzzers to the archives in corpus/ beside this
script; the same bytes each time. An archive has more inputs, which campaigns found. Those
of fuzz_index hold states of the decoder: they are written if lumsdk can be imported
(PYTHONPATH=build/release/python). When a state gets another form, remove that archive,
write it again, and add what a campaign finds (script/fuzz --keep index)."""
import bz2
import pathlib
import random
import struct
import tempfile
import zlib

import corpus

MAGIC = bytes.fromhex("edfef3a1efbe3412")


def packet(kind, body=b""):
    return MAGIC + bytes((kind, 0, 0, 0)) + body


def data(tag, eye, line, first, samples, clock=7):
    head = struct.pack("<BBHHHI", tag, eye, line, len(samples), first, clock)
    return packet(8, head + b"".join(samples))


def tlv(kind, value):
    return struct.pack("<HH", kind, len(value)) + value


def packet_seeds():
    angles = [struct.pack("<hh", 100 * i, -i) for i in range(4)]
    words = [struct.pack("<I", 5000 << 12 | 0x400 | i) for i in range(4)]
    yscan = struct.pack("<4h", -17, 0, 3, 32767)
    tlvs = (packet(7, struct.pack("<I", 9) + tlv(1, b"u 55p 150h")
                   + tlv(2, b"\x00\x08") + tlv(3, b"ok") + tlv(4, yscan)))

    def profile(*fields, samples=16, order=0, unit=0, bits=(0,) * 12):
        return b"\4" + bytes((*fields, samples - 16, 8, 0, 3 * order, 0, 1, 0, 1, unit, 0, *bits))

    usual = (4, 0, 5, 0, 6, 1, 8, 1, 10, 1, 12, 2)
    big, some = 4 << 3, 0x40
    wide = struct.pack(">BxHQHQ", 3, 1, 5, 0, 1 << 60) + b"".join(w[::-1] for w in words)
    shared = struct.pack("<HHIQ", 2 | 1 << 2 | 5 << 3, 4, 0, 1 << 40 | 77) + b"".join(angles)
    return {
        "heartbeat": b"\0" + packet(8),
        "set-ip": b"\0" + packet(5, bytes((10, 42, 0, 99))),
        "set-ip-little": b"\3" + packet(5, bytes((99, 0, 42, 10))),
        "timestamp": b"\0" + packet(6, struct.pack("<II", 7, 1 << 31)),
        "tlv": b"\0" + tlvs,
        "angles": b"\0" + data(2, 1, 5, 996, angles),
        "ranges": b"\0" + data(3, 0, 65535, 12, words),
        "tag-on-type": b"\1" + packet(3, data(3, 0, 5, 0, words)[12:]),
        "no-clock": b"\2" + data(2, 0, 5, 0, angles),
        "data-type-3": b"\3" + packet(3, data(3, 0, 5, 0, words)[12:]),
        "profile": profile(*usual, samples=24) + data(3, 0, 5, 0, words),
        # eight bytes, the highest first, and as many samples as there are
        "wide": profile(4, 0, 6, big | 1, 8, big | 3, 40, 4, 16, big | 1, 18, big | 3, samples=34, order=1, unit=2)
        + packet(8, wide),
        # a tag of two bits, an eye of one and a line of 13 in the same two bytes, and a clock of 41 bits
        "bits": profile(4, some | 1, 4, some | 1, 4, some | 1, 6, 1, 8, 2, 12, some | 3, samples=28, unit=1,
                        bits=(0, 2, 2, 1, 3, 13, 0, 0, 0, 0, 0, 41)) + packet(8, shared),
        "commands": b"\0u 55p 0f 15y 150h 30G 0B d",
    }


PUSH = 0x4F  # until the packet is taken; its arrival is one later
FLUSH, IDLE, NONSENSE, OTHER_SAMPLES, PUSH_ONCE, _, LINES, WHOLE = range(0x40, 0x48)
AHEAD, BACK = 8, 0x88  # clocks: 5 ms, more than a line's span


def step(eye, tag, n, line, clock, first, rest=(90, 0xFF, 30), call=PUSH):
    return bytes((eye | (2 if tag == 2 else 0) | (n - 1) << 2, line, clock,
                  first & 255, first >> 8, *rest, call))


def lines(count, clock=4):
    for line in range(count):
        for eye in (0, 1):
            yield step(eye, 2, 20, line, 0, 0)
            yield step(eye, 3, 16, line, 0, 0)
            yield step(eye, 3, 16, line, clock if eye else 0, 40)


def assembler_seeds():
    rng = random.Random(1)
    usual = bytes((0, 0, 3, 7, 99, 0, 2))
    frames = [*lines(12), *lines(12), *lines(12)]
    mixed = frames[:]
    for i in range(0, len(mixed) - 20, 5):
        j = i + rng.randrange(20)
        mixed[i], mixed[j] = mixed[j], mixed[i]
    careless = [p[:-1] + bytes((PUSH_ONCE,)) if i % 3 else p for i, p in enumerate(frames)]
    asked = frames[:]
    for i, call in enumerate((FLUSH, IDLE, NONSENSE, OTHER_SAMPLES, PUSH_ONCE) * 8):
        asked.insert(5 * i + 3, frames[5 * i][:-1] + bytes((call,)))
    whole = [step(0, 3, 16, line, 4, 0, (90 + line, 0xFF, 0), WHOLE) for line in range(3)]
    runs = [step(0, 3, 1 + i % 4, 4 * i % 24, 0, 0, call=LINES) for i in range(12)]
    # three lines are to close, one does, another by a flush; then the third gets a packet of its own
    given_up = [*(step(0, 3, 4, line, 0, 0) for line in (1, 2, 3)), step(0, 3, 4, 3, AHEAD, 0, call=PUSH_ONCE),
                step(0, 3, 4, 0, 0, 0, call=FLUSH), step(0, 2, 4, 3, BACK, 0), step(0, 2, 4, 3, 0, 8)]
    # of four open lines the second alone is idle
    idle = [*(step(0, 3, 4, line, 0, 0) for line in range(4)), step(0, 2, 4, 0, 0, 0), step(0, 3, 2, 1, 0, 0, call=IDLE),
            *(step(0, 3, 4, line, 0, 40) for line in range(2, 8))]
    return {
        "idle": usual + b"".join(idle),
        "whole": usual + b"".join(whole),
        "longest-whole": bytes((0, 0, 0, 7, 200, 0, 0xFB)) + b"".join(whole),
        "long-whole": bytes((0, 0, 0, 7, 201, 0, 0xFB)) + b"".join(whole),
        "runs": usual + b"".join(runs),
        "all-open": bytes((0, 0, 255, 7, 99, 0, 2)) + step(0, 3, 3, 0, 0, 0, (90, 0xFF, 250), LINES) * 2,
        "given-up": usual + b"".join(given_up),
        "frames": usual + b"".join(frames),
        "careless": usual + b"".join(careless),
        "asked": usual + b"".join(asked),
        "large": bytes((0, 0, 1, 7, 200, 0, 3)) + b"".join(
            bytes((p[0] | 0x80,)) + p[1:] for p in mixed[:200]),
        "longest": bytes((0, 0, 0, 7, 200, 0, 0xFB)) + b"".join(
            bytes((p[0] | 0x80,)) + p[1:] for p in frames[:150]),
        "reordered": usual + b"".join(mixed),
        "repeated": usual + b"".join(p + p for p in frames[:120]),
        "jumps": usual + b"".join(
            p[:2] + bytes((11 if i % 13 == 0 else p[2],)) + p[3:]
            for i, p in enumerate(frames[:200])),
        "no-clock": bytes((4, 0, 3, 7, 99, 0, 2)) + b"".join(mixed[:200]),
        "one-byte-clock": bytes((3, 200, 0, 0, 9, 2, 2)) + b"".join(mixed[:200]),
        "one-line": bytes((0, 0, 0, 0, 0, 0, 2)) + b"".join(frames[:60]),
        "chance": usual + rng.randbytes(1600),
    }


def receiver_seeds():
    """Calls of the assembler's form: what its last byte asks for is another thing there."""
    wanted = ("frames", "large", "reordered", "repeated", "jumps", "no-clock", "one-byte-clock", "chance")
    return {name: seed for name, seed in assembler_seeds().items() if name in wanted}


def points_seeds():
    rng = random.Random(2)
    word = struct.Struct("<I").pack
    ordered = b"".join(word(rng.getrandbits(32) | 0x700) for _ in range(300))
    typical = bytes(64)
    return {
        "typical": typical + ordered,
        "whole": b"\0\4" + typical[2:] + ordered,
        "green": b"\1\0\6" + typical[3:] + ordered,
        "chance": rng.randbytes(1264),
    }


def device_seeds():
    beat = b"\0"
    on = tlv(1, b"u")

    def tlvs(*items):
        body = b"".join(items)
        return b"\2" + struct.pack("<H", len(body)) + body

    def wait(ms):
        return b"\1" + struct.pack("<H", ms)

    def hazards(up, down):
        return b"\5" + struct.pack("<HH", up, down)

    table = struct.pack("<64h", *(32000 - 900 * i for i in range(64)))
    whole = packet(7, struct.pack("<I", 9) + tlv(1, b"d 55p"))
    return {
        "boot": b"\0" + tlvs() + tlvs(on) + beat + tlvs(on) + wait(2999) + beat
                + wait(2999) + tlvs(on) + wait(1) + beat + tlvs(on),
        "commands": b"\0" + beat + tlvs(tlv(
            1, b"d u 55p 20g 30b 0f 15y 150h 30G 1B 101p 165h what 050p")),
        "uncut": b"\0" + tlvs(tlv(1, b"5p  6p"), tlv(1, b" "), tlv(1, b"u ")),
        "table": b"\1" + tlvs(tlv(4, table), tlv(1, b"1f"), tlv(4, table),
                              tlv(4, table[:126]), tlv(4, b"abc")),
        "order": b"\10" + tlvs(tlv(4, table), tlv(1, b"20y 1f")),
        "hazards": b"\0" + beat + tlvs(on) + hazards(0x40, 0)
                   + tlvs(on) + hazards(0, 0x40) + hazards(0xFFFF, 0xFFFF),
        "times": b"\4" + b"\4\6\10" + bytes(8) + wait(60000) + b"\4\6\10"
                 + bytes(range(8)),
        "set-ip": b"\2" + b"\4\5\4" + bytes((10, 42, 0, 99)) + b"\4\5\4"
                  + bytes(4),
        "whole": b"\0" + b"\3" + struct.pack("<H", len(whole)) + whole,
        "broken": b"\0" + tlvs(tlv(1, b"7p"), b"\1\0\7"),
    }


def session_seeds():
    """How it is opened, how often the sensor answers; then calls, and what the
    sensor does with each packet that it gets."""
    alone, owner = b"\x02\x80", b"\x03\x80"
    poll, command, time, give_up, stall, off = (bytes((i,)) for i in range(6))
    wait, network = b"\6", b"\7"
    receive = b"\x0d"
    lost = b"\xff"
    down, up = b"\0\4\x20", b"\0\4\x80"
    broken = b"\0\1\2" + b"\7\5" + struct.pack("<HHB", 2, 9, 1)
    return {
        "answer": alone + poll + receive + b"\x32" + down + receive + b"\5",
        "owner": owner + command + receive + b"\x32" + lost + up
                 + (receive + b"\x32") * 2 + lost,
        "time": alone + time + receive + b"\x32" + lost + b"\0\4"
                + receive + b"\x32",
        "silence": alone + poll + receive + b"\xfa" + lost * 3 + receive,
        "off": owner + off + lost + down + lost * 2 + down + receive + b"\0",
        "flips": alone + off + down + up + down + down,
        "refused": alone + off + up * 3,
        "late": alone + poll + receive + b"\0" + lost + give_up
                + b"\x08\0\1\2\x20" + receive + b"\x32",
        "alert": alone + b"\x08\0\1\0\x20" + b"\x08\3\1\1\x20"
                 + receive + b"\x32",
        "broken": alone + poll + receive + b"\0" + lost + b"\x0a" + broken
                  + receive + b"\x32",
        "foreign": owner + b"\x09\1\1\2" + b"\x08\2\1\2\x20" + wait
                   + b"\x32" + receive + b"\x32" + lost,
        "stall": owner + receive + b"\0" + lost + stall + b"\xff\xff"
                 + receive + b"\xff" + lost * 3,
        "network": owner + network + b"\1" + receive + b"\xff" + receive
                   + b"\xff" + network + b"\0" + receive + b"\xff" + lost,
        "cancel": owner + network + b"\2" + receive + b"\xff" + off + lost
                  + down + lost * 2 + down + stall + b"\xff\xff" + receive
                  + b"\xff" + lost * 2,
        "flood": owner + network + b"\4" + poll + receive + b"\xff" + lost * 2
                 + down + network + b"\x24" + receive + b"\xff" + lost * 2,
        # Campaigns found them: each failed once.
        "held_up": bytes.fromhex("03ffffffffffffff800d0003800d00ff04ffff04ffffff"),
        "held_up_before_the_first_try": bytes.fromhex("f7ff0004200724ceffd1ddff"),
        "cancelled_before_the_first_try": bytes.fromhex(
            "030000000000000000000021077e200428ff6666ffff66666666666666666666666666666666666666666666666666666666"
            "6666666666666666666666666666666602000000000000000021077e200428ff6666ffff6666666666666666666666666666"
            "6666666666666666666666666666666666666666666666666666666666660280000d00ff0a00010207050002070517000000"
            "000a0001020705170015150000000280000d00ff0a0001020705000000000a00010207051700550000000000000000000000"
            "17000000d2000000000080000d00ff0a00010207050002070517000000000a0001020705170015150000000280000d00ff0a"
            "0001020705000000000a0001020705170055000000000000000000000017000000d2000000000000020d6666666666662766"
            "66666666666666666666ffffff03ff"),
        "off_behind_events": bytes.fromhex(
            "030504800802800580ff20ac000d3200027f0004800000fb0280000d3200027f00048000048080000d3200040420003d0d05"
            "0d0800"),
        "off_leaves_nothing": bytes.fromhex(
            "0100ffffffffffff800d000380010000000d0d000000000000008005ff000420ffff00040380018d320d32200d003bff00"),
    }


def checksummed(kind, payload):
    return struct.pack("<II", kind, len(payload) + 12) + payload + struct.pack("<I", len(payload) + 12)


def ip_packet(payload, at=0, more=False, whole=None):
    """An IPv4 packet; of a UDP datagram, or a fragment of one of a given length."""
    udp = struct.pack(">HHHH", 5517, 50000, 8 + (whole or len(payload)), 0) if at == 0 else b""
    body = udp + payload
    head = struct.pack(">BBHHHBBH4B4B", 0x45, 0, 20 + len(body), 7, (0x2000 if more else 0) | at // 8, 64, 17, 0,
                       10, 42, 0, 37, 10, 42, 0, 1)
    return head + body


def capture_seeds():
    """Every kind of file and link, whole and broken."""
    words = [struct.pack("<I", 5000 << 12 | 0x400 | i) for i in range(4)]
    datagram = ip_packet(data(3, 0, 5, 0, words))
    ethernet = bytes(12)
    links = {
        "ethernet": (1, ethernet + b"\x08\0" + datagram),
        "vlan": (1, ethernet + b"\x81\0\0\x05\x08\0" + datagram),
        "two-vlans": (1, ethernet + b"\x88\xa8\0\x05\x81\0\0\x06\x08\0" + datagram),
        "cooked": (113, bytes(14) + b"\x08\0" + datagram),
        "cooked-2": (276, b"\x08\0" + bytes(18) + datagram),
        "raw": (101, datagram),
        "ipv4": (228, datagram),
        "null": (0, b"\2\0\0\0" + datagram),
        "loop": (108, b"\0\0\0\2" + datagram),
        "arp": (1, ethernet + b"\x08\6" + bytes(28)),
        "unknown-link": (147, datagram),
    }

    def pcap(link, *frames, order="<", magic=0xA1B2C3D4, cut=0):
        out = struct.pack(order + "IHHIIII", magic, 2, 4, 0, 0, 262144, link)
        for i, f in enumerate(frames):
            out += struct.pack(order + "IIII", 1700000000, i, len(f) - cut, len(f)) + f[:len(f) - cut]
        return out

    def pcapng(link, *frames):
        out = checksummed(0x0A0D0D0A, struct.pack("<IHHq", 0x1A2B3C4D, 1, 0, -1))
        out += checksummed(1, struct.pack("<HHI", link, 0, 262144) + struct.pack("<HHB3xHH", 9, 1, 9, 0, 0))
        for i, f in enumerate(frames):
            body = struct.pack("<IIIII", 0, 0x17000, i, len(f), len(f)) + f + bytes(-len(f) % 4)
            out += checksummed(6, body)
        return out

    whole = data(3, 1, 6, 0, words * 10)
    fragments = (ip_packet(whole[:40], more=True, whole=len(whole)), ip_packet(whole[40:], at=48))
    seeds = {name: pcap(*link) for name, link in links.items()}
    frame = links["ethernet"][1]
    seeds.update({
        "big-endian": pcap(1, frame, frame, order=">"),
        "nanoseconds": pcap(1, frame, frame, magic=0xA1B23C4D),
        "cut-short": pcap(1, frame, frame, cut=20),
        "truncated": pcap(1, frame, frame)[:-9],
        "fragments": pcap(101, *fragments, datagram),
        "fragments-reversed": pcap(101, *reversed(fragments)),
        "fragments-apart": pcap(101, fragments[0], datagram, fragments[0], datagram),
        "joined": pcap(101, *(ip_packet(whole[:40] * 3 + whole[:n]) for n in (0, 8, 12, 40)), datagram),
        "joined-fragments": pcap(101, *(ip_packet((whole * 2)[at:at + 96], at and at + 8, more=at < 288, whole=2 * len(whole))
                                        for at in (0, 96, 192, 288))),
        "pcapng": pcapng(1, frame, frame),
        "pcapng-raw": pcapng(101, datagram, *fragments),
        "header-alone": pcap(1),
        "gzip": gzip_stored(pcap(1, frame)),
        "gzip-cut": gzip_stored(pcap(1, frame))[:-30],
        "gzip-twice": gzip_stored(pcap(1, frame)[:30]) + gzip_stored(pcap(1, frame)[30:]),
        "zstd": zstd_stored(pcap(1, frame)),
        "zstd-cut": zstd_stored(pcap(1, frame))[:-30],
        "lz4": lz4_stored(pcap(1, frame)),
        "lz4-cut": lz4_stored(pcap(1, frame))[:-30],
        "bz2": bz2.compress(pcap(1, frame)),
        "bz2-cut": bz2.compress(pcap(1, frame))[:-30],
        "can-beside-ethernet": mixed_links(frame),
        "mcap": mcap(),
        "mcap-zstd": mcap(b"zstd", zstd_stored),
        "mcap-lz4": mcap(b"lz4", lz4_stored),
        "mcap-cut": mcap()[:-120],
        "mcap-damaged": mcap(b"zstd"),
        "bag": bag(b"none"),
        "bag-lz4": bag(b"lz4", lz4_stored),
        "bag-bz2": bag(b"bz2", bz2.compress),
        "bag-damaged": bag(b"lz4"),
    })
    return seeds


def bag(compression, pack=bytes):
    """A batch of one packet for each eye, in a chunk."""
    def field(name, value):
        return struct.pack("<I", len(name) + 1 + len(value)) + name + b"=" + value

    def record(op, data, *fields):
        header = b"".join(fields) + field(b"op", bytes([op]))
        return struct.pack("<I", len(header)) + header + struct.pack("<I", len(data)) + data

    def message(eye):
        return record(2, bytes(12) + bytes(4) + struct.pack("<BIQQB", eye, 0x0a2a0025, 0, 2, 0) + struct.pack("<IH", 1, eye)
                      + struct.pack("<III", 1, 7, 9) + struct.pack("<IH", 1, 3) + struct.pack("<I", 3) + b"one",
                      field(b"conn", bytes(4)))

    records = record(7, field(b"type", b"lumsdk_ros/Packets"), field(b"conn", bytes(4))) + message(0) + message(1)
    return b"#ROSBAG V2.0\n" + record(3, b" ") + record(5, pack(records), field(b"compression", compression),
                                                      field(b"size", struct.pack("<I", len(records))))


def mcap(compression=b"", pack=bytes):
    """A datagram in a chunk, and one behind it."""
    def text(value):
        return struct.pack("<I", len(value)) + value

    def record(opcode, body):
        return struct.pack("<BQ", opcode, len(body)) + body

    def message(payload):
        return record(5, struct.pack("<HIQQ", 1, 0, 0, 0) + b"\0\1\0\0" + struct.pack("<II", 7, 9) + b"\x0a\x2a\0\x25\x8d\x15"
                      + b"\x0a\x2a\0\1\x50\xc3" + struct.pack("<II", len(payload), len(payload)) + payload)

    content = record(3, struct.pack("<H", 1) + text(b"lumsdk_msgs/msg/Datagram") + text(b"ros2msg") + text(b""))
    content += record(4, struct.pack("<HH", 1, 1) + text(b"/p") + text(b"cdr") + text(b"")) + message(b"one")
    packed = pack(content)
    head = struct.pack("<QQQI", 0, 0, len(content), zlib.crc32(content)) + text(compression)
    magic = b"\x89MCAP0\r\n"
    return (magic + record(1, text(b"") + text(b"")) + record(6, head + struct.pack("<Q", len(packed)) + packed) + message(b"two")
            + record(15, bytes(4)) + record(11, struct.pack("<Q", 2) + bytes(34)) + record(2, bytes(20)) + magic)


def gzip_stored(content):
    packer = zlib.compressobj(0, wbits=-15)
    body = packer.compress(content) + packer.flush()
    return (bytes((0x1f, 0x8b, 8, 0, 0, 0, 0, 0, 0, 255)) + body
            + struct.pack("<II", zlib.crc32(content), len(content)))


def zstd_stored(content):
    """One frame of one block, of less than 256 bytes."""
    return b"\x28\xb5\x2f\xfd\x20" + bytes((len(content),)) + (len(content) << 3 | 1).to_bytes(3, "little") + content


def lz4_stored(content):
    """One frame of one block."""
    return b"\x04\x22\x4d\x18\x60\x40\x82" + struct.pack("<I", len(content) | 1 << 31) + content + bytes(4)


def index_capture():
    """The one of fuzz_index.c: three frames of ten lines, the datagrams of every other one joined."""
    out = struct.pack("<IHHIIII", 0xA1B2C3D4, 2, 4, 0, 0, 65535, 228)
    for i in range(30):
        alone = []
        for k in range(4):
            first = 5 * (k // 2)
            words = [struct.pack("<I", 3000 << 12 | 0x400 | first + n) for n in range(5)]
            alone.append(data(3, k % 2, i % 10, first, words, 1000 * i))
        for datagram in alone if i % 2 else [b"".join(alone)]:
            udp = struct.pack(">HHHH", 5517, 50000, 8 + len(datagram), 0) + datagram
            packet = struct.pack(">BBHHHBBH4B4B", 0x45, 0, 20 + len(udp), 0, 0, 64, 17, 0, 10, 42, 0, 37, 10, 42, 0, 1) + udp
            out += struct.pack("<IIII", 1700000000, 1000 * i, len(packet), len(packet)) + packet
    return out


def index_seeds():
    """Where to go, and the body of the index of that capture. None without lumsdk."""
    try:
        import lumsdk
    except ImportError:  # or NumPy is missing
        return None

    with tempfile.TemporaryDirectory() as folder:
        capture = pathlib.Path(folder) / "capture.pcap"
        capture.write_bytes(index_capture())
        with lumsdk.open(capture) as source:
            count = source.index(keep=True)
        index = (capture.parent / "capture.pcap.lumindex").read_bytes()
    at = 14
    at += 1 + index[at]
    for _ in range(3):  # the numbers of the key
        while index[at] > 127:
            at += 1
        at += 1
    places = {kind: [3 * n + kind for n in range(count + 1)] for kind in range(2)}
    places[2] = [2, 2 + 3 * 9, 2 + 3 * 19, 2 + 3 * 40]
    names = ("frame", "number", "time")
    return {f"{names[kind]}-{n}": bytes((where,)) + index[at:] for kind, list_of in places.items() for n, where in enumerate(list_of)}


def block(kind, body, order="<"):
    size = struct.pack(order + "I", len(body) + 12)
    return struct.pack(order + "I", kind) + size + body + size


def section(order="<", minor=0, options=b""):
    return block(0x0A0D0D0A, struct.pack(order + "IHHq", 0x1A2B3C4D, 1, minor, -1) + options, order)


def option(code, value, order="<"):
    return struct.pack(order + "HH", code, len(value)) + value + bytes(-len(value) % 4)


def interface(link=1, snap=0, options=b"", order="<"):
    return block(1, struct.pack(order + "HHI", link, 0, snap) + options, order)


def enhanced(content, time=0, index=0, whole=None, order="<", options=b""):
    fields = struct.pack(order + "IIIII", index, time >> 32, time & 0xFFFFFFFF, len(content), whole or len(content))
    return block(6, fields + content + bytes(-len(content) % 4) + options, order)


def simple(content, whole=None, order="<"):
    return block(3, struct.pack(order + "I", whole or len(content)) + content + bytes(-len(content) % 4), order)


def obsolete(content, time=0, index=0, order="<"):
    fields = struct.pack(order + "HHIIII", index, 0xFFFF, time >> 32, time & 0xFFFFFFFF, len(content), len(content))
    return block(2, fields + content + bytes(-len(content) % 4), order)


def mixed_links(frame):
    return (section() + interface(227) + interface(1) + enhanced(b"can frame", 1, 0) + enhanced(frame, 2, 1)
            + enhanced(b"can", 3, 0))


def pcap_seeds():
    """Every kind of file header and of block, in either byte order; small, since headers matter here."""
    seeds = {}
    for name, order in (("little", "<"), ("big", ">")):
        def file(magic, version=(2, 4), extra=b"", link=1, snap=100, order=order):
            head = struct.pack(order + "IHHIIII", magic, *version, 0, 0, snap, link)
            records = b"".join(struct.pack(order + "IIII", 0x65000000 + i, i, 5, 60 + i) + extra + b"abcde"
                               for i in range(3))
            return head + records

        end = option(0, b"", order)
        resolutions = b"".join(
            interface(1, 0, option(9, bytes((r,)), order) + end, order) for r in (0, 6, 9, 12, 19, 0x80, 0x8A, 0xA3, 0xBF))
        times = b"".join(enhanced(b"x", 0x1234567890ABCDEF, i, order=order) for i in range(9))
        offset = option(1, b"a comment", order) + option(14, struct.pack(order + "q", -3600), order)
        seeds.update({
            f"micro-{name}": file(0xA1B2C3D4),
            f"nano-{name}": file(0xA1B23C4D),
            f"kuznetzov-{name}": file(0xA1B2CD34, extra=bytes(8)),
            f"swapped-{name}": file(0xA1B2C3D4, (2, 2)),
            f"either-{name}": file(0xA1B2C3D4, (2, 3)),
            f"dgux-{name}": file(0xA1B2C3D4, (543, 0)),
            f"snap-{name}": file(0xA1B2C3D4, snap=3),
            f"raw-{name}": file(0xA1B2C3D4, link=101, snap=0),
            f"ng-{name}": section(order) + interface(1, 0, b"", order) + enhanced(b"frame", 7, order=order)
            + simple(b"simple", order=order) + obsolete(b"old", 9, order=order),
            f"ng-snap-{name}": section(order) + interface(1, 4, b"", order) + simple(b"fram", 60, order)
            + enhanced(b"fra", 8, 0, 60, order),
            f"ng-resolutions-{name}": section(order) + resolutions + times,
            f"ng-offset-{name}": section(order) + interface(1, 0, offset, order) + enhanced(b"x", 10**15, order=order),
            f"ng-sections-{name}": (section(order) + interface(1, 0, b"", order) + enhanced(b"1", 1, order=order)) * 3,
            f"ng-unknown-{name}": section(order, 2) + block(5, bytes(24), order) + interface(1, 0, b"", order)
            + block(4, b"name" * 3, order) + enhanced(b"x", 1, order=order, options=option(1, b"seen", order))
            + block(0xBAD, b"four", order) + enhanced(b"y", 2, order=order),
        })
    seeds["ng-orders"] = (section("<") + interface() + enhanced(b"1", 1)
                          + section(">") + interface(order=">") + enhanced(b"2", 2, order=">"))
    seeds["ng-links"] = mixed_links(b"frame")
    return seeds


def infer_seeds():
    """An even byte, which fields are given, these, lines, ticks and eyes; then changes of four bytes."""
    usual = bytes((0, 0, 14, 30, 1))

    def field(at, shape=0, low=0, bits=0):
        return bytes((at - 8, shape, low, bits))

    # line and first_sample_index in the bits of four bytes, num_samples behind them
    packed = b"\0" + bytes((1 << 2 | 1 << 3 | 1 << 4,)) + field(14, 2, 0, 12) + field(18, 1) + field(14, 2, 12, 16)
    # all of the other order, in eight bytes where there are some, and an eye above the line
    wide = b"\0\x7f" + field(21) + field(22, 5, 15, 1) + field(22, 5, 0, 15) + field(12, 1) + field(26, 5) + field(30, 7) \
        + bytes((26, 1, 1, 3))
    return {
        "usual": usual,
        "one-eye": usual[:-1] + b"\0",
        "packed": packed + usual[2:],
        "wide": wide + usual[2:],
        "samples-at-60": b"\0\x40" + bytes((48, 0, 0, 8)) + usual[2:],
        "constant": usual + bytes((0, 20, 0, 7)),
        "counter": usual + bytes((0, 15, 1, 0)),
        "twice": usual + bytes((0, 13, 2, 8, 0, 14, 2, 9)),
        "reserved": usual + bytes((0, 1, 0, 1)),
        "noise": usual + bytes((0, 6, 3, 5)),
        "faults": usual + bytes((3, 9, 0, 64, 7, 1, 1, 128, 11, 40, 2, 9, 17, 0, 4, 1, 23, 2, 5, 77, 40, 0, 3, 2)),
        "any": b"\1" + bytes((220,)) + bytes(range(72)) + bytes((250,)) + bytes(72),
    }


def yaml_seeds():
    """The samples without their remarks, and what the samples leave out."""
    calib = pathlib.Path(__file__).resolve().parent.parent.parent / "calib"

    def sample(name):
        lines = (line.split(" #")[0].rstrip() for line in (calib / name).read_text().splitlines())
        return "\n".join(line for line in lines if line and not line.lstrip().startswith("#")).encode() + b"\n"

    return {
        "calibration": b"\0" + sample("typical.yaml"),
        "profile": b"\1" + sample("profile-default.yaml"),
        "settings": b"\2" + sample("settings.yaml"),
        "gaussian": b"\2version: 1\nyscan: {shape: gaussian, center_deg: -7, sigma_deg: 4}\n",
        "regions": b"\2version: 1\nyscan:\n  shape: regions\n  regions:\n"
                   b"    1: {min_deg: -10, max_deg: -5, weight: 3}\n    2: {min_deg: -2, max_deg: 1}\n",
        "alias": b"\0version: 1\neyes: &a {blue: *a}\n",
        "twice": b"\0version: 1\nversion: 1\n",
        "deep": b"\0" + b"[" * 200,
    }


SEEDS = {
    "packet": packet_seeds,
    "assembler": assembler_seeds,
    "receiver": receiver_seeds,
    "points": points_seeds,
    "device": device_seeds,
    "session": session_seeds,
    "capture": capture_seeds,
    "pcap": pcap_seeds,
    "infer": infer_seeds,
    "yaml": yaml_seeds,
    "index": index_seeds,
}


def main():
    folder = pathlib.Path(__file__).resolve().parent / "corpus"
    folder.mkdir(exist_ok=True)
    for name, make in SEEDS.items():
        seeds = make()
        if seeds is None:
            print(f"{name}: not written, since lumsdk cannot be imported")
            continue
        archive = folder / f"{name}.txt"
        there = corpus.read(archive) if archive.exists() else ()
        corpus.write(archive, [*there, *seeds.values()])


if __name__ == "__main__":
    main()
