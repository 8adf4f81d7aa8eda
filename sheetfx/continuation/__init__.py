"""Following equilibrium: controls, the corrector, steps from state to state."""
