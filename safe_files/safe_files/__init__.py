"""Files from others, read strictly; files of ours, written whole or not at all. Knows neither ROS nor runs."""
