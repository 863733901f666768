"""Where tasks are computed: in this process, in processes of this machine, by dask, by MPI."""
