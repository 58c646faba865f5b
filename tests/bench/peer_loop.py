"""peer_loop.py NAME CAPTURE: reads a capture to x y z in NumPy for every line of standard input, in one process.

Each line is answered by "WALL PROCESSOR COUNT": seconds, seconds of this process, points.
  lumsdk            lumsdk.open(), frame.xyz
  ouster            open_source(), XYZLut, all returns
  ouster-ranges     the same, its fastest: only ranges are decoded, XYZLutFloat
  ouster-memory     CAPTURE is a number: packets of so many frames of 128 x 2048 pixels, one return each, which lie in memory,
                    to ranges and XYZLutFloat; bench_frame has frames of x y z from datagrams in memory
  velodyne          read_pcap()
  memory            as lumsdk, answered by megabytes after a tenth of the frames, megabytes at the end, and frames
"""
import os
import sys
import time


def lumsdk(path):
    import lumsdk

    count = 0
    with lumsdk.open(path, columns=["x", "y", "z"]) as source:
        for frame in source:
            count += len(frame.xyz)
    return count


def ouster_points(source, lut_of):
    lut = None
    count = 0
    for frames in source:
        for frame in frames:
            if lut is None:
                lut = lut_of(frame.sensor_info)
                ranges = [name for name in frame.fields if name in ("RANGE", "RANGE2")]
            for name in ranges:
                xyz = lut(frame.field(name))
                count += xyz.shape[0] * xyz.shape[1]
    return count


def ouster(path):
    from ouster.sdk import open_source
    from ouster.sdk.core import XYZLut

    return ouster_points(open_source(path), XYZLut)


def ouster_ranges(path):
    from ouster.sdk import open_source
    from ouster.sdk.core import XYZLutFloat

    names = ["RANGE", "RANGE2"] if "two" in os.path.basename(path) else ["RANGE"]
    return ouster_points(open_source(path, field_names=names), XYZLutFloat)


def ouster_memory(frames):
    from ouster.sdk.core import FrameBatcher, LidarFrame, XYZLutFloat, get_field_types
    from peer_captures import OUSTER, ouster_info, ouster_packets

    info = ouster_info(OUSTER["ouster-one"])
    packets = list(ouster_packets(info, int(frames)))
    lut = XYZLutFloat(info)
    frame = LidarFrame(info, [kind for kind in get_field_types(info) if kind.name == "RANGE"])

    def read(_):
        batcher = FrameBatcher(info)
        count = 0
        for packet in packets:
            if batcher.batch(packet, frame):
                xyz = lut(frame.field("RANGE"))
                count += xyz.shape[0] * xyz.shape[1]
        return count

    return read


def velodyne(path):
    import velodyne_decoder

    config = velodyne_decoder.Config(model=velodyne_decoder.Model.VLP16)
    return sum(len(points[:, :3]) for _, points in velodyne_decoder.read_pcap(path, config))


def resident_mb():
    with open("/proc/self/statm") as f:
        return int(f.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6


def memory(path):
    import lumsdk

    sizes = []
    with lumsdk.open(path) as source:
        for frame in source:
            use = frame.xyz, frame["range"], frame.number
            sizes.append(resident_mb())
    del use
    return sizes[len(sizes) // 10], sizes[-1], len(sizes)


def main(name, path):
    read = {"lumsdk": lumsdk, "ouster": ouster, "ouster-ranges": ouster_ranges, "velodyne": velodyne, "memory": memory,
            "ouster-memory": ouster_memory}[name]
    if name == "ouster-memory":
        read = read(path)
    for _ in sys.stdin:
        wall, processor = time.monotonic(), time.process_time()
        count = read(path)
        answer = count if name == "memory" else (time.monotonic() - wall, time.process_time() - processor, count)
        print(*answer, flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
