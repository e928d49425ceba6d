"""The inverse: the states and pressures that give a force at a strain."""
