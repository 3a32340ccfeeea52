"""Learning to drive from recordings. Needs torch and Lightning Fabric."""
