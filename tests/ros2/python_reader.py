#!/usr/bin/env python3
"""python_reader.py DOMAIN COUNT FOLDER: reads rt/points by Cyclone DDS for Python, decoded, as its own type.

Prints "ready", then a line for each sample, whose data goes into FOLDER as 0.data, 1.data, ...
"""
import pathlib
import sys
from dataclasses import dataclass

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.annotations import final
from cyclonedds.idl.types import int32, sequence, uint8, uint32
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration


@dataclass
@final
class Time(IdlStruct, typename="builtin_interfaces::msg::dds_::Time_"):
    """When."""

    sec: int32
    nanosec: uint32


@dataclass
@final
class Header(IdlStruct, typename="std_msgs::msg::dds_::Header_"):
    """Of most messages."""

    stamp: Time
    frame_id: str


@dataclass
@final
class Field(IdlStruct, typename="sensor_msgs::msg::dds_::PointField_"):
    """A column."""

    name: str
    offset: uint32
    datatype: uint8
    count: uint32


@dataclass
@final
class Cloud(IdlStruct, typename="sensor_msgs::msg::dds_::PointCloud2_"):
    """A frame."""

    header: Header
    height: uint32
    width: uint32
    fields: sequence[Field]
    is_bigendian: bool
    point_step: uint32
    row_step: uint32
    data: sequence[uint8]
    is_dense: bool


def main():
    domain, count, folder = int(sys.argv[1]), int(sys.argv[2]), pathlib.Path(sys.argv[3])
    participant = DomainParticipant(domain)
    topic = Topic(participant, "rt/points", Cloud)
    qos = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepLast(50))
    reader = DataReader(participant, topic, qos=qos)
    print("ready", flush=True)
    for n in range(count):
        cloud = next(iter(reader.take_iter(timeout=duration(seconds=300))))
        (folder / f"{n}.data").write_bytes(bytes(cloud.data))
        print(cloud.header.frame_id, cloud.width, cloud.point_step, [field.name for field in cloud.fields], flush=True)


if __name__ == "__main__":
    main()
