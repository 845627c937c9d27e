"""Files and messages from others, read strictly; files of ours, written whole or not at all. Knows no ROS, no runs."""
