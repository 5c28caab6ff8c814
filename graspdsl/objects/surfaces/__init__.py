"""Closed smooth surfaces for contacts that float on an object: level, normals, retraction, even samples."""
