"""Immutable data model: Town, Route, Scenario, Scene and Hazard."""
