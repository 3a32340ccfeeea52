"""Towns from maps of others: a SUMO network, an OpenDRIVE or an OpenStreetMap file.

```
source      a file -> a checked MapSource; nothing hostile gets past it
converting  netconvert, with limits on time, memory and output
mending     converts again until all that is left can be driven; each step is a Finding
levels      roads that cross at one height without a junction: lifted where there is room
checking    what is only reported
town_making the folders of a town and its routes, whole or not at all
carla_routes, lane_ways, matching, matched_route, route_import   CARLA's routes onto such towns
```
"""
