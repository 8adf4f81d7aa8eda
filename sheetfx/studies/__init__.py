"""Many runs: charts, traps, the failure map, and the command that runs one scene."""
