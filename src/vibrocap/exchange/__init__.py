"""Exchange: a case as what other programs run, with its exact contact.

Given a case, it gives files: C sources (`c_library`), of the same kernel as every motion of the package.
"""
