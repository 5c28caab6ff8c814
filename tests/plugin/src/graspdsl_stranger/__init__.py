"""What a stranger adds to graspdsl: one thing of each kind, each in a file of its own."""
