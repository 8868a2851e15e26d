"""Changes to rospy: nothing is missed, less is computed, web pages stay out."""
