"""The command line: ``graspdsl``. The only part that prints, and the only one that knows colours and exit codes."""

from graspdsl.cli.main import main

__all__ = ["main"]
