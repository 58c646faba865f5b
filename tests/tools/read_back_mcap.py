#!/usr/bin/env python3
"""read_back_mcap.py --capture PCAP PCD MCAP...: compare MCAP files with a PCD of the same capture, frame by frame, all
points; with clouds of lines, all points of the capture; and the datagrams with those of the capture itself.

The PCD has the columns x,y,z,pulse_width,frame,eye,line,return_number,time and UTC timestamps. Each MCAP is read with
libraries that are not this project's: mcap with its check of CRCs, both by the index and as a stream, mcap-ros2-support
for the messages, and rosbags. Points have to be the same numbers, and as many.
Prints a line for each file and reader and "N passed, N failed"; the exit status is 1 if any failed.
"""
import argparse
import pathlib
import sys

import mcap_maker
import numpy
from pypcd4 import PointCloud
from support import frames_of

POINT = numpy.dtype([("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("intensity", "<f4"), ("time", "<f4"), ("ring", "<u2"),
                     ("return", "u1"), ("eye", "u1")])
TYPES = {2: "u1", 4: "<u2", 7: "<f4"}
LINES = 64


def read_pcd(path):
    """A list of the points of each frame, as a message has them."""
    data = PointCloud.from_path(path).pc_data
    out = []
    for frame in numpy.unique(data["frame"]):
        rows = data[data["frame"] == frame]
        points = numpy.zeros(len(rows), POINT)
        for name in "x", "y", "z", "intensity", "eye":
            points[name] = rows[name]
        points["time"] = rows["time"] - rows["time"].min()
        points["ring"] = rows["eye"].astype("u2") * LINES + rows["line"]
        points["return"] = rows["return_number"]
        out.append(points)
    return out


def points_of(message):
    """Checks that the message describes its bytes as they are."""
    fields = [(f.name, f.offset, TYPES[f.datatype], f.count) for f in message.fields]
    if fields != [(name, POINT.fields[name][1], POINT[name].str.replace("|", ""), 1) for name in POINT.names]:
        raise ValueError(f"the fields are {fields}")
    points = numpy.frombuffer(bytes(message.data), POINT)
    if (message.height, message.width, message.point_step) != (1, len(points), POINT.itemsize):
        raise ValueError(f"{message.height} x {message.width} points, {len(points)} are there")
    if message.is_bigendian or not message.is_dense or message.header.frame_id != "luminar":
        raise ValueError("byte order, density or frame_id")
    if len(points) and ((numpy.diff(points["time"]) < 0).any() or points["time"][0] != 0):
        raise ValueError("the points are not in order of time")
    return points


def check_others(found):
    if found["/datagrams"]:
        if found["/points"] or found["/tf_static"] or found["/diagnostics"]:
            raise ValueError("others beside the datagrams")
        return
    tf, diagnostics = found["/tf_static"], found["/diagnostics"]
    names = [(t.header.frame_id, t.child_frame_id) for m in tf for t in m.transforms]
    if names != len(tf) * [("luminar", "luminar_blue"), ("luminar", "luminar_green")] or not tf:
        raise ValueError(f"/tf_static has {names}")
    if sorted({s.name for m in diagnostics for s in m.status}) != ["lumdump: data", "lumdump: losses"]:
        raise ValueError("/diagnostics")


def new_messages():
    return {"/points": [], "/tf_static": [], "/diagnostics": [], "/datagrams": []}


def datagram_of(message):
    """As the capture's are known: what a frame of Ethernet makes of it."""
    if message.length != len(message.data):
        raise ValueError(f"{len(message.data)} bytes of a datagram of {message.length}")
    return (message.stamp.sec * 10**9 + message.stamp.nanosec, bytes(message.source_address), message.source_port,
            bytes(message.destination_address), message.destination_port, bytes(message.data))


def datagrams_of(capture):
    out = []
    for ns, frame in zip(mcap_maker.times_of(capture), frames_of(capture)):
        ports = [int.from_bytes(frame[at:at + 2], "big") for at in (34, 36, 38)]
        out.append((ns, frame[26:30], ports[0], frame[30:34], ports[1], frame[42:34 + ports[2]]))
    return out


def read_mcap(path):
    from mcap.reader import make_reader
    from mcap.stream_reader import StreamReader
    from mcap_ros2.decoder import DecoderFactory

    with open(path, "rb") as file:
        records = sum(1 for _ in StreamReader(file, validate_crcs=True).records)
    found = new_messages()
    with open(path, "rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        statistics = reader.get_summary().statistics
        for _, channel, _, message in reader.iter_decoded_messages():
            found[channel.topic].append(message)
        if not list(reader.iter_metadata()):
            raise ValueError("no metadata")
    if statistics.message_count != sum(map(len, found.values())) or records < statistics.message_count:
        raise ValueError(f"{statistics.message_count} messages by the statistics")
    check_others(found)
    return [points_of(m) for m in found["/points"]], [datagram_of(m) for m in found["/datagrams"]]


def read_rosbags(path):
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    found = new_messages()
    with AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
        for connection, _, raw in reader.messages():
            found[connection.topic].append(reader.deserialize(raw, connection.msgtype))
    check_others(found)
    return [points_of(m) for m in found["/points"]], [datagram_of(m) for m in found["/datagrams"]]


def joined(clouds):
    """All points, without the times, which count from the stamp of each cloud."""
    points = numpy.concatenate(clouds)
    points["time"] = 0
    return [points]


def disagreement(path, want, packets, read):
    got, datagrams = read
    if path.name.startswith("packets"):
        return None if datagrams == packets else f"{len(datagrams)} datagrams, want {len(packets)}, or others"
    if path.name.startswith("lines"):
        if any(len(numpy.unique(points["ring"])) != 1 for points in got):
            return "a cloud of several lines"
        want, got = joined(want), joined(got)
    got = [points for points in got if len(points)]
    if len(got) != len(want):
        return f"{len(got)} frames with points, want {len(want)}"
    for i, (w, g) in enumerate(zip(want, got)):
        if not (numpy.sort(w) == numpy.sort(g)).all() if len(w) == len(g) else True:
            return f"frame {i}: {len(g)} points, want {len(w)}, or others"
    return None


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--capture", type=pathlib.Path, required=True)
    parser.add_argument("pcd", type=pathlib.Path)
    parser.add_argument("files", type=pathlib.Path, nargs="+")
    arguments = parser.parse_args()
    want, packets = read_pcd(arguments.pcd), datagrams_of(arguments.capture.read_bytes())
    passed = failed = 0
    for path in arguments.files:
        readers = (("mcap", read_mcap), ("rosbags", read_rosbags))
        for name, reader in readers[1:] if path.is_dir() else readers:
            try:
                why = disagreement(path, want, packets, reader(path))
            except Exception as error:  # whatever a reader makes of a bad file
                why = f"{type(error).__name__}: {error}"
            passed, failed = passed + (not why), failed + bool(why)
            print(f"FAIL {path} with {name}: {why}" if why else f"ok   {path} with {name}")
    print(f"{passed} passed, {failed} failed")
    return bool(failed)


if __name__ == "__main__":
    sys.exit(main())
