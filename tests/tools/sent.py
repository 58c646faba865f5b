"""Captures of the simulator as a sensor would rather send them: the eyes' clocks some microseconds apart, clocks that go on along a line,
and bytes between fields that are not 0."""
import struct

PAYLOAD = 42  # behind Ethernet, IPv4, UDP
PER_PACKET = 334  # samples of a packet, about


class Field:
    """A field of a wire profile, in packets."""

    def __init__(self, at, bytes=1, order="little", bits=None, unit_ns=1000):  # the profile's own names
        self.at, self.width, self.order, self.unit_ns = at, bytes, order, unit_ns
        low, high = bits or (0, 8 * bytes - 1)
        self.low, self.mask = low, (1 << high - low + 1) - 1

    def load(self, packet):
        return int.from_bytes(packet[self.at:self.at + self.width], self.order) >> self.low & self.mask

    def add(self, packet, value):
        whole = int.from_bytes(packet[self.at:self.at + self.width], self.order)
        kept = whole & ~(self.mask << self.low)
        whole = kept | ((whole >> self.low) + value & self.mask) << self.low
        packet[self.at:self.at + self.width] = whole.to_bytes(self.width, self.order)


def packets(data):
    """Those of a little-endian pcap file, as views of it."""
    view, at = memoryview(data), 24
    while at < len(data):
        length = struct.unpack_from("<I", data, at + 8)[0]
        yield view[at + 16 + PAYLOAD:at + 16 + length]
        at += 16 + length


def edit(path, group, eyes, apart_us, step_us, filler):
    """In a capture by a profile's group and eye values: green's clock apart_us later than blue's, that of each further packet of a line
    step_us later, and filler, a dictionary of offsets and functions without argument, on bytes that are 0 in sound packets. What
    corruption has changed stays changed."""
    data = bytearray(path.read_bytes())
    fields = {name: Field(**field) for name, field in group.items() if isinstance(field, dict)}
    clock, first = fields.get("timestamp"), fields["first_sample_index"]
    for packet in packets(data):
        if clock is not None:
            later_us = (apart_us if fields["eye"].load(packet) == eyes[1] else 0) + min(first.load(packet) // PER_PACKET, 20) * step_us
            clock.add(packet, later_us * 1000 // clock.unit_ns)
        for at, make in filler.items():
            packet[at] ^= make()
    path.write_bytes(data)
