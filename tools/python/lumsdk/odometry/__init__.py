"""Poses of a drive from its frames alone: lumodom. Needs kiss-icp and matplotlib (extra: odometry)."""
