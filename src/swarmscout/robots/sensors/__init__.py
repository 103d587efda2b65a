"""Range sensors: one file per model, all with the interface of :class:`.sensor.Sensor`."""
