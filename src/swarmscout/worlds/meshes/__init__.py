"""Caves as triangle meshes: their files, the worlds made of them, and the generator of both."""
