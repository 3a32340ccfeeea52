"""Towns: made by our own generator from a spec and a seed, checked, drawn, read into a Town.

Only this package and `plant_bench.sim` know SUMO; everything else reads `networks/<town>/town.json`
through `plant_bench.world.town`.
"""
