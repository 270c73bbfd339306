"""Long studies in pieces: on all cores or a cluster, resumed after an interruption."""
