"""What the fingertips feel: one tactile sensor in each, and whether each of them touches. It knows no engine."""
