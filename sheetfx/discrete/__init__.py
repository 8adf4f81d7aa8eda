"""From a scene to unknowns, and from contributions to residual and tangent."""
