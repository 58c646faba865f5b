"""A solution of lumcal eyes that nobody had to compute."""
import math

import numpy as np
from lumsdk.calibrate._solution import Parameter, Plane, Residuals, Solution

HELD = "no floor is seen by both eyes: record one <with> the floor"


def make(is_better=True):
    rng = np.random.default_rng(1)
    count = 2000
    eye = rng.integers(0, 2, count)
    azimuth, elevation, ranges = rng.uniform(-30, 30, count), rng.uniform(-17, 3, count), rng.uniform(2, 8, count)
    after = rng.normal(0, 0.002, count)
    before = after + 0.01 + 0.02 * np.sin(np.radians(3 * azimuth)) * (eye == 1)
    planes = []
    for number, turn in enumerate((0, 90, 180)):
        c, s = math.cos(math.radians(turn)), math.sin(math.radians(turn))
        along, up = rng.uniform(-3, 3, 50), rng.uniform(-1, 1, 50)
        planes.append(Plane(-np.array([c, s, 0.0]), -4.0, (0, 1, 2), (0, 1), 5000 + number,
                            np.stack((4 * c - along * s, 4 * s + along * c, up), 1), 0.021, 0.0022))
    planes.append(Plane(np.array([0.0, 0.0, 1.0]), -1.0, (), (), 0, np.zeros((0, 3)), math.nan, math.nan))  # that no cell was left of
    parameters = [Parameter("blue.tof_offset_ps", 12.34, 0.0, 20.1), Parameter("green.mount.yaw_deg", 30.5123, 30.0, 0.012),
                  Parameter("green.elevation.max_deg", 3.0, 3.0, math.inf, HELD)]
    return Solution(parameters, Residuals(eye, ranges, azimuth, elevation, rng.integers(0, 3, count), rng.integers(0, 3, count), before, after),
                    planes, ["a&b.pcap", "b.pcap", "c.pcap"], 0.02, 0.002, 0.021, 0.0023 if is_better else 0.03, is_better,
                    {"version": 1}, ["two captures see the same wall"], 0.02162, "mine.yaml",
                    np.array([[[0.0, 0.0, 0.0], [0.0, 0.012, 0.0]], [[-0.05, 0.0, 0.0], [0.0, 0.0, 0.0]]]), {"wave": 0.0014, "bend_deg": 0.003})
