"""Contact: unknowns, evaluation at contact points, and the ways to enforce an interface law."""
