"""Towns and routes: generated from a spec and a seed, checked, drawn, and read into a Town.

Only this package and `plant_bench.sim` know SUMO; everything else reads `networks/<town>/town.json`
through `plant_bench.world.town`.
"""
