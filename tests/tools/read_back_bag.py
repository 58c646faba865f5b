#!/usr/bin/env python3
"""Bags of ROS 1 that rosbags has written, from the definition of the messages: lumdump makes the points of the capture of
them."""
import pathlib
import unittest

import bag_maker
import mcap_maker
import numpy
from rosbags.rosbag1 import Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from support import Folder, frames_of, run, simulate

DEFINITION = pathlib.Path(__file__).parent / "../../tools/ros/lumsdk_ros/msg/Packets.msg"
TYPE = "lumsdk_ros/msg/Packets"
SENSOR = 0x0a2a0025
BATCH = 50


def store_of_packets():
    store = get_typestore(Stores.ROS1_NOETIC)
    store.register(get_types_from_msg(DEFINITION.read_text(), TYPE))
    return store


def message(store, eye, begin, end, chosen):
    """Of one eye: (number, ns, payload) of each of its packets."""
    types = store.types
    time = types["builtin_interfaces/msg/Time"]
    header = types["std_msgs/msg/Header"](seq=0, stamp=time(sec=0, nanosec=0), frame_id="luminar")
    return types[TYPE](
        header=header, eye=eye, sensor=SENSOR, begin=begin, end=end, last=False,
        places=numpy.array([n - begin for n, _, _ in chosen], numpy.uint16),
        stamps=[time(sec=ns // 10**9, nanosec=ns % 10**9) for _, ns, _ in chosen],
        lengths=numpy.array([len(payload) for _, _, payload in chosen], numpy.uint16),
        data=numpy.frombuffer(b"".join(payload for _, _, payload in chosen), numpy.uint8))


def write(path, capture, compression=None):
    store = store_of_packets()
    packets = [(number, ns, frame[42:34 + int.from_bytes(frame[38:40], "big")])
               for number, (ns, frame) in enumerate(zip(mcap_maker.times_of(capture), frames_of(capture)))]
    writer = Writer(path)
    if compression:
        writer.set_compression(compression)
    with writer:
        topics = [writer.add_connection(f"/{eye}", TYPE, typestore=store) for eye in ("blue", "green")]
        for begin in range(0, len(packets), BATCH):
            batch = packets[begin:begin + BATCH]
            for eye, topic in enumerate(topics):
                mine = [p for p in batch if (p[2][9] == bag_maker.GREEN) == (eye == bag_maker.GREEN)]
                one = message(store, eye, begin, begin + len(batch), mine)
                writer.write(topic, batch[0][1], store.serialize_ros1(one, TYPE))


class Bag(unittest.TestCase):
    def setUp(self):
        self.folder = Folder(self)
        self.source = simulate(self.folder / "street.pcap", "--frames", "3", "--seed", "5", "--loss", "0.01")
        self.bag = self.folder / "drive.bag"

    def points(self, source):
        r = run("lumdump", source, "-o", "-", "--format", "csv", "-q")
        self.assertEqual(r.returncode, 0, r.stderr)
        return r.stdout_bytes

    def test_it_has_the_points_of_the_capture(self):
        write(self.bag, self.source.read_bytes())
        want = self.points(self.source)
        self.assertGreater(want.count(b"\n"), 10000)
        self.assertTrue(self.points(self.bag) == want, "other points")

    def test_so_has_one_that_is_compressed(self):
        want = self.points(self.source)
        for compression in Writer.CompressionFormat:
            with self.subTest(compression):
                path = self.folder / f"{compression.name}.bag"
                write(path, self.source.read_bytes(), compression)
                self.assertTrue(self.points(path) == want, "other points")


if __name__ == "__main__":
    unittest.main()
