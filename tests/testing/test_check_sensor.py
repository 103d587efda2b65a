"""The conformance check of sensors passes what is sound, and names each mistake."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from wrong_sensors import MISTAKES

from swarmscout.core.errors import SensorError
from swarmscout.core.scan import Scan
from swarmscout.robots.sensors.registry import SENSORS
from swarmscout.testing import check_sensor


@pytest.mark.parametrize("name", sorted(SENSORS.names()))
def test_built_in_sensors_are_sound(name: str) -> None:
    report = check_sensor(name)
    assert report.answers > 30
    assert f"sensor '{name}' is sound" in str(report)
    assert "one robot" in str(report)


@pytest.mark.parametrize(("kind", "says"), MISTAKES, ids=[kind.__name__ for kind, _ in MISTAKES])
def test_each_mistake_is_named(kind: type, says: str) -> None:
    with pytest.raises(SensorError, match=re.escape(says)) as caught:
        check_sensor(kind, missions=0)
    message = str(caught.value)
    assert kind.__name__ in message
    assert "\n" not in message
    assert message.count("SensorError") == 0


def test_a_mistake_that_shows_late_is_found_in_a_mission() -> None:
    class Late:
        def scan(self, bodies: Any, world: Any, step: int) -> Scan:
            if 20 < step < 60:
                raise KeyError("no such thing")
            return Scan(np.full((len(bodies.heading), 1), np.inf), np.array([0]), 1.0)

    check_sensor(Late(), missions=0)
    with pytest.raises(SensorError, match=r"'Late' in step 21 failed: KeyError"):
        check_sensor(Late())
