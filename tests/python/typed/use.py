"""What a user writes, for the type checkers alone: no line is an error. What is one is in mistakes.py."""
# pyright: strict
from __future__ import annotations

import datetime
import pathlib
from typing import Any, Optional

import lumsdk
import numpy as np
from numpy.typing import NDArray
from typing_extensions import assert_type


def read(path: pathlib.Path) -> float:
    with lumsdk.open(path, returns="last", range=(2, 80), columns=["x", "y", "z", "range"]) as source:
        assert_type(source, lumsdk.Source)
        nearest = float("inf")
        for frame in source:
            assert_type(frame, lumsdk.Frame)
            nearest = min(nearest, float(frame["range"].min()), float(frame.xyz.max()))
        lost: int = source.losses["lost_words"]
        return nearest + lost


def look(source: lumsdk.Source) -> None:
    assert_type(source[0], lumsdk.Frame)
    for frame in source[2:5]:
        assert_type(frame, lumsdk.Frame)
        assert_type(frame.time, datetime.datetime)
        assert_type(frame.utc_ns, int)
        assert_type(frame.complete, bool)
        assert_type(frame.grid("range", eye="blue", returns=2), NDArray[np.float32])
        for name in frame:
            print(name, frame[name].dtype)
    source.seek(datetime.datetime.now(datetime.timezone.utc))
    source.seek(1.5)


def frames_of_ones_own(frame: lumsdk.Frame) -> lumsdk.Frame:
    near = frame[frame["range"] < 30]
    assert_type(near, lumsdk.Frame)
    assert_type(frame[10:20], lumsdk.Frame)
    assert_type(frame[[1, 2]].replace(x=frame["x"] + 1, z=[1.0, 2.0]), lumsdk.Frame)
    labelled = near.with_columns({"weight": np.ones(len(near))}, label=np.zeros(len(near), "u1"))
    assert_type(lumsdk.Frame.from_arrays(labelled.to_dict(), lines=near.lines, number=3), lumsdk.Frame)
    return labelled


def kinds_of_sources() -> None:
    lumsdk.open("drive-*.pcap")
    lumsdk.open(["a.pcap", pathlib.Path("b.pcap")])
    lumsdk.open(b"")
    with open("drive.pcap", "rb") as file:
        lumsdk.open(file, calibration={"eyes": {"blue": {"mount": {"yaw_deg": -30}}}}, set={"tof_lsb_ps": 12.9})


def several_sensors() -> None:
    rig = lumsdk.Rig([{"name": "front", "address": "10.42.0.37"}])
    assert_type(rig["front"], lumsdk.RigSensor)
    with lumsdk.open("drive.pcap", rig=rig, sensor="front") as source:
        for frames in lumsdk.sync(source, tolerance=0.02):
            assert_type(frames["front"], lumsdk.Frame)
            assert_type(frames.missing, dict[str, str])
            assert_type(frames.joined(["x", "y"]), lumsdk.Frame)


def find_a_layout() -> None:
    found = lumsdk.infer(["a.pcap", "b.pcap"], sensor="10.42.0.37", port=5600)
    assert_type(found, lumsdk.Inference)
    assert_type(found.findings, tuple[lumsdk.Finding, ...])
    if found.profile is not None:
        lumsdk.open("a.pcap", profile=found.profile)


def columns(frame: lumsdk.Frame, chosen: list[lumsdk.Column]) -> None:
    assert_type(frame["x"], NDArray[np.float32])
    assert_type(frame["time"], NDArray[np.float32])
    assert_type(frame["line"], NDArray[np.uint32])
    assert_type(frame["pixel"], NDArray[np.uint16])
    assert_type(frame["eye"], NDArray[np.uint8])
    assert_type(frame[lumsdk.OwnColumn("label")], NDArray[Any])
    assert_type(frame.xyz, NDArray[np.float32])
    assert_type(frame.lines, NDArray[np.void])
    assert_type(frame.to_structured(), NDArray[np.void])
    lumsdk.open("drive.pcap", columns="all")
    lumsdk.open("drive.pcap", columns=chosen, returns=2, edge="both", eye="green", frames=(10, None), range="2:80",
                box=((0, 50), (None, 10), "0:4"), smooth=(31, 2), incomplete="drop", broken="warn", threads=1)


def pictures(frame: lumsdk.Frame) -> None:
    assert_type(frame.image("xyz", eye="both", returns="strongest", view=(60, -60, 3, -17), rows=64), NDArray[np.float32])
    assert_type(frame.image_index("blue", "first"), NDArray[np.int32])
    assert_type(frame.image_pixels(columns=800), NDArray[np.int32])
    assert_type(frame.to_png("height", size=(800, 800)), bytes)
    seen = frame.project(np.eye(3), np.eye(4), distortion=(0.1, 0, 0, 0), size=(1920, 1080))
    assert_type(seen.pixels, NDArray[np.float64])
    assert_type(seen.visible, NDArray[np.bool_])


def motion(frame: lumsdk.Frame) -> None:
    poses = lumsdk.Poses(np.arange(3), np.stack([np.eye(4)] * 3), clock="sensor")
    assert_type(poses.times, NDArray[np.int64])
    assert_type(poses.at(1.5, outside="nearest"), NDArray[np.float64])
    assert_type(poses.origin(), Optional[tuple[float, float, float]])
    assert_type(frame.deskew(poses, to="middle"), lumsdk.Frame)
    assert_type(frame.to_world(lumsdk.Poses("00.txt", times="times.txt"), outside="raise"), lumsdk.Frame)


def files(source: lumsdk.Source, frame: lumsdk.Frame) -> int:
    lumsdk.convert("drive.pcap", "a.csv", columns=["x", "timestamp"], time="utc", comments=True, returns="last")
    lumsdk.convert(["a.pcap"], pathlib.Path("a.laz"), voxel=0.1, poses="poses.txt", to="world")
    lumsdk.convert(source, "a.parquet", columns="all", compression="zstd")
    lumsdk.convert((frame for frame in source if frame.complete), "a.feather", preset="argoverse2")
    frame.to_arrow(columns=["x", "sensor"])  # pyright: ignore[reportUnknownMemberType], where pyarrow has no types
    return lumsdk.convert(frame, "%04d.bin")["points"]


def views(source: lumsdk.Source, frame: lumsdk.Frame) -> None:
    assert_type(lumsdk.view("drive.pcap", profile="profile.yaml", browser=False), lumsdk.View)
    assert_type(lumsdk.view(source[:2], height=300), lumsdk.View)
    lumsdk.view(lumsdk.sync(source))
    lumsdk.view([frame.xyz, frame.xyz], calibration={"tof_lsb_ps": 12.9})
    lumsdk.view(frame.xyz).save(pathlib.Path("a.html"))
    assert_type(lumsdk.view(frame).path, Optional[str])


def live() -> None:
    with lumsdk.SimulatedSensor(lines=64) as simulated, lumsdk.Sensor(simulated.address, set={"tof_lsb_ps": 12.9}) as sensor:
        assert_type(sensor.threshold("blue", 50), lumsdk.Answer)
        assert_type(sensor.status(), lumsdk.Status)
        with sensor.laser():
            for frame in sensor.frames(duration=1, columns=["x"], returns="last", eye="blue"):
                assert_type(frame, lumsdk.Frame)
    assert_type(lumsdk.simulate(frames=2), bytes)
    assert_type(lumsdk.simulate("drive.pcap", lines=640, scene="town", motion=pathlib.Path("circle")), str)
