"""Training of learned planners from recordings; needs torch and Lightning Fabric."""
