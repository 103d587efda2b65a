"""Routes: over the occupancy grid to a destination or a charging station, and along them."""
