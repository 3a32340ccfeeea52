"""The rule-based careful driver, in parts; the expert and the rule-based planners use it."""
