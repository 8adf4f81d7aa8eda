"""How much model a critical load needs: what may be left out of a scene, and the evidence for it."""
