"""Pedestrians and parked cars: the actors that SUMO does not move."""
