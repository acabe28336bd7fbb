"""Citations: the sources of the laws, machines, drives and methods that a system uses.

It is given a system, or what has one, and gives back `Citations`: what is to be cited, as text and as BibTeX. The
references stand once, in `bibliography.bib`; parts name them in `source`, methods in `cite.py`.
"""
