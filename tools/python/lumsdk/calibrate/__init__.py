"""Calibration of a sensor from recordings of flat faces: lumcal. Needs SciPy and matplotlib (extra: calibrate)."""
