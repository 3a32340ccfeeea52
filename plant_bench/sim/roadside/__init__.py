"""Pedestrians and parked cars: all whom SUMO does not move."""
