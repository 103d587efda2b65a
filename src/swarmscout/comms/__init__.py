"""Communication: who hears whom, and what beacons carry."""
