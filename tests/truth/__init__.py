"""Truth that shares no code with the package: nothing in here imports floquet.

==================  =================================================================================================
blade_element       hinge moments by adaptive quadrature of Appendix A's physics
closed_forms        the polynomials, tables and hover formulas those integrals lead to, transcribed one by one
taylor              exponents to any number of digits from Taylor series in arbitrary precision
problems            equations with known or computed exponents, as pieces that taylor integrates
make_reference      the program that writes data/reference/exponents.json
==================  =================================================================================================
"""
