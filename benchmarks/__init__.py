"""How fast and how exact ``floquet`` is beside what one would use instead: ``python -m benchmarks``, or ``make bench``.

Reading order, which is the order in which data flow::

    machine → points, truth → equations → peers → timing → speed, states, roofline, scaling, startup → figure

README.md has the rules of the comparison.
"""
