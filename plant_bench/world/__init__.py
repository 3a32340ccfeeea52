"""Town, Route, Scenario and Scene: immutable values that everything else is made of."""
