"""Many runs: charts, studies, diagrams, and the command that runs one scene."""
