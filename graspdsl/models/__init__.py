"""Models of robots and things that others wrote: URDF and MJCF, read by the compiler of MuJoCo."""
