"""Single pictures of scenes, without ROS: for authors, documents and tests."""
