"""That a database survives anything, job by job; :mod:`tests.prove_storage` runs them all.

=================  ============================================================================================
tracing            a forked child under strace, which kills it at a system call or has the call fail
operations         what is disturbed: run, resume, pack and merge of a small study, and what must hold afterwards
disturbed          every system call of every operation, killed or failing
random_kills       SIGKILLs at random moments: of runs, of their worker processes, of Dask workers
=================  ============================================================================================
"""
