"""What might be true of a robot, numbers of its file and effects that it lacks, and fits of that to equations."""
