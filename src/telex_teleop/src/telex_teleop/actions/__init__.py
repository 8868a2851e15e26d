"""Actions of an operator: their grammar, and the file that gives them keys and words.

`grammar` reads the text of an action, `vocabulary` the file ``config/actions.yaml``, `keys` knows
what a browser calls a key. None of them knows ROS.
"""
