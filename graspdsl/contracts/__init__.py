"""What an entry of each table has to keep, whoever wrote it: one module a kind, with its ``RULES``."""
