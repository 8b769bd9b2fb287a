"""Places where the jobs of a campaign run: this machine, a Dask cluster, or Slurm; all as a
`concurrent.futures.Executor`.
"""
