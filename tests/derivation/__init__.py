"""The equations derived symbolically: nothing in blade and rotor imports floquet or the other truths.

==================  =================================================================================================
blade               from the speeds and accelerations of a blade element to one blade's equation of motion
rotor               from one blade to the teetering rotor, multiblade coordinates and the tip-path plane
==================  =================================================================================================

The tests hold the derivation against the report's printed equations (``test_appendix_a``, ``test_appendix_b``,
``test_tip_path_plane``) and the package's numbers against the derivation (``test_code``).
"""
