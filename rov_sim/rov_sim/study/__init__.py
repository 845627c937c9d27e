"""Studies by simulation: parts that resume, processes or a cluster, scores over seeds with their intervals."""
