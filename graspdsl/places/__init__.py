"""YAML and XML with the place of every node, held against models; files that a user named. Nothing here grasps."""
