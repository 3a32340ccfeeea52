"""Why an episode went wrong: the seconds before each infraction, in words and in a picture."""
