"""Looking at runs: pictures of the map, and more to come."""
