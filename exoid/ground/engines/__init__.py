"""Where many jobs run: this machine, a Dask cluster, or Slurm; all as a `concurrent.futures.Executor`."""
