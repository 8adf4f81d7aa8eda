"""A run's folder, files of states, and states that another number of processes kept."""
