"""Imports maps (SUMO, OpenDRIVE, OpenStreetMap) as towns, and CARLA routes onto such towns.

```
map_source      reads an untrusted map file and checks it
map_conversion  runs netconvert with limits on time, memory and output
network_repair  converts again until everything left can be driven; each step gives a Finding
levels          raises one of two roads that cross at the same height without a junction
map_checks      problems that are reported but not repaired
town_making     writes the folders of a town and its routes
carla_routes, lane_graph, matching, matched_route, route_import   CARLA's routes on such towns
```
"""
