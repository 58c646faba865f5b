"""peer_captures.py NAME FILE COUNT: a capture as other makers' sensors send it, for script/bench --peers.

  ouster-one, ouster-low, ouster-two   COUNT frames of 128 x 2048 pixels in the profile RNG19_RFL8_SIG16_NIR16, RNG15_RFL8_NIR8
                    or RNG19_RFL8_SIG16_NIR16_DUAL, encoded and written by Ouster's SDK, with its metadata in FILE.json
  velodyne          COUNT packets of a VLP-16, as its data sheet gives them (63-9243, section 9)
  tiny              COUNT frames of the Model G2 with 10 lines of one pixel

Every pixel has a return. The same arguments give the same capture.
"""
import json
import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "tools"))
sys.dont_write_bytecode = True

BEAMS, COLUMNS = 128, 2048
OUSTER = {"ouster-one": "RNG19_RFL8_SIG16_NIR16", "ouster-low": "RNG15_RFL8_NIR8", "ouster-two": "RNG19_RFL8_SIG16_NIR16_DUAL"}
FRAME_NS = 100_000_000
BEGIN_NS = 1_700_000_000_000_000_000

BLOCKS, CHANNELS = 12, 32  # of a VLP-16's packet
PACKET_S = 12 * 110.592e-6


def ouster_info(profile):
    """Metadata of an OS1 with 128 beams, from what the SDK has of one with 64."""
    from ouster.sdk.core import LidarMode, SensorInfo

    info = json.loads(SensorInfo.from_default(LidarMode._2048x10).to_json_string())
    beams = range(BEAMS)
    info["beam_intrinsics"]["beam_altitude_angles"] = np.linspace(21, -21, BEAMS).tolist()
    info["beam_intrinsics"]["beam_azimuth_angles"] = [(3.164, 1.055, -1.055, -3.164)[i % 4] for i in beams]
    info["lidar_data_format"].update(pixels_per_column=BEAMS, pixel_shift_by_row=[(36, 24, 12, 0)[i % 4] for i in beams],
                                     udp_profile_lidar=profile)
    info["config_params"].update(udp_port_lidar=7502, udp_port_imu=7503)
    info["sensor_info"]["prod_line"] = f"OS-1-{BEAMS}"
    return SensorInfo(json.dumps(info))


def ouster_packets(info, frames):
    from ouster.sdk.core import LidarFrame
    from ouster.sdk.util import frame_to_packets

    random = np.random.default_rng(7)
    for number in range(frames):
        frame = LidarFrame(info)
        frame.frame_id = number + 1
        frame.status[:] = 1
        frame.timestamp[:] = 10**9 + number * FRAME_NS + np.arange(COLUMNS) * (FRAME_NS // COLUMNS)
        packets = len(frame.packet_timestamp)
        frame.packet_timestamp[:] = BEGIN_NS + number * FRAME_NS + np.arange(packets) * (FRAME_NS // packets)
        for name in frame.fields:
            field = frame.field(name)
            if name.startswith("RANGE"):
                field[:] = random.integers(125, 12500, field.shape) * 8  # mm, which every profile can tell
            elif field.shape == (BEAMS, COLUMNS) and not name.startswith("FLAGS"):
                field[:] = random.integers(0, 200, field.shape)
        yield from frame_to_packets(frame, info)


def make_ouster(profile, path, frames):
    from ouster.sdk.pcap.pcap import record

    info = ouster_info(profile)
    record(ouster_packets(info, frames), path)
    pathlib.Path(path).with_suffix(".json").write_text(info.to_json_string())


def make_velodyne(path, packets):
    """One pcap record a packet, all of one array."""
    block = np.dtype([("flag", "u2"), ("azimuth", "<u2"), ("returns", [("distance", "<u2"), ("reflectivity", "u1")], CHANNELS)])
    record = np.dtype([("seconds", "<u4"), ("micros", "<u4"), ("kept", "<u4"), ("length", "<u4"), ("head", "u1", 42),
                       ("blocks", block, BLOCKS), ("time", "<u4"), ("mode", "u1"), ("model", "u1")])
    import support

    random = np.random.default_rng(7)
    out = np.zeros(packets, record)
    micros = np.rint(np.arange(packets) * PACKET_S * 1e6).astype(np.int64)
    size = record.itemsize - 16
    out["seconds"], out["micros"] = BEGIN_NS // 10**9 + micros // 10**6, micros % 10**6
    out["kept"] = out["length"] = size
    out["head"] = np.frombuffer(support.udp(bytes(size - 42), sport=2368, dport=2368)[:42], "u1")
    out["blocks"]["flag"] = 0xEEFF
    out["blocks"]["azimuth"] = (np.arange(packets * BLOCKS) * 40 % 36000).reshape(packets, BLOCKS)  # 10 turns a second
    shape = packets, BLOCKS, CHANNELS
    out["blocks"]["returns"]["distance"] = random.integers(500, 50000, shape)  # of 2 mm
    out["blocks"]["returns"]["reflectivity"] = random.integers(0, 255, shape)
    out["time"] = micros % 3_600_000_000
    out["mode"], out["model"] = 0x37, 0x22  # strongest return, VLP-16
    with open(path, "wb") as f:
        f.write(support.pcap([]))
        out.tofile(f)


def make_tiny(path, frames):
    import support

    def packets():
        for i in range(frames * 10):
            words = [support.word(3000, 100)]
            yield from map(support.udp, support.line(words, number=i % 10 * 5, clock=1000 + i * 1562))
    pathlib.Path(path).write_bytes(support.pcap(packets()))


def main(name, path, count):
    if name in OUSTER:
        make_ouster(OUSTER[name], path, int(count))
    else:
        {"velodyne": make_velodyne, "tiny": make_tiny}[name](path, int(count))


if __name__ == "__main__":
    main(*sys.argv[1:])
