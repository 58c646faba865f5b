"""What a user writes, for the type checkers alone: every line that ends with `# wrong` is an error, and no other is."""
# pyright: strict
from __future__ import annotations

import datetime
import pathlib
from typing import Any

import lumsdk
import numpy as np
from typing_extensions import assert_type


def read(path: pathlib.Path) -> float:
    with lumsdk.open(path, returns="last", range=(2, 80), columns=["x", "y", "z", "range"]) as source:
        assert_type(source, lumsdk.Source)
        nearest = float("inf")
        for frame in source:
            assert_type(frame, lumsdk.Frame)
            xyz: np.ndarray[Any, Any] = frame.xyz
            nearest = min(nearest, float(frame["range"].min()), float(xyz.max()))
        lost: int = source.losses["lost_words"]
        return nearest + lost


def look(source: lumsdk.Source) -> None:
    assert_type(source[0], lumsdk.Frame)
    for frame in source[2:5]:
        assert_type(frame, lumsdk.Frame)
        assert_type(frame.time, datetime.datetime)
        assert_type(frame.utc_ns, int)
        assert_type(frame.complete, bool)
        assert_type(frame.columns, tuple[str, ...])
        image: np.ndarray[Any, Any] = frame.grid("range", eye="blue", returns=2)
        print(image.shape)
    source.seek(datetime.datetime.now(datetime.timezone.utc))
    source.seek(1.5)


def frames_of_ones_own(frame: lumsdk.Frame) -> lumsdk.Frame:
    near = frame[frame["range"] < 30]
    assert_type(near, lumsdk.Frame)
    assert_type(frame[10:20], lumsdk.Frame)
    assert_type(frame[[1, 2]].replace(x=frame["x"] + 1, z=[1.0, 2.0]), lumsdk.Frame)
    labelled = near.with_columns({"weight": np.ones(len(near))}, label=np.zeros(len(near), "u1"))
    assert_type(lumsdk.Frame.from_arrays(labelled.to_dict(), lines=near.lines, number=3), lumsdk.Frame)
    frame.with_columns(label="cars", weight={1: 2})  # wrong
    lumsdk.Frame.from_arrays(x=[1.0], number="3")  # wrong
    lumsdk.Frame.from_arrays(5)  # wrong
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
    lumsdk.open("drive.pcap", rig=5)  # wrong
    lumsdk.sync(5)  # wrong


def find_a_layout() -> None:
    found = lumsdk.infer(["a.pcap", "b.pcap"], sensor="10.42.0.37", port=5600)
    assert_type(found, lumsdk.Inference)
    assert_type(found.findings, tuple[lumsdk.Finding, ...])
    if found.profile is not None:
        lumsdk.open("a.pcap", profile=found.profile)
    lumsdk.infer("a.pcap", sensor=5)  # wrong


def mistakes(source: lumsdk.Source) -> None:
    lumsdk.open(5)  # wrong
    lumsdk.open("drive.pcap", retruns="last")  # wrong
    lumsdk.open("drive.pcap", edge="up")  # wrong
    lumsdk.open("drive.pcap", eye=1)  # wrong
    lumsdk.open("drive.pcap", range=2)  # wrong
    source["range"]  # wrong
    source.seek("now")  # wrong
    source[0].complete = True  # wrong
    source[0][0]  # wrong
    source[0].grid("range", returns="2")  # wrong
    number: str = source[0].number  # wrong
    print(number)
