"""The rule-based careful driver, shared by the expert and the rule-based planners."""
