"""lumfleet: the captures of a fleet converted on one machine, or on many by Ray."""
