"""The specs that ship: those of the chapter's equations and experiments, and others to begin with."""
