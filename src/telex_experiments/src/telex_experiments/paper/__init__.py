"""The paper's results, reproduced: experiments on the real system, and the report of them.

`./launch_scripts/reproduce_paper.sh` runs `python -m telex_experiments.paper`. Each experiment has
a process of its own (`python -m telex_experiments.paper.one`), with a ROS master, a simulator and
free ports of its own.

`experiment` says what an experiment is, `session` what it works with, `registry` which there are,
`schedule` runs them, `page` writes the report.
"""
