"""A sensor of your own: a class with one method, scan(bodies, world, step)."""

import swarmscout as ss
from swarmscout.core.scan import Scan
from swarmscout.robots.sensors.raster_rays import raster_ranges
from swarmscout.robots.sensors.ray_sensor import directions_of
from swarmscout.testing import check_sensor

STEPS = 150


class FourWays:
    """Rays ahead, left, back and right, without noise."""

    def __init__(self, range_m: float = 2.0):
        self.range_m = range_m

    def scan(self, bodies, world, step):
        directions = directions_of([0, 90, 180, 270])
        ranges = raster_ranges(bodies, world, directions, self.range_m)
        return Scan(ranges, directions, self.range_m)


check_sensor(FourWays, missions=0)
for sensor in (None, FourWays()):
    mission = ss.Mission(ss.Scenario(robots=8, steps=STEPS, world="lava-tube-small"), sensor=sensor)
    summary = mission.run()
    print(f"{mission.sensing.name:9} {summary['explored_m2']:6.1f} m²")
