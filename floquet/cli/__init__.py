"""The command line: parse → one library call → print.

Results go to stdout, talk to stderr.  Exit status: 0 done (also for an unstable rotor or an empty answer), 1 failed
(disk full, damage found), 2 bad input (also a damaged or foreign file), 3 finished with failed points, 130 interrupted;
a closed pipe is silent.  Everything heavy is imported inside the commands, so that ``floquet --help`` loads none of it.

::

    options     the group of all commands, and the options that several of them take
    talk        what is printed, and where: answers, sentences, progress
    rotors      rotor, analyse, validity
    databases   run, pack, merge, verify, export
    queries     query
    studies     plot, study
    ending      main: every way out has its status
"""

from floquet.cli import databases, queries, rotors, studies
from floquet.cli.ending import main
from floquet.cli.options import command

__all__ = ["command", "databases", "main", "queries", "rotors", "studies"]
