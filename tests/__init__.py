"""The tests; a package, so that ``python -m tests.truth.make_reference`` and plain ``pytest`` both find them."""
