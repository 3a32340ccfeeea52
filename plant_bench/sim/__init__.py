"""The world in motion: SUMO behind one door, the ego's vehicle model, and the traffic around it."""
