"""Things of other packages, and of Python files that a spec names: found without importing any, and entered into the
tables when a spec first names them."""
