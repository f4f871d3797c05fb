"""Pages of single studies: cold start, the filter's consistency, the paper, real rigs, a motor."""
