#!/usr/bin/env python3
"""read_back_mcap.py PCD MCAP...: compare MCAP files with a PCD of the same capture, frame by frame, all points.

The PCD has the columns x,y,z,pulse_width,frame,eye,line,return_number,time and UTC timestamps. Each MCAP is read with
libraries that are not this project's: mcap with its check of CRCs, both by the index and as a stream, mcap-ros2-support
for the messages, and rosbags. Points have to be the same numbers, and as many.
Prints a line for each file and reader and "N passed, N failed"; the exit status is 1 if any failed.
"""
import argparse
import pathlib
import sys

import numpy
from pypcd4 import PointCloud

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


def check_others(tf, diagnostics):
    names = [(t.header.frame_id, t.child_frame_id) for m in tf for t in m.transforms]
    if names != [("luminar", "luminar_blue"), ("luminar", "luminar_green")]:
        raise ValueError(f"/tf_static has {names}")
    if [s.name for m in diagnostics for s in m.status] != ["lumdump: data", "lumdump: losses"]:
        raise ValueError("/diagnostics")


def read_mcap(path):
    from mcap.reader import make_reader
    from mcap.stream_reader import StreamReader
    from mcap_ros2.decoder import DecoderFactory

    with open(path, "rb") as file:
        records = sum(1 for _ in StreamReader(file, validate_crcs=True).records)
    found = {"/points": [], "/tf_static": [], "/diagnostics": []}
    with open(path, "rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        statistics = reader.get_summary().statistics
        for _, channel, _, message in reader.iter_decoded_messages():
            found[channel.topic].append(message)
        if not list(reader.iter_metadata()):
            raise ValueError("no metadata")
    if statistics.message_count != sum(map(len, found.values())) or records < statistics.message_count:
        raise ValueError(f"{statistics.message_count} messages by the statistics")
    check_others(found["/tf_static"], found["/diagnostics"])
    return [points_of(m) for m in found["/points"]]


def read_rosbags(path):
    from rosbags.highlevel import AnyReader
    from rosbags.typesys import Stores, get_typestore

    found = {"/points": [], "/tf_static": [], "/diagnostics": []}
    with AnyReader([path], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
        for connection, _, raw in reader.messages():
            found[connection.topic].append(reader.deserialize(raw, connection.msgtype))
    check_others(found["/tf_static"], found["/diagnostics"])
    return [points_of(m) for m in found["/points"]]


def disagreement(want, got):
    got = [points for points in got if len(points)]
    if len(got) != len(want):
        return f"{len(got)} frames with points, want {len(want)}"
    for i, (w, g) in enumerate(zip(want, got)):
        if not (numpy.sort(w) == numpy.sort(g)).all() if len(w) == len(g) else True:
            return f"frame {i}: {len(g)} points, want {len(w)}, or others"
    return None


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("pcd", type=pathlib.Path)
    parser.add_argument("files", type=pathlib.Path, nargs="+")
    arguments = parser.parse_args()
    want = read_pcd(arguments.pcd)
    passed = failed = 0
    for path in arguments.files:
        for name, reader in (("mcap", read_mcap), ("rosbags", read_rosbags)):
            try:
                why = disagreement(want, reader(path))
            except Exception as error:  # whatever a reader makes of a bad file
                why = f"{type(error).__name__}: {error}"
            passed, failed = passed + (not why), failed + bool(why)
            print(f"FAIL {path} with {name}: {why}" if why else f"ok   {path} with {name}: {sum(map(len, want))} points")
    print(f"{passed} passed, {failed} failed")
    return bool(failed)


if __name__ == "__main__":
    sys.exit(main())
