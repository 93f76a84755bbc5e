"""Sweeps: a case at many points, in local processes or on a cluster, and what follows from it."""
