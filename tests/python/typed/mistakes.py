"""Mistakes, for the type checkers alone: every line that has one ends with a comment that names it, and no other line is one.

The comment is `# wrong: WHAT: KIND`; KIND is what mypy calls it.
"""
# pyright: strict
from __future__ import annotations

import datetime
from collections.abc import Iterator

import lumsdk
import numpy as np
from lumsdk import ray
from numpy.typing import NDArray


def options(source: lumsdk.Source) -> None:
    lumsdk.open(5)  # wrong: no source: arg-type
    lumsdk.open("drive.pcap", retruns="last")  # wrong: an unknown option: call-arg
    lumsdk.open("drive.pcap", columns=["rnage"])  # wrong: an unknown column: list-item
    lumsdk.open("drive.pcap", columns=("x", "Y"))  # wrong: an unknown column: arg-type
    lumsdk.open("drive.pcap", columns="x,y,z")  # wrong: a text, in which no checker sees a mistake: arg-type
    lumsdk.open("drive.pcap", columns=["xyz"])  # wrong: a column of data sets: list-item
    lumsdk.open("drive.pcap", columns=["timestamp"])  # wrong: a column of files: list-item
    lumsdk.open("drive.pcap", returns="lst")  # wrong: an unknown word: arg-type
    lumsdk.open("drive.pcap", returns=1.5)  # wrong: a part of a return: arg-type
    lumsdk.open("drive.pcap", edge="up")  # wrong: an unknown word: arg-type
    lumsdk.open("drive.pcap", eye="red")  # wrong: an unknown eye: arg-type
    lumsdk.open("drive.pcap", eye=1)  # wrong: the eye as a number: arg-type
    lumsdk.open("drive.pcap", range=2)  # wrong: one limit: arg-type
    lumsdk.open("drive.pcap", box=((0, 50), (-10, 10)))  # wrong: two axes: arg-type
    lumsdk.open("drive.pcap", incomplete="skip")  # wrong: an unknown word: arg-type
    lumsdk.open("drive.pcap", broken="ignore")  # wrong: an unknown word: arg-type
    lumsdk.open("drive.pcap", threads="2")  # wrong: a number as a text: arg-type
    lumsdk.open("drive.pcap", progress=3)  # wrong: no function: arg-type
    lumsdk.open("drive.pcap", calibration=5)  # wrong: no calibration: arg-type
    lumsdk.open("drive.pcap", sensor=None)  # wrong: no sensor: arg-type
    lumsdk.open("drive.pcap", storage_options="anon")  # wrong: no mapping: arg-type
    source["range"]  # wrong: a column of a source: call-overload
    source.seek("now")  # wrong: a time as a text: arg-type
    source.index(kept=True)  # wrong: an unknown argument: call-arg
    source.name = "another"  # wrong: set what is only read: misc


def frames(frame: lumsdk.Frame) -> Iterator[object]:
    yield frame["rnage"]  # wrong: an unknown column: call-overload
    yield frame["label"]  # wrong: a column of one's own without OwnColumn: call-overload
    yield frame[5.0]  # wrong: no column and no place: call-overload
    yield frame.xzy  # wrong: an unknown attribute: attr-defined
    yield frame.grid("rnage")  # wrong: an unknown column: arg-type
    yield frame.grid("range", eye="both")  # wrong: two eyes in one grid: arg-type
    yield frame.grid("range", returns="2")  # wrong: a number as a text: arg-type
    yield frame.image("range", eye="left")  # wrong: an unknown eye: arg-type
    yield frame.image("range", returns="all")  # wrong: more than a pixel holds: arg-type
    yield frame.image_index(rows=2.5)  # wrong: a part of a row: arg-type
    yield frame.to_arrow(columns=["rnage"])  # wrong: an unknown column: list-item
    yield frame.to_arrow(preset="nuscenes")  # wrong: an unknown preset: arg-type
    yield frame.to_pandas(colums=["x"])  # wrong: an unknown argument: call-arg
    yield frame.project([[1.0]])  # wrong: a matrix is missing: call-arg
    frame.complete = True  # wrong: set what is only read: misc


def own_frames(frame: lumsdk.Frame, source: lumsdk.Source) -> Iterator[object]:
    yield frame.with_columns(label="cars", weight={1: 2})  # wrong: a mapping as a column: arg-type
    yield lumsdk.Frame.from_arrays(x=[1.0], number="3")  # wrong: a number as a text: arg-type
    yield lumsdk.Frame.from_arrays(5)  # wrong: no mapping: arg-type
    yield frame[1:5].lable  # wrong: an unknown attribute: attr-defined
    angles: NDArray[np.float32] = frame.angles  # wrong: int16: assignment
    yield angles
    flights: NDArray[np.float32] = frame["tof"]  # wrong: int32: assignment
    yield flights
    lumsdk.open("drive.pcap", raw="yes")  # wrong: a text as a flag: arg-type
    lumsdk.write_capture("a.pcap", [frame.xyz])  # wrong: arrays and not frames: list-item
    lumsdk.write_capture("a.pcap", [frame], profile=5)  # wrong: no profile: arg-type
    lumsdk.open("drive.pcap", rig=5)  # wrong: no rig: arg-type
    lumsdk.Rig(5)  # wrong: no rig: arg-type
    lumsdk.sync(5)  # wrong: no source: arg-type
    lumsdk.sync(source, tolerance="20 ms")  # wrong: a number as a text: arg-type
    for frames in lumsdk.sync(source):
        yield frames[0]  # wrong: a name as a number: index
        yield frames.mising  # wrong: an unknown attribute: attr-defined


def arrays(frame: lumsdk.Frame) -> Iterator[object]:
    doubles: NDArray[np.float64] = frame["x"]  # wrong: float32: assignment
    floats: NDArray[np.float32] = frame["line"]  # wrong: uint32: assignment
    wide: NDArray[np.uint32] = frame["pixel"]  # wrong: uint16: assignment
    bits: NDArray[np.bool_] = frame["eye"]  # wrong: uint8: assignment
    records: NDArray[np.float32] = frame.to_structured()  # wrong: records: assignment
    places: NDArray[np.uint32] = frame.image_index()  # wrong: int32: assignment
    number: str = frame.number  # wrong: int: assignment
    moment: float = frame.time  # wrong: a datetime: assignment
    error: int = frame.utc_error_ns  # wrong: it may be None: assignment
    yield doubles, floats, wide, bits, records, places, number, moment, error


def motion(frame: lumsdk.Frame, poses: lumsdk.Poses) -> Iterator[object]:
    yield lumsdk.Poses("poses.txt", clock="gps")  # wrong: an unknown clock: arg-type
    yield lumsdk.Poses()  # wrong: nothing is given: call-arg
    yield poses.at("now")  # wrong: a time as a text: arg-type
    yield poses.at(5, outside="nan")  # wrong: of frames alone: arg-type
    yield frame.deskew("poses.txt")  # wrong: a path: arg-type
    yield frame.deskew(poses, to="world")  # wrong: that is to_world(): arg-type
    yield frame.to_world(poses, outside="skip")  # wrong: an unknown word: arg-type
    times: NDArray[np.float64] = poses.times  # wrong: int64: assignment
    yield times


def files(frame: lumsdk.Frame) -> None:
    lumsdk.convert("drive.pcap")  # wrong: no destination: call-arg
    lumsdk.convert("drive.pcap", "a.csv", columns=["rnage"])  # wrong: an unknown column: list-item
    lumsdk.convert("drive.pcap", "a.csv", time="gps")  # wrong: an unknown clock: arg-type
    lumsdk.convert("drive.pcap", "a.csv", to="end")  # wrong: an unknown moment: arg-type
    lumsdk.convert("drive.pcap", "a", format="e57")  # wrong: an unknown format: arg-type
    lumsdk.convert("drive.pcap", "a.las", voxel="0.1")  # wrong: a number as a text: arg-type
    lumsdk.convert("drive.pcap", "a.csv", coments=True)  # wrong: an unknown option: call-arg
    lumsdk.convert([frame.xyz], "a.csv")  # wrong: arrays and not frames: arg-type
    lumsdk.convert(frame, "a.csv")["point"]  # wrong: an unknown key: typeddict-item


def live() -> Iterator[object]:
    yield lumsdk.Sensor(5517)  # wrong: a port alone: arg-type
    yield lumsdk.Sensor("127.0.0.1", retry=2)  # wrong: an unknown argument: call-arg
    with lumsdk.Sensor("127.0.0.1") as sensor:
        yield sensor.frames(columns=["rnage"])  # wrong: an unknown column: list-item
        yield sensor.frames(broken="warn")  # wrong: an option of captures: call-arg
        yield sensor.threshold("both", 50)  # wrong: both eyes: arg-type
        yield sensor.lines(128)  # wrong: no such number of lines: arg-type
        yield sensor.power("60")  # wrong: a number as a text: arg-type
    yield lumsdk.SimulatedSensor(lines=128)  # wrong: no such number of lines: arg-type


def others(path: str) -> Iterator[object]:
    lumsdk.simulate("drive.pcap", lines=128)  # wrong: no such number of lines: call-overload
    lumsdk.simulate("drive.pcap", scene="moon")  # wrong: an unknown scene: call-overload
    made: str = lumsdk.simulate(frames=2)  # wrong: bytes: assignment
    yield lumsdk.infer(path, sensor=5)  # wrong: no address: arg-type
    yield lumsdk.infer(path).layout  # wrong: an unknown attribute: attr-defined
    yield lumsdk.view(path, colour="range")  # wrong: an option of pictures: call-arg
    yield lumsdk.view(path, height="300")  # wrong: a number as a text: arg-type
    yield lumsdk.Calibration(5)  # wrong: no calibration: arg-type
    yield lumsdk.Profile()[5]  # wrong: a key as a number: index
    yield ray.read_captures(path, rows="lines")  # wrong: no such rows: arg-type
    yield ray.read_captures(path, columns=["rnage"])  # wrong: an unknown column: list-item
    raise lumsdk.CaptureWarning("x") from made  # wrong: a text as a cause: misc


def columns(names: list[str], at: datetime.datetime) -> Iterator[object]:
    yield lumsdk.open("drive.pcap", columns=names)  # wrong: any text: arg-type
    name: lumsdk.Column = "rnage"  # wrong: an unknown column: assignment
    yield name, lumsdk.frobnicate, at  # wrong: an unknown name: attr-defined
